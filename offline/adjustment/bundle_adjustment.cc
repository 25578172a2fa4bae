#include "adjustment/bundle_adjustment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "adjustment/normal_equations.h"
#include "adjustment/prior_evidence.h"

namespace raygrid {
namespace {

constexpr double kInitialLambda = 1e-4;
constexpr double kMinLambda = 1e-9, kMaxLambda = 1e8;

AdjustmentState ApplyStep(const AdjustmentState& state,
                          const AdjustmentStep& step) {
  AdjustmentState updated = state;
  for (size_t c = 0; c < step.cameras.size(); ++c)
    updated.cameras[c]->SetParameters(state.cameras[c]->Parameters() +
                                      step.cameras[c]);
  for (size_t c = 0; c < step.camera_poses.size(); ++c)
    updated.camera_from_rig[c + 1] =
        UpdatedPose(state.camera_from_rig[c + 1], step.camera_poses[c]);
  for (size_t i = 0; i < step.places.size(); ++i)
    updated.target_from_board[i] =
        UpdatedPose(state.target_from_board[i], step.places[i]);
  for (Eigen::Index i = 0; i < step.points.size() / 3; ++i)
    updated.points[i] += step.points.segment<3>(3 * i);
  for (size_t i = 0; i < step.poses.size(); ++i)
    updated.rig_from_pattern[i] =
        UpdatedPose(state.rig_from_pattern[i], step.poses[i]);
  for (size_t i = 0; i < step.flex.size(); ++i) updated.flex[i] += step.flex[i];
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
      cost += prior.points_precision / 2 *
              (state.points[i] - prior.points_mean[i]).squaredNorm();
  for (const DeformationModes::Coefficients& flex : state.flex)
    for (int mode = 0; mode < state.modes.count(); ++mode)
      cost += prior.DeformationPrecision(state.modes.orders[mode]) / 2 *
              flex[mode] * flex[mode];
  return cost;
}

double TotalCost(const std::vector<Residual>& residuals, double huber_px) {
  return CompareCosts(residuals, residuals, huber_px).first;
}

// Effect of an accepted step.
struct StepEffect {
  double decrease = 0;      // relative decrease of the cost
  double step_stddevs = 0;  // see ComputeStepInStdDevs()
};

// Returns the RMS displacement of the projections by a step, per parameter and
// relative to the standard deviation of the noise (D. Bates, D. Watts, "A
// Relative Offset Orthogonality Convergence Criterion for Nonlinear Least
// Squares", 1981).
double ComputeStepInStdDevs(const std::vector<Residual>& before,
                            const std::vector<Residual>& after, double huber_px,
                            double num_parameters) {
  double sum_squared_change = 0;
  for (size_t i = 0; i < before.size(); ++i)
    if (before[i].valid && after[i].valid)
      sum_squared_change +=
          (after[i].error_px - before[i].error_px).squaredNorm();
  return std::sqrt(sum_squared_change / num_parameters /
                   ResidualVariance(after, huber_px, num_parameters));
}

int NumValid(const std::vector<Residual>& residuals) {
  return static_cast<int>(
      std::count_if(residuals.begin(), residuals.end(),
                    [](const Residual& residual) { return residual.valid; }));
}

// Whether a step may lose observations. Costs are compared over the residuals
// that are valid in both states, so that both losing an observation and
// regaining it may reduce the cost: without kRejected, the optimization could
// alternate between the two states forever.
enum class Losses { kAccepted, kRejected };

// Steps that move more than this fraction of the observations out of the
// calibrated area are rejected: the cost of the remaining ones is meaningless.
constexpr double kMaxLostFraction = 0.5;

// Tries steps with increasing damping until one reduces the cost; leaves the
// state unchanged if none does.
StepEffect TryDampedSteps(const NormalEquations& equations,
                          const std::vector<View>& views,
                          const GaussianPrior& prior,
                          const AdjustmentOptions& options, Losses losses,
                          double* lambda, AdjustmentState* state,
                          std::vector<Residual>* residuals) {
  const double prior_cost = PriorCost(prior, *state, options);
  for (; *lambda < kMaxLambda; *lambda *= 10) {
    AdjustmentStep step;
    if (!equations.Solve(*lambda, &step)) continue;
    AdjustmentState next = ApplyStep(*state, step);
    std::vector<Residual> next_residuals =
        ComputeResiduals(next, views, options.num_threads);
    const ComparableCosts costs =
        CompareCosts(*residuals, next_residuals, options.huber_px);
    const double before = costs.first + prior_cost;
    const double after = costs.second + PriorCost(prior, next, options);
    if (!(after < before) || costs.num_common == 0) continue;
    const int num_before = NumValid(*residuals);
    if (costs.num_common < (1 - kMaxLostFraction) * num_before) continue;
    if (losses == Losses::kRejected && costs.num_common < num_before) continue;
    const ParameterLayout layout(*state,
                                 {options.fix_cameras, options.fix_points});
    const double sum_squared_change = ComputeStepInStdDevs(
        *residuals, next_residuals, options.huber_px, layout.size);
    *state = std::move(next);
    *residuals = std::move(next_residuals);
    *lambda = std::max(*lambda / 10, kMinLambda);
    return {(before - after) / before, sum_squared_change};
  }
  return {};
}

bool ShouldStop(const AdjustmentOptions& options) {
  return options.should_stop && options.should_stop();
}

void Report(const AdjustmentOptions& options, int iteration,
            const std::vector<Residual>& residuals) {
  if (options.progress)
    options.progress(iteration, TotalCost(residuals, options.huber_px));
}

// Successive small steps required for convergence: in a flat valley, a short
// step may precede longer ones.
constexpr int kMinStandstillSteps = 3;
constexpr double kStandstillDecrease = 1e-5;
// Observations may be lost in the first steps only. Most optimizations have
// converged by then.
constexpr int kStepsWithLosses = 50;

AdjustmentSummary OptimizeCameras(const std::vector<View>& views,
                                  const GaussianPrior& prior,
                                  const AdjustmentOptions& options,
                                  double lambda, EquationsBuilder* builder,
                                  AdjustmentState* state) {
  AdjustmentSummary summary;
  summary.residuals = ComputeResiduals(*state, views, options.num_threads);
  summary.initial_cost = TotalCost(summary.residuals, options.huber_px);
  int num_standstill_steps = 0;  // successive small steps
  while (summary.num_iterations < options.max_iterations &&
         !summary.converged && !ShouldStop(options)) {
    ++summary.num_iterations;
    const Losses losses = summary.num_iterations <= kStepsWithLosses
                              ? Losses::kAccepted
                              : Losses::kRejected;
    const StepEffect effect = TryDampedSteps(
        *builder->Build(prior, {options.fix_cameras, options.fix_points},
                        *state),
        views, prior, options, losses, &lambda, state, &summary.residuals);
    const bool stands = effect.decrease < kStandstillDecrease &&
                        effect.step_stddevs < options.standstill;
    num_standstill_steps = stands ? num_standstill_steps + 1 : 0;
    summary.converged = effect.decrease < options.relative_tolerance ||
                        num_standstill_steps >= kMinStandstillSteps;
    Report(options, summary.num_iterations, summary.residuals);
  }
  summary.final_cost = TotalCost(summary.residuals, options.huber_px);
  return summary;
}

// Levenberg-Marquardt damping that is negligible compared with the prior.
constexpr double kEvidenceLambda = 1e-6;

// Moves the mean per-view deformation of each board from the deformation and
// its prior mean to the points and theirs, which leaves all residuals
// unchanged.
void MoveMeanDeformation(const std::vector<View>& views, GaussianPrior* prior,
                         AdjustmentState* state) {
  const DeformationModes& modes = state->modes;
  if (!state->HasPerViewDeformation()) return;
  std::vector<int> board_by_pose(state->flex.size(), -1);
  for (const View& view : views)
    if (!view.observations.empty())
      board_by_pose[view.pose] = modes.boards[view.observations[0].point];
  for (int board = 0; board < modes.num_boards(); ++board) {
    DeformationModes::Coefficients mean =
        DeformationModes::Coefficients::Zero(modes.count());
    const double count = static_cast<double>(
        std::count(board_by_pose.begin(), board_by_pose.end(), board));
    for (size_t i = 0; i < state->flex.size(); ++i)
      if (board_by_pose[i] == board) mean += state->flex[i] / count;
    for (size_t i = 0; i < state->flex.size(); ++i)
      if (board_by_pose[i] == board) state->flex[i] -= mean;
    for (size_t i = 0; i < state->points.size(); ++i) {
      if (modes.boards[i] != board) continue;
      const Eigen::Vector3d sum_squared_change = modes.by_point[i] * mean;
      state->points[i] += sum_squared_change;
      prior->points_mean[i] += sum_squared_change;
    }
  }
}

// Returns the mean squared displacement of a point in metres per squared pixel
// of its projection.
double SquaredMetresPerPixel(const AdjustmentState& state,
                             const std::vector<View>& views,
                             const AdjustmentOptions& options) {
  double sum = 0, count = 0;
  for (const ViewJacobian& jacobian :
       WeightedJacobians(state, views, options.huber_px, options.num_threads)) {
    sum += jacobian.J_point.squaredNorm() / 2;
    count += jacobian.count();
  }
  return sum > 0 ? count / sum : 1;
}

// Initializes precisions that are 0. Second differences and deformation get the
// variance of the residuals; points get the variance that their observations
// imply jointly.
void InitializePrecisions(const std::vector<CameraGroup>& groups,
                          const std::vector<Residual>& residuals,
                          double huber_px, int num_points,
                          double square_metres_per_pixel,
                          GaussianPrior* prior) {
  const double variance = ResidualVariance(residuals, huber_px, 0);
  for (const CameraGroup& group : groups)
    if (group.group->weight == 0) group.group->SetPrecision(1, variance);
  if (prior->points_precision == 0)
    prior->points_precision =
        std::max(1.0, static_cast<double>(residuals.size()) /
                          static_cast<double>(num_points)) /
        square_metres_per_pixel;
  for (double& weight : prior->deformation_precisions)
    if (weight == 0) weight = 1 / square_metres_per_pixel;
}

// Returns the total effective number of parameters over all groups.
double ComputeEffectiveParameters(const PriorEvidence& evidence,
                                  const ParameterLayout& layout) {
  double count = layout.first_shape + 6.0 * layout.num_poses;
  for (const GroupEvidence& group : evidence.groups)
    count += group.effective_parameters - group.count;
  if (layout.num_points > 0) count += evidence.points.effective_parameters;
  for (const GroupEvidence& flex : evidence.flex)
    count += flex.effective_parameters;
  return count;
}

// Fixes points at their nominal positions, and deformation at zero, if the
// evidence does not support estimating them. Returns whether anything was
// fixed.
bool ExcludeUndetermined(const PriorEvidence& evidence, double variance,
                         const GaussianPrior& prior, bool* fix_points,
                         AdjustmentState* state) {
  bool is_simpler = false;
  if (!*fix_points && IsUndetermined(evidence.points) &&
      !FavorsLargerVariance(evidence.points,
                            variance / prior.points_precision)) {
    state->points = prior.points_mean;
    *fix_points = is_simpler = true;
  }
  for (int k = 0; k < kNumDeformationOrders; ++k) {
    const GroupEvidence& flex = evidence.flex[k];
    if (flex.count == 0) continue;
    if (state->HasStaticDeformation()
            ? !IsInsignificant(flex, variance / prior.deformation_precisions[k])
            : !IsUndetermined(flex))
      continue;
    state->modes.Remove(static_cast<DeformationOrder>(k), &state->flex);
    is_simpler = true;
  }
  return is_simpler;
}

// Updates the prior precisions iteratively. Each update returns the maximum
// change of their logarithms.
class PrecisionUpdater {
 public:
  PrecisionUpdater(const std::vector<CameraGroup>& groups,
                   double square_metres_per_pixel)
      : groups_(groups),
        negligible_m2_(kNegligiblePx2 * square_metres_per_pixel),
        group_updates_(groups.size()) {}

  double UpdateCameras(const PriorEvidence& evidence, double variance) {
    double change = 0;
    for (size_t g = 0; g < groups_.size(); ++g) {
      PriorGroup& group = *groups_[g].group;
      double weight = group.weight;
      change = std::max(
          change,
          group_updates_[g].Update(evidence.groups[g], variance, kNegligiblePx2,
                                   group.precision_floor * variance, &weight));
      group.SetPrecision(weight, variance);
    }
    return change;
  }

  double UpdateBoards(const PriorEvidence& evidence, double variance,
                      bool fix_points, const AdjustmentState& state,
                      GaussianPrior* prior) {
    double change = 0;
    if (!fix_points)
      change = point_update_.Update(evidence.points, variance, negligible_m2_,
                                    &prior->points_precision);
    for (int k = 0; k < kNumDeformationOrders; ++k)
      if (evidence.flex[k].count > 0)
        change =
            std::max(change, deformation_updates_[k].Update(
                                 evidence.flex[k], variance, negligible_m2_,
                                 MinDeformationPrecision(state, variance),
                                 &prior->deformation_precisions[k]));
    return change;
  }

 private:
  // Standard deviations below 1e-3 px are negligible.
  static constexpr double kNegligiblePx2 = 1e-3 * 1e-3;

  // Limits the standard deviation of per-view deformation to a fraction of the
  // board size; static deformation is not limited.
  static double MinDeformationPrecision(const AdjustmentState& state,
                                        double variance) {
    if (state.deformation_scope == DeformationScope::kBoard) return 0;
    return variance / std::pow(state.modes.MaxStdDevM(), 2);
  }

  const std::vector<CameraGroup>& groups_;
  double negligible_m2_;
  std::vector<PrecisionUpdate> group_updates_;
  VarianceUpdate point_update_;
  std::array<PrecisionUpdate, kNumDeformationOrders> deformation_updates_;
};

}  // namespace

AdjustmentSummary RunBundleAdjustment(const std::vector<View>& views,
                                      const GaussianPrior& prior,
                                      const AdjustmentOptions& options,
                                      AdjustmentState* state) {
  EquationsBuilder builder(views, options.huber_px, options.num_threads);
  return OptimizeCameras(views, prior, options, kInitialLambda, &builder,
                         state);
}

AdjustmentSummary OptimizeWithLearnedPrior(const std::vector<View>& views,
                                           const AdjustmentOptions& options,
                                           GaussianPrior* prior,
                                           AdjustmentState* state) {
  constexpr int kMaxRounds = 30;
  constexpr double kStableChange = 0.05;  // change of log precision
  constexpr double kStableCost = 1e-4;
  constexpr double kMinInitialDecrease = 0.1;  // relative decrease of the cost
  constexpr double kRoughChange = 0.1, kRoughDecrease = 0.05;
  const std::vector<CameraGroup> groups = MakeCameraGroups(prior);
  const double square_metres_per_pixel =
      SquaredMetresPerPixel(*state, views, options);
  std::vector<Residual> residuals =
      ComputeResiduals(*state, views, options.num_threads);
  InitializePrecisions(groups, residuals, options.huber_px,
                       CountObservedPoints(views, state->points.size()),
                       square_metres_per_pixel, prior);

  PrecisionUpdater update(groups, square_metres_per_pixel);
  AdjustmentOptions fixed = options;
  double variance = 0, num_effective = 0;
  EquationsBuilder builder(views, options.huber_px, options.num_threads);
  double lambda = kEvidenceLambda;
  bool acceptance_checked = !options.should_accept, should_accept = false;
  for (int round = 0; round < kMaxRounds && !ShouldStop(options); ++round) {
    // Takes one step, then computes the evidence from the same normal
    // equations.
    const FixedParameters fixed_parameters = {fixed.fix_cameras,
                                              fixed.fix_points};
    const ParameterLayout layout(*state, fixed_parameters);
    const std::unique_ptr<NormalEquations> equations =
        builder.Build(*prior, fixed_parameters, *state);
    const double tried_lambda = lambda;
    const double decrease =
        TryDampedSteps(*equations, views, *prior, fixed, Losses::kAccepted,
                       &lambda, state, &residuals)
            .decrease;
    if (!fixed.fix_points) MoveMeanDeformation(views, prior, state);
    Report(options, round, residuals);
    const std::optional<PriorEvidence> evidence = ComputeEvidence(
        groups, *prior, views, *equations, layout, tried_lambda, *state);
    if (!evidence) break;
    num_effective = ComputeEffectiveParameters(*evidence, layout);
    variance = ResidualVariance(residuals, options.huber_px, num_effective);
    double change = update.UpdateCameras(*evidence, variance);
    if (ExcludeUndetermined(*evidence, variance, *prior, &fixed.fix_points,
                            state)) {
      residuals = ComputeResiduals(*state, views, options.num_threads);
      continue;
    }
    change =
        std::max(change, update.UpdateBoards(*evidence, variance,
                                             fixed.fix_points, *state, prior));
    if (!acceptance_checked && change <= kRoughChange &&
        decrease <= kRoughDecrease) {
      acceptance_checked = true;
      should_accept = options.should_accept(residuals);
      if (should_accept) break;
    }
    if (change < kStableChange && decrease < kStableCost) break;
    if (options.is_initialization && decrease < kMinInitialDecrease) break;
  }
  if (options.is_initialization || should_accept) fixed.max_iterations = 0;
  AdjustmentSummary summary =
      OptimizeCameras(views, *prior, fixed, lambda, &builder, state);
  if (!fixed.fix_points) MoveMeanDeformation(views, prior, state);
  summary.noise_px = std::sqrt(variance);
  summary.num_effective = num_effective;
  return summary;
}

}  // namespace raygrid
