#include "adjustment/view_jacobian.h"

#include <algorithm>
#include <cmath>

#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

template <typename Derived>
Eigen::Map<const Eigen::VectorXd> Flat(
    const Eigen::PlainObjectBase<Derived>& matrix, Eigen::Index columns) {
  return {matrix.data(), 2 * columns};
}

void Resize(const LinearizedResidual& like, int count, ViewJacobian* jacobian) {
  const LinearizedProjection& projection = like.projection;
  jacobian->camera = like.camera;
  jacobian->pose = like.pose;
  jacobian->place = like.place;
  jacobian->num_nodes = projection.num_nodes;
  jacobian->num_per_node = projection.num_per_node;
  jacobian->num_global = projection.num_global;
  jacobian->first_global = projection.first_global;
  jacobian->node_parameter.resize(projection.num_nodes, count);
  jacobian->node_weight.resize(projection.num_nodes, count);
  jacobian->J_node.resize(2 * projection.num_per_node, count);
  jacobian->J_global.resize(2 * projection.num_global, count);
  jacobian->J_camera_pose.resize(12, like.camera > 0 ? count : 0);
  jacobian->J_board_pose.resize(12, like.place >= 0 ? count : 0);
  jacobian->J_pose.resize(6 + like.J_deformation.cols(), 2 * count);
  jacobian->J_point.resize(6, count);
  jacobian->error.resize(2, count);
}

void SetColumn(const LinearizedResidual& r, double root, int column,
               ViewJacobian* jacobian) {
  const LinearizedProjection& projection = r.projection;
  for (int k = 0; k < projection.num_nodes; ++k) {
    jacobian->node_parameter(k, column) = projection.node_parameter[k];
    jacobian->node_weight(k, column) = projection.node_weight[k];
  }
  jacobian->J_node.col(column) =
      root * Flat(projection.J_node, projection.num_per_node);
  jacobian->J_global.col(column) =
      root * Flat(projection.J_global, projection.num_global);
  if (r.camera > 0)
    jacobian->J_camera_pose.col(column) = root * Flat(r.J_camera_pose, 6);
  if (r.place >= 0)
    jacobian->J_board_pose.col(column) = root * Flat(r.J_board_pose, 6);
  auto J_pose = jacobian->J_pose.middleCols<2>(2 * column);
  J_pose.topRows<6>() = root * r.J_pose.transpose();
  J_pose.bottomRows(r.J_deformation.cols()) =
      root * r.J_deformation.transpose();
  jacobian->J_point.col(column) = root * Flat(r.J_point, 3);
  jacobian->error.col(column) = root * r.residual.error_px;
}

}  // namespace

ViewJacobian WeightedJacobian(const std::vector<LinearizedResidual>& residuals,
                              double huber_px) {
  const auto is_valid = [](const auto& r) { return r.residual.valid; };
  const auto first = std::find_if(residuals.begin(), residuals.end(), is_valid);
  ViewJacobian jacobian;
  if (first == residuals.end()) {
    Resize(LinearizedResidual(), 0, &jacobian);
    return jacobian;
  }
  Resize(*first,
         static_cast<int>(std::count_if(first, residuals.end(), is_valid)),
         &jacobian);
  for (const LinearizedResidual& r : residuals) {
    if (!r.residual.valid) continue;
    SetColumn(r, std::sqrt(HuberWeight(r.residual.error_px.norm(), huber_px)),
              jacobian.count(), &jacobian);
    jacobian.points.push_back(r.point);
  }
  return jacobian;
}

std::vector<ViewJacobian> WeightedJacobians(const AdjustmentState& state,
                                            const std::vector<View>& views,
                                            double huber_px, int num_threads) {
  std::vector<ViewJacobian> jacobians(views.size());
  ParallelFor(static_cast<int>(views.size()), num_threads, [&](int v) {
    jacobians[v] = WeightedJacobian(LinearizeView(state, views[v]), huber_px);
  });
  return jacobians;
}

}  // namespace raygrid
