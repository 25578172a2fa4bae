#include "calibration/rig_uncertainty.h"

#include <algorithm>
#include <cmath>

#include "adjustment/group_jackknife.h"
#include "calibration/rig_initialization.h"

namespace raygrid {
namespace {

std::vector<Pose> WithUpdate(std::vector<Pose> camera_from_rig, int parameter,
                             double step) {
  Eigen::Matrix<double, 6, 1> update = Eigen::Matrix<double, 6, 1>::Zero();
  update[parameter % 6] = step;
  Pose& pose = camera_from_rig[1 + parameter / 6];
  pose = UpdatedPose(pose, update);
  return camera_from_rig;
}

// Returns the Jacobian of the distance and rotation between two cameras (four
// rows) with respect to the pose parameters.
Eigen::MatrixXd ComputeJacobianOfBaseline(
    const std::vector<Pose>& camera_from_rig, const Baseline& baseline,
    int num_parameters) {
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

// Returns the Jacobian of the baselines, four rows each, with respect to the
// poses of all cameras but the first.
Eigen::MatrixXd ComputeJacobianOfBaselines(
    const std::vector<Pose>& camera_from_rig,
    const std::vector<Baseline>& baselines) {
  const int count = 6 * (static_cast<int>(camera_from_rig.size()) - 1);
  Eigen::MatrixXd rows(4 * baselines.size(), count);
  for (size_t b = 0; b < baselines.size(); ++b)
    rows.middleRows<4>(4 * static_cast<Eigen::Index>(b)) =
        ComputeJacobianOfBaseline(camera_from_rig, baselines[b], count);
  return rows;
}

// Adds the standard deviations of the baselines; leaves them empty if the
// equations are singular.
void AddDeviations(const AdjustmentResult& adjusted, AdjustmentOptions options,
                   std::vector<Baseline>* baselines) {
  options.fix_points = !HavePointsMoved(adjusted);
  const LinearResponse response(adjusted.problem.views, adjusted.prior, options,
                                adjusted.state);
  const Eigen::MatrixXd by_poses =
      ComputeJacobianOfBaselines(adjusted.state.camera_from_rig, *baselines);
  const int first = response.layout().CameraPose(1);
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(response.layout().num_all(),
                                                by_poses.rows()),
                  x;
  right.middleRows(first, by_poses.cols()) = by_poses.transpose();
  if (!response.Solve(right, &x)) return;
  const double noise_px = adjusted.summary.noise_px;
  const GroupJackknife jackknife(response, adjusted.problem.views,
                                 adjusted.prior, options, adjusted.state,
                                 noise_px);
  const auto variance_of = [&](Eigen::Index row) {
    const double white = noise_px * noise_px * x.col(row).dot(right.col(row));
    if (!jackknife.IsValid()) return white;
    return white *
           VarianceFactors(jackknife.Of(first, by_poses.row(row))).of_all;
  };
  for (size_t b = 0; b < baselines->size(); ++b) {
    const auto row = 4 * static_cast<Eigen::Index>(b);
    (*baselines)[b].distance_sd_m = std::sqrt(variance_of(row));
    (*baselines)[b].rotation_sd_rad = std::sqrt(
        variance_of(row + 1) + variance_of(row + 2) + variance_of(row + 3));
  }
}

}  // namespace

std::vector<Baseline> EstimateBaselines(const AdjustmentResult& adjusted,
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
