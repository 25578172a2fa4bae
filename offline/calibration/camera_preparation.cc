#include "calibration/camera_preparation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/grid_choice.h"
#include "calibration/starting_lens.h"
#include "calibration/stopwatch.h"
#include "camera/model_fitting.h"
#include "dataset/error.h"
#include "dataset/parallel_for.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

void Keep(const CalibrationOptions& options, const Checkpoint& checkpoint) {
  if (options.keep) options.keep(checkpoint);
}

// The RMS distance between features before and after; both datasets have the
// same features.
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
// Nothing if it is told to stop first.
std::optional<Dataset> MeasureFeaturesAgain(const Dataset& dataset,
                                            const Pattern& pattern,
                                            const CalibrationOptions& options,
                                            const AdjustmentOptions& adjustment,
                                            Adjusted first) {
  constexpr size_t kMediumCandidate = 2;
  const std::vector<double> cells = CellCandidates(dataset, options.model);
  const double cell_px =
      options.cell_px > 0 ? options.cell_px
                          : cells[std::min(kMediumCandidate, cells.size() - 1)];
  AdjustmentOptions stoppable = adjustment;
  stoppable.should_stop = options.should_stop;
  AdjustModel(pattern, options.model, {cell_px}, stoppable, &first);
  if (ShouldStop(options)) return std::nullopt;
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
  Dataset again =
      options.measure_again(first.state.camera(), adjusted_pattern, known);
  if (ShouldStop(options)) return std::nullopt;  // it may not be complete
  return again;
}

// Chooses the resolution; the held-out residuals are those of the chosen one.
void ValidateResolutions(const Pattern& pattern,
                         const CalibrationOptions& options,
                         const std::function<void(double)>& progress,
                         const std::vector<double>& cells,
                         PreparedCamera* start) {
  const std::vector<Split> camera = {start->split};
  std::vector<std::vector<double>> candidates;
  for (const double cell_px : cells) candidates.push_back({cell_px});
  CrossValidate(
      camera, pattern,
      {options.model, options.flat_board, options.num_threads, progress,
       options.should_stop, [&] { Keep(options, start->checkpoint); }},
      candidates, &start->checkpoint.trials);
  std::vector<std::vector<FeatureResidual>> held_out;
  for (const auto& cells_px : candidates) {
    HeldOut joined =
        JoinFolds(start->checkpoint.trials, NumFoldsToTry(camera), cells_px);
    if (joined.alone.empty()) return;
    held_out.push_back(std::move(joined.alone.front()));
  }
  CalibrationResult& result = start->result;
  for (size_t i = 0; i < cells.size(); ++i)
    result.cell_candidates.push_back(Summarize(cells[i], held_out[i]));
  const size_t chosen = ChooseCandidate(result.cell_candidates);
  result.held_out = held_out[chosen];
  result.cross_validated = true;
  if (result.cell_px > 0)
    result.cell_px = cells[chosen];
  else
    result.cell_candidates.clear();
}

// Features measured again, now or before an interruption, and a start from
// them; none if it is told to stop.
void StartAgain(const Dataset& measured, const Pattern& pattern,
                const CalibrationOptions& options,
                const AdjustmentOptions& adjustment, PreparedCamera* start) {
  const Stopwatch again_time;
  std::optional<Dataset>& again = start->checkpoint.measured_again;
  if (!again)
    again = MeasureFeaturesAgain(measured, pattern, options, adjustment,
                                 start->adjusted);
  if (!again) return;
  Keep(options, start->checkpoint);
  start->result.measured_again_rms_px = RmsMovePx(measured, *again);
  start->split = SplitImages("", *again, options.hold_out);
  start->adjusted =
      AdjustStartingLens(start->split.training, pattern, adjustment);
  start->result.seconds["measuring_again"] = again_time.Seconds();
}

// Boards that are mostly far away have their lengths in another unit: the
// images do not tell.
void AskAboutDistance(const Adjusted& adjusted) {
  constexpr double kFarM = 20;
  std::vector<double> distances_m;
  for (const View& view : adjusted.problem.views)
    distances_m.push_back(
        adjusted.state.CameraFromPattern(view).translation.norm());
  const double median_m = Quantile(distances_m, 0.5);
  if (median_m > kFarM)
    throw Error(ExitCode::kUsage,
                fmt::format("boards {:.3g} m away (median)? the pattern's "
                            "square_m, in metres, makes them so; correct it, "
                            "or --yes if that is meant",
                            median_m));
}

}  // namespace

void RequireKnownModel(const std::string& model) {
  if (model != "central-generic" && model != "noncentral-generic" &&
      !IsParametricModel(model))
    throw Error(ExitCode::kUsage,
                fmt::format("unknown model '{}'; this version calibrates "
                            "central-generic, noncentral-generic, "
                            "central-radial, thin-prism-fisheye and opencv",
                            model));
}

bool ShouldStop(const CalibrationOptions& options) {
  return options.should_stop && options.should_stop();
}

AdjustmentOptions AdjustmentOptionsOf(const CalibrationOptions& options) {
  AdjustmentOptions adjustment;
  adjustment.num_threads = NumThreads(options.num_threads);
  adjustment.fix_points = options.flat_board;
  return adjustment;
}

PreparedCamera PrepareCamera(const Dataset& measured, const Pattern& pattern,
                             const CalibrationOptions& options,
                             bool want_held_out_error) {
  const auto report = [&options](const std::string& stage, double done) {
    if (options.progress) options.progress(stage, done);
  };
  const AdjustmentOptions adjustment = AdjustmentOptionsOf(options);
  PreparedCamera start;
  CalibrationResult& result = start.result;
  if (options.resume) start.checkpoint = *options.resume;

  report("start", 0);
  const Stopwatch start_time;
  start.split = SplitImages("", measured, options.hold_out);
  start.adjusted =
      AdjustStartingLens(start.split.training, pattern, adjustment);
  if (!options.any_distance) AskAboutDistance(start.adjusted);
  result.seconds["start"] = start_time.Seconds();

  if (options.measure_again && !ShouldStop(options)) {
    report("measuring again", 0.05);
    StartAgain(measured, pattern, options, adjustment, &start);
  }
  result.rejected_images = start.adjusted.rejected_images;

  const bool is_grid = !IsParametricModel(options.model);
  const bool choose_cell = is_grid && options.cell_px <= 0;
  const std::vector<double> cells =
      choose_cell ? CellCandidates(start.split.training, options.model)
                  : std::vector<double>{options.cell_px};
  result.cell_px = is_grid ? cells.front() : 0;
  const Stopwatch validation_time;
  report("cross-validation", 0.1);
  if (NumFoldsToTry({start.split}) > 0 && (choose_cell || want_held_out_error))
    ValidateResolutions(
        pattern, options,
        [&report](double done) {
          report("cross-validation", 0.1 + 0.7 * done);
        },
        cells, &start);
  result.seconds["cross_validation"] = validation_time.Seconds();
  return start;
}

}  // namespace raygrid
