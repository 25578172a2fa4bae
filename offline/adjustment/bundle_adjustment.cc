#include "adjustment/bundle_adjustment.h"

#include <algorithm>
#include <cmath>

#include "adjustment/normal_equations.h"

namespace raygrid {
namespace {

constexpr double kInitialLambda = 1e-4;
constexpr double kMinLambda = 1e-9, kMaxLambda = 1e8;

AdjustmentState Updated(const AdjustmentState& state,
                        const AdjustmentStep& step) {
  AdjustmentState updated = state;
  for (size_t c = 0; c < step.cameras.size(); ++c)
    updated.cameras[c]->SetParameters(state.cameras[c]->Parameters() +
                                      step.cameras[c]);
  for (size_t c = 0; c < step.camera_poses.size(); ++c)
    updated.camera_from_rig[c + 1] =
        UpdatedPose(state.camera_from_rig[c + 1], step.camera_poses[c]);
  for (Eigen::Index i = 0; i < step.points.size() / 3; ++i)
    updated.points[i] += step.points.segment<3>(3 * i);
  for (size_t i = 0; i < step.poses.size(); ++i)
    updated.rig_from_pattern[i] =
        UpdatedPose(state.rig_from_pattern[i], step.poses[i]);
  return updated;
}

double PriorCost(const GaussianPrior& prior, const AdjustmentState& state,
                 const AdjustmentOptions& options) {
  double cost = 0;
  if (!options.fix_cameras)
    for (size_t c = 0; c < prior.cameras.size(); ++c)
      cost += prior.cameras[c].Cost(state.cameras[c]->Parameters());
  if (!options.fix_points)
    for (size_t i = 0; i < prior.points_mean.size(); ++i)
      cost += prior.points_weight / 2 *
              (state.points[i] - prior.points_mean[i]).squaredNorm();
  return cost;
}

NormalEquations BuildEquations(const std::vector<View>& views,
                               const GaussianPrior& prior,
                               const AdjustmentOptions& options,
                               const AdjustmentState& state) {
  NormalEquations equations(
      NormalEquations::SizesOf(state, options.fix_cameras, options.fix_points),
      options.num_threads);
  equations.AddResiduals(LinearizeResiduals(state, views, options.num_threads),
                         options.huber_px);
  equations.AddPrior(prior, state);
  return equations;
}

double TotalCost(const std::vector<Residual>& residuals, double huber_px) {
  return CompareCosts(residuals, residuals, huber_px).first;
}

// Tries damped steps until one lowers the cost. Returns the relative decrease,
// 0 if none was found.
double TakeStep(const std::vector<View>& views, const GaussianPrior& prior,
                const AdjustmentOptions& options, double* lambda,
                AdjustmentState* state, std::vector<Residual>* residuals) {
  const NormalEquations equations =
      BuildEquations(views, prior, options, *state);
  const double prior_cost = PriorCost(prior, *state, options);
  for (; *lambda < kMaxLambda; *lambda *= 10) {
    AdjustmentStep step;
    if (!equations.Solve(*lambda, &step)) continue;
    AdjustmentState next = Updated(*state, step);
    std::vector<Residual> next_residuals =
        ComputeResiduals(next, views, options.num_threads);
    const ComparableCosts costs =
        CompareCosts(*residuals, next_residuals, options.huber_px);
    const double before = costs.first + prior_cost;
    const double after = costs.second + PriorCost(prior, next, options);
    if (!(after < before) || costs.num_common == 0) continue;
    *state = std::move(next);
    *residuals = std::move(next_residuals);
    *lambda = std::max(*lambda / 10, kMinLambda);
    return (before - after) / before;
  }
  return 0;
}

// ---- Evidence approximation ------------------------------------------------

// Of a group of parameters under the prior: how many of them there are, their
// squared distance from its mean (in K's metric), and the trace of K times
// their covariance in units of the residuals' variance.
struct GroupEvidence {
  double count = 0, squared_distance = 0, trace = 0;

  // The number of parameters that the observations determine.
  double NumDetermined(double weight) const {
    return std::clamp(count - weight * trace, 1e-3 * count, count);
  }
};

// Of each group of each camera.
std::vector<GroupEvidence> CameraEvidence(const GaussianPrior& prior,
                                          const AdjustmentState& state,
                                          const CovarianceSamples& samples) {
  std::vector<GroupEvidence> evidence;
  for (size_t c = 0; c < prior.cameras.size(); ++c) {
    const Eigen::VectorXd difference =
        state.cameras[c]->Parameters() - prior.cameras[c].mean;
    const Eigen::MatrixXd& scatter = samples.cameras[c];
    for (const PriorGroup& group : prior.cameras[c].groups)
      evidence.push_back(
          {static_cast<double>(group.rank), group.SquaredDistance(difference),
           scatter.cwiseProduct(group.precision * scatter).sum() /
               static_cast<double>(scatter.cols())});
  }
  return evidence;
}

GroupEvidence PointsEvidence(const GaussianPrior& prior,
                             const AdjustmentState& state,
                             const CovarianceSamples& samples) {
  GroupEvidence group;
  group.count = 3.0 * static_cast<double>(state.points.size());
  for (size_t i = 0; i < state.points.size(); ++i)
    group.squared_distance +=
        (state.points[i] - prior.points_mean[i]).squaredNorm();
  group.trace =
      samples.points.squaredNorm() / static_cast<double>(samples.points.cols());
  return group;
}

// In the order of CameraEvidence().
std::vector<PriorGroup*> CameraGroups(GaussianPrior* prior) {
  std::vector<PriorGroup*> groups;
  for (CameraPrior& camera : prior->cameras)
    for (PriorGroup& group : camera.groups) groups.push_back(&group);
  return groups;
}

// The variance of a residual's coordinate, with the loss's weights.
double ResidualVariance(const std::vector<Residual>& residuals, double huber_px,
                        double num_parameters) {
  double sum = 0, count = 0;
  for (const Residual& residual : residuals) {
    if (!residual.valid) continue;
    const double norm = residual.error_px.norm();
    const double weight = HuberWeight(norm, huber_px);
    sum += weight * norm * norm;
    count += 2 * weight;
  }
  return sum / std::max(count - num_parameters, 0.1 * count + 1);
}

constexpr double kNegligiblePx = 1e-3;   // smaller departures are no matter
constexpr double kStableChange = 0.05;   // of a weight's logarithm
constexpr double kFewDetermined = 0.02;  // part of a group

// Sets a weight to what the evidence makes of it; the variance of the group's
// parameters is taken for no smaller than smallest_variance. Returns how much
// the weight's logarithm changed.
double UpdateWeight(const GroupEvidence& group, double residual_variance,
                    double smallest_variance, double* weight) {
  const double variance = group.squared_distance / group.NumDetermined(*weight);
  const double updated =
      residual_variance / std::max(variance, smallest_variance);
  const double change = std::abs(std::log(updated / *weight));
  *weight = updated;
  return change;
}

// A point's displacement that moves its image by one pixel, squared, on the
// average over the views.
double SquaredMetresPerPixel(const std::vector<LinearizedResidual>& residuals) {
  double sum = 0;
  int count = 0;
  for (const LinearizedResidual& r : residuals) {
    if (!r.residual.valid) continue;
    sum += r.by_point.squaredNorm() / 2;
    ++count;
  }
  return count > 0 ? count / sum : 1;
}

}  // namespace

AdjustmentSummary AdjustBundle(const std::vector<View>& views,
                               const GaussianPrior& prior,
                               const AdjustmentOptions& options,
                               AdjustmentState* state) {
  AdjustmentSummary summary;
  summary.residuals = ComputeResiduals(*state, views, options.num_threads);
  summary.initial_cost = TotalCost(summary.residuals, options.huber_px);
  double lambda = kInitialLambda;
  while (summary.num_iterations < options.max_iterations &&
         !summary.converged) {
    ++summary.num_iterations;
    const double decrease =
        TakeStep(views, prior, options, &lambda, state, &summary.residuals);
    summary.converged = decrease < options.relative_tolerance;
  }
  summary.final_cost = TotalCost(summary.residuals, options.huber_px);
  return summary;
}

AdjustmentSummary AdjustWithLearnedPrior(const std::vector<View>& views,
                                         const AdjustmentOptions& options,
                                         GaussianPrior* prior,
                                         AdjustmentState* state) {
  constexpr int kMaxRounds = 12, kTraceSamples = 64;
  const double square_metres_per_pixel = SquaredMetresPerPixel(
      LinearizeResiduals(*state, views, options.num_threads));
  // A first guess: residuals, second differences and points all scatter alike.
  const std::vector<PriorGroup*> groups = CameraGroups(prior);
  for (PriorGroup* group : groups)
    if (group->weight == 0) group->weight = 1;
  if (prior->points_weight == 0)
    prior->points_weight = 1 / square_metres_per_pixel;
  AdjustmentOptions rough = options;
  rough.relative_tolerance = 1e-4;
  rough.max_iterations = 10;
  for (int round = 0; round < kMaxRounds; ++round) {
    const AdjustmentSummary summary = AdjustBundle(views, *prior, rough, state);
    const NormalEquations equations =
        BuildEquations(views, *prior, rough, *state);
    CovarianceSamples samples;
    if (!equations.SampleCovariance(kTraceSamples, &samples)) break;

    const std::vector<GroupEvidence> cameras =
        CameraEvidence(*prior, *state, samples);
    double num_camera = state->NumCameraParameters();
    for (size_t g = 0; g < groups.size(); ++g)
      num_camera +=
          cameras[g].NumDetermined(groups[g]->weight) - cameras[g].count;
    double num_points = 0;
    GroupEvidence points;
    if (!rough.fix_points) {
      points = PointsEvidence(*prior, *state, samples);
      num_points = points.NumDetermined(prior->points_weight);
    }
    const double variance = ResidualVariance(
        summary.residuals, options.huber_px,
        num_camera + num_points +
            6.0 * static_cast<double>(state->rig_from_pattern.size()));
    double camera_change = 0;
    for (size_t g = 0; g < groups.size(); ++g)
      camera_change =
          std::max(camera_change, UpdateWeight(cameras[g], variance,
                                               kNegligiblePx * kNegligiblePx,
                                               &groups[g]->weight));
    if (!rough.fix_points && num_points < kFewDetermined * points.count) {
      // The board is as nominal as these observations can tell.
      state->points = prior->points_mean;
      rough.fix_points = true;
      continue;
    }
    const double points_change =
        rough.fix_points ? 0
                         : UpdateWeight(points, variance,
                                        kNegligiblePx * kNegligiblePx *
                                            square_metres_per_pixel,
                                        &prior->points_weight);
    if (std::max(camera_change, points_change) < kStableChange) break;
  }
  AdjustmentOptions final_options = options;
  final_options.fix_points = rough.fix_points;
  return AdjustBundle(views, *prior, final_options, state);
}

}  // namespace raygrid
