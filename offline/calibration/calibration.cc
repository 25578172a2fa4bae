#include "calibration/calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "calibration/camera_evaluation.h"
#include "calibration/cross_validation.h"
#include "calibration/model_adjustment.h"
#include "calibration/starting_camera.h"
#include "camera/model_fitting.h"
#include "dataset/error.h"
#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

class Stopwatch {
 public:
  double Seconds() const {
    return std::chrono::duration<double>(Clock::now() - start_).count();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

std::vector<FeatureResidual> TrainingResiduals(const Pattern& pattern,
                                               const Adjusted& adjusted,
                                               int num_threads) {
  const CalibrationProblem& problem = adjusted.problem;
  const std::vector<Residual> residuals =
      ComputeResiduals(adjusted.state, problem.views, num_threads);
  std::vector<FeatureResidual> result;
  size_t index = 0;
  for (size_t v = 0; v < problem.views.size(); ++v) {
    for (const Observation& observation : problem.views[v].observations) {
      const Residual& residual = residuals[index++];
      if (!residual.valid) continue;
      const Feature feature =
          problem.FeatureOf(pattern, static_cast<int>(v), observation);
      result.push_back({problem.images[v], feature.board, feature.column,
                        feature.row, observation.pixel, residual.error_px});
    }
  }
  return result;
}

Dataset UsedFeatures(const Pattern& pattern,
                     const CalibrationProblem& problem) {
  Dataset used;
  used.image_size = problem.image_sizes[0];
  for (size_t v = 0; v < problem.views.size(); ++v) {
    if (used.images.empty() || used.images.back().image != problem.images[v])
      used.images.push_back({problem.images[v], {}});
    for (const Observation& observation : problem.views[v].observations)
      used.images.back().features.push_back(
          problem.FeatureOf(pattern, static_cast<int>(v), observation));
  }
  return used;
}

void FillResult(const Pattern& pattern, const CalibrationOptions& options,
                const Adjusted& adjusted, CalibrationResult* result) {
  const CalibrationProblem& problem = adjusted.problem;
  result->camera.camera = adjusted.state.camera().Clone();
  result->pattern = AdjustedPattern(pattern, adjusted);
  result->features = UsedFeatures(pattern, problem);
  for (size_t v = 0; v < problem.views.size(); ++v)
    result->poses.push_back(
        {problem.images[v], pattern.boards[problem.boards[v]].id,
         adjusted.state.CameraFromPattern(problem.views[v])});
  result->training = TrainingResiduals(pattern, adjusted, options.num_threads);
  result->camera.training = ComputeErrorFigures(result->training);
  result->rejected_images = adjusted.rejected_images;
  result->rejected_features = adjusted.rejected_features;
  result->num_parameters = adjusted.state.camera().NumParameters();
  result->converged = adjusted.summary.converged;
  result->bias_kl =
      ComputeBias(result->training, result->camera.camera->area());
  if (!result->camera.camera->IsCentral())
    result->line_spread = MeasureLineSpread(*result->camera.camera);
}

CalibrationFigures FiguresOf(const CalibrationResult& result) {
  return {result.converged,
          result.camera.camera->image_size(),
          result.camera.camera->area(),
          static_cast<int>(result.features.images.size()),
          static_cast<int>(result.rejected_images.size()),
          *result.camera.training,
          result.camera.held_out,
          result.neighbor_correlation};
}

// Both have the same features.
double RmsMovePx(const Dataset& before, const Dataset& after) {
  double sum = 0;
  size_t count = 0;
  for (size_t i = 0; i < before.images.size(); ++i) {
    const auto& b = before.images[i].features;
    const auto& a = after.images[i].features;
    for (size_t k = 0; k < b.size(); ++k, ++count)
      sum += (a[k].pixel - b[k].pixel).squaredNorm();
  }
  return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0;
}

// Through a first camera of medium resolution: what bends the mapping within a
// window is mostly the lens's distortion.
Dataset MeasureFeaturesAgain(const Dataset& dataset, const Pattern& pattern,
                             const CalibrationOptions& options,
                             const AdjustmentOptions& adjustment,
                             Adjusted first) {
  constexpr size_t kMediumCandidate = 2;
  const std::vector<double> cells = CellCandidates(dataset, options.model);
  const double cell_px =
      options.cell_px > 0 ? options.cell_px
                          : cells[std::min(kMediumCandidate, cells.size() - 1)];
  AdjustModel(pattern, options.model, cell_px, adjustment, &first);
  AlignBoards(pattern, &first);
  const Pattern adjusted_pattern = AdjustedPattern(pattern, first);
  std::vector<RejectedImage> rejected;
  const CalibrationProblem problem =
      BuildProblem({dataset}, adjusted_pattern, &rejected);
  const std::vector<std::optional<Pose>> poses =
      LocalizeViews(first.state.camera(), 0, problem, adjustment.num_threads);
  std::vector<BoardPose> known;
  for (size_t v = 0; v < poses.size(); ++v)
    if (poses[v])
      known.push_back(
          {problem.images[v], pattern.boards[problem.boards[v]].id, *poses[v]});
  return options.measure_again(first.state.camera(), adjusted_pattern, known);
}

void RequireKnownModel(const std::string& model) {
  if (model != "central-generic" && model != "noncentral-generic" &&
      !IsParametricModel(model))
    throw Error(ExitCode::kUsage,
                fmt::format("unknown model '{}'; this version calibrates "
                            "central-generic, noncentral-generic, "
                            "central-radial, thin-prism-fisheye and opencv",
                            model));
}

void RequireHeldOutImagesExist(const Dataset& dataset,
                               const std::vector<std::string>& hold_out) {
  for (const std::string& name : hold_out)
    if (std::none_of(dataset.images.begin(), dataset.images.end(),
                     [&](const auto& image) { return image.image == name; }))
      throw Error(
          ExitCode::kUsage,
          fmt::format("--hold-out {}: no features of such an image", name));
}

}  // namespace

CalibrationResult Calibrate(const Dataset& measured, const Pattern& pattern,
                            const CalibrationOptions& options) {
  RequireKnownModel(options.model);
  RequireHeldOutImagesExist(measured, options.hold_out);
  const auto report = [&options](const std::string& stage, double done) {
    if (options.progress) options.progress(stage, done);
  };
  const auto split_images = [&options](const Dataset& dataset) {
    return SplitImages(dataset, [&](size_t i) {
      return std::count(options.hold_out.begin(), options.hold_out.end(),
                        dataset.images[i].image) > 0;
    });
  };
  Split split = split_images(measured);
  AdjustmentOptions adjustment;
  adjustment.num_threads = NumThreads(options.num_threads);
  adjustment.fix_points = options.flat_board;
  CalibrationResult result;

  report("start", 0);
  const Stopwatch start_time;
  Adjusted adjusted = AdjustStart(split.training, pattern, adjustment);
  result.seconds["start"] = start_time.Seconds();

  if (options.measure_again) {
    report("measuring again", 0.05);
    const Stopwatch again_time;
    const Dataset again =
        MeasureFeaturesAgain(measured, pattern, options, adjustment, adjusted);
    result.measured_again_rms_px = RmsMovePx(measured, again);
    split = split_images(again);
    adjusted = AdjustStart(split.training, pattern, adjustment);
    result.seconds["measuring_again"] = again_time.Seconds();
  }

  const bool is_grid = !IsParametricModel(options.model);
  const bool choose_cell = is_grid && options.cell_px <= 0;
  const std::vector<double> cells =
      choose_cell ? CellCandidates(split.training, options.model)
                  : std::vector<double>{options.cell_px};
  result.cell_px = is_grid ? cells.front() : 0;
  const Stopwatch validation_time;
  report("cross-validation", 0.1);
  if (NumFoldsToTry(split.training) > 0 &&
      (choose_cell || options.hold_out.empty())) {
    const ValidationOptions validation = {
        options.model, options.flat_board, options.num_threads,
        [&report](double done) {
          report("cross-validation", 0.1 + 0.7 * done);
        }};
    const std::vector<Trial> trials =
        CrossValidate(split.training, pattern, validation, cells);
    for (const Trial& trial : trials)
      result.cell_candidates.push_back(Summarize(trial));
    const size_t chosen = ChooseCandidate(result.cell_candidates);
    if (is_grid) result.cell_px = cells[chosen];
    result.held_out = trials[chosen].held_out;
    result.cross_validated = true;
    if (!is_grid) result.cell_candidates.clear();
  }
  result.seconds["cross_validation"] = validation_time.Seconds();

  report("bundle adjustment", 0.8);
  const Stopwatch adjustment_time;
  AdjustModel(pattern, options.model, result.cell_px, adjustment, &adjusted);
  AlignBoards(pattern, &adjusted);
  FillResult(pattern, options, adjusted, &result);
  result.seconds["adjustment"] = adjustment_time.Seconds();

  if (!options.hold_out.empty()) {
    result.held_out = EvaluateCamera(*result.camera.camera, split.test,
                                     result.pattern, options.num_threads)
                          .residuals;
    result.cross_validated = false;
  }
  if (!result.held_out.empty())
    result.camera.held_out = ComputeErrorFigures(result.held_out);
  result.neighbor_correlation = NeighborCorrelation(
      result.held_out.empty() ? result.training : result.held_out);
  result.verdict = JudgeCalibration(FiguresOf(result));
  report("done", 1);
  return result;
}

}  // namespace raygrid
