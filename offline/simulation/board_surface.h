#ifndef RAYGRID_SIMULATION_BOARD_SURFACE_H
#define RAYGRID_SIMULATION_BOARD_SURFACE_H

#include <Eigen/Core>
#include <optional>

#include "camera/observation_line.h"
#include "simulation/board_bend.h"
#include "simulation/ink_map.h"

namespace raygrid {

/// A board as a thing in space: printed paper, flat or bent. Made once per
/// board, which takes a fraction of a second, and used for all images.
class BoardSurface {
 public:
  /// Paper goes on beyond the ink by paper_margin_squares squares. The ink is
  /// where the board's kind says, not where its points are.
  explicit BoardSurface(const Board& board, double bend_m = 0,
                        double paper_margin_squares = 0.5);

  struct Point {
    Eigen::Vector2d board_m;
    double depth = 0;  ///< t of the line
  };
  /// The point where a line, in the board's coordinates, meets the front of the
  /// surface, on the paper or beside it.
  std::optional<Point> Intersect(const ObservationLine& line) const;

  double InkFraction(const Eigen::Vector2d& center_m,
                     const Footprint& footprint) const {
    return ink_.InkFraction(center_m, footprint);
  }
  double PaperFraction(const Eigen::Vector2d& center_m,
                       const Footprint& footprint) const;

  const Area& paper_m() const { return paper_m_; }

 private:
  BoardBend bend_;
  InkMap ink_;
  Area paper_m_;
};

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_BOARD_SURFACE_H
