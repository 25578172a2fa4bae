#ifndef RAYGRID_SIMULATION_BOARD_BEND_H
#define RAYGRID_SIMULATION_BOARD_BEND_H

#include <Eigen/Core>

#include "dataset/pattern.h"

namespace raygrid {

/// The shape of a curved board: a paraboloid, zero at the centre of its
/// features, z = bend_m (x^2 + y^2 / 2) with x and y from -1 to 1 over the
/// features.
class BoardBend {
 public:
  BoardBend(const Board& board, double bend_m);

  double Height(double x_m, double y_m) const {
    const double x = x_m - center_m_.x(), y = y_m - center_m_.y();
    return by_x2_ * x * x + by_y2_ * y * y;
  }

  const Eigen::Vector2d& center_m() const { return center_m_; }
  double by_x2() const { return by_x2_; }  ///< 1 / metre
  double by_y2() const { return by_y2_; }

 private:
  Eigen::Vector2d center_m_;
  double by_x2_, by_y2_;
};

/// Returns the board with its features on the curved surface.
Board BendBoard(const Board& board, double bend_m);

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_BOARD_BEND_H
