#include "calibration/value_regression.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>

#include "calibration/value_equations.h"
#include "camera/operating_point_grid.h"
#include "dataset/parallel_for.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

constexpr double kStdDevPerMedian = 1.4826;  // for a normal distribution

// Fits a line to a power of t; returns intercept and slope.
Eigen::Vector2d FitLineToPower(const Eigen::ArrayXd& t, int power) {
  const Eigen::ArrayXd values = t.pow(power), centered = t - t.mean();
  const double slope = (centered * values).sum() / centered.square().sum();
  return {values.mean() - slope * t.mean(), slope};
}

void AddTerm(double factor, const BSplineSurface& term, BSplineSurface* sum) {
  for (size_t k = 0; k < term.points().size(); ++k)
    sum->points()[k] += factor * term.points()[k];
}

// Returns the linear model that best approximates a model over the values of
// the views.
OperatingPointModel MakeLinearModel(const OperatingPointModel& stack,
                                    const std::vector<View>& views) {
  const size_t num_ranges = stack.ranges().size();
  OperatingPointModel straight(stack.ranges(), std::vector<int>(num_ranges, 1),
                               stack.At(stack.Center()));
  for (size_t r = 0; r < num_ranges; ++r) {
    const OperatingRange& range = stack.ranges()[r];
    Eigen::ArrayXd t(views.size());
    for (size_t v = 0; v < views.size(); ++v)
      t[static_cast<Eigen::Index>(v)] =
          (views[v].conditions[r] - range.Center()) /
          (range.high - range.Center());
    for (int power = 1; power <= stack.orders()[r]; ++power) {
      const BSplineSurface& term =
          stack.terms()[stack.FirstTerm(r) + power - 1];
      const Eigen::Vector2d line = FitLineToPower(t, power);
      AddTerm(line[0], term, &straight.terms().front());
      AddTerm(line[1], term, &straight.terms()[straight.FirstTerm(r)]);
    }
  }
  return straight;
}

// Weighted regression of fitted values on powers of the stated values, which
// are scaled to [-1, 1].
struct Equations {
  Eigen::MatrixXd powers;  // without weights
  Eigen::VectorXd fitted, weight;

  Eigen::Index count() const { return fitted.size(); }
};

Eigen::MatrixXd ComputePowers(const std::vector<double>& values) {
  const auto count = static_cast<Eigen::Index>(values.size());
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const Eigen::ArrayXd t =
      2 * (Eigen::Map<const Eigen::ArrayXd>(values.data(), count) - *low) /
          std::max(*high - *low, 1e-12) -
      1;
  // Uses a quadratic if enough distinct values remain to test its fit.
  const bool is_line =
      std::set<double>(values.begin(), values.end()).size() < 4;
  Eigen::MatrixXd powers(count, is_line ? 2 : 3);
  for (Eigen::Index k = 0; k < powers.cols(); ++k)
    powers.col(k) = t.pow(static_cast<double>(k)).matrix();
  return powers;
}

// Sum of the smallest squared residuals, and all weighted residuals.
struct TrimmedFit {
  double trimmed = INFINITY;
  Eigen::VectorXd residuals;
};

// Least trimmed squares: minimum over random subsets with one image per
// coefficient, each refined by repeated fits to the images with the smallest
// residuals.
TrimmedFit FitTrimmed(const Equations& equations, int num_trials,
                      std::mt19937* random_bits) {
  constexpr int kNumImprovements = 2;
  const Eigen::Index count = equations.count(), num = equations.powers.cols(),
                     num_kept = (count + num + 1) / 2;
  TrimmedFit best;
  std::vector<Eigen::Index> order(count);
  for (Eigen::Index i = 0; i < count; ++i) order[i] = i;
  for (int trial = 0; trial < num_trials; ++trial) {
    for (Eigen::Index i = 0; i < num; ++i)
      std::swap(
          order[i],
          order[i + static_cast<Eigen::Index>((*random_bits)() % (count - i))]);
    Eigen::Index num_rows = num;
    Eigen::VectorXd residuals;
    for (int improvement = 0; improvement <= kNumImprovements; ++improvement) {
      Eigen::MatrixXd rows(num_rows, num);
      Eigen::VectorXd right(num_rows);
      for (Eigen::Index i = 0; i < num_rows; ++i) {
        const double weight = equations.weight[order[i]];
        rows.row(i) = weight * equations.powers.row(order[i]);
        right[i] = weight * equations.fitted[order[i]];
      }
      const Eigen::VectorXd coefficients =
          (rows.transpose() * rows +
           1e-12 * rows.squaredNorm() * Eigen::MatrixXd::Identity(num, num))
              .ldlt()
              .solve(rows.transpose() * right);
      residuals = (equations.fitted - equations.powers * coefficients)
                      .cwiseProduct(equations.weight);
      num_rows = num_kept;
      std::nth_element(order.begin(), order.begin() + (num_kept - 1),
                       order.end(), [&](Eigen::Index a, Eigen::Index b) {
                         return std::abs(residuals[a]) < std::abs(residuals[b]);
                       });
    }
    double trimmed = 0;
    for (Eigen::Index i = 0; i < num_kept; ++i)
      trimmed += residuals[order[i]] * residuals[order[i]];
    if (trimmed < best.trimmed) best = {trimmed, residuals};
  }
  return best;
}

// Returns the robust standard deviation of residuals, from their median.
double ComputeResidualStdDev(const TrimmedFit& fit) {
  const Eigen::VectorXd sizes = fit.residuals.cwiseAbs();
  return kStdDevPerMedian *
         Quantile({sizes.data(), sizes.data() + sizes.size()}, 0.5);
}

// Returns the sum of squared residuals, each truncated at three standard
// deviations.
double TruncatedSquares(const TrimmedFit& fit, double scatter) {
  const double most = 3 * scatter;
  return fit.residuals.cwiseAbs().cwiseMin(most).squaredNorm();
}

}  // namespace

std::vector<FittedValue> FitValues(const AdjustmentResult& adjusted,
                                   size_t range, int num_threads) {
  const OperatingPointModel& stack =
      *adjusted.state.camera().GetOperatingPointModel();
  const std::vector<View>& views = adjusted.problem.views;
  AdjustmentState state = adjusted.state;
  const OperatingPointModel straight = MakeLinearModel(stack, views);
  state.SetCamera(OperatingPointGrid(straight, straight.Center()));
  // Wide limits: wrong values bias the model towards a smaller change.
  OperatingRange limits = stack.ranges()[range];
  const double width = limits.high - limits.low;
  limits.low -= 2 * width;
  limits.high += 2 * width;
  std::map<std::string, std::vector<View>> by_image;
  for (size_t v = 0; v < views.size(); ++v)
    by_image[adjusted.problem.images[v]].push_back(views[v]);
  std::vector<FittedValue> values;
  for (const auto& [image, of_image] : by_image)
    values.push_back({image, of_image.front().conditions[range], 0, 0});
  ParallelFor(
      static_cast<int>(values.size()), NumThreads(num_threads), [&](int i) {
        const ValueStep step =
            FitValue(state, by_image.at(values[i].image), range, limits);
        values[i].fitted = values[i].stated + step.step;
        values[i].deviation = step.deviation;
      });
  values.erase(std::remove_if(values.begin(), values.end(),
                              [](const FittedValue& value) {
                                return !(value.deviation > 0) ||
                                       !std::isfinite(value.deviation);
                              }),
               values.end());
  return values;
}

ValueRegression RegressValues(const std::vector<FittedValue>& values) {
  constexpr int kNumTrials = 500, kNumPermutations = 200, kFewTrials = 40;
  constexpr size_t kMinImages = 8;
  ValueRegression regression;
  if (values.size() < kMinImages) return regression;
  const auto count = static_cast<Eigen::Index>(values.size());
  std::vector<double> stated;
  Equations equations = {Eigen::MatrixXd::Ones(count, 1),
                         Eigen::VectorXd(count), Eigen::VectorXd(count)};
  for (const FittedValue& value : values) {
    const auto i = static_cast<Eigen::Index>(stated.size());
    stated.push_back(value.stated);
    equations.fitted[i] = value.fitted;
    equations.weight[i] = 1 / value.deviation;
  }
  std::mt19937 random_bits;  // default seed: reproducible
  regression.scatter_around_constant =
      ComputeResidualStdDev(FitTrimmed(equations, kNumTrials, &random_bits));
  equations.powers = ComputePowers(stated);
  const TrimmedFit fit = FitTrimmed(equations, kNumTrials, &random_bits);
  regression.scatter = ComputeResidualStdDev(fit);
  regression.left =
      ComputeResidualStdDev({0, fit.residuals.cwiseQuotient(equations.weight)});
  const double scatter = std::max(1.0, regression.scatter);
  for (const double residual : fit.residuals)
    regression.scores.push_back(std::abs(residual) / scatter);
  const double explained = TruncatedSquares(fit, scatter);
  int num_permutations_as_good = 0;
  for (int k = 0; k < kNumPermutations; ++k) {
    for (size_t i = stated.size(); i > 1; --i)
      std::swap(stated[i - 1], stated[random_bits() % i]);
    equations.powers = ComputePowers(stated);
    num_permutations_as_good +=
        TruncatedSquares(FitTrimmed(equations, kFewTrials, &random_bits),
                         scatter) <= explained;
  }
  regression.p_value =
      (1.0 + num_permutations_as_good) / (1.0 + kNumPermutations);
  return regression;
}

}  // namespace raygrid
