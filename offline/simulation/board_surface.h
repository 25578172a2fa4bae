#ifndef RAYGRID_SIMULATION_BOARD_SURFACE_H
#define RAYGRID_SIMULATION_BOARD_SURFACE_H

#include <Eigen/Core>
#include <optional>

#include "camera/observation_line.h"
#include "simulation/board_curvature.h"
#include "simulation/ink_map.h"

namespace raygrid {

/// The surface of a board for rendering: printed paper, planar or curved.
/// Construction takes a fraction of a second per board.
class BoardSurface {
 public:
  /// The paper extends paper_margin_squares squares around the ink. The ink
  /// follows the board's nominal geometry, not its points.
  explicit BoardSurface(const Board& board, double bend_m = 0,
                        double paper_margin_squares = 0.5);

  struct Point {
    Eigen::Vector2d board_m;
    double depth = 0;  ///< parameter t of the line
  };
  /// Intersects a line, in the board frame, with the front of the surface,
  /// inside or outside the paper; nullopt without an intersection.
  std::optional<Point> Intersect(const ObservationLine& line) const;

  double InkFraction(const Eigen::Vector2d& center_m,
                     const Footprint& footprint) const {
    return ink_.InkFraction(center_m, footprint);
  }
  double PaperFraction(const Eigen::Vector2d& center_m,
                       const Footprint& footprint) const;

  const Area& paper_m() const { return paper_m_; }

 private:
  BoardCurvature curvature_;
  InkMap ink_;
  Area paper_m_;
};

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_BOARD_SURFACE_H
