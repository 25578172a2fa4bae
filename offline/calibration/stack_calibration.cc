#include "calibration/stack_calibration.h"

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
#include "calibration/board_turns.h"
#include "calibration/camera_in_progress.h"
#include "calibration/camera_result.h"
#include "calibration/camera_trust.h"
#include "calibration/doubtful_condition.h"
#include "calibration/stack_start.h"
#include "calibration/stopwatch.h"
#include "camera/stacked_grid.h"
#include "dataset/error.h"
#include "dataset/repeated_images.h"

namespace raygrid {
namespace {

// The part of the squared spread of one condition that does not go with the
// other one.
double PartBeside(const Eigen::MatrixX2d& values) {
  const Eigen::MatrixX2d centered = values.rowwise() - values.colwise().mean();
  const Eigen::Vector2d squares = centered.colwise().squaredNorm();
  const double product = centered.col(0).dot(centered.col(1));
  return 1 - product * product / (squares[0] * squares[1]);
}

// Throws where all images have one value of a condition, or one condition says
// the other one.
void RequireSpread(const ImageConditions& conditions,
                   const std::vector<ConditionValues>& values) {
  for (size_t k = 0; k < conditions.conditions.size(); ++k) {
    const std::string name = ConditionName(conditions.conditions[k]);
    // Nothing changes by less.
    const double least =
        conditions.conditions[k] == CameraCondition::kLensPosition ? 0.01 : 0.1;
    const auto [low, high] = std::minmax_element(
        values.begin(), values.end(),
        [k](const ConditionValues& a, const ConditionValues& b) {
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
                  ? fmt::format(" (range {:.2g}, required {:g} {})", spread,
                                least, ConditionUnit(conditions.conditions[k]))
                  : std::string(),
              conditions.conditions.size() > 1 ? name
                                               : std::string("--vary-with")));
  }
  if (conditions.conditions.size() < 2) return;
  // Below this, a change is as well one of either condition.
  constexpr double kLeastPart = 0.05;
  Eigen::MatrixX2d both(values.size(), 2);
  for (size_t i = 0; i < values.size(); ++i)
    both.row(static_cast<Eigen::Index>(i)) << values[i][0], values[i][1];
  if (PartBeside(both) < kLeastPart)
    throw Error(ExitCode::kUsage,
                "lens_position and temperature of the images are correlated, "
                "so their effects cannot be separated; add images at other "
                "combinations, or calibrate over one of them");
}

// The largest value that blobs can have: formats/SPEC.md, "Operating points".
constexpr double kMostValue = 1024;

// An image has been taken at one value.
void RequireOneValueOfCopies(const Dataset& dataset,
                             const ImageConditions& conditions) {
  const std::vector<std::optional<size_t>> repeated = RepeatedImages(dataset);
  for (size_t i = 0; i < repeated.size(); ++i)
    if (repeated[i])
      RequireOneValue(conditions, dataset.images[*repeated[i]].image,
                      dataset.images[i].image);
}

void RequireConditions(const Dataset& dataset,
                       const ImageConditions& conditions,
                       const CalibrationOptions& options) {
  std::string names;
  for (const CameraCondition condition : conditions.conditions)
    names += (names.empty() ? "" : ",") + ConditionName(condition);
  if (options.model != models::kCentralGeneric)
    throw Error(ExitCode::kUsage,
                fmt::format("--vary-with {}: requires model {}, not {}", names,
                            models::kCentralGeneric, options.model));
  std::vector<ConditionValues> values;
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
      if (std::abs(value) > kMostValue)
        throw Error(
            ExitCode::kUsage,
            fmt::format(
                "image {}: {} is {:g}, above the limit of {:g}; use dioptres "
                "or °C, or divide all values by the same factor",
                image.image, names, value, kMostValue));
    values.push_back(found->second);
  }
  RequireSpread(conditions, values);
  RequireOneValueOfCopies(dataset, conditions);
}

using FeatureKey = std::tuple<std::string, int, int, int>;

// The features of the images that have poses, where images show them, but for
// those that were rejected.
Dataset UsedOf(const Dataset& given, const CalibrationResult& result) {
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

// The problem of all images at their conditions, from where the camera in the
// middle left poses and boards.
Adjusted StartFrom(const CalibrationResult& result, const Dataset& used,
                   const ImageConditions& conditions, const Pattern& pattern,
                   const CameraStack& stack) {
  Adjusted adjusted;
  std::vector<RejectedImage> rejected;
  adjusted.problem = BuildProblem({used}, pattern, &rejected);
  CalibrationProblem& problem = adjusted.problem;
  AdjustmentState& state = adjusted.state;
  state.SetCamera(StackedGrid(stack, stack.Middle()));
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
  adjusted.prior.cameras = {StackPrior(stack.At(stack.Middle()),
                                       static_cast<int>(stack.terms().size()))};
  adjusted.prior.points_mean = problem.nominal;
  adjusted.rejected_features = {result.rejected_features};
  return adjusted;
}

// Goes on to all images at their conditions.
void AdjustStack(const CalibrationResult& result, const Pattern& pattern,
                 const CalibrationOptions& options, Adjusted* adjusted) {
  AdjustmentOptions adjustment = StoppableAdjustment(options);
  AdjustmentOptions first = adjustment;
  first.fix_points = true;
  first.is_start = true;
  const auto adjust = [&](const AdjustmentOptions& with) {
    adjusted->summary = AdjustWithLearnedPrior(
        adjusted->problem.views, with, &adjusted->prior, &adjusted->state);
  };
  adjust(first);
  const CalibrationProblem& problem = adjusted->problem;
  if (result.bends) {
    adjusted->state.SetModes(ModesOf(problem), BendScope::kPose);
    adjustment.rigid_boards = false;
  } else if (HavePointsMoved(*adjusted)) {
    adjusted->state.TakeShapes(ModesOf(problem), problem.nominal);
  }
  if (!HavePointsMoved(*adjusted)) adjustment.fix_points = true;
  adjust(adjustment);
  AlignBoards(pattern, adjusted);
}

// All tuples of so many values of each range, ascending.
std::vector<ConditionValues> ValuesOver(const CameraStack& stack) {
  // The second condition changes the camera little, and each value takes time
  // and room.
  constexpr int kNumFirst = 5, kNumSecond = 3;
  std::vector<ConditionValues> all = {{}};
  for (const ConditionRange& range : stack.ranges()) {
    std::vector<ConditionValues> longer;
    for (const ConditionValues& values : all)
      for (const double value :
           range.Spread(values.empty() ? kNumFirst : kNumSecond)) {
        longer.push_back(values);
        longer.back().push_back(value);
      }
    all = std::move(longer);
  }
  return all;
}

// The standard deviations of the stack's cameras at values over its ranges.
std::vector<StackDeviation> StackDeviations(const Adjusted& adjusted,
                                            int num_threads) {
  const CameraStack& stack = *adjusted.state.camera().Stack();
  std::vector<StackedGrid> cameras;
  std::vector<const CameraModel*> as;
  for (const ConditionValues& values : ValuesOver(stack))
    cameras.emplace_back(stack, values);
  for (const StackedGrid& camera : cameras) as.push_back(&camera);
  std::vector<StackDeviation> deviations;
  for (const DeviationLattice& lattice :
       DeviationsOf(adjusted, 0, as, num_threads))
    deviations.push_back({cameras[deviations.size()].values(), lattice});
  return deviations;
}

// The RMS of t^(order + 1) that no polynomial of the order has.
double RmsBeyondOrder(const Eigen::ArrayXd& t, int order) {
  Eigen::MatrixXd powers(t.size(), order + 1);
  for (int k = 0; k <= order; ++k) powers.col(k) = t.pow(k);
  const Eigen::VectorXd next = t.pow(order + 1);
  const Eigen::VectorXd beyond =
      next - powers * powers.colPivHouseholderQr().solve(next);
  return std::sqrt(beyond.squaredNorm() / static_cast<double>(t.size()));
}

// The middle of the widest gap between values.
double MiddleOfGap(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  size_t widest = 1;
  for (size_t k = 1; k < values.size(); ++k)
    if (values[k] - values[k - 1] > values[widest] - values[widest - 1])
      widest = k;
  return (values[widest - 1] + values[widest]) / 2;
}

// Two positions fit any line: images there show no error of the cameras
// between them.
std::vector<std::string> FindUntestedConditions(const CameraStack& stack,
                                                const Adjusted& adjusted) {
  constexpr double kLeastPart = 0.3;  // of what evenly spread values show
  std::vector<std::string> untested;
  for (size_t k = 0; k < stack.ranges().size(); ++k) {
    const ConditionRange& range = stack.ranges()[k];
    std::vector<double> values;
    for (const View& view : adjusted.problem.views)
      values.push_back(view.conditions[k]);
    const Eigen::ArrayXd t =
        (Eigen::Map<const Eigen::ArrayXd>(
             values.data(), static_cast<Eigen::Index>(values.size())) -
         range.Middle()) /
        (range.high - range.Middle());
    const int order = stack.orders()[k];
    const Eigen::ArrayXd even = Eigen::ArrayXd::LinSpaced(101, -1, 1);
    if (RmsBeyondOrder(t, order) < kLeastPart * RmsBeyondOrder(even, order))
      untested.push_back(fmt::format(
          "a polynomial of order {} interpolates these values of {} exactly, "
          "so its error between them is unknown and not included in the "
          "predicted uncertainty: add images in between, such as at {:.3g} {}",
          order, ConditionName(range.condition), MiddleOfGap(values),
          ConditionUnit(range.condition)));
  }
  return untested;
}

void Warn(const std::string& reason, Verdict* verdict) {
  if (verdict->word == "pass") verdict->word = "warn";
  verdict->reasons.insert(verdict->reasons.begin(), reason);
}

void WarnOf(const ConditionCheck& check, Verdict* verdict) {
  constexpr size_t kMostNamed = 5;
  for (const UnexplainedCondition& condition : check.unexplained)
    Warn(condition.Text(), verdict);
  for (const UncertainCondition& condition : check.uncertain) {
    if (condition.IsUnobserved())
      Warn(condition.Text(), verdict);
    else
      verdict->reasons.push_back(condition.Text());
  }
  const std::vector<DoubtfulCondition>& doubtful = check.doubtful;
  if (doubtful.empty()) return;
  std::string names;
  for (size_t k = 0; k < std::min(doubtful.size(), kMostNamed); ++k)
    names += (k == 0 ? "" : "; ") + doubtful[k].Text();
  if (doubtful.size() > kMostNamed)
    names += fmt::format("; and {} more", doubtful.size() - kMostNamed);
  Warn(names + ": correct the values, or remove these images", verdict);
}

// Adjusts a stack to the images of a problem from their features alone: what it
// was before may have been bent by images that left.
void StartAnew(const ImageConditions& conditions, const Pattern& pattern,
               const CalibrationOptions& options, Adjusted* adjusted) {
  CalibrationProblem& problem = adjusted->problem;
  AdjustmentState& state = adjusted->state;
  const CameraStack& before = *state.camera().Stack();
  const BSplineSurface& grid = before.terms().front();
  Dataset dataset = {before.image_size(), {}};
  for (size_t v = 0; v < problem.views.size(); ++v) {
    if (dataset.images.empty() ||
        dataset.images.back().image != problem.images[v])
      dataset.images.push_back({problem.images[v], {}});
    for (const Observation& observation : problem.views[v].observations)
      dataset.images.back().features.push_back(
          problem.FeatureOf(pattern, static_cast<int>(v), observation));
  }
  const CameraStack start = StartStack(dataset, conditions, pattern, options);
  const CentralGeneric middle = FitCentralGeneric(
      start.At(start.Middle()), grid.area(), grid.columns(), grid.rows());
  const CameraStack stack = ChangesOnGrid(start, middle);
  for (const View& view : problem.views)
    if (const auto pose = Localize(stack.At(view.conditions),
                                   MatchesOf(view, problem.nominal)))
      state.rig_from_pattern[view.pose] = *pose;
  state.SetCamera(StackedGrid(stack, stack.Middle()));
  adjusted->prior.cameras = {
      StackPrior(middle, static_cast<int>(stack.terms().size()))};
  AdjustmentOptions adjustment = StoppableAdjustment(options);
  adjustment.fix_points = true;
  adjusted->summary = AdjustWithLearnedPrior(problem.views, adjustment,
                                             &adjusted->prior, &state);
}

// The result of all images in place of that of the camera in the middle.
void PutResult(const CalibrationInput& input, const ImageConditions& conditions,
               const Pattern& pattern, const CalibrationOptions& options,
               const Adjusted& adjusted, CalibrationResult* result) {
  const CameraStack& stack = *adjusted.state.camera().Stack();
  result->poses.clear();
  FillResult(pattern, adjusted, 0, input.image_circle, options.num_threads,
             result);
  FillUncertainty(adjusted, 0, input.image_circle, options.valid_px,
                  options.num_threads, result);
  CentralGeneric middle = stack.At(stack.Middle());
  middle.SetImageCircle(input.image_circle);
  result->camera.camera = middle.Clone();
  result->camera.stack =
      StackOfCameras{stack, StackDeviations(adjusted, options.num_threads)};
  const auto readjust = [&](Adjusted* fewer) {
    try {
      StartAnew(conditions, pattern, options, fewer);
    } catch (const Error&) {  // they lead to no lens: the stack stays
    }
  };
  std::vector<RejectedImage> rejected;
  const ConditionCheck check = CheckConditions(
      adjusted, BuildProblem({input.dataset}, pattern, &rejected), readjust,
      options.num_threads);
  if (!check.unexplained.empty()) {
    // Residuals of wrong values look like errors of boards, motion or focus.
    result->budget.reset();
    result->two_cameras.reset();
    result->flat_board_height_m = 0;
  }
  JudgeResult(options.num_threads, result);
  WarnOf(check, &result->verdict);
  for (const std::string& reason : FindUntestedConditions(stack, adjusted))
    Warn(reason, &result->verdict);
}

}  // namespace

void RequireOneValue(const ImageConditions& conditions,
                     const std::string& image, const std::string& copy) {
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

int MaxStackOrder(int num_values) {
  return std::clamp((num_values + 1) / 2, 1, CameraStack::kMaxOrder);
}

RigResult CalibrateStack(const CalibrationInput& input,
                         const ImageConditions& conditions,
                         const Pattern& pattern,
                         const CalibrationOptions& options) {
  RequireConditions(input.dataset, conditions, options);
  const auto report = [&](const char* stage, double done) {
    if (options.progress) options.progress(stage, done);
  };
  report("initialization over the range", 0);
  std::map<std::string, double> seconds;
  std::optional<CameraStack> start;
  {
    const Stopwatch stopwatch(&seconds["stack_start"]);
    start = StartStack(input.dataset, conditions, pattern, options);
  }
  CalibrationInput in_middle = input;
  in_middle.dataset = BringToMiddle(input.dataset, conditions, *start);
  // It would look where features were moved to.
  in_middle.measure_again = nullptr;
  CalibrationOptions of_middle = options;
  of_middle.progress = [&](const std::string& stage, double done) {
    if (options.progress) options.progress(stage, 0.1 + 0.7 * done);
  };
  RigResult result = Calibrate({in_middle}, pattern, of_middle);
  CalibrationResult& camera = result.cameras.front();
  // Features as given, but with boards turned as poses have them.
  const Dataset turned = Turned(input.dataset, pattern, camera.turns);
  if (options.ShouldStop()) {
    // The camera is that of the middle, but files tell where images show
    // features.
    camera.features = UsedOf(turned, camera);
    return result;
  }
  report("bundle adjustment over the range", 0.8);
  const CameraStack stack =
      ChangesOnGrid(*start, CentralPart(*camera.camera.camera));
  Adjusted adjusted =
      StartFrom(camera, UsedOf(turned, camera), conditions, pattern, stack);
  adjusted.problem.area = options.area;
  {
    const Stopwatch stopwatch(&seconds["stack_adjustment"]);
    AdjustStack(camera, pattern, options, &adjusted);
  }
  {
    const Stopwatch stopwatch(&seconds["stack_figures"]);
    PutResult(input, conditions, pattern, options, adjusted, &camera);
  }
  result.seconds.merge(seconds);
  result.pattern = camera.pattern;
  result.converged = camera.converged;
  result.verdict = JudgeRig(result);
  report("done", 1);
  return result;
}

}  // namespace raygrid
