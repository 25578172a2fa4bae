#ifndef RAYGRID_ADJUSTMENT_STATIC_DEFORMATION_H
#define RAYGRID_ADJUSTMENT_STATIC_DEFORMATION_H

#include <Eigen/Core>
#include <vector>

#include "adjustment/coarse_basis.h"
#include "adjustment/deformation_modes.h"
#include "adjustment/normal_equations.h"

namespace raygrid {

/// Static deformation as displacements T of the points. A residual depends on
/// it only through its point, so its Jacobian over a layout is J = J' T, where
/// J' is over cameras, poses and all points. Normal equations are summed over
/// J', and transformed to the layout once.
class StaticDeformation {
 public:
  StaticDeformation(const ParameterLayout& layout,
                    const DeformationModes& modes);

  /// The layout of J': without static deformation, with all points. Equals the
  /// layout if that has no static deformation.
  const ParameterLayout& moved() const { return moved_; }

  /// Returns T x: rows of the layout (before the poses) to rows of moved().
  template <typename Matrix>
  Matrix MapToPoints(const Matrix& x) const {
    if (boards_.empty()) return x;
    Matrix y = Matrix::Zero(moved_.size, x.cols());
    y.topRows(layout_.first_shape) = x.topRows(layout_.first_shape);
    if (layout_.num_points > 0)
      y.bottomRows(NumCoordinates()) = x.bottomRows(NumCoordinates());
    for (const Board& board : boards_)
      y.middleRows(moved_.first_point + board.first, board.modes.rows())
          .noalias() +=
          board.modes * x.middleRows(board.shape, board.modes.cols());
    return y;
  }
  /// Returns T times a basis of the layout.
  CoarseBasis MapToPoints(const CoarseBasis& basis) const;

  /// Returns T^T y: from rows of moved() to rows of the layout.
  template <typename Matrix>
  Matrix MapToModes(const Matrix& y) const {
    if (boards_.empty()) return y;
    Matrix x(layout_.size, y.cols());
    x.topRows(layout_.first_shape) = y.topRows(layout_.first_shape);
    x.middleRows(layout_.first_shape, NumModes()) =
        ComputeModeGradient(y.bottomRows(NumCoordinates()));
    if (layout_.num_points > 0)
      x.bottomRows(NumCoordinates()) = y.bottomRows(NumCoordinates());
    return x;
  }

  /// Returns the deformation's rows of T^T y, from the points' rows of y.
  template <typename Derived>
  Eigen::MatrixXd ComputeModeGradient(
      const Eigen::MatrixBase<Derived>& y) const {
    Eigen::MatrixXd bends = Eigen::MatrixXd::Zero(NumModes(), y.cols());
    for (const Board& board : boards_)
      bends.middleRows(board.shape - layout_.first_shape, board.modes.cols())
          .noalias() = board.modes.transpose() *
                       y.middleRows(board.first, board.modes.rows());
    return bends;
  }

  /// Calls body(point, first, move) for the points of each board: first is the
  /// index of the board's first coefficient in the layout, move the
  /// displacement per unit of each coefficient (3 x N).
  template <typename Body>
  void ForEachPoint(const Body& body) const {
    for (const Board& board : boards_)
      for (int i = 0; i < board.modes.rows(); i += 3)
        body((board.first + i) / 3, board.shape - layout_.first_shape,
             board.modes.template middleRows<3>(i));
  }

  int NumModes() const { return layout_.first_point - layout_.first_shape; }

 private:
  // The index of a board's coefficients in the layout, and the Jacobian of its
  // points' coordinates, beginning with the board's first point.
  struct Board {
    int shape, first;
    Eigen::MatrixXd modes;
  };
  int NumCoordinates() const { return 3 * moved_.num_points; }

  ParameterLayout layout_, moved_;
  std::vector<Board> boards_;  // empty without static deformation
};

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_STATIC_DEFORMATION_H
