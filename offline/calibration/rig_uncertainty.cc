#include "calibration/rig_uncertainty.h"

#include <algorithm>
#include <cmath>

#include "adjustment/normal_equations.h"
#include "calibration/rig_start.h"

namespace raygrid {
namespace {

// The covariance of the poses of all cameras but the first, in units of the
// residuals' variance; empty if the equations are singular.
Eigen::MatrixXd PoseCovariance(const Adjusted& adjusted,
                               const AdjustmentOptions& options) {
  const AdjustmentState& state = adjusted.state;
  const FixedParameters fixed = {false, !HavePointsMoved(adjusted)};
  const ParameterLayout layout(state, fixed);
  const int first = layout.CameraPose(1);
  const int count = layout.first_place - first;
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(layout.size, count);
  right.middleRows(first, count).setIdentity();
  EquationsBuilder builder(adjusted.problem.views, options.huber_px,
                           options.num_threads);
  Eigen::MatrixXd solution;
  if (!builder.Build(adjusted.prior, fixed, state)
           ->SolveFor(0, right, &solution))
    return {};
  return solution.middleRows(first, count);
}

std::vector<Pose> WithUpdate(std::vector<Pose> camera_from_rig, int parameter,
                             double step) {
  Eigen::Matrix<double, 6, 1> update = Eigen::Matrix<double, 6, 1>::Zero();
  update[parameter % 6] = step;
  Pose& pose = camera_from_rig[1 + parameter / 6];
  pose = UpdatedPose(pose, update);
  return camera_from_rig;
}

// Distance and rotation of two cameras by the poses' parameters, in four rows.
Eigen::MatrixXd ByPoses(const std::vector<Pose>& camera_from_rig,
                        const Baseline& baseline, int num_parameters) {
  constexpr double kStep = 1e-5;
  Eigen::MatrixXd derivative(4, num_parameters);
  for (int k = 0; k < num_parameters; ++k) {
    Pose relative[2];
    for (int side = 0; side < 2; ++side) {
      const std::vector<Pose> changed =
          WithUpdate(camera_from_rig, k, side == 0 ? kStep : -kStep);
      relative[side] =
          changed[baseline.second] * changed[baseline.first].Inverse();
    }
    Eigen::Quaterniond turn =
        relative[0].rotation * relative[1].rotation.conjugate();
    if (turn.w() < 0) turn.coeffs() = -turn.coeffs();
    derivative(0, k) =
        relative[0].translation.norm() - relative[1].translation.norm();
    derivative.col(k).tail<3>() = 2 * turn.vec();
  }
  return derivative / (2 * kStep);
}

// Leaves the deviations empty if the equations are singular.
void AddDeviations(const Adjusted& adjusted, const AdjustmentOptions& options,
                   std::vector<Baseline>* baselines) {
  const AdjustmentState& state = adjusted.state;
  const Eigen::MatrixXd covariance = PoseCovariance(adjusted, options);
  if (covariance.size() == 0) return;
  const double variance = ResidualVariance(
      ComputeResiduals(state, adjusted.problem.views, options.num_threads),
      options.huber_px, 6 * static_cast<double>(state.rig_from_pattern.size()));
  for (Baseline& baseline : *baselines) {
    const Eigen::MatrixXd derivative = ByPoses(
        state.camera_from_rig, baseline, static_cast<int>(covariance.cols()));
    const Eigen::Vector4d variances =
        variance *
        (derivative * covariance * derivative.transpose()).diagonal();
    baseline.distance_sd_m = std::sqrt(std::max(variances[0], 0.0));
    baseline.rotation_sd_rad =
        std::sqrt(std::max(variances.tail<3>().sum(), 0.0));
  }
}

}  // namespace

std::vector<Baseline> MeasureBaselines(const Adjusted& adjusted,
                                       const AdjustmentOptions& options) {
  std::vector<Baseline> baselines =
      ComputeBaselines(adjusted.state.camera_from_rig);
  if (baselines.empty()) return baselines;
  const auto num_shared = CountSharedViews(adjusted.problem);
  for (Baseline& baseline : baselines)
    baseline.num_shared_views = num_shared[baseline.first][baseline.second];
  AddDeviations(adjusted, options, &baselines);
  return baselines;
}

}  // namespace raygrid
