#include "calibration/camera_equations.h"

#include <Eigen/Cholesky>

#include "adjustment/view_jacobian.h"

namespace raygrid {
namespace {

// The derivatives of a view's residuals by its camera's parameters: two rows a
// residual.
Eigen::MatrixXd ByCamera(const ViewJacobian& jacobian, int num_parameters) {
  Eigen::MatrixXd by_camera =
      Eigen::MatrixXd::Zero(2 * jacobian.count(), num_parameters);
  for (int i = 0; i < jacobian.count(); ++i) {
    auto rows = by_camera.middleRows<2>(2 * i);
    const auto by_node = ViewJacobian::Block(jacobian.by_node, i);
    for (int node = 0; node < jacobian.num_nodes; ++node)
      rows.middleCols(jacobian.node_parameter(node, i),
                      jacobian.num_per_node) +=
          jacobian.node_weight(node, i) *
          by_node.leftCols(jacobian.num_per_node);
    rows.middleCols(jacobian.first_global, jacobian.num_global) +=
        ViewJacobian::Block(jacobian.by_global, i)
            .leftCols(jacobian.num_global);
  }
  return by_camera;
}

}  // namespace

std::vector<CameraEquations> EquationsByView(const Adjusted& adjusted,
                                             double huber_px, int num_threads) {
  const int num_parameters = adjusted.state.camera().NumParameters();
  const std::vector<View>& views = adjusted.problem.views;
  const std::vector<ViewJacobian> jacobians =
      WeightedJacobians(adjusted.state, views, huber_px, num_threads);
  std::vector<CameraEquations> equations;
  for (size_t v = 0; v < views.size(); ++v) {
    const ViewJacobian& jacobian = jacobians[v];
    if (jacobian.count() == 0) continue;
    Eigen::MatrixXd by_camera = ByCamera(jacobian, num_parameters);
    Eigen::VectorXd error = jacobian.error.reshaped();
    const Eigen::MatrixXd by_pose = jacobian.by_pose.transpose();
    const Eigen::LDLT<Eigen::MatrixXd> pose(by_pose.transpose() * by_pose);
    by_camera -= by_pose * pose.solve(by_pose.transpose() * by_camera);
    error -= by_pose * pose.solve(by_pose.transpose() * error);
    equations.push_back(
        {adjusted.problem.images[v], by_camera.transpose() * by_camera,
         by_camera.transpose() * error, error.squaredNorm(), jacobian.count()});
  }
  return equations;
}

Eigen::VectorXd LeastSquaresChange(Eigen::MatrixXd hessian,
                                   const Eigen::VectorXd& gradient,
                                   double ridge) {
  hessian.diagonal() *= 1 + ridge;
  hessian.diagonal().array() += ridge;
  return -hessian.ldlt().solve(gradient);
}

}  // namespace raygrid
