#include "calibration/split_gain.h"

#include <Eigen/Cholesky>

#include "adjustment/view_jacobian.h"

namespace raygrid {
namespace {

constexpr int kMaxParameters = 200;

// Returns the Jacobian of a view's residuals, two rows each, with respect to
// the parameters of its camera.
Eigen::MatrixXd GetCameraBlock(const ViewJacobian& jacobian,
                               int num_parameters) {
  Eigen::MatrixXd by_camera =
      Eigen::MatrixXd::Zero(2 * jacobian.count(), num_parameters);
  for (int i = 0; i < jacobian.count(); ++i) {
    auto rows = by_camera.middleRows<2>(2 * i);
    const auto J_node = ViewJacobian::Block(jacobian.J_node, i);
    for (int node = 0; node < jacobian.num_nodes; ++node)
      rows.middleCols(jacobian.node_parameter(node, i),
                      jacobian.num_per_node) +=
          jacobian.node_weight(node, i) *
          J_node.leftCols(jacobian.num_per_node);
    rows.middleCols(jacobian.first_global, jacobian.num_global) +=
        ViewJacobian::Block(jacobian.J_global, i).leftCols(jacobian.num_global);
  }
  return by_camera;
}

}  // namespace

SplitGain::SplitGain(const AdjustmentResult& joint, double huber_px,
                     int num_threads) {
  const int num_parameters = joint.state.camera().NumParameters();
  if (num_parameters > kMaxParameters) return;
  const std::vector<View>& views = joint.problem.views;
  const std::vector<ViewJacobian> jacobians =
      WeightedJacobians(joint.state, views, huber_px, num_threads);
  for (size_t v = 0; v < views.size(); ++v) {
    const ViewJacobian& jacobian = jacobians[v];
    if (jacobian.count() == 0) continue;
    Eigen::MatrixXd by_camera = GetCameraBlock(jacobian, num_parameters);
    Eigen::VectorXd error = jacobian.error.reshaped();
    squares_ += error.squaredNorm();
    const Eigen::MatrixXd J_pose = jacobian.J_pose.transpose();
    const Eigen::LDLT<Eigen::MatrixXd> pose(J_pose.transpose() * J_pose);
    by_camera -= J_pose * pose.solve(J_pose.transpose() * by_camera);
    error -= J_pose * pose.solve(J_pose.transpose() * error);
    views_.push_back({joint.problem.images[v],
                      by_camera.transpose() * by_camera,
                      by_camera.transpose() * error});
  }
}

double SplitGain::ComputeRemainingShare(
    const std::set<std::string>& first) const {
  constexpr double kRidge = 1e-9;  // regularizes unobservable directions
  if (views_.empty()) return 0;
  const Eigen::Index size = views_.front().gradient.size();
  double gain = 0;
  for (const bool is_first : {true, false}) {
    Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(size, size);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(size);
    for (const ViewTerms& view : views_) {
      if ((first.count(view.image) > 0) != is_first) continue;
      hessian += view.hessian;
      gradient += view.gradient;
    }
    hessian.diagonal() *= 1 + kRidge;
    hessian.diagonal().array() += kRidge;
    gain += gradient.dot(hessian.ldlt().solve(gradient));
  }
  return 1 - gain / squares_;
}

}  // namespace raygrid
