#ifndef RAYGRID_ADJUSTMENT_VIEW_JACOBIAN_H
#define RAYGRID_ADJUSTMENT_VIEW_JACOBIAN_H

#include <Eigen/Core>
#include <type_traits>
#include <vector>

#include "adjustment/reprojection_error.h"

namespace raygrid {

/// The valid residuals of a view and their Jacobians, all scaled by the square
/// root of the Huber weight. One column per observation; the Jacobian for k
/// parameters is a column of 2 k numbers.
struct ViewJacobian {
  int camera = 0, pose = 0, place = -1;
  /// Counts and indices of parameters, as in LinearizedProjection.
  int num_nodes = 0, num_per_node = 0, num_global = 0, first_global = 0;

  std::vector<int> points;
  Eigen::MatrixXi node_parameter;
  Eigen::MatrixXd node_weight, J_node, J_global;
  Eigen::Matrix<double, 12, Eigen::Dynamic> J_camera_pose, J_board_pose;
  /// J_pose, with the per-view deformation: one row per parameter, two columns
  /// per observation.
  Eigen::MatrixXd J_pose;
  Eigen::Matrix<double, 6, Eigen::Dynamic> J_point;
  Eigen::Matrix2Xd error;

  auto PoseJacobian(int column) const {
    return J_pose.middleCols<2>(2 * column);
  }

  int count() const { return static_cast<int>(points.size()); }

  /// Returns the Jacobian in a column, 2 x N.
  template <int N, typename Derivatives>
  static Eigen::Map<const Eigen::Matrix<double, 2, N>> Block(
      const Derivatives& derivatives, int column) {
    return Eigen::Map<const Eigen::Matrix<double, 2, N>>(
        derivatives.col(column).data());
  }
  /// Returns the Jacobian in a column, with N as an argument.
  static Eigen::Map<const Eigen::Matrix2Xd> Block(
      const Eigen::MatrixXd& derivatives, int column) {
    return {derivatives.col(column).data(), 2, derivatives.rows() / 2};
  }
};

/// Computes the weighted Jacobian of the residuals of one view.
ViewJacobian WeightedJacobian(const std::vector<LinearizedResidual>& residuals,
                              double huber_px);

/// Computes the weighted Jacobian of each view; deterministic with threads.
std::vector<ViewJacobian> WeightedJacobians(const AdjustmentState& state,
                                            const std::vector<View>& views,
                                            double huber_px, int num_threads);

/// Calls body with a control point's number of parameters as a compile-time
/// constant: for central and non-central grids and most operating-point models;
/// 0 for others. Not called without control points.
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
