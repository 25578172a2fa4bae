#include "evaluation/cause_group.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "evaluation/prediction_comparison.h"

namespace raygrid {
namespace {

constexpr int kNumRandomDraws = 16;

CauseShare& GetCauseShare(ErrorCause cause, ResidualBudget* budget) {
  return budget->causes[static_cast<size_t>(cause)];
}

// Returns the minimum share of a cause to be significant.
double MinSignificantGain(const CauseShare& share) {
  constexpr double kNegligible = 0.002;
  return std::max(share.random_limit, kNegligible);
}

std::array<Eigen::VectorXd, 2> PredictHalves(
    const CrossFit& fit, const std::array<Eigen::VectorXd, 2>& errors) {
  return {fit.Predict(0, errors[0]), fit.Predict(1, errors[1])};
}

double SumLanes(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

// Whether the difference between the shares of two causes is insignificant.
bool IsDifferenceInsignificant(const std::vector<double>& more,
                               const std::vector<double>& less) {
  constexpr double kMinPValue = 0.01;
  std::vector<double> differences;
  for (size_t u = 0; u < more.size(); ++u)
    differences.push_back(more[u] - less[u]);
  return SumLanes(differences) <= 0 ||
         SignedRankProbability(differences) > kMinPValue;
}

}  // namespace

double CauseGroup::Gain(const CrossFit& fit, const HalfErrors& errors) const {
  return SumLanes(
             ComputeExplainedSquares(fit, errors, PredictHalves(fit, errors))) /
         squares_;
}

// Simulates errors of the same size at the same positions with random signs.
void CauseGroup::EstimateRandomShares(const Eigen::VectorXd& errors,
                                      ResidualBudget* budget) const {
  constexpr double kNumSigmas = 3;
  std::mt19937_64 bits(1);  // sequence is standardized
  std::vector<double> sums(fits_.size(), 0), squares(fits_.size(), 0);
  for (int draw = 0; draw < kNumRandomDraws; ++draw) {
    Eigen::VectorXd tossed = errors;
    for (Eigen::Index i = 0; i < tossed.size(); ++i)
      if (bits() >> 63) tossed[i] = -tossed[i];
    if (pose_) pose_->Remove(&tossed);
    for (size_t k = 0; k < fits_.size(); ++k) {
      const double gain = Gain(fits_[k].fit, {tossed, tossed});
      sums[k] += gain;
      squares[k] += gain * gain;
    }
  }
  for (size_t k = 0; k < fits_.size(); ++k) {
    const double mean = sums[k] / kNumRandomDraws;
    const double variance =
        std::max(0.0, squares[k] / kNumRandomDraws - mean * mean);
    CauseShare& share = GetCauseShare(fits_[k].cause, budget);
    share.random_mean = mean;
    share.random_limit = std::max(0.0, mean + kNumSigmas * std::sqrt(variance));
  }
}

// Returns the cause with the largest significant share of the remaining errors.
std::optional<size_t> CauseGroup::FindNextCause(
    const HalfErrors& remaining_errors, const std::vector<bool>& is_removed,
    ResidualBudget* budget) const {
  std::optional<size_t> best;
  double best_gain = 0;
  for (size_t k = 0; k < fits_.size(); ++k) {
    const CauseShare& share = budget->Of(fits_[k].cause);
    if (is_removed[k] || share.alone <= MinSignificantGain(share)) continue;
    const double gain = Gain(fits_[k].fit, remaining_errors);
    if (gain <= std::max(best_gain, MinSignificantGain(share))) continue;
    best_gain = gain;
    best = k;
  }
  if (best)
    GetCauseShare(fits_[*best].cause, budget).sequential_share = best_gain;
  return best;
}

// Returns the remaining error of each feature, with coefficients estimated from
// the other half.
Eigen::VectorXd CauseGroup::Join(const HalfErrors& remaining_errors) const {
  Eigen::VectorXd joined = remaining_errors[0];
  for (Eigen::Index at = 0; !fits_.empty() && at < joined.size(); at += 2) {
    const int half = fits_.front().fit.half(static_cast<size_t>(at / 2));
    joined.segment<2>(at) = remaining_errors[1 - half].segment<2>(at);
  }
  return joined;
}

Eigen::VectorXd CauseGroup::Explain(const Eigen::VectorXd& errors,
                                    ResidualBudget* budget) const {
  for (const CauseFit& named : fits_) {
    CauseShare& share = GetCauseShare(named.cause, budget);
    share.is_observable = true;
    share.alone = Gain(named.fit, {errors, errors});
  }
  EstimateRandomShares(errors, budget);
  // Each half is corrected with its own coefficients, so that the halves remain
  // independent.
  HalfErrors remaining_errors = {errors, errors};
  std::vector<bool> is_removed(fits_.size(), false);
  while (const auto next =
             FindNextCause(remaining_errors, is_removed, budget)) {
    is_removed[*next] = true;
    const HalfErrors predicted =
        PredictHalves(fits_[*next].fit, remaining_errors);
    for (int half = 0; half < 2; ++half)
      remaining_errors[half] -= predicted[half];
  }
  return Join(remaining_errors);
}

void CauseGroup::FindEquivalentCauses(const Eigen::VectorXd& errors,
                                      const CrossFit& control,
                                      ResidualBudget* budget) const {
  const HalfErrors halves = {errors, errors};
  const auto explained_by = [&](const CrossFit& fit) {
    return ComputeExplainedSquares(fit, halves, PredictHalves(fit, halves));
  };
  const CauseFit* largest = nullptr;
  for (const CauseFit& named : fits_)
    if (budget->Of(named.cause).IsDetermined() &&
        (!largest || budget->Of(named.cause).sequential_share >
                         budget->Of(largest->cause).sequential_share))
      largest = &named;
  if (!largest) return;
  const std::vector<double> most = explained_by(largest->fit);
  for (const CauseFit& named : fits_)
    GetCauseShare(named.cause, budget).is_indistinguishable =
        &named == largest ||
        IsDifferenceInsignificant(most, explained_by(named.fit));
  const std::vector<double> explained_by_control = explained_by(control);
  budget->column_delay = SumLanes(explained_by_control) / squares_;
  budget->is_column_delay_indistinguishable =
      IsDifferenceInsignificant(most, explained_by_control);
}

}  // namespace raygrid
