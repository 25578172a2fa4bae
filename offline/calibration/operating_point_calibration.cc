#include "calibration/operating_point_calibration.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "adjustment/smoothness_prior.h"
#include "calibration/board_rotations.h"
#include "calibration/camera_in_progress.h"
#include "calibration/camera_result.h"
#include "calibration/operating_point_check.h"
#include "calibration/operating_point_initialization.h"
#include "calibration/stopwatch.h"
#include "calibration/uncertainty_estimation.h"
#include "camera/operating_point_grid.h"
#include "dataset/error.h"
#include "dataset/repeated_images.h"

namespace raygrid {
namespace {

// Returns the fraction of the variance of one parameter that is uncorrelated
// with the other one.
double ComputeUncorrelatedFraction(const Eigen::MatrixX2d& values) {
  const Eigen::MatrixX2d centered = values.rowwise() - values.colwise().mean();
  const Eigen::Vector2d squares = centered.colwise().squaredNorm();
  const double product = centered.col(0).dot(centered.col(1));
  return 1 - product * product / (squares[0] * squares[1]);
}

// Throws if a parameter has the same value in all images, or if the two
// parameters are correlated.
void RequireDistinctValues(const ImageOperatingPoints& conditions,
                           const std::vector<OperatingPoint>& values) {
  for (size_t k = 0; k < conditions.conditions.size(); ++k) {
    const std::string name = OperatingParameterName(conditions.conditions[k]);
    // Smaller differences have no measurable effect on a camera.
    const double least =
        conditions.conditions[k] == OperatingParameter::kLensPosition ? 0.01
                                                                      : 0.1;
    const auto [low, high] = std::minmax_element(
        values.begin(), values.end(),
        [k](const OperatingPoint& a, const OperatingPoint& b) {
          return a[k] < b[k];
        });
    const double spread = (*high)[k] - (*low)[k];
    if (spread < least)
      throw Error(
          ExitCode::kUsage,
          fmt::format(
              "all images have the same {}{}: its effect on the camera is not "
              "observable; calibrate without {}, or add images at other values",
              name,
              spread > 0
                  ? fmt::format(
                        " (range {:.2g}, required {:g} {})", spread, least,
                        OperatingParameterUnit(conditions.conditions[k]))
                  : std::string(),
              conditions.conditions.size() > 1 ? name
                                               : std::string("--vary-with")));
  }
  if (conditions.conditions.size() < 2) return;
  // Below this fraction, changes cannot be attributed to one of the parameters.
  constexpr double kMinFraction = 0.05;
  Eigen::MatrixX2d both(values.size(), 2);
  for (size_t i = 0; i < values.size(); ++i)
    both.row(static_cast<Eigen::Index>(i)) << values[i][0], values[i][1];
  if (ComputeUncorrelatedFraction(both) < kMinFraction)
    throw Error(
        ExitCode::kUsage,
        "lens_position and temperature of the images are correlated, so their "
        "effects cannot be separated; add images at other combinations, or "
        "calibrate over only one of the two quantities");
}

// Maximum value that a blob can store: formats/SPEC.md, "Operating points".
constexpr double kMaxValue = 1024;

// Requires equal operating points for duplicate images.
void RequireDuplicatesHaveEqualValues(const Dataset& dataset,
                                      const ImageOperatingPoints& conditions) {
  const std::vector<std::optional<size_t>> repeated = RepeatedImages(dataset);
  for (size_t i = 0; i < repeated.size(); ++i)
    if (repeated[i])
      RequireConsistentValues(conditions, dataset.images[*repeated[i]].image,
                              dataset.images[i].image);
}

void RequireOperatingPoints(const Dataset& dataset,
                            const ImageOperatingPoints& conditions,
                            const CalibrationOptions& options) {
  std::string names;
  for (const OperatingParameter condition : conditions.conditions)
    names += (names.empty() ? "" : ",") + OperatingParameterName(condition);
  if (options.model != models::kCentralGeneric)
    throw Error(ExitCode::kUsage,
                fmt::format("--vary-with {}: requires model {}, not {}", names,
                            models::kCentralGeneric, options.model));
  std::vector<OperatingPoint> values;
  for (const ImageFeatures& image : dataset.images) {
    const auto found = conditions.values.find(image.image);
    if (found == conditions.values.end() ||
        !std::all_of(found->second.begin(), found->second.end(),
                     [](double value) { return std::isfinite(value); }))
      throw Error(ExitCode::kUsage,
                  fmt::format("image {} has no {}: specify a value for each "
                              "image, or remove the image",
                              image.image, names));
    for (const double value : found->second)
      if (std::abs(value) > kMaxValue)
        throw Error(
            ExitCode::kUsage,
            fmt::format(
                "image {}: {} is {:g}, above the limit of {:g}; use dioptres "
                "or °C, or divide all values by the same factor",
                image.image, names, value, kMaxValue));
    values.push_back(found->second);
  }
  RequireDistinctValues(conditions, values);
  RequireDuplicatesHaveEqualValues(dataset, conditions);
}

using FeatureKey = std::tuple<std::string, int, int, int>;

// Returns the features of the images with poses, at their observed positions
// and without rejected ones.
Dataset SelectUsedImages(const Dataset& given,
                         const CalibrationResult& result) {
  std::set<FeatureKey> rejected;
  for (const FeatureResidual& f : result.rejected_features)
    rejected.insert({f.image, f.board, f.column, f.row});
  std::set<std::string> placed;
  for (const BoardPose& pose : result.poses) placed.insert(pose.image);
  Dataset used = {given.image_size, {}};
  for (const ImageFeatures& image : given.images) {
    if (placed.count(image.image) == 0) continue;
    used.images.push_back({image.image, {}});
    for (const Feature& f : image.features)
      if (rejected.count({image.image, f.board, f.column, f.row}) == 0)
        used.images.back().features.push_back(f);
  }
  return used;
}

// Sets up the problem of all images at their operating points, starting from
// the poses and boards of the mid-range camera.
AdjustmentResult InitializeFrom(const CalibrationResult& result,
                                const Dataset& used,
                                const ImageOperatingPoints& conditions,
                                const Pattern& pattern,
                                const OperatingPointModel& stack) {
  AdjustmentResult adjusted;
  std::vector<RejectedImage> rejected;
  adjusted.problem = BuildProblem({used}, pattern, &rejected);
  CalibrationProblem& problem = adjusted.problem;
  AdjustmentState& state = adjusted.state;
  state.SetCamera(OperatingPointGrid(stack, stack.Center()));
  for (const Board& board : result.pattern.boards)
    state.points.insert(state.points.end(), board.points.begin(),
                        board.points.end());
  std::map<std::pair<std::string, int>, Pose> poses;
  for (const BoardPose& pose : result.poses)
    poses[{pose.image, pose.board}] = pose.camera_from_board;
  const auto pose_of = [&](size_t v) {
    return poses.find(
        {problem.images[v], pattern.boards[problem.boards[v]].id});
  };
  std::vector<bool> are_lost;
  for (size_t v = 0; v < problem.views.size(); ++v)
    are_lost.push_back(pose_of(v) == poses.end());
  RemoveViews(are_lost, &problem);
  state.rig_from_pattern.resize(problem.num_poses);
  for (size_t v = 0; v < problem.views.size(); ++v) {
    View& view = problem.views[v];
    view.conditions = conditions.values.at(problem.images[v]);
    state.rig_from_pattern[view.pose] = pose_of(v)->second;
  }
  adjusted.prior.cameras = {MakeOperatingPointPrior(
      stack.At(stack.Center()), static_cast<int>(stack.terms().size()))};
  adjusted.prior.points_mean = problem.nominal;
  adjusted.rejected_features = {result.rejected_features};
  return adjusted;
}

// Optimizes all images at their operating points.
void OptimizeOperatingPointModel(const CalibrationResult& result,
                                 const Pattern& pattern,
                                 const CalibrationOptions& options,
                                 AdjustmentResult* adjusted) {
  AdjustmentOptions adjustment = MakeStoppableOptions(options);
  AdjustmentOptions first = adjustment;
  first.fix_points = true;
  first.is_initialization = true;
  const auto adjust = [&](const AdjustmentOptions& with) {
    adjusted->summary = OptimizeWithLearnedPrior(
        adjusted->problem.views, with, &adjusted->prior, &adjusted->state);
  };
  adjust(first);
  const CalibrationProblem& problem = adjusted->problem;
  if (result.bends) {
    adjusted->state.SetModes(GetDeformationModes(problem),
                             DeformationScope::kPose);
    adjustment.rigid_boards = false;
  } else if (HavePointsMoved(*adjusted)) {
    adjusted->state.FitStaticDeformation(GetDeformationModes(problem),
                                         problem.nominal);
  }
  if (!HavePointsMoved(*adjusted)) adjustment.fix_points = true;
  adjust(adjustment);
  AlignBoards(pattern, adjusted);
}

// Returns the Cartesian product of evenly spaced values over the ranges, in
// ascending order.
std::vector<OperatingPoint> ListSampledValues(
    const OperatingPointModel& stack) {
  // The second parameter changes the camera little, and each value costs
  // computation time and storage.
  constexpr int kNumFirst = 5, kNumSecond = 3;
  std::vector<OperatingPoint> all = {{}};
  for (const OperatingRange& range : stack.ranges()) {
    std::vector<OperatingPoint> longer;
    for (const OperatingPoint& values : all)
      for (const double value :
           range.SampleValues(values.empty() ? kNumFirst : kNumSecond)) {
        longer.push_back(values);
        longer.back().push_back(value);
      }
    all = std::move(longer);
  }
  return all;
}

// Computes the standard deviations of the model at values over its ranges.
std::vector<OperatingPointUncertainty> ComputeOperatingPointStdDevs(
    const AdjustmentResult& adjusted, int num_threads) {
  const OperatingPointModel& stack =
      *adjusted.state.camera().GetOperatingPointModel();
  std::vector<OperatingPointGrid> cameras;
  std::vector<const CameraModel*> as;
  for (const OperatingPoint& values : ListSampledValues(stack))
    cameras.emplace_back(stack, values);
  for (const OperatingPointGrid& camera : cameras) as.push_back(&camera);
  std::vector<OperatingPointUncertainty> deviations;
  for (const UncertaintyLattice& lattice :
       EstimateStdDevs(adjusted, 0, as, num_threads))
    deviations.push_back({cameras[deviations.size()].values(), lattice});
  return deviations;
}

// Returns the RMS of the residual of t^(order + 1) after fitting polynomials of
// this order.
double ComputeRmsAboveOrder(const Eigen::ArrayXd& t, int order) {
  Eigen::MatrixXd powers(t.size(), order + 1);
  for (int k = 0; k <= order; ++k) powers.col(k) = t.pow(k);
  const Eigen::VectorXd next = t.pow(order + 1);
  const Eigen::VectorXd beyond =
      next - powers * powers.colPivHouseholderQr().solve(next);
  return std::sqrt(beyond.squaredNorm() / static_cast<double>(t.size()));
}

// Returns the centre of the widest gap between the values.
double FindWidestGapCenter(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  size_t widest_gap = 1;
  for (size_t k = 1; k < values.size(); ++k)
    if (values[k] - values[k - 1] > values[widest_gap] - values[widest_gap - 1])
      widest_gap = k;
  return (values[widest_gap - 1] + values[widest_gap]) / 2;
}

// Returns parameters whose polynomial order cannot be validated: a line fits
// any two values, so that images at these reveal no interpolation error.
std::vector<std::string> FindUntestedParameters(
    const OperatingPointModel& stack, const AdjustmentResult& adjusted) {
  constexpr double kMinFraction = 0.3;  // relative to evenly spaced values
  std::vector<std::string> untested;
  for (size_t k = 0; k < stack.ranges().size(); ++k) {
    const OperatingRange& range = stack.ranges()[k];
    std::vector<double> values;
    for (const View& view : adjusted.problem.views)
      values.push_back(view.conditions[k]);
    const Eigen::ArrayXd t =
        (Eigen::Map<const Eigen::ArrayXd>(
             values.data(), static_cast<Eigen::Index>(values.size())) -
         range.Center()) /
        (range.high - range.Center());
    const int order = stack.orders()[k];
    const Eigen::ArrayXd even = Eigen::ArrayXd::LinSpaced(101, -1, 1);
    if (ComputeRmsAboveOrder(t, order) <
        kMinFraction * ComputeRmsAboveOrder(even, order))
      untested.push_back(fmt::format(
          "a polynomial of order {} interpolates these values of {} exactly, "
          "so its error between them is unknown and not included in the "
          "predicted uncertainty: add images in between, such as at {:.3g} {}",
          order, OperatingParameterName(range.condition),
          FindWidestGapCenter(values),
          OperatingParameterUnit(range.condition)));
  }
  return untested;
}

void Warn(const std::string& reason, Assessment* assessment) {
  if (assessment->word == "pass") assessment->word = "warn";
  assessment->reasons.insert(assessment->reasons.begin(), reason);
}

void WarnAboutCheck(const OperatingPointCheck& check, Assessment* assessment) {
  constexpr size_t kMaxListedImages = 5;
  for (const UnexplainedOperatingParameter& condition : check.unexplained)
    Warn(condition.Text(), assessment);
  for (const UncertainOperatingParameter& condition : check.uncertain) {
    if (condition.IsUnobservable())
      Warn(condition.Text(), assessment);
    else
      assessment->reasons.push_back(condition.Text());
  }
  const std::vector<SuspectOperatingPoint>& doubtful = check.doubtful;
  if (doubtful.empty()) return;
  std::string names;
  for (size_t k = 0; k < std::min(doubtful.size(), kMaxListedImages); ++k)
    names += (k == 0 ? "" : "; ") + doubtful[k].Text();
  if (doubtful.size() > kMaxListedImages)
    names += fmt::format("; and {} more", doubtful.size() - kMaxListedImages);
  Warn(names + ": correct the values, or remove these images", assessment);
}

// Optimizes a model from the features of a problem alone, since its previous
// state may be distorted by images that were removed.
void OptimizeFromFeatures(const ImageOperatingPoints& conditions,
                          const Pattern& pattern,
                          const CalibrationOptions& options,
                          AdjustmentResult* adjusted) {
  CalibrationProblem& problem = adjusted->problem;
  AdjustmentState& state = adjusted->state;
  const OperatingPointModel& before = *state.camera().GetOperatingPointModel();
  const BSplineSurface& grid = before.terms().front();
  Dataset dataset = {before.image_size(), {}};
  for (size_t v = 0; v < problem.views.size(); ++v) {
    if (dataset.images.empty() ||
        dataset.images.back().image != problem.images[v])
      dataset.images.push_back({problem.images[v], {}});
    for (const Observation& observation : problem.views[v].observations)
      dataset.images.back().features.push_back(
          problem.GetFeature(pattern, static_cast<int>(v), observation));
  }
  const OperatingPointModel start =
      InitializeOperatingPointModel(dataset, conditions, pattern, options);
  const CentralGeneric center = FitCentralGeneric(
      start.At(start.Center()), grid.area(), grid.columns(), grid.rows());
  const OperatingPointModel stack = TransferTermsBetweenGrids(start, center);
  for (const View& view : problem.views)
    if (const auto pose = Localize(stack.At(view.conditions),
                                   MakeMatches(view, problem.nominal)))
      state.rig_from_pattern[view.pose] = *pose;
  state.SetCamera(OperatingPointGrid(stack, stack.Center()));
  adjusted->prior.cameras = {
      MakeOperatingPointPrior(center, static_cast<int>(stack.terms().size()))};
  AdjustmentOptions adjustment = MakeStoppableOptions(options);
  adjustment.fix_points = true;
  adjusted->summary = OptimizeWithLearnedPrior(problem.views, adjustment,
                                               &adjusted->prior, &state);
}

// Replaces the result of the mid-range camera by that of the operating-point
// model.
void FillOperatingPointResult(const CalibrationInput& input,
                              const ImageOperatingPoints& conditions,
                              const Pattern& pattern,
                              const CalibrationOptions& options,
                              const AdjustmentResult& adjusted,
                              CalibrationResult* result) {
  const OperatingPointModel& stack =
      *adjusted.state.camera().GetOperatingPointModel();
  result->poses.clear();
  FillResult(pattern, adjusted, 0, input.image_circle, options.num_threads,
             result);
  FillUncertainty(adjusted, 0, input.image_circle, options.valid_px,
                  options.num_threads, result);
  CentralGeneric center = stack.At(stack.Center());
  center.SetImageCircle(input.image_circle);
  result->camera.camera = center.Clone();
  result->camera.stack = OperatingPointCalibration{
      stack, ComputeOperatingPointStdDevs(adjusted, options.num_threads)};
  const auto reoptimize = [&](AdjustmentResult* subset) {
    try {
      OptimizeFromFeatures(conditions, pattern, options, subset);
    } catch (const Error&) {  // not solvable: keeps the model
    }
  };
  std::vector<RejectedImage> rejected;
  const OperatingPointCheck check = CheckOperatingPoints(
      adjusted, BuildProblem({input.dataset}, pattern, &rejected), reoptimize,
      options.num_threads);
  if (!check.unexplained.empty()) {
    // Residuals due to wrong values resemble deformation, motion or focus
    // errors.
    result->budget.reset();
    result->mixed_cameras.reset();
    result->flatness_error_m = 0;
  }
  AssessResult(options.num_threads, result);
  WarnAboutCheck(check, &result->assessment);
  for (const std::string& reason : FindUntestedParameters(stack, adjusted))
    Warn(reason, &result->assessment);
}

}  // namespace

void RequireConsistentValues(const ImageOperatingPoints& conditions,
                             const std::string& image,
                             const std::string& copy) {
  const auto first = conditions.values.find(image),
             second = conditions.values.find(copy);
  const auto end = conditions.values.end();
  if (first == end || second == end || first->second == second->second) return;
  throw InputError(fmt::format(
      "images {} and {} have the same features but different operating points, "
      "{:g} and {:g}; use different images for each value",
      image, copy, fmt::join(first->second, ","),
      fmt::join(second->second, ",")));
}

int MaxPolynomialOrder(int num_values) {
  return std::clamp((num_values + 1) / 2, 1, OperatingPointModel::kMaxOrder);
}

RigResult CalibrateOperatingPoints(const CalibrationInput& input,
                                   const ImageOperatingPoints& conditions,
                                   const Pattern& pattern,
                                   const CalibrationOptions& options) {
  RequireOperatingPoints(input.dataset, conditions, options);
  const auto report = [&](const char* stage, double done) {
    if (options.progress) options.progress(stage, done);
  };
  report("initialization over the range", 0);
  std::map<std::string, double> seconds;
  std::optional<OperatingPointModel> start;
  {
    const Stopwatch stopwatch(&seconds["stack_start"]);
    start = InitializeOperatingPointModel(input.dataset, conditions, pattern,
                                          options);
  }
  CalibrationInput at_center = input;
  at_center.dataset = MapFeaturesToReference(input.dataset, conditions, *start);
  // Refinement would search at the mapped, not at the observed feature
  // positions.
  at_center.refine_features = nullptr;
  CalibrationOptions mean_options = options;
  mean_options.progress = [&](const std::string& stage, double done) {
    if (options.progress) options.progress(stage, 0.1 + 0.7 * done);
  };
  RigResult result = Calibrate({at_center}, pattern, mean_options);
  CalibrationResult& camera = result.cameras.front();
  // The observed features, with boards rotated according to their poses.
  const Dataset turned = Rotated(input.dataset, pattern, camera.turns);
  if (options.ShouldStop()) {
    // The result is the mid-range camera, but files list the observed features.
    camera.features = SelectUsedImages(turned, camera);
    return result;
  }
  report("bundle adjustment over the range", 0.8);
  const OperatingPointModel stack =
      TransferTermsBetweenGrids(*start, MakeCentral(*camera.camera.camera));
  AdjustmentResult adjusted = InitializeFrom(
      camera, SelectUsedImages(turned, camera), conditions, pattern, stack);
  adjusted.problem.area = options.area;
  {
    const Stopwatch stopwatch(&seconds["stack_adjustment"]);
    OptimizeOperatingPointModel(camera, pattern, options, &adjusted);
  }
  {
    const Stopwatch stopwatch(&seconds["stack_figures"]);
    FillOperatingPointResult(input, conditions, pattern, options, adjusted,
                             &camera);
  }
  result.seconds.merge(seconds);
  result.pattern = camera.pattern;
  result.converged = camera.converged;
  result.assessment = AssessRig(result);
  report("done", 1);
  return result;
}

}  // namespace raygrid
