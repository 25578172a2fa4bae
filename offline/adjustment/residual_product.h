#ifndef RAYGRID_ADJUSTMENT_RESIDUAL_PRODUCT_H
#define RAYGRID_ADJUSTMENT_RESIDUAL_PRODUCT_H

#include <Eigen/Core>

#include "adjustment/normal_equations.h"

namespace raygrid {

/// Columns of as many vectors, which a product takes at once; a vector's number
/// stands beside those of the others.
template <int kNum>
using Columns = Eigen::Matrix<double, Eigen::Dynamic, kNum,
                              kNum == 1 ? Eigen::ColMajor : Eigen::RowMajor>;

/// u = J x and y += J^T u for one residual, of a few vectors, over a layout
/// without bends that boards have in all views (ShapeMoves::moved()).
class ResidualProduct {
 public:
  ResidualProduct(const ParameterLayout& layout, const ViewJacobian& jacobian)
      : jacobian_(jacobian),
        first_(layout.first_camera[jacobian.camera]),
        camera_pose_(jacobian.camera > 0 ? layout.CameraPose(jacobian.camera)
                                         : -1),
        place_(jacobian.place >= 0 ? layout.Place(jacobian.place) : -1),
        first_point_(layout.num_points > 0 ? layout.first_point : -1) {}

  template <int kNum>
  Eigen::Matrix<double, 2, kNum> Times(const Columns<kNum>& x, int i) const {
    const ViewJacobian& j = jacobian_;
    Eigen::Matrix<double, 2, kNum> u = Eigen::Matrix<double, 2, kNum>::Zero();
    WithNumPerNode(j.num_per_node, [&](auto per_node) {
      if constexpr (per_node == 0)
        u = AnyNodes(x, i);
      else
        u = Nodes<per_node>(x, i);
    });
    if (j.num_global > 0)
      u += ViewJacobian::Block(j.by_global, i) *
           x.middleRows(first_ + j.first_global, j.num_global);
    if (camera_pose_ >= 0)
      u += ViewJacobian::Block<6>(j.by_camera_pose, i) *
           x.template middleRows<6>(camera_pose_);
    if (place_ >= 0)
      u += ViewJacobian::Block<6>(j.by_place, i) *
           x.template middleRows<6>(place_);
    if (first_point_ >= 0)
      u += ViewJacobian::Block<3>(j.by_point, i) *
           x.template middleRows<3>(first_point_ + 3 * j.points[i]);
    return u;
  }

  template <int kNum>
  void AddTransposed(const Eigen::Matrix<double, 2, kNum>& u, int i,
                     Columns<kNum>* y) const {
    const ViewJacobian& j = jacobian_;
    WithNumPerNode(j.num_per_node, [&](auto per_node) {
      if constexpr (per_node == 0)
        AddAnyNodes(u, i, y);
      else
        AddNodes<per_node>(u, i, y);
    });
    if (j.num_global > 0)
      y->middleRows(first_ + j.first_global, j.num_global) +=
          ViewJacobian::Block(j.by_global, i).transpose() * u;
    if (camera_pose_ >= 0)
      y->template middleRows<6>(camera_pose_) +=
          ViewJacobian::Block<6>(j.by_camera_pose, i).transpose() * u;
    if (place_ >= 0)
      y->template middleRows<6>(place_) +=
          ViewJacobian::Block<6>(j.by_place, i).transpose() * u;
    if (first_point_ >= 0)
      y->template middleRows<3>(first_point_ + 3 * j.points[i]) +=
          ViewJacobian::Block<3>(j.by_point, i).transpose() * u;
  }

 private:
  // The nodes of a spline surface, each a K-vector; those of a row follow each
  // other.
  static constexpr int kNumNodes = 16, kNodesInARow = 4;

  // Numbers of K parameters that follow each other.
  template <int K, int kNum>
  using Node = Eigen::Matrix<double, K, kNum,
                             kNum == 1 ? Eigen::ColMajor : Eigen::RowMajor>;

  template <int K, int kNum>
  Eigen::Matrix<double, 2, kNum> Nodes(const Columns<kNum>& x, int i) const {
    Node<K, kNum> sum = Node<K, kNum>::Zero();
    const double* weight = jacobian_.node_weight.col(i).data();
    for (int k = 0; k < kNumNodes; k += kNodesInARow) {
      const double* row =
          x.data() + kNum * (first_ + jacobian_.node_parameter(k, i));
      for (int n = 0; n < kNodesInARow; ++n)
        sum +=
            weight[k + n] * Eigen::Map<const Node<K, kNum>>(row + n * K * kNum);
    }
    return ViewJacobian::Block<K>(jacobian_.by_node, i) * sum;
  }
  template <int kNum>
  Eigen::Matrix<double, 2, kNum> AnyNodes(const Columns<kNum>& x, int i) const {
    Columns<kNum> sum = Columns<kNum>::Zero(jacobian_.num_per_node, kNum);
    for (int k = 0; k < jacobian_.num_nodes; ++k)
      sum += jacobian_.node_weight(k, i) *
             x.middleRows(first_ + jacobian_.node_parameter(k, i), sum.rows());
    return ViewJacobian::Block(jacobian_.by_node, i) * sum;
  }
  template <int K, int kNum>
  void AddNodes(const Eigen::Matrix<double, 2, kNum>& u, int i,
                Columns<kNum>* y) const {
    const Node<K, kNum> sum =
        ViewJacobian::Block<K>(jacobian_.by_node, i).transpose() * u;
    const double* weight = jacobian_.node_weight.col(i).data();
    for (int k = 0; k < kNumNodes; k += kNodesInARow) {
      double* row =
          y->data() + kNum * (first_ + jacobian_.node_parameter(k, i));
      for (int n = 0; n < kNodesInARow; ++n)
        Eigen::Map<Node<K, kNum>>(row + n * K * kNum) += weight[k + n] * sum;
    }
  }
  template <int kNum>
  void AddAnyNodes(const Eigen::Matrix<double, 2, kNum>& u, int i,
                   Columns<kNum>* y) const {
    const Columns<kNum> sum =
        ViewJacobian::Block(jacobian_.by_node, i).transpose() * u;
    for (int k = 0; k < jacobian_.num_nodes; ++k)
      y->middleRows(first_ + jacobian_.node_parameter(k, i), sum.rows()) +=
          jacobian_.node_weight(k, i) * sum;
  }

  const ViewJacobian& jacobian_;
  int first_, camera_pose_, place_, first_point_;
};

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_RESIDUAL_PRODUCT_H
