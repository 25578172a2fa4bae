#include "simulation/board_curvature.h"

namespace raygrid {

BoardCurvature::BoardCurvature(const Board& board, double bend_m) {
  // The last feature is diagonally opposite the first, which is the origin.
  center_m_ = board.NominalPoints().back().head<2>() / 2;
  x2_coefficient_ = bend_m / (center_m_.x() * center_m_.x());
  y2_coefficient_ = bend_m / (2 * center_m_.y() * center_m_.y());
}

Board CurveBoard(const Board& board, double bend_m) {
  if (bend_m == 0) return board;
  Board curved_board = board;
  const BoardCurvature curvature(board, bend_m);
  for (Eigen::Vector3d& point : curved_board.points)
    point.z() += curvature.Height(point.x(), point.y());
  return curved_board;
}

}  // namespace raygrid
