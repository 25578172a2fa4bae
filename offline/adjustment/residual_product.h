#ifndef RAYGRID_ADJUSTMENT_RESIDUAL_PRODUCT_H
#define RAYGRID_ADJUSTMENT_RESIDUAL_PRODUCT_H

#include <Eigen/Core>

#include "adjustment/normal_equations.h"

namespace raygrid {

/// u = J x and y += J^T u for one residual, over the layout.
class ResidualProduct {
 public:
  ResidualProduct(const ParameterLayout& layout, const ViewJacobian& jacobian)
      : jacobian_(jacobian),
        first_(layout.first_camera[jacobian.camera]),
        camera_pose_(jacobian.camera > 0 ? layout.CameraPose(jacobian.camera)
                                         : -1),
        place_(jacobian.place >= 0 ? layout.Place(jacobian.place) : -1),
        first_point_(layout.num_points > 0 ? layout.first_point : -1) {}

  Eigen::Vector2d Times(const Eigen::VectorXd& x, int i) const {
    const ViewJacobian& j = jacobian_;
    Eigen::Vector2d u(0, 0);
    if (j.num_per_node == 2)
      u = Nodes<2>(x, i);
    else if (j.num_per_node == 5)
      u = Nodes<5>(x, i);
    else if (j.num_per_node > 0)
      u = Nodes(x, i);
    if (j.num_global > 0)
      u += ViewJacobian::Block(j.by_global, i) *
           x.segment(first_ + j.first_global, j.num_global);
    if (camera_pose_ >= 0)
      u += ViewJacobian::Block<6>(j.by_camera_pose, i) *
           x.segment<6>(camera_pose_);
    if (place_ >= 0)
      u += ViewJacobian::Block<6>(j.by_place, i) * x.segment<6>(place_);
    if (first_point_ >= 0)
      u += ViewJacobian::Block<3>(j.by_point, i) *
           x.segment<3>(first_point_ + 3 * j.points[i]);
    return u;
  }

  void AddTransposed(const Eigen::Vector2d& u, int i,
                     Eigen::VectorXd* y) const {
    const ViewJacobian& j = jacobian_;
    if (j.num_per_node == 2)
      AddNodes<2>(u, i, y);
    else if (j.num_per_node == 5)
      AddNodes<5>(u, i, y);
    else if (j.num_per_node > 0)
      AddNodes(u, i, y);
    if (j.num_global > 0)
      y->segment(first_ + j.first_global, j.num_global) +=
          ViewJacobian::Block(j.by_global, i).transpose() * u;
    if (camera_pose_ >= 0)
      y->segment<6>(camera_pose_) +=
          ViewJacobian::Block<6>(j.by_camera_pose, i).transpose() * u;
    if (place_ >= 0)
      y->segment<6>(place_) +=
          ViewJacobian::Block<6>(j.by_place, i).transpose() * u;
    if (first_point_ >= 0)
      y->segment<3>(first_point_ + 3 * j.points[i]) +=
          ViewJacobian::Block<3>(j.by_point, i).transpose() * u;
  }

 private:
  // The nodes of a spline surface, each a K-vector; those of a row follow each
  // other.
  static constexpr int kNumNodes = 16, kNodesInARow = 4;

  template <int K>
  Eigen::Vector2d Nodes(const Eigen::VectorXd& x, int i) const {
    using Node = Eigen::Matrix<double, K, 1>;
    Node sum = Node::Zero();
    const double* weight = jacobian_.node_weight.col(i).data();
    for (int k = 0; k < kNumNodes; k += kNodesInARow) {
      const double* row = &x[first_ + jacobian_.node_parameter(k, i)];
      for (int n = 0; n < kNodesInARow; ++n)
        sum += weight[k + n] * Eigen::Map<const Node>(row + n * K);
    }
    return ViewJacobian::Block<K>(jacobian_.by_node, i) * sum;
  }
  Eigen::Vector2d Nodes(const Eigen::VectorXd& x, int i) const {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(jacobian_.num_per_node);
    for (int k = 0; k < jacobian_.num_nodes; ++k)
      sum += jacobian_.node_weight(k, i) *
             x.segment(first_ + jacobian_.node_parameter(k, i), sum.size());
    return ViewJacobian::Block(jacobian_.by_node, i) * sum;
  }
  template <int K>
  void AddNodes(const Eigen::Vector2d& u, int i, Eigen::VectorXd* y) const {
    using Node = Eigen::Matrix<double, K, 1>;
    const Node sum =
        ViewJacobian::Block<K>(jacobian_.by_node, i).transpose() * u;
    const double* weight = jacobian_.node_weight.col(i).data();
    for (int k = 0; k < kNumNodes; k += kNodesInARow) {
      double* row = &(*y)[first_ + jacobian_.node_parameter(k, i)];
      for (int n = 0; n < kNodesInARow; ++n)
        Eigen::Map<Node>(row + n * K) += weight[k + n] * sum;
    }
  }
  void AddNodes(const Eigen::Vector2d& u, int i, Eigen::VectorXd* y) const {
    const Eigen::VectorXd sum =
        ViewJacobian::Block(jacobian_.by_node, i).transpose() * u;
    for (int k = 0; k < jacobian_.num_nodes; ++k)
      y->segment(first_ + jacobian_.node_parameter(k, i), sum.size()) +=
          jacobian_.node_weight(k, i) * sum;
  }

  const ViewJacobian& jacobian_;
  int first_, camera_pose_, place_, first_point_;
};

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_RESIDUAL_PRODUCT_H
