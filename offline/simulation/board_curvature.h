#ifndef RAYGRID_SIMULATION_BOARD_CURVATURE_H
#define RAYGRID_SIMULATION_BOARD_CURVATURE_H

#include <Eigen/Core>

#include "dataset/pattern.h"

namespace raygrid {

/// The shape of a curved board: a paraboloid, zero at the centre of its
/// features, z = bend_m (x^2 + y^2 / 2) with x and y from -1 to 1 over the
/// features.
class BoardCurvature {
 public:
  BoardCurvature(const Board& board, double bend_m);

  double Height(double x_m, double y_m) const {
    const double x = x_m - center_m_.x(), y = y_m - center_m_.y();
    return x2_coefficient_ * x * x + y2_coefficient_ * y * y;
  }

  const Eigen::Vector2d& center_m() const { return center_m_; }
  double x2_coefficient() const { return x2_coefficient_; }  ///< 1 / metre
  double y2_coefficient() const { return y2_coefficient_; }

 private:
  Eigen::Vector2d center_m_;
  double x2_coefficient_, y2_coefficient_;
};

/// Returns the board with its features on the curved surface.
Board CurveBoard(const Board& board, double bend_m);

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_BOARD_CURVATURE_H
