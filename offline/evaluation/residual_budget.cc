#include "evaluation/residual_budget.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "evaluation/cause_group.h"
#include "evaluation/cross_fit.h"
#include "evaluation/error_causes.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

constexpr int kMinBudgetFeatures = 200, kMinBudgetViews = 8;

double SumSquares(const BudgetInput& input) {
  double squares = 0;
  for (const BudgetFeature& feature : input.features)
    squares += feature.error_px.squaredNorm();
  return squares;
}

// Returns the robust standard deviation per coordinate from the median norm.
double ComputeRobustStdDev(std::vector<double> norms) {
  return Quantile(std::move(norms), 0.5) / std::sqrt(2 * std::log(2.0));
}

// Returns the error limits per view: five standard deviations of the view or of
// all views, whichever is larger. Views differ, depending on the causes; a few
// large errors would mask the rest.
std::vector<double> ComputeMaxErrorByView(const BudgetInput& input) {
  constexpr double kOutlierSigmas = 5;
  std::vector<std::vector<double>> norms(CountFeaturesByView(input).size());
  std::vector<double> all, max_error;
  for (const BudgetFeature& feature : input.features) {
    norms[feature.view].push_back(feature.error_px.norm());
    all.push_back(norms[feature.view].back());
  }
  const double of_all = ComputeRobustStdDev(std::move(all));
  for (std::vector<double>& of_view : norms)
    max_error.push_back(
        kOutlierSigmas *
        std::max(of_all, ComputeRobustStdDev(std::move(of_view))));
  return max_error;
}

// Returns the errors in sequence, each clipped to the limit of its view.
Eigen::VectorXd ErrorsWithin(const BudgetInput& input) {
  const std::vector<double> max_error = ComputeMaxErrorByView(input);
  Eigen::VectorXd errors(2 * input.features.size());
  for (size_t i = 0; i < input.features.size(); ++i) {
    const Eigen::Vector2d& error = input.features[i].error_px;
    const double norm = error.norm(), most = max_error[input.features[i].view];
    errors.segment<2>(2 * static_cast<Eigen::Index>(i)) =
        error * (norm > most ? most / norm : 1);
  }
  return errors;
}

// ---- Causes ----------------------------------------------------------------

void MarkUnresolved(const std::vector<ErrorCause>& causes,
                    const std::string& why, ResidualBudget* budget) {
  for (const ErrorCause cause : causes)
    budget->causes[static_cast<size_t>(cause)].unobservable_reason = why;
}

Eigen::VectorXd ExplainByImagePosition(const BudgetInput& input, double squares,
                                       const Eigen::VectorXd& errors,
                                       ResidualBudget* budget) {
  if (budget->num_views < kMinBudgetViews) {
    MarkUnresolved({ErrorCause::kImagePosition, ErrorCause::kBoardPosition},
                   fmt::format("{} views, at least {} required",
                               budget->num_views, kMinBudgetViews),
                   budget);
    return errors;
  }
  std::vector<CauseFit> fits;
  fits.push_back({ErrorCause::kImagePosition,
                  CrossFit(MakeImagePositionCauseModel(input))});
  fits.push_back({ErrorCause::kBoardPosition,
                  CrossFit(MakeBoardPositionCauseModel(input))});
  return CauseGroup(std::move(fits), nullptr, squares).Explain(errors, budget);
}

// Whether at least half of the features are in views with many features.
bool HaveViewsMany(const BudgetInput& input) {
  size_t in_these = 0;
  for (const int count : CountFeaturesByView(input))
    if (count >= kMinBudgetViewFeatures) in_these += count;
  return 2 * in_these >= input.features.size();
}

void ExplainByViewEffects(const BudgetInput& input, double squares,
                          Eigen::VectorXd errors, ResidualBudget* budget) {
  const std::vector<ErrorCause> causes = {
      ErrorCause::kDeformation, ErrorCause::kInPlane, ErrorCause::kImageAffine,
      ErrorCause::kRollingShutter};
  if (!HaveViewsMany(input)) {
    MarkUnresolved(causes,
                   fmt::format("most views have fewer than {} features",
                               kMinBudgetViewFeatures),
                   budget);
    return;
  }
  const PoseComponents pose(input);
  pose.Remove(&errors);
  std::vector<CauseFit> fits;
  for (const ErrorCause cause : causes) {
    if (auto linear = MakeViewCauseModel(cause, input, pose))
      fits.push_back({cause, CrossFit(std::move(*linear))});
    else
      MarkUnresolved({cause}, "the target is not planar, or too small", budget);
  }
  const CauseGroup group(std::move(fits), &pose, squares);
  group.Explain(errors, budget);
  if (budget->PerViewShare() > 0)
    group.FindEquivalentCauses(
        errors, CrossFit(MakeColumnDelayControl(input, pose)), budget);
}

// ---- Noise -----------------------------------------------------------------

// Returns the variance of the white noise of features from second differences
// along the lattice, which remove constant and linear components.
Eigen::Vector2d NoiseVariance(const BudgetInput& input,
                              const Eigen::VectorXd& errors) {
  constexpr double kDifferenceVariance = 1 + 4 + 1;
  std::map<std::array<int, 3>, size_t> places;
  const auto get_position = [&](const BudgetFeature& feature, int right,
                                int down) {
    return std::array<int, 3>{feature.view, feature.row + down,
                              feature.column + right};
  };
  for (size_t i = 0; i < input.features.size(); ++i)
    places[get_position(input.features[i], 0, 0)] = i;
  Eigen::Vector2d squares = Eigen::Vector2d::Zero();
  int count = 0;
  const auto get_error = [&errors](size_t i) {
    return errors.segment<2>(2 * static_cast<Eigen::Index>(i));
  };
  for (size_t i = 0; i < input.features.size(); ++i)
    for (const auto& [right, down] : {std::pair(1, 0), std::pair(0, 1)}) {
      const auto before =
          places.find(get_position(input.features[i], -right, -down));
      const auto after =
          places.find(get_position(input.features[i], right, down));
      if (before == places.end() || after == places.end()) continue;
      squares += (get_error(before->second) + get_error(after->second) -
                  2 * get_error(i))
                     .cwiseAbs2() /
                 kDifferenceVariance;
      ++count;
    }
  return squares / std::max(count, 1);
}

void AddNoise(const BudgetInput& input, double squares,
              const Eigen::VectorXd& errors, ResidualBudget* budget) {
  const Eigen::Vector2d variance = NoiseVariance(input, errors);
  budget->noise_px = variance.cwiseSqrt();
  // Fitting reduces the variance by the ratio of parameters to observations.
  const double count = static_cast<double>(input.features.size());
  const double left = std::max(
      0.0, 1 - (input.num_parameters + 6.0 * budget->num_views) / (2 * count));
  budget->noise = left * count * variance.sum() / squares;
}

}  // namespace

const char* ToString(ErrorCause cause) {
  switch (cause) {
    case ErrorCause::kImagePosition:
      return "lens model";
    case ErrorCause::kBoardPosition:
      return "target geometry";
    case ErrorCause::kDeformation:
      return "per-view deformation";
    case ErrorCause::kInPlane:
      return "in-plane deformation";
    case ErrorCause::kImageAffine:
      return "image shift/scale";
    default:
      return "rolling shutter";
  }
}

double ResidualBudget::PerViewShare() const {
  return Of(ErrorCause::kDeformation).sequential_share +
         Of(ErrorCause::kInPlane).sequential_share +
         Of(ErrorCause::kImageAffine).sequential_share +
         Of(ErrorCause::kRollingShutter).sequential_share;
}

ResidualBudget ComputeResidualBudget(const BudgetInput& input) {
  ResidualBudget budget;
  budget.facts = input.facts;
  budget.num_features = static_cast<int>(input.features.size());
  budget.num_views = static_cast<int>(CountFeaturesByView(input).size());
  const double squares = SumSquares(input);
  if (budget.num_features < kMinBudgetFeatures) {
    budget.unobservable_reason =
        fmt::format("{} features, at least {} required", budget.num_features,
                    kMinBudgetFeatures);
    return budget;
  }
  budget.rms_px = std::sqrt(squares / (2.0 * budget.num_features));
  const Eigen::VectorXd errors = ErrorsWithin(input);
  if (!(errors.squaredNorm() > 0) || !std::isfinite(squares)) {
    budget.unobservable_reason = "all residuals are zero";
    return budget;
  }
  budget.large = 1 - errors.squaredNorm() / squares;
  const Eigen::VectorXd left =
      ExplainByImagePosition(input, squares, errors, &budget);
  ExplainByViewEffects(input, squares, left, &budget);
  AddNoise(input, squares, left, &budget);
  const double explained =
      budget.large + budget.PerViewShare() +
      budget.Of(ErrorCause::kImagePosition).sequential_share +
      budget.Of(ErrorCause::kBoardPosition).sequential_share;
  // If residuals of neighbours are anticorrelated, the noise estimate exceeds
  // the variance of all residuals.
  budget.noise = std::min(budget.noise, std::max(0.0, 1 - explained));
  budget.rest = 1 - explained - budget.noise;
  return budget;
}

}  // namespace raygrid
