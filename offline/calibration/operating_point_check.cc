#include "calibration/operating_point_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "calibration/value_equations.h"
#include "calibration/value_regression.h"
#include "camera/operating_point_model.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

// Minimum error to report, as a fraction of the range.
constexpr double kMinFraction = 0.05;
constexpr double kDisplayedFraction = 0.02;       // displayed resolution
constexpr double kStdDevPerMedianScore = 1.4826;  // standard deviation / median
// Probability of reporting any image in a calibration without wrong values.
constexpr double kFalseAlarmProbability = 1e-3;
// A parameter is reported if errors up to this fraction of its range are
// undetectable.
constexpr double kMaxUndetectableFraction = 0.5;
// Maximum fraction of wrong values; if there are more, the parameter does not
// explain the images.
constexpr double kMaxExcludedFraction = 1.0 / 3;

const std::vector<OperatingRange>& GetOperatingRanges(
    const AdjustmentResult& adjusted) {
  return adjusted.state.camera().GetOperatingPointModel()->ranges();
}

double GetWidth(const OperatingRange& range) { return range.high - range.low; }

// Converts a quantile of Student's t-distribution to the normal distribution
// (Wallace, "Bounds on normal approximations to Student's and the chi-square
// distributions", 1959).
double NormalScoreFromStudent(double t, double degrees_of_freedom) {
  return (8 * degrees_of_freedom + 1) / (8 * degrees_of_freedom + 3) *
         std::sqrt(degrees_of_freedom * std::log1p(t * t / degrees_of_freedom));
}

// Whether a score significantly exceeds the maximum of `count` random scores
// (Bonferroni correction).
bool IsSignificant(double score, double degrees_of_freedom,
                   Eigen::Index count) {
  return static_cast<double>(count) *
             std::erfc(NormalScoreFromStudent(score, degrees_of_freedom) /
                       std::sqrt(2.0)) <
         kFalseAlarmProbability;
}

// Detects wrong values from the steps that the normal equations suggest for
// them.
class ValueOutlierTest {
 public:
  ValueOutlierTest(const AdjustmentResult& adjusted,
                   const ValueEquations& equations)
      : ranges_(GetOperatingRanges(adjusted)),
        num_images_(static_cast<double>(equations.images.size())),
        count_(equations.count()) {
    for (int r = 0; r < equations.num_ranges; ++r)
      stddev_scales_.push_back(ComputeStdDevScale(r, equations));
  }

  // Returns the smallest detectable error of a value with the given standard
  // deviation.
  double ComputeMinDetectableError(double deviation, int range) const {
    constexpr double kStep = 1.05;
    double error = kMinFraction * GetWidth(ranges_[range]);
    while (!IsDoubtful({error, deviation}, range)) error *= kStep;
    return error;
  }

  bool IsDoubtful(const ValueStep& step, int range) const {
    return std::abs(step.step) >= kMinFraction * GetWidth(ranges_[range]) &&
           IsSignificant(step.Score() / stddev_scales_[range], num_images_,
                         count_);
  }

 private:
  // Returns the ratio of the actual scatter of the steps of a range to their
  // standard deviations: other model errors shift values as well.
  static double ComputeStdDevScale(int range, const ValueEquations& equations) {
    std::vector<double> scores;
    for (Eigen::Index i = range; i < equations.count();
         i += equations.num_ranges)
      scores.push_back(equations.ComputeStep(i).Score());
    return std::max(1.0, kStdDevPerMedianScore * Quantile(scores, 0.5));
  }

  std::vector<OperatingRange> ranges_;
  std::vector<double> stddev_scales_;
  double num_images_;
  Eigen::Index count_;
};

// Returns the images whose values are inconsistent with the normal equations.
std::set<std::string> FindImagesWithDoubtfulValues(
    const AdjustmentResult& adjusted, const ValueEquations& equations) {
  const ValueOutlierTest outlier_test(adjusted, equations);
  std::set<std::string> images;
  for (Eigen::Index i = 0; i < equations.count(); ++i)
    if (outlier_test.IsDoubtful(equations.ComputeStep(i),
                                equations.RangeIndex(i)))
      images.insert(equations.images[equations.GetImageIndex(i)]);
  return images;
}

// Removes the images' views; each view has a separate pose.
void RemoveImages(const std::set<std::string>& images,
                  AdjustmentResult* adjusted) {
  std::vector<bool> remove;
  std::vector<Pose> poses;
  std::vector<DeformationModes::Coefficients> flex;
  const AdjustmentState& state = adjusted->state;
  for (size_t v = 0; v < adjusted->problem.views.size(); ++v) {
    remove.push_back(images.count(adjusted->problem.images[v]) > 0);
    if (remove.back()) continue;
    poses.push_back(state.rig_from_pattern[adjusted->problem.views[v].pose]);
    if (state.HasPerViewDeformation())
      flex.push_back(state.flex[adjusted->problem.views[v].pose]);
  }
  RemoveViews(remove, &adjusted->problem);
  adjusted->state.rig_from_pattern = std::move(poses);
  if (state.HasPerViewDeformation()) adjusted->state.flex = std::move(flex);
}

// Returns the views of an image with all its features, since those least
// consistent with the stated value were rejected as outliers.
std::vector<View> SelectViews(const std::string& image,
                              const CalibrationProblem& problem,
                              const CalibrationProblem& given) {
  std::vector<View> views;
  for (size_t v = 0; v < problem.views.size(); ++v) {
    if (problem.images[v] != image) continue;
    views.push_back(problem.views[v]);
    for (size_t g = 0; g < given.views.size(); ++g)
      if (given.images[g] == image && given.boards[g] == problem.boards[v])
        views.back().observations = given.views[g].observations;
  }
  return views;
}

// Whether images differ significantly, but stated values explain the
// differences no better than permuted values, or leave most of them
// unexplained.
bool AreUnexplained(const ValueRegression& regression,
                    const OperatingRange& range) {
  constexpr double kScatterLimitSigmas = 3, kMinPValue = 0.01,
                   kMaxRemainingFraction = 0.15;
  return (regression.scatter_around_constant > kScatterLimitSigmas &&
          regression.p_value > kMinPValue) ||
         (regression.scatter > kScatterLimitSigmas &&
          regression.left > kMaxRemainingFraction * GetWidth(range));
}

// Finds images whose fitted values deviate from the regression on stated
// values.
std::set<std::string> FindInconsistentImages(
    const std::vector<FittedValue>& values, const ValueRegression& regression) {
  const size_t count = regression.scores.size();
  std::set<std::string> images;
  for (size_t i = 0; i < count; ++i)
    if (IsSignificant(regression.scores[i], static_cast<double>(count),
                      static_cast<Eigen::Index>(count)))
      images.insert(values[i].image);
  return images;
}

// Summarizes how well the features of an image determine the value of a range.
// Where the camera hardly depends on the value, wrong values cannot be
// detected.
UncertainOperatingParameter MakeUncertainParameter(
    const std::vector<FittedValue>& values, const OperatingRange& range,
    int index, const ValueOutlierTest& outlier_test) {
  UncertainOperatingParameter uncertainty = {range.condition, GetWidth(range)};
  if (values.empty()) return uncertainty;
  std::vector<double> deviations;
  double mean = 0, squares = 0;
  for (const FittedValue& value : values) {
    deviations.push_back(value.deviation);
    mean += value.stated / static_cast<double>(values.size());
  }
  for (const FittedValue& value : values)
    squares += std::pow((value.stated - mean) / value.deviation, 2);
  uncertainty.deviation = Quantile(deviations, 0.5);
  uncertainty.min_detectable_error =
      outlier_test.ComputeMinDetectableError(uncertainty.deviation, index);
  uncertainty.change_score = std::sqrt(squares);
  return uncertainty;
}

// Estimates the values of images with a model that was adjusted without them.
std::vector<SuspectOperatingPoint> PredictValues(
    const std::set<std::string>& images, const AdjustmentResult& all,
    const CalibrationProblem& given, const AdjustmentResult& remaining,
    int num_threads) {
  std::vector<SuspectOperatingPoint> doubtful;
  const ValueEquations equations = MakeValueEquations(remaining, num_threads);
  if (equations.count() == 0) return doubtful;
  const ValueOutlierTest outlier_test(remaining, equations);
  const std::vector<OperatingRange>& ranges = GetOperatingRanges(all);
  AdjustmentState state = all.state;
  state.cameras[0] = remaining.state.camera().Clone();
  for (const std::string& image : images) {
    const std::vector<View> views = SelectViews(image, all.problem, given);
    for (size_t r = 0; r < ranges.size(); ++r) {
      const ValueStep step = FitValue(state, views, r, ranges[r]);
      if (!outlier_test.IsDoubtful(step, static_cast<int>(r))) continue;
      const double stated = views.front().conditions[r];
      const int num_decimals = std::clamp(
          static_cast<int>(
              std::ceil(-std::log10(kDisplayedFraction * GetWidth(ranges[r])))),
          0, 9);
      doubtful.push_back({image, ranges[r].condition, stated,
                          stated + step.step, num_decimals});
    }
  }
  return doubtful;
}

}  // namespace

std::string SuspectOperatingPoint::Text() const {
  return fmt::format(
      "{} is specified as {:g} {}, but its features indicate {:.{}f}", image,
      stated, OperatingParameterUnit(condition), predicted, num_decimals);
}

std::string UnexplainedOperatingParameter::Text() const {
  const std::string name = OperatingParameterName(condition);
  return fmt::format(
      "the specified {} does not explain the differences between images: check "
      "that each value belongs to its image and that all use the same unit, or "
      "calibrate without {}",
      name, name);
}

bool UncertainOperatingParameter::IsUnobservable() const {
  constexpr double kOutlierSigmas = 6;
  return change_score < kOutlierSigmas;
}

std::string UncertainOperatingParameter::Text() const {
  const std::string name = OperatingParameterName(condition),
                    unit = OperatingParameterUnit(condition);
  if (IsUnobservable())
    return fmt::format(
        "the images show no change of the camera with {}: the value estimated "
        "from a single image has a standard deviation of {:.2g} {} over a "
        "range of {:.2g}; the effect is too small, or the values do not belong "
        "to these images: check them, or calibrate without {}",
        name, deviation, unit, width, name);
  const std::string detection =
      min_detectable_error > width
          ? "single wrong values cannot be detected"
          : fmt::format(
                "a single wrong value is detected only if its error "
                "exceeds {:.2g} {}",
                min_detectable_error, unit);
  return fmt::format(
      "the camera changes little with {}: the value estimated from a single "
      "image has a standard deviation of {:.2g} {} over a range of {:.2g}, so "
      "that {}",
      name, deviation, unit, width, detection);
}

OperatingPointCheck CheckOperatingPoints(
    const AdjustmentResult& adjusted, const CalibrationProblem& given,
    const std::function<void(AdjustmentResult* fewer)>& readjust,
    int num_threads) {
  constexpr int kMaxRounds = 4;
  const std::vector<OperatingRange>& ranges = GetOperatingRanges(adjusted);
  const size_t num_images =
      std::set<std::string>(adjusted.problem.images.begin(),
                            adjusted.problem.images.end())
          .size();
  OperatingPointCheck check;
  // Wrong values distort the model, which masks them and makes correct values
  // suspect. The model is therefore adjusted without the suspect images,
  // repeatedly if this reveals more of them.
  AdjustmentResult remaining = adjusted;
  std::set<std::string> left_out;
  for (int round = 0; round < kMaxRounds; ++round) {
    std::set<std::string> found;
    for (size_t r = 0; r < ranges.size(); ++r) {
      const std::vector<FittedValue> values =
          FitValues(remaining, r, num_threads);
      const ValueRegression regression = RegressValues(values);
      found.merge(FindInconsistentImages(values, regression));
      if (AreUnexplained(regression, ranges[r]) ||
          kMaxExcludedFraction * static_cast<double>(num_images) <
              static_cast<double>(left_out.size() + found.size()))
        check.unexplained.push_back({ranges[r].condition});
    }
    if (!check.unexplained.empty()) return check;
    const ValueEquations equations = MakeValueEquations(remaining, num_threads);
    if (equations.count() == 0) return check;
    check.uncertain.clear();
    for (size_t r = 0; r < ranges.size(); ++r) {
      const UncertainOperatingParameter uncertainty = MakeUncertainParameter(
          FitValues(remaining, r, num_threads), ranges[r], static_cast<int>(r),
          ValueOutlierTest(remaining, equations));
      if (uncertainty.min_detectable_error >
          kMaxUndetectableFraction * GetWidth(ranges[r]))
        check.uncertain.push_back(uncertainty);
    }
    found.merge(FindImagesWithDoubtfulValues(remaining, equations));
    if (found.empty()) break;
    left_out.insert(found.begin(), found.end());
    RemoveImages(found, &remaining);
    readjust(&remaining);
  }
  if (!left_out.empty())
    check.doubtful =
        PredictValues(left_out, adjusted, given, remaining, num_threads);
  return check;
}

}  // namespace raygrid
