#include "adjustment/group_jackknife.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

namespace raygrid {
namespace {

constexpr int kMaxGroups = 16;

// The views that remain without a group of poses, and the state without these
// poses.
struct Remaining {
  std::vector<View> views;
  AdjustmentState state;
};

bool IsInGroup(int pose, int group, int num_groups) {
  return pose % num_groups == group;
}

Remaining WithoutGroup(const std::vector<View>& views,
                       const AdjustmentState& state, int group,
                       int num_groups) {
  Remaining remaining;
  remaining.state = state;
  remaining.state.rig_from_pattern.clear();
  if (state.HasPerViewDeformation()) remaining.state.flex.clear();
  const auto num_poses = static_cast<int>(state.rig_from_pattern.size());
  std::vector<int> new_index(num_poses, -1);
  for (int pose = 0; pose < num_poses; ++pose) {
    if (IsInGroup(pose, group, num_groups)) continue;
    new_index[pose] = static_cast<int>(remaining.state.rig_from_pattern.size());
    remaining.state.rig_from_pattern.push_back(state.rig_from_pattern[pose]);
    if (state.HasPerViewDeformation())
      remaining.state.flex.push_back(state.flex[pose]);
  }
  for (const View& view : views) {
    if (new_index[view.pose] < 0) continue;
    remaining.views.push_back(view);
    remaining.views.back().pose = new_index[view.pose];
  }
  return remaining;
}

// Keeps the errors of a group of poses, and sets all others to zero.
ViewErrors SelectGroupErrors(const LinearResponse& response, ViewErrors errors,
                             int group, int num_groups) {
  for (size_t v = 0; v < errors.size(); ++v)
    if (!IsInGroup(response.jacobians()[v].pose, group, num_groups))
      errors[v].setZero();
  return errors;
}

// Draws residuals after optimization for white noise with unit variance and
// random prior means and deformations.
std::vector<ViewErrors> DrawResiduals(const LinearResponse& response,
                                      int count) {
  std::mt19937 random_bits(1);  // sequence is standardized
  std::vector<ViewErrors> residuals;
  Eigen::MatrixXd right(response.layout().num_all(), count), x;
  for (int k = 0; k < count; ++k) {
    residuals.push_back(response.SampleNoise(&random_bits));
    right.col(k) = response.Gradient(residuals.back()) +
                   response.SamplePrior(&random_bits) +
                   response.SampleDeformationPrior(&random_bits);
  }
  if (!response.Solve(right, &x)) return {};
  for (int k = 0; k < count; ++k) {
    const ViewErrors fitted = response.ApplyJacobian(x.col(k));
    for (size_t v = 0; v < fitted.size(); ++v) residuals[k][v] -= fitted[v];
  }
  return residuals;
}

// Estimate of a log variance ratio and the variance of this estimate.
struct LogRatio {
  double mean = 0, variance = 0;
};

// For a sum of squares with n degrees of freedom, log chi^2_n / n has a mean of
// about -1/n and a variance of about 2/n.
LogRatio ComputeLogRatio(double observed, double predicted,
                         double independent) {
  return {std::log(observed / predicted) + 1 / independent, 2 / independent};
}

// Returns the posterior mean and variance of an estimate with a normal prior.
LogRatio ShrinkImage(const LogRatio& estimate, const LogRatio& prior) {
  const double weight = prior.variance / (prior.variance + estimate.variance);
  return {prior.mean + weight * (estimate.mean - prior.mean),
          prior.variance * (1 - weight)};
}

struct Band {
  double observed = 0, predicted = 0, squared_sum = 0, sum_of_squares = 0;

  // Returns the effective number of independent components in the band.
  double NumIndependent() const {
    return std::max(1.0, squared_sum / sum_of_squares);
  }
};

Band ComputeBand(const GroupJackknife::SquaredChanges& changes,
                 Eigen::Index first, Eigen::Index count) {
  const auto predicted = changes.predicted.middleRows(first, count);
  Band band;
  band.observed = changes.observed.middleRows(first, count).sum();
  band.predicted = predicted.sum();
  band.squared_sum = band.predicted * band.predicted;
  band.sum_of_squares = predicted.squaredNorm();
  return band;
}

}  // namespace

GroupJackknife::GroupJackknife(const LinearResponse& response,
                               const std::vector<View>& views,
                               const GaussianPrior& prior,
                               const AdjustmentOptions& options,
                               const AdjustmentState& state, double noise_px) {
  const int num_groups = std::min(kMaxGroups, response.layout().num_poses);
  if (num_groups < 3) return;
  const int num_draws = response.IsExact() ? 8 : 4;
  std::vector<ViewErrors> residuals(1);
  for (const ViewJacobian& view : response.jacobians())
    residuals.front().push_back(view.error / noise_px);
  for (ViewErrors& drawn : DrawResiduals(response, num_draws))
    residuals.push_back(std::move(drawn));
  if (residuals.size() == 1) return;
  const Eigen::Index size = response.layout().size;
  std::vector<Eigen::MatrixXd> changes;
  for (int group = 0; group < num_groups; ++group) {
    const Remaining remaining = WithoutGroup(views, state, group, num_groups);
    const LinearResponse reduced_response(remaining.views, prior, options,
                                          remaining.state);
    Eigen::MatrixXd right = Eigen::MatrixXd::Zero(
                        reduced_response.layout().num_all(), 1 + num_draws),
                    x;
    for (int k = 0; k <= num_draws; ++k)
      right.col(k).head(size) =
          response
              .Gradient(
                  SelectGroupErrors(response, residuals[k], group, num_groups))
              .head(size);
    if (!reduced_response.Solve(right, &x)) return;
    changes.push_back(noise_px * x.topRows(size));
  }
  changes_ = std::move(changes);
}

GroupJackknife::SquaredChanges GroupJackknife::Of(
    int first, const Eigen::MatrixXd& jacobian) const {
  const auto num_groups = static_cast<Eigen::Index>(changes_.size());
  SquaredChanges squares = {Eigen::MatrixXd(jacobian.rows(), num_groups),
                            Eigen::MatrixXd(jacobian.rows(), num_groups)};
  for (Eigen::Index group = 0; group < num_groups; ++group) {
    const Eigen::MatrixXd& changes = changes_[group];
    const Eigen::MatrixXd squared_changes =
        (jacobian * changes.middleRows(first, jacobian.cols())).cwiseAbs2();
    squares.observed.col(group) = squared_changes.col(0);
    squares.predicted.col(group) =
        squared_changes.rightCols(squared_changes.cols() - 1).rowwise().mean();
  }
  return squares;
}

VarianceFactors::VarianceFactors(
    const GroupJackknife::SquaredChanges& changes) {
  constexpr LogRatio kOverallPrior = {0, 4};
  constexpr double kBandVariance = 1;
  const Eigen::Index count = changes.observed.rows();
  group_factors.setOnes(count);
  const Band all = ComputeBand(changes, 0, count);
  if (!(all.predicted > 0) || !(all.observed > 0)) return;
  const LogRatio overall_ratio = ShrinkImage(
      ComputeLogRatio(all.observed, all.predicted, all.NumIndependent()),
      kOverallPrior);
  overall_factor = std::exp(overall_ratio.mean);
  for (Eigen::Index first = 0, size = 1; first < count;
       first += size, size *= 2) {
    size = std::min(size, count - first);
    const Band band = ComputeBand(changes, first, size);
    LogRatio ratio = overall_ratio;
    if (band.predicted > 0 && band.observed > 0)
      ratio = ShrinkImage(
          ComputeLogRatio(band.observed, band.predicted, band.NumIndependent()),
          {overall_ratio.mean, kBandVariance});
    group_factors.segment(first, size).setConstant(std::exp(ratio.mean));
  }
}

}  // namespace raygrid
