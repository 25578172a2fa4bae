#include "calibration/deformation_share.h"

#include <Eigen/Cholesky>
#include <vector>

#include "adjustment/view_jacobian.h"

namespace raygrid {
namespace {

// Gauss-Newton equations of a pose and of its board's per-view deformation.
struct PoseDeformationEquations {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd gradient;
  double squares = 0;
  int num_features = 0;
};

// Returns the reduction of the sum of squared residuals by a Gauss-Newton step
// in the first `count` parameters.
double ComputeCostDecrease(const PoseDeformationEquations& equations,
                           Eigen::Index count) {
  const Eigen::VectorXd gradient = equations.gradient.head(count);
  return gradient.dot(
      equations.matrix.topLeftCorner(count, count).ldlt().solve(gradient));
}

}  // namespace

double ComputeDeformationShare(const AdjustmentResult& adjusted,
                               int num_threads) {
  AdjustmentState state = adjusted.state;
  state.ApplyStaticDeformation();
  state.SetModes(GetDeformationModes(adjusted.problem),
                 DeformationScope::kPose);
  const Eigen::Index size = 6 + state.modes.count();
  std::vector<PoseDeformationEquations> poses(
      state.rig_from_pattern.size(),
      {Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size)});
  for (const ViewJacobian& jacobian :
       WeightedJacobians(state, adjusted.problem.views,
                         AdjustmentOptions().huber_px, num_threads)) {
    if (jacobian.count() == 0) continue;
    PoseDeformationEquations& pose = poses[jacobian.pose];
    pose.matrix.noalias() += jacobian.J_pose * jacobian.J_pose.transpose();
    pose.gradient.noalias() += jacobian.J_pose * jacobian.error.reshaped();
    pose.squares += jacobian.error.squaredNorm();
    pose.num_features += jacobian.count();
  }
  double squares = 0, degrees = 0, taken = 0, num_bends = 0;
  for (const PoseDeformationEquations& pose : poses) {
    // With fewer features, deformation modes would fit noise.
    if (pose.num_features < size) continue;
    squares += pose.squares;
    degrees += 2 * pose.num_features - 6;
    taken += ComputeCostDecrease(pose, size) - ComputeCostDecrease(pose, 6);
    num_bends += static_cast<double>(
        (pose.matrix.diagonal().tail(size - 6).array() > 0).count());
  }
  if (!(degrees > 2 * num_bends)) return 1;  // not observable
  const double noise = (squares - taken) / (degrees - num_bends);
  return squares > 0 ? (taken - num_bends * noise) / squares : 0;
}

}  // namespace raygrid
