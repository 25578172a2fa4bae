#ifndef RAYGRID_ADJUSTMENT_RESIDUAL_PRODUCT_H
#define RAYGRID_ADJUSTMENT_RESIDUAL_PRODUCT_H

#include <Eigen/Core>
#include <algorithm>

#include "adjustment/normal_equations.h"

namespace raygrid {

/// kNum column vectors for one product; the entries of one row are adjacent in
/// memory.
template <int kNum>
using Columns = Eigen::Matrix<double, Eigen::Dynamic, kNum,
                              kNum == 1 ? Eigen::ColMajor : Eigen::RowMajor>;

/// The two coordinates of a residual for kNum vectors.
template <int kNum>
using Pairs = Eigen::Matrix<double, 2, kNum,
                            kNum == 1 ? Eigen::ColMajor : Eigen::RowMajor>;

/// Computes u = J x and y += J^T u for one residual and a few vectors, over a
/// layout without static deformation (StaticDeformation::moved()). Loops over
/// scalars, because compiling products of small fixed-size matrices takes
/// minutes.
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
  Pairs<kNum> Times(const Columns<kNum>& x, int i) const {
    const ViewJacobian& j = jacobian_;
    Pairs<kNum> u = Pairs<kNum>::Zero();
    WithNumPerNode(j.num_per_node, [&](auto per_node) {
      const int size = kNum * (per_node > 0 ? per_node : j.num_per_node);
      double sum[kNum * LinearizedProjection::kMaxPerNode];
      std::fill_n(sum, size, 0.0);
      for (int k = 0; k < j.num_nodes; ++k) {
        const double* node = At<kNum>(x, first_ + j.node_parameter(k, i));
        const double weight = j.node_weight(k, i);
        for (int n = 0; n < size; ++n) sum[n] += weight * node[n];
      }
      AddTimes<kNum>(j.J_node, i, sum, &u);
    });
    ForEachOther(i, [&](const auto& derivatives, int first) {
      AddTimes<kNum>(derivatives, i, At<kNum>(x, first), &u);
    });
    return u;
  }

  template <int kNum>
  void AddTransposed(const Pairs<kNum>& u, int i, Columns<kNum>* y) const {
    const ViewJacobian& j = jacobian_;
    WithNumPerNode(j.num_per_node, [&](auto per_node) {
      const int size = kNum * (per_node > 0 ? per_node : j.num_per_node);
      double sum[kNum * LinearizedProjection::kMaxPerNode];
      std::fill_n(sum, size, 0.0);
      AddTransposedTimes<kNum>(j.J_node, i, u, sum);
      for (int k = 0; k < j.num_nodes; ++k) {
        double* node = At<kNum>(*y, first_ + j.node_parameter(k, i));
        const double weight = j.node_weight(k, i);
        for (int n = 0; n < size; ++n) node[n] += weight * sum[n];
      }
    });
    ForEachOther(i, [&](const auto& derivatives, int first) {
      AddTransposedTimes<kNum>(derivatives, i, u, At<kNum>(*y, first));
    });
  }

 private:
  // Returns the entries of a parameter and the following ones.
  template <int kNum>
  static const double* At(const Columns<kNum>& x, int parameter) {
    return x.data() + static_cast<Eigen::Index>(kNum) * parameter;
  }
  template <int kNum>
  static double* At(Columns<kNum>& y, int parameter) {
    return y.data() + static_cast<Eigen::Index>(kNum) * parameter;
  }

  // Calls body with each Jacobian except the control points' Jacobian, and with
  // the index of its first parameter.
  template <typename Body>
  void ForEachOther(int i, const Body& body) const {
    const ViewJacobian& j = jacobian_;
    if (j.num_global > 0) body(j.J_global, first_ + j.first_global);
    if (camera_pose_ >= 0) body(j.J_camera_pose, camera_pose_);
    if (place_ >= 0) body(j.J_board_pose, place_);
    if (first_point_ >= 0) body(j.J_point, first_point_ + 3 * j.points[i]);
  }

  // *u += D x, where column i of derivatives is column i of D.
  template <int kNum, typename Derivatives>
  static void AddTimes(const Derivatives& derivatives, int i, const double* x,
                       Pairs<kNum>* u) {
    const double* d = derivatives.col(i).data();
    double top[kNum] = {}, bottom[kNum] = {};
    for (Eigen::Index k = 0; k < derivatives.rows() / 2; ++k)
      for (int n = 0; n < kNum; ++n) {
        top[n] += d[2 * k] * x[k * kNum + n];
        bottom[n] += d[2 * k + 1] * x[k * kNum + n];
      }
    for (int n = 0; n < kNum; ++n) {
      (*u)(0, n) += top[n];
      (*u)(1, n) += bottom[n];
    }
  }

  // y += D^T u
  template <int kNum, typename Derivatives>
  static void AddTransposedTimes(const Derivatives& derivatives, int i,
                                 const Pairs<kNum>& u, double* y) {
    const double* d = derivatives.col(i).data();
    for (Eigen::Index k = 0; k < derivatives.rows() / 2; ++k)
      for (int n = 0; n < kNum; ++n)
        y[k * kNum + n] += d[2 * k] * u(0, n) + d[2 * k + 1] * u(1, n);
  }

  const ViewJacobian& jacobian_;
  int first_, camera_pose_, place_, first_point_;
};

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_RESIDUAL_PRODUCT_H
