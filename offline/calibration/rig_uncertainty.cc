#include "calibration/rig_uncertainty.h"

#include <algorithm>
#include <cmath>

#include "adjustment/normal_equations.h"

namespace raygrid {
namespace {

// One part in 20 of a deviation is uncertain then.
constexpr int kNumSamples = 256;

// Of a residual's coordinate, with the loss's weights; the poses take up six
// coordinates each.
double ResidualVariance(const std::vector<LinearizedResidual>& residuals,
                        double huber_px, size_t num_poses) {
  double sum = 0, count = 0;
  for (const LinearizedResidual& r : residuals) {
    if (!r.residual.valid) continue;
    const double norm = r.residual.error_px.norm();
    const double weight = HuberWeight(norm, huber_px);
    sum += weight * norm * norm;
    count += 2 * weight;
  }
  return sum / std::max(count - 6 * static_cast<double>(num_poses), 1.0);
}

// False where the prior's strength kept the points as they are; then they were
// no more than aligned.
bool HavePointsMoved(const Adjusted& adjusted) {
  constexpr double kRoundingM = 1e-9;
  for (size_t i = 0; i < adjusted.state.points.size(); ++i)
    if ((adjusted.state.points[i] - adjusted.problem.nominal[i]).norm() >
        kRoundingM)
      return true;
  return false;
}

// camera_from_rig as one of the samples has it.
std::vector<Pose> Sampled(const std::vector<Pose>& camera_from_rig,
                          const Eigen::VectorXd& sample) {
  std::vector<Pose> sampled = camera_from_rig;
  for (size_t c = 1; c < sampled.size(); ++c)
    sampled[c] =
        UpdatedPose(sampled[c], sample.segment<6>(6 * static_cast<int>(c - 1)));
  return sampled;
}

Eigen::Quaterniond Rotation(const std::vector<Pose>& camera_from_rig,
                            const Baseline& baseline) {
  return (camera_from_rig[baseline.second] *
          camera_from_rig[baseline.first].Inverse())
      .rotation;
}

}  // namespace

void AddDeviations(const Adjusted& adjusted, const AdjustmentOptions& options,
                   std::vector<Baseline>* baselines) {
  const AdjustmentState& state = adjusted.state;
  const auto residuals =
      LinearizeResiduals(state, adjusted.problem.views, options.num_threads);
  NormalEquations equations(
      NormalEquations::SizesOf(state, false, !HavePointsMoved(adjusted)),
      options.num_threads);
  equations.AddResiduals(residuals, options.huber_px);
  equations.AddPrior(adjusted.prior, state);
  CovarianceSamples samples;
  if (!equations.SampleCovariance(kNumSamples, &samples)) return;

  const Eigen::MatrixXd changes =
      std::sqrt(ResidualVariance(residuals, options.huber_px,
                                 state.rig_from_pattern.size())) *
      samples.camera_poses;
  std::vector<double> distance(baselines->size()), rotation(baselines->size());
  for (int k = 0; k < kNumSamples; ++k) {
    const std::vector<Pose> sampled =
        Sampled(state.camera_from_rig, changes.col(k));
    const std::vector<Baseline> changed = ComputeBaselines(sampled);
    for (size_t i = 0; i < baselines->size(); ++i) {
      const Baseline& baseline = (*baselines)[i];
      distance[i] += std::pow(changed[i].distance_m - baseline.distance_m, 2);
      rotation[i] += std::pow(
          Rotation(sampled, baseline)
              .angularDistance(Rotation(state.camera_from_rig, baseline)),
          2);
    }
  }
  for (size_t i = 0; i < baselines->size(); ++i) {
    (*baselines)[i].distance_sd_m = std::sqrt(distance[i] / kNumSamples);
    (*baselines)[i].rotation_sd_rad = std::sqrt(rotation[i] / kNumSamples);
  }
}

}  // namespace raygrid
