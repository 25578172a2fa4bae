#include "calibration/rig_uncertainty.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "adjustment/linear_response.h"
#include "adjustment/shared_noise.h"
#include "calibration/rig_start.h"

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

// The baselines by the poses of all cameras but the first, four rows each.
Eigen::MatrixXd AllByPoses(const std::vector<Pose>& camera_from_rig,
                           const std::vector<Baseline>& baselines) {
  const int count = 6 * (static_cast<int>(camera_from_rig.size()) - 1);
  Eigen::MatrixXd rows(4 * baselines.size(), count);
  for (size_t b = 0; b < baselines.size(); ++b)
    rows.middleRows<4>(4 * static_cast<Eigen::Index>(b)) =
        ByPoses(camera_from_rig, baselines[b], count);
  return rows;
}

// The noise of each camera's views, by what it does to the camera's baselines.
std::vector<ObservationNoise> NoiseByCamera(
    const Adjusted& adjusted, const LinearResponse& response,
    const std::vector<Baseline>& baselines, const Eigen::MatrixXd& by_poses) {
  std::vector<ObservationNoise> noise;
  for (size_t c = 0; c < adjusted.state.cameras.size(); ++c) {
    Eigen::MatrixXd moves(0, by_poses.cols());
    for (size_t b = 0; b < baselines.size(); ++b) {
      if (baselines[b].first != c && baselines[b].second != c) continue;
      moves.conservativeResize(moves.rows() + 4, Eigen::NoChange);
      moves.bottomRows<4>() =
          by_poses.middleRows<4>(4 * static_cast<Eigen::Index>(b));
    }
    noise.push_back(MeasureNoise(response, adjusted.state, static_cast<int>(c),
                                 response.layout().CameraPose(1), moves,
                                 adjusted.summary.noise_px));
  }
  return noise;
}

// The variances of what answers to errors of the views so.
class Variances {
 public:
  Variances(const Adjusted& adjusted, const LinearResponse& response,
            const std::vector<ObservationNoise>& noise)
      : response_(response), noise_(noise) {
    for (const ObservationNoise& of_camera : noise)
      for (const ObservationNoise::Shared& part : of_camera.shared)
        if (fields_.count(part.length) == 0)
          fields_[part.length] =
              SmoothFields(response, adjusted.state.points, part.length);
  }

  // The share of the views' noise.
  double OfNoise(const ViewErrors& weights) const {
    double variance = 0;
    for (size_t v = 0; v < weights.size(); ++v) {
      const ObservationNoise& noise = noise_[response_.jacobians()[v].camera];
      variance += noise.own_px * noise.own_px * weights[v].squaredNorm();
      for (const ObservationNoise::Shared& part : noise.shared)
        variance += part.deviation_px * part.deviation_px *
                    fields_.at(part.length)[v].VarianceOf(weights[v]);
    }
    return variance;
  }
  // The share of noise that is white, and of variance 1.
  static double OfWhiteNoise(const ViewErrors& weights) {
    double variance = 0;
    for (const Eigen::Matrix2Xd& of_view : weights)
      variance += of_view.squaredNorm();
    return variance;
  }

 private:
  const LinearResponse& response_;
  const std::vector<ObservationNoise>& noise_;
  std::map<double, std::vector<SmoothField>> fields_;  // by length
};

// Leaves the deviations empty if the equations are singular.
void AddDeviations(const Adjusted& adjusted, AdjustmentOptions options,
                   std::vector<Baseline>* baselines) {
  options.fix_points = !HavePointsMoved(adjusted);
  const LinearResponse response(adjusted.problem.views, adjusted.prior, options,
                                adjusted.state);
  const Eigen::MatrixXd by_poses =
      AllByPoses(adjusted.state.camera_from_rig, *baselines);
  const int first = response.layout().CameraPose(1);
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(response.layout().num_all(),
                                                by_poses.rows()),
                  x;
  right.middleRows(first, by_poses.cols()) = by_poses.transpose();
  if (!response.Solve(right, &x)) return;
  const std::vector<ObservationNoise> noise =
      NoiseByCamera(adjusted, response, *baselines, by_poses);
  const Variances variances(adjusted, response, noise);
  // With H = J^T J + P, the prior's share of H^-1 is what J^T J leaves.
  const double white_px2 = std::pow(adjusted.summary.noise_px, 2);
  const auto variance_of = [&](Eigen::Index row) {
    const ViewErrors weights = response.ErrorsBy(x.col(row));
    const double inverse = x.col(row).dot(right.col(row));
    return variances.OfNoise(weights) +
           white_px2 *
               std::max(0.0, inverse - Variances::OfWhiteNoise(weights));
  };
  for (size_t b = 0; b < baselines->size(); ++b) {
    const auto row = 4 * static_cast<Eigen::Index>(b);
    (*baselines)[b].distance_sd_m = std::sqrt(variance_of(row));
    (*baselines)[b].rotation_sd_rad = std::sqrt(
        variance_of(row + 1) + variance_of(row + 2) + variance_of(row + 3));
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
