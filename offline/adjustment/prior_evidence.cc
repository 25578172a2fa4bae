#include "adjustment/prior_evidence.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <set>

namespace raygrid {
namespace {

// Effective number of parameters of each prior group.
struct EffectiveParameters {
  std::vector<double> groups;  // camera groups
  double points = 0;
  std::array<double, kNumDeformationOrders> flex = {};
};

// Parameter index of a deformation coefficient, and the order of its mode.
struct DeformationCoefficient {
  int row;
  DeformationOrder order;
};

// Whether a mode moves any point of a board: small boards have fewer modes.
bool IsDetermined(const DeformationModes& modes, int board, int mode) {
  for (size_t i = 0; i < modes.boards.size(); ++i)
    if (modes.boards[i] == board && !modes.by_point[i].col(mode).isZero(0))
      return true;
  return false;
}

// Lists the deformation coefficients of all poses, or of all observed boards.
std::vector<DeformationCoefficient> ListDeformationCoefficients(
    const ParameterLayout& layout, const std::vector<View>& views,
    const AdjustmentState& state) {
  const DeformationModes& modes = state.modes;
  std::set<int> poses, boards;
  for (const View& view : views) {
    if (state.HasPerViewDeformation()) poses.insert(view.pose);
    if (layout.has_shapes() && !view.observations.empty())
      boards.insert(modes.boards[view.observations[0].point]);
  }
  std::vector<DeformationCoefficient> rows;
  for (const int pose : poses)
    for (int mode = 0; mode < modes.count(); ++mode)
      rows.push_back({layout.Pose(pose) + 6 + mode, modes.orders[mode]});
  for (const int board : boards)
    for (int mode = 0; mode < modes.count(); ++mode)
      if (IsDetermined(modes, board, mode))
        rows.push_back({layout.Shape(board) + mode, modes.orders[mode]});
  return rows;
}

double CountCoefficients(const std::vector<DeformationCoefficient>& rows,
                         DeformationOrder order) {
  return static_cast<double>(std::count_if(
      rows.begin(), rows.end(), [order](const DeformationCoefficient& row) {
        return row.order == order;
      }));
}

// Returns the effective number of parameters: the number of a group's
// parameters minus the trace of the product of its prior precision and H^-1.
// The trace is estimated as the mean of b^T H^-1 b (Hutchinson, 1989) with b =
// sqrt(weight) B z for random signs z, for all groups at once, since they are
// independent. Returns nullopt if the system is singular.
std::optional<EffectiveParameters> CountEffectiveParameters(
    const NormalEquations& equations, const ParameterLayout& layout,
    const std::vector<CameraGroup>& groups, const GaussianPrior& prior,
    const std::vector<DeformationCoefficient>& deformation_coefficients,
    int num_observed_points, double lambda) {
  const int num_samples = equations.MaxNumRightSides();
  std::mt19937 random_bits(1);  // sequence is standardized
  std::vector<Eigen::MatrixXd> shares;
  const bool has_per_view_deformation = layout.per_pose > 6;
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(
      has_per_view_deformation ? layout.num_all() : layout.size, num_samples);
  for (const CameraGroup& group : groups) {
    const int size = layout.NumCameraParameters(group.camera);
    Eigen::MatrixXd share(size, num_samples);
    for (int k = 0; k < num_samples; ++k)
      share.col(k) =
          std::sqrt(group.group->weight) *
          ProjectOutUnpenalized(
              group.group->free, group.group->unpenalized,
              group.root.Times(RandomSigns(group.root.size(), &random_bits),
                               size));
    right.middleRows(layout.first_camera[group.camera], size) += share;
    shares.push_back(std::move(share));
  }
  for (int k = 0; k < num_samples; ++k)
    right.col(k).segment(layout.first_point, 3 * layout.num_points) =
        std::sqrt(prior.points_precision) *
        RandomSigns(3 * layout.num_points, &random_bits);
  for (const DeformationCoefficient& flex : deformation_coefficients)
    right.row(flex.row) = std::sqrt(prior.DeformationPrecision(flex.order)) *
                          RandomSigns(num_samples, &random_bits).transpose();
  Eigen::MatrixXd solution, rest;
  if (!equations.SolveWithResidual(lambda, right, &solution, &rest))
    return std::nullopt;
  // The effective number of parameters is a small difference of large numbers:
  // an error e of x changes b^T x by b^T e, which would dominate. Adding x^T (b
  // - H x) reduces this to e^T H e. Each parameter contributes to the trace of
  // its group.
  const auto trace = [&](int first, const Eigen::MatrixXd& share) {
    const auto left =
        (share.array() != 0).select(rest.middleRows(first, share.rows()), 0.0);
    return solution.middleRows(first, share.rows())
        .cwiseProduct(share + left)
        .sum();
  };
  const auto effective_parameters = [num_samples](double count, double sum) {
    return std::clamp(count - sum / num_samples, 1e-3 * count, count);
  };
  EffectiveParameters result;
  for (size_t g = 0; g < groups.size(); ++g)
    result.groups.push_back(effective_parameters(
        groups[g].group->rank,
        trace(layout.first_camera[groups[g].camera], shares[g])));
  // Each coordinate of an unobserved point adds 1 to the trace.
  const double num_unseen = layout.num_points - num_observed_points;
  result.points = effective_parameters(
      3.0 * num_observed_points,
      trace(layout.first_point,
            right.middleRows(layout.first_point, 3 * layout.num_points)) -
          3 * num_unseen * num_samples);
  std::array<double, kNumDeformationOrders> flex = {};
  for (const auto& [row, order] : deformation_coefficients)
    flex[static_cast<int>(order)] +=
        solution.row(row).dot(right.row(row) + rest.row(row));
  for (int k = 0; k < kNumDeformationOrders; ++k)
    result.flex[k] = effective_parameters(
        CountCoefficients(deformation_coefficients,
                          static_cast<DeformationOrder>(k)),
        flex[k]);
  return result;
}

// Returns the sum of the squared deformation coefficients of one order.
// Outlying views are clipped, since they show a different board or camera
// rather than a deformation. Static deformation is not clipped, since a single
// board may be deformed.
double SumSquaredDeformation(const AdjustmentState& state,
                             DeformationOrder order) {
  constexpr double kTimesMedian = 9;
  std::vector<double> squares;
  for (const DeformationModes::Coefficients& flex : state.flex) {
    double square = 0;
    for (int mode = 0; mode < state.modes.count(); ++mode)
      if (state.modes.orders[mode] == order) square += flex[mode] * flex[mode];
    squares.push_back(square);
  }
  if (squares.empty()) return 0;
  if (state.deformation_scope == DeformationScope::kBoard)
    return std::accumulate(squares.begin(), squares.end(), 0.0);
  std::vector<double> sorted = squares;
  const auto median =
      sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), median, sorted.end());
  double sum = 0;
  for (const double square : squares)
    sum += std::min(square, kTimesMedian * *median);
  return sum;
}

PriorEvidence EvaluateEvidence(
    const std::vector<CameraGroup>& groups, const GaussianPrior& prior,
    const EffectiveParameters& effective_parameters,
    const std::vector<DeformationCoefficient>& deformation_coefficients,
    int num_observed_points, const AdjustmentState& state) {
  PriorEvidence evidence;
  for (size_t g = 0; g < groups.size(); ++g) {
    const Eigen::VectorXd difference =
        state.cameras[groups[g].camera]->Parameters() -
        prior.cameras[groups[g].camera].mean;
    evidence.groups.push_back({static_cast<double>(groups[g].group->rank),
                               effective_parameters.groups[g],
                               groups[g].group->SquaredDistance(difference)});
  }
  evidence.points = {3.0 * num_observed_points, effective_parameters.points, 0};
  for (size_t i = 0; i < state.points.size(); ++i)
    evidence.points.squared_distance +=
        (state.points[i] - prior.points_mean[i]).squaredNorm();
  for (int k = 0; k < kNumDeformationOrders; ++k) {
    const auto order = static_cast<DeformationOrder>(k);
    evidence.flex[k] = {CountCoefficients(deformation_coefficients, order),
                        effective_parameters.flex[k],
                        SumSquaredDeformation(state, order)};
  }
  return evidence;
}

}  // namespace

std::vector<CameraGroup> MakeCameraGroups(GaussianPrior* prior) {
  std::vector<CameraGroup> groups;
  for (size_t c = 0; c < prior->cameras.size(); ++c)
    for (PriorGroup& group : prior->cameras[c].groups)
      groups.push_back(
          {static_cast<int>(c), &group, PrecisionRoot(group.precision)});
  return groups;
}

int CountObservedPoints(const std::vector<View>& views, size_t num_points) {
  std::vector<bool> is_observed(num_points);
  for (const View& view : views)
    for (const Observation& observation : view.observations)
      is_observed[observation.point] = true;
  return static_cast<int>(
      std::count(is_observed.begin(), is_observed.end(), true));
}

std::optional<PriorEvidence> ComputeEvidence(
    const std::vector<CameraGroup>& groups, const GaussianPrior& prior,
    const std::vector<View>& views, const NormalEquations& equations,
    const ParameterLayout& layout, double lambda,
    const AdjustmentState& state) {
  const std::vector<DeformationCoefficient> deformation_coefficients =
      ListDeformationCoefficients(layout, views, state);
  const int num_observed_points =
      CountObservedPoints(views, state.points.size());
  const std::optional<EffectiveParameters> effective_parameters =
      CountEffectiveParameters(equations, layout, groups, prior,
                               deformation_coefficients, num_observed_points,
                               lambda);
  if (!effective_parameters) return std::nullopt;
  return EvaluateEvidence(groups, prior, *effective_parameters,
                          deformation_coefficients, num_observed_points, state);
}

bool IsUndetermined(const GroupEvidence& evidence) {
  constexpr double kMaxEffectiveFraction = 0.02;  // fraction of a group
  return evidence.effective_parameters < kMaxEffectiveFraction * evidence.count;
}

bool FavorsLargerVariance(const GroupEvidence& evidence,
                          double prior_variance) {
  return evidence.squared_distance >
         prior_variance * evidence.effective_parameters;
}

// For a prior variance u and a variance v due to the observations alone, the
// effective fraction of the parameters is g = u / (u + v), and their squared
// distance from the prior mean is g^2 times the distance x v without a prior.
// The evidence is maximal where u = distance / (g count), so where g = 1 -
// count / x. If the evidence does not favour a larger variance, g decreases
// towards this value.
bool IsInsignificant(const GroupEvidence& evidence, double prior_variance) {
  constexpr double kMinEffectiveFraction =
      0.7;  // at an x of 3.3 times the count
  return evidence.effective_parameters <
             kMinEffectiveFraction * evidence.count &&
         !FavorsLargerVariance(evidence, prior_variance);
}

double PrecisionUpdate::Update(const GroupEvidence& group,
                               double residual_variance,
                               double smallest_variance, double min_precision,
                               double* weight) {
  const double variance = std::max(
      group.squared_distance / group.effective_parameters, smallest_variance);
  double change = std::log(residual_variance / variance / *weight);
  // Extrapolates to the limit of a geometric series of changes.
  const double factor = change / last_change_;
  last_change_ = change;
  if (factor > 0 && factor < kMaxFactor) {
    change /= 1 - factor;
    last_change_ = 0;
  }
  const double before = *weight;
  *weight = std::max(before * std::exp(change), min_precision);
  return std::abs(std::log(*weight / before));
}

// With u and v as above, and u0 the variance to estimate, the expected squared
// distance per parameter is g^2 (u0 + v), and the next estimate is g (u0 + v).
// The change is g (u0 - u), so that the full step is 1 / g of it. If v varies
// among the parameters, this overshoots and the step changes its sign; the
// exponent is reduced in that case.
double VarianceUpdate::Update(const GroupEvidence& group,
                              double residual_variance,
                              double smallest_variance, double* weight) {
  constexpr double kMaxDecreaseFactor = 10,
                   kMaxIncreaseFactor = 100;  // per round
  const double variance = residual_variance / *weight;
  const double step =
      group.squared_distance / group.effective_parameters - variance;
  if (step * last_step_ < 0) exponent_ /= 2;
  last_step_ = step;
  const double next =
      variance +
      step * std::pow(group.count / group.effective_parameters, exponent_);
  const double before = *weight;
  *weight = residual_variance /
            std::max(std::clamp(next, variance / kMaxDecreaseFactor,
                                variance * kMaxIncreaseFactor),
                     smallest_variance);
  return std::abs(std::log(*weight / before));
}

}  // namespace raygrid
