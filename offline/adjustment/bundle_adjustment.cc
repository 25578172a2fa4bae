#include "adjustment/bundle_adjustment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <random>
#include <set>

#include "adjustment/normal_equations.h"
#include "adjustment/precision_root.h"

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
  for (size_t i = 0; i < step.places.size(); ++i)
    updated.body_from_board[i] =
        UpdatedPose(state.body_from_board[i], step.places[i]);
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
      cost += prior.points_weight / 2 *
              (state.points[i] - prior.points_mean[i]).squaredNorm();
  for (const FlexModes::Coefficients& flex : state.flex)
    for (int mode = 0; mode < state.modes.count(); ++mode)
      cost += prior.FlexWeight(state.modes.orders[mode]) / 2 * flex[mode] *
              flex[mode];
  return cost;
}

double TotalCost(const std::vector<Residual>& residuals, double huber_px) {
  return CompareCosts(residuals, residuals, huber_px).first;
}

// How far a step of the adjustment got.
struct StepEffect {
  double decrease = 0;          // of the cost, relative
  double moved_deviations = 0;  // as MovedDeviations()
};

// How far a step moved the observed points' images beside how far the noise
// lets the solution scatter (D. Bates, D. Watts, "A Relative Offset
// Orthogonality Convergence Criterion for Nonlinear Least Squares", 1981).
double MovedDeviations(const std::vector<Residual>& before,
                       const std::vector<Residual>& after, double huber_px,
                       double num_parameters) {
  double moved = 0;
  for (size_t i = 0; i < before.size(); ++i)
    if (before[i].valid && after[i].valid)
      moved += (after[i].error_px - before[i].error_px).squaredNorm();
  return std::sqrt(moved / num_parameters /
                   ResidualVariance(after, huber_px, num_parameters));
}

int NumValid(const std::vector<Residual>& residuals) {
  return static_cast<int>(
      std::count_if(residuals.begin(), residuals.end(),
                    [](const Residual& residual) { return residual.valid; }));
}

// Costs are compared by the observations that both states can project. So steps
// that lose an observation lower the cost, and its return raises it: the two
// may take turns for ever.
enum class Losses { kAllowed, kRefused };

// Tries damped steps until one lowers the cost; nothing is done if none does.
StepEffect TakeStep(const NormalEquations& equations,
                    const std::vector<View>& views, const GaussianPrior& prior,
                    const AdjustmentOptions& options, Losses losses,
                    double* lambda, AdjustmentState* state,
                    std::vector<Residual>* residuals) {
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
    if (losses == Losses::kRefused && costs.num_common < NumValid(*residuals))
      continue;
    const ParameterLayout layout(*state,
                                 {options.fix_cameras, options.fix_points});
    const double moved = MovedDeviations(*residuals, next_residuals,
                                         options.huber_px, layout.size);
    *state = std::move(next);
    *residuals = std::move(next_residuals);
    *lambda = std::max(*lambda / 10, kMinLambda);
    return {(before - after) / before, moved};
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

// A single step may move little before others that move much, along a valley.
constexpr int kEnoughStanding = 3;
constexpr double kStandstillDecrease = 1e-5;
// Adjustments that end are nearly always done by then.
constexpr int kStepsWithLosses = 50;

AdjustmentSummary Adjust(const std::vector<View>& views,
                         const GaussianPrior& prior,
                         const AdjustmentOptions& options, double lambda,
                         EquationsBuilder* builder, AdjustmentState* state) {
  AdjustmentSummary summary;
  summary.residuals = ComputeResiduals(*state, views, options.num_threads);
  summary.initial_cost = TotalCost(summary.residuals, options.huber_px);
  int num_standing = 0;  // steps in a row
  while (summary.num_iterations < options.max_iterations &&
         !summary.converged && !ShouldStop(options)) {
    ++summary.num_iterations;
    const Losses losses = summary.num_iterations <= kStepsWithLosses
                              ? Losses::kAllowed
                              : Losses::kRefused;
    const StepEffect effect = TakeStep(
        *builder->Build(prior, {options.fix_cameras, options.fix_points},
                        *state),
        views, prior, options, losses, &lambda, state, &summary.residuals);
    const bool stands = effect.decrease < kStandstillDecrease &&
                        effect.moved_deviations < options.standstill;
    num_standing = stands ? num_standing + 1 : 0;
    summary.converged = effect.decrease < options.relative_tolerance ||
                        num_standing >= kEnoughStanding;
    Report(options, summary.num_iterations, summary.residuals);
  }
  summary.final_cost = TotalCost(summary.residuals, options.huber_px);
  return summary;
}

// ---- Evidence approximation ------------------------------------------------

// So little damping that it does not count as knowledge of the parameters.
constexpr double kLearningLambda = 1e-6;

// The evidence on a group of parameters under the prior: how many of them there
// are, how many the observations determine, and their squared distance from the
// prior's mean (in K's metric).
struct GroupEvidence {
  double count = 0, determined = 0, squared_distance = 0;
};

// A group of the prior, with the place of its camera among the parameters.
struct CameraGroup {
  int camera = 0;
  PriorGroup* group = nullptr;
  PrecisionRoot root;
};

std::vector<CameraGroup> CameraGroups(GaussianPrior* prior) {
  std::vector<CameraGroup> groups;
  for (size_t c = 0; c < prior->cameras.size(); ++c)
    for (PriorGroup& group : prior->cameras[c].groups)
      groups.push_back(
          {static_cast<int>(c), &group, PrecisionRoot(group.precision)});
  return groups;
}

// How many parameters of each group of the prior the observations determine.
struct Determined {
  std::vector<double> groups;  // of cameras
  double points = 0;
  std::array<double, kNumBendOrders> flex = {};
};

// The place of a bend among the parameters, and its order.
struct FlexRow {
  int row;
  BendOrder order;
};

// Whether a bend moves any point of a board: one of few rows has fewer bends.
bool IsTold(const FlexModes& modes, int board, int mode) {
  for (size_t i = 0; i < modes.boards.size(); ++i)
    if (modes.boards[i] == board && !modes.by_point[i].col(mode).isZero(0))
      return true;
  return false;
}

// The bends of all poses, or those that all boards that are seen may have.
std::vector<FlexRow> FlexRows(const ParameterLayout& layout,
                              const std::vector<View>& views,
                              const AdjustmentState& state) {
  const FlexModes& modes = state.modes;
  std::set<int> poses, boards;
  for (const View& view : views) {
    if (state.HasFlex()) poses.insert(view.pose);
    if (layout.has_shapes() && !view.observations.empty())
      boards.insert(modes.boards[view.observations[0].point]);
  }
  std::vector<FlexRow> rows;
  for (const int pose : poses)
    for (int mode = 0; mode < modes.count(); ++mode)
      rows.push_back({layout.Pose(pose) + 6 + mode, modes.orders[mode]});
  for (const int board : boards)
    for (int mode = 0; mode < modes.count(); ++mode)
      if (IsTold(modes, board, mode))
        rows.push_back({layout.Shape(board) + mode, modes.orders[mode]});
  return rows;
}

double NumOfOrder(const std::vector<FlexRow>& rows, BendOrder order) {
  return static_cast<double>(std::count_if(
      rows.begin(), rows.end(),
      [order](const FlexRow& row) { return row.order == order; }));
}

// The number of a group's parameters less the trace of the prior's part of H
// times H's inverse, which is the mean of b^T H^-1 b (Hutchinson, 1989), with
// b = sqrt(weight) B z of random signs z. For all groups at once: they are
// independent. Nothing if the system is singular.
std::optional<Determined> NumDetermined(const NormalEquations& equations,
                                        const ParameterLayout& layout,
                                        const std::vector<CameraGroup>& groups,
                                        const GaussianPrior& prior,
                                        const std::vector<FlexRow>& flex_rows,
                                        double lambda) {
  const int num_samples = equations.NumCheapSides();
  std::mt19937 random_bits(1);  // the standard fixes its sequence
  std::vector<Eigen::MatrixXd> shares;
  const bool has_flex = layout.per_pose > 6;
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(
      has_flex ? layout.num_all() : layout.size, num_samples);
  for (const CameraGroup& group : groups) {
    const int size = layout.NumCameraParameters(group.camera);
    Eigen::MatrixXd share(size, num_samples);
    for (int k = 0; k < num_samples; ++k)
      share.col(k) =
          std::sqrt(group.group->weight) *
          WithoutFree(group.group->free, group.group->freed,
                      group.root.Times(
                          RandomSigns(group.root.size(), &random_bits), size));
    right.middleRows(layout.first_camera[group.camera], size) += share;
    shares.push_back(std::move(share));
  }
  for (int k = 0; k < num_samples; ++k)
    right.col(k).segment(layout.first_point, 3 * layout.num_points) =
        std::sqrt(prior.points_weight) *
        RandomSigns(3 * layout.num_points, &random_bits);
  for (const FlexRow& flex : flex_rows)
    right.row(flex.row) = std::sqrt(prior.FlexWeight(flex.order)) *
                          RandomSigns(num_samples, &random_bits).transpose();
  Eigen::MatrixXd solution, rest;
  if (!equations.SolveWithRest(lambda, right, &solution, &rest))
    return std::nullopt;
  // Determined parameters are a small difference of large numbers: an error e
  // of x, which alone makes the trace wrong by b^T e, would drown it. With x^T
  // (b - H x) added it is e^T H e. Parameters belong to one group: it gets
  // their part.
  const auto trace = [&](int first, const Eigen::MatrixXd& share) {
    const auto left =
        (share.array() != 0).select(rest.middleRows(first, share.rows()), 0.0);
    return solution.middleRows(first, share.rows())
        .cwiseProduct(share + left)
        .sum();
  };
  const auto determined = [num_samples](double count, double sum) {
    return std::clamp(count - sum / num_samples, 1e-3 * count, count);
  };
  Determined result;
  for (size_t g = 0; g < groups.size(); ++g)
    result.groups.push_back(
        determined(groups[g].group->rank,
                   trace(layout.first_camera[groups[g].camera], shares[g])));
  result.points = determined(
      3.0 * layout.num_points,
      trace(layout.first_point,
            right.middleRows(layout.first_point, 3 * layout.num_points)));
  std::array<double, kNumBendOrders> flex = {};
  for (const auto& [row, order] : flex_rows)
    flex[static_cast<int>(order)] +=
        solution.row(row).dot(right.row(row) + rest.row(row));
  for (int k = 0; k < kNumBendOrders; ++k)
    result.flex[k] =
        determined(NumOfOrder(flex_rows, static_cast<BendOrder>(k)), flex[k]);
  return result;
}

// The sum of squared coefficients of an order. A view that is far from the
// others is of another board or camera rather than bent so much: it counts as
// one that is as far as chance lets few be. A board may be bent alone.
double SquaredFlex(const AdjustmentState& state, BendOrder order) {
  constexpr double kTimesMedian = 9;
  std::vector<double> squares;
  for (const FlexModes::Coefficients& flex : state.flex) {
    double square = 0;
    for (int mode = 0; mode < state.modes.count(); ++mode)
      if (state.modes.orders[mode] == order) square += flex[mode] * flex[mode];
    squares.push_back(square);
  }
  if (squares.empty()) return 0;
  if (state.bend_scope == BendScope::kBoard)
    return std::accumulate(squares.begin(), squares.end(), 0.0);
  std::vector<double> sorted = squares;
  const auto middle =
      sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  double sum = 0;
  for (const double square : squares)
    sum += std::min(square, kTimesMedian * *middle);
  return sum;
}

// The evidence of each group of the prior.
struct Evidence {
  std::vector<GroupEvidence> groups;  // of cameras
  GroupEvidence points;
  std::array<GroupEvidence, kNumBendOrders> flex;
};

Evidence EvidenceOf(const std::vector<CameraGroup>& groups,
                    const GaussianPrior& prior, const Determined& determined,
                    const std::vector<FlexRow>& flex_rows,
                    const AdjustmentState& state) {
  Evidence evidence;
  for (size_t g = 0; g < groups.size(); ++g) {
    const Eigen::VectorXd difference =
        state.cameras[groups[g].camera]->Parameters() -
        prior.cameras[groups[g].camera].mean;
    evidence.groups.push_back({static_cast<double>(groups[g].group->rank),
                               determined.groups[g],
                               groups[g].group->SquaredDistance(difference)});
  }
  evidence.points = {3.0 * static_cast<double>(state.points.size()),
                     determined.points, 0};
  for (size_t i = 0; i < state.points.size(); ++i)
    evidence.points.squared_distance +=
        (state.points[i] - prior.points_mean[i]).squaredNorm();
  for (int k = 0; k < kNumBendOrders; ++k) {
    const auto order = static_cast<BendOrder>(k);
    evidence.flex[k] = {NumOfOrder(flex_rows, order), determined.flex[k],
                        SquaredFlex(state, order)};
  }
  return evidence;
}

constexpr double kNegligiblePx = 1e-3;   // smaller departures are no matter
constexpr double kStableChange = 0.05;   // of a weight's logarithm
constexpr double kFewDetermined = 0.02;  // part of a group

bool IsNextToNothing(const GroupEvidence& evidence) {
  return evidence.determined < kFewDetermined * evidence.count;
}

// Whether parameters depart so little from their mean as chance lets 1 of 50 of
// them. With a prior of variance u, and v of what the observations alone tell
// of them, a part g = u / (u + v) is determined, and their squared distance is
// g^2 times what it were without a prior, x v. The evidence is greatest where u
// is distance / (g count), so with g = 1 - count / x. It falls towards there.
bool IsByChance(const GroupEvidence& evidence, double prior_variance) {
  constexpr double kLeastDetermined = 0.7;  // x is 3.3 times the count
  return evidence.determined < kLeastDetermined * evidence.count &&
         evidence.squared_distance < prior_variance * evidence.determined;
}

// Moves a weight round by round to where the evidence leaves it.
class WeightUpdate {
 public:
  // The variance of the group's parameters is taken for no smaller than
  // smallest_variance, the weight for no smaller than least_weight. Returns how
  // much the weight's logarithm changed.
  double Update(const GroupEvidence& group, double residual_variance,
                double smallest_variance, double least_weight, double* weight) {
    const double variance =
        std::max(group.squared_distance / group.determined, smallest_variance);
    double change = std::log(residual_variance / variance / *weight);
    // Changes that shrink by the same factor add up to a known sum.
    const double factor = change / last_change_;
    last_change_ = change;
    if (factor > 0 && factor < kMaxFactor) {
      change /= 1 - factor;
      last_change_ = 0;
    }
    const double before = *weight;
    *weight = std::max(before * std::exp(change), least_weight);
    return std::abs(std::log(*weight / before));
  }

 private:
  static constexpr double kMaxFactor = 0.8;
  double last_change_ = 0;  // none, or of which none is known
};

// The mean over a board's views of how it bends there is its shape: it moves
// from the flex to the points and their mean, which changes no residual.
void MoveMeanBends(const std::vector<View>& views, GaussianPrior* prior,
                   AdjustmentState* state) {
  const FlexModes& modes = state->modes;
  if (!state->HasFlex()) return;
  std::vector<int> board_of_pose(state->flex.size(), -1);
  for (const View& view : views)
    if (!view.observations.empty())
      board_of_pose[view.pose] = modes.boards[view.observations[0].point];
  for (int board = 0; board < modes.num_boards(); ++board) {
    FlexModes::Coefficients mean = FlexModes::Coefficients::Zero(modes.count());
    const double count = static_cast<double>(
        std::count(board_of_pose.begin(), board_of_pose.end(), board));
    for (size_t i = 0; i < state->flex.size(); ++i)
      if (board_of_pose[i] == board) mean += state->flex[i] / count;
    for (size_t i = 0; i < state->flex.size(); ++i)
      if (board_of_pose[i] == board) state->flex[i] -= mean;
    for (size_t i = 0; i < state->points.size(); ++i) {
      if (modes.boards[i] != board) continue;
      const Eigen::Vector3d moved = modes.by_point[i] * mean;
      state->points[i] += moved;
      prior->points_mean[i] += moved;
    }
  }
}

// A point's displacement that moves its image by one pixel, squared, on the
// average over the views.
double SquaredMetresPerPixel(const AdjustmentState& state,
                             const std::vector<View>& views,
                             const AdjustmentOptions& options) {
  double sum = 0, count = 0;
  for (const ViewJacobian& jacobian :
       WeightedJacobians(state, views, options.huber_px, options.num_threads)) {
    sum += jacobian.by_point.squaredNorm() / 2;
    count += jacobian.count();
  }
  return sum > 0 ? count / sum : 1;
}

// A view's board bends by a part of its size. A board may be of any shape.
double LeastFlexWeight(const AdjustmentState& state, double residual_variance) {
  if (state.bend_scope == BendScope::kBoard) return 0;
  return residual_variance / std::pow(state.modes.MaxDeviationM(), 2);
}

}  // namespace

AdjustmentSummary AdjustBundle(const std::vector<View>& views,
                               const GaussianPrior& prior,
                               const AdjustmentOptions& options,
                               AdjustmentState* state) {
  EquationsBuilder builder(views, options.huber_px, options.num_threads);
  return Adjust(views, prior, options, kInitialLambda, &builder, state);
}

AdjustmentSummary AdjustWithLearnedPrior(const std::vector<View>& views,
                                         const AdjustmentOptions& options,
                                         GaussianPrior* prior,
                                         AdjustmentState* state) {
  constexpr int kMaxRounds = 30;
  constexpr double kStableCost = 1e-4;
  constexpr double kGoodEnoughToStart = 0.1;  // decrease of the cost
  constexpr double kRoughChange = 0.1, kRoughDecrease = 0.05;
  const double square_metres_per_pixel =
      SquaredMetresPerPixel(*state, views, options);
  // A first guess: residuals, second differences and bends all scatter alike.
  const std::vector<CameraGroup> groups = CameraGroups(prior);
  std::vector<Residual> residuals =
      ComputeResiduals(*state, views, options.num_threads);
  const double first_variance =
      ResidualVariance(residuals, options.huber_px, 0);
  for (const CameraGroup& group : groups)
    if (group.group->weight == 0) group.group->SetWeight(1, first_variance);
  // Points scatter as far as their observations together leave open.
  if (prior->points_weight == 0)
    prior->points_weight =
        std::max(1.0, static_cast<double>(residuals.size()) /
                          static_cast<double>(state->points.size())) /
        square_metres_per_pixel;
  for (double& weight : prior->flex_weights)
    if (weight == 0) weight = 1 / square_metres_per_pixel;

  std::vector<WeightUpdate> updates(groups.size());
  WeightUpdate points_update;
  std::array<WeightUpdate, kNumBendOrders> flex_updates;
  AdjustmentOptions fixed = options;
  double variance = 0;
  EquationsBuilder builder(views, options.huber_px, options.num_threads);
  double lambda = kLearningLambda;
  bool is_asked = !options.is_enough, is_enough = false;
  for (int round = 0; round < kMaxRounds && !ShouldStop(options); ++round) {
    // One step, then what its equations tell of the prior.
    const FixedParameters fixed_parameters = {fixed.fix_cameras,
                                              fixed.fix_points};
    const ParameterLayout layout(*state, fixed_parameters);
    const std::unique_ptr<NormalEquations> equations =
        builder.Build(*prior, fixed_parameters, *state);
    const double tried_lambda = lambda;
    const double decrease =
        TakeStep(*equations, views, *prior, fixed, Losses::kAllowed, &lambda,
                 state, &residuals)
            .decrease;
    if (!fixed.fix_points) MoveMeanBends(views, prior, state);
    Report(options, round, residuals);
    const std::vector<FlexRow> flex_rows = FlexRows(layout, views, *state);
    const std::optional<Determined> determined = NumDetermined(
        *equations, layout, groups, *prior, flex_rows, tried_lambda);
    if (!determined) break;
    const Evidence evidence =
        EvidenceOf(groups, *prior, *determined, flex_rows, *state);
    double num_parameters = layout.first_shape + 6.0 * layout.num_poses;
    for (const GroupEvidence& group : evidence.groups)
      num_parameters += group.determined - group.count;
    const GroupEvidence& points = evidence.points;
    if (!fixed.fix_points) num_parameters += points.determined;
    for (const GroupEvidence& flex : evidence.flex)
      num_parameters += flex.determined;
    variance = ResidualVariance(residuals, options.huber_px, num_parameters);

    double change = 0;
    for (size_t g = 0; g < groups.size(); ++g) {
      double weight = groups[g].group->weight;
      change = std::max(
          change,
          updates[g].Update(evidence.groups[g], variance,
                            kNegligiblePx * kNegligiblePx,
                            groups[g].group->firmness * variance, &weight));
      groups[g].group->SetWeight(weight, variance);
    }
    bool is_simpler = false;
    if (!fixed.fix_points && IsNextToNothing(points)) {
      // The board is as nominal as these observations can tell.
      state->points = prior->points_mean;
      fixed.fix_points = is_simpler = true;
    }
    for (int k = 0; k < kNumBendOrders; ++k) {
      const GroupEvidence& flex = evidence.flex[k];
      if (flex.count == 0) continue;
      const double prior_variance = variance / prior->flex_weights[k];
      if (state->HasShapes() ? !IsByChance(flex, prior_variance)
                             : !IsNextToNothing(flex))
        continue;
      // Nothing is bent like this, for all that these observations tell.
      state->modes.Remove(static_cast<BendOrder>(k), &state->flex);
      is_simpler = true;
    }
    if (is_simpler) {
      residuals = ComputeResiduals(*state, views, options.num_threads);
      continue;
    }
    const double negligible_m2 =
        kNegligiblePx * kNegligiblePx * square_metres_per_pixel;
    if (!fixed.fix_points)
      change =
          std::max(change, points_update.Update(points, variance, negligible_m2,
                                                0, &prior->points_weight));
    for (int k = 0; k < kNumBendOrders; ++k)
      if (evidence.flex[k].count > 0)
        change = std::max(change, flex_updates[k].Update(
                                      evidence.flex[k], variance, negligible_m2,
                                      LeastFlexWeight(*state, variance),
                                      &prior->flex_weights[k]));
    if (change < kStableChange && decrease < kStableCost) break;
    if (options.is_start && decrease < kGoodEnoughToStart) break;
    if (is_asked || change > kRoughChange || decrease > kRoughDecrease)
      continue;
    is_asked = true;
    is_enough = options.is_enough(residuals);
    if (is_enough) break;
  }
  if (options.is_start || is_enough) fixed.max_iterations = 0;
  AdjustmentSummary summary =
      Adjust(views, *prior, fixed, lambda, &builder, state);
  if (!fixed.fix_points) MoveMeanBends(views, prior, state);
  summary.noise_px = std::sqrt(variance);
  return summary;
}

}  // namespace raygrid
