#ifndef RAYGRID_ADJUSTMENT_VIEW_JACOBIAN_H
#define RAYGRID_ADJUSTMENT_VIEW_JACOBIAN_H

#include <Eigen/Core>
#include <type_traits>
#include <vector>

#include "adjustment/reprojection_error.h"

namespace raygrid {

/// The valid residuals of a view with their derivatives, all times the square
/// root of the loss's weight. A column an observation; its derivative by k
/// parameters is a column of 2 k numbers.
struct ViewJacobian {
  int camera = 0, pose = 0, place = -1;
  /// The numbers and places of parameters, as in LinearizedProjection.
  int num_nodes = 0, num_per_node = 0, num_global = 0, first_global = 0;

  std::vector<int> points;
  Eigen::MatrixXi node_parameter;
  Eigen::MatrixXd node_weight, by_node, by_global;
  Eigen::Matrix<double, 12, Eigen::Dynamic> by_camera_pose, by_place;
  /// By the board's pose and its flex there: a row a parameter, two columns an
  /// observation.
  Eigen::MatrixXd by_pose;
  Eigen::Matrix<double, 6, Eigen::Dynamic> by_point;
  Eigen::Matrix2Xd error;

  auto ByPose(int column) const { return by_pose.middleCols<2>(2 * column); }

  int count() const { return static_cast<int>(points.size()); }

  /// A column's derivative, 2 x N.
  template <int N, typename Derivatives>
  static Eigen::Map<const Eigen::Matrix<double, 2, N>> Block(
      const Derivatives& derivatives, int column) {
    return Eigen::Map<const Eigen::Matrix<double, 2, N>>(
        derivatives.col(column).data());
  }
  /// A column of derivatives as a matrix of a size known at run time.
  static Eigen::Map<const Eigen::Matrix2Xd> Block(
      const Eigen::MatrixXd& derivatives, int column) {
    return {derivatives.col(column).data(), 2, derivatives.rows() / 2};
  }
};

/// The weighted Jacobian of the residuals of one view.
ViewJacobian WeightedJacobian(const std::vector<LinearizedResidual>& residuals,
                              double huber_px);

/// The weighted Jacobian of each view. Same result for any number of threads.
std::vector<ViewJacobian> WeightedJacobians(const AdjustmentState& state,
                                            const std::vector<View>& views,
                                            double huber_px, int num_threads);

/// Calls a body with a node's number of parameters as a constant that the
/// compiler knows: those of central and non-central grids and of most stacks; 0
/// for others. Without nodes it is not called.
template <typename Body>
void WithNumPerNode(int num_per_node, const Body& body) {
  switch (num_per_node) {
    case 0:
      return;
    case 2:
      return body(std::integral_constant<int, 2>());
    case 4:
      return body(std::integral_constant<int, 4>());
    case 5:
      return body(std::integral_constant<int, 5>());
    case 6:
      return body(std::integral_constant<int, 6>());
    case 8:
      return body(std::integral_constant<int, 8>());
    case 10:
      return body(std::integral_constant<int, 10>());
    default:
      return body(std::integral_constant<int, 0>());
  }
}

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_VIEW_JACOBIAN_H
