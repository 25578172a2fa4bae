#include "calibration/calibration.h"

#include <fmt/format.h>

#include <algorithm>

#include "calibration/camera_evaluation.h"
#include "calibration/camera_preparation.h"
#include "calibration/camera_result.h"
#include "calibration/frame_adjustment.h"
#include "calibration/parametric_comparison.h"
#include "calibration/stopwatch.h"
#include "calibration/two_cameras.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

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
  PreparedCamera start =
      PrepareCamera(measured, pattern, options, options.hold_out.empty());
  CalibrationResult result = std::move(start.result);
  if (!ShouldStop(options)) {
    const Stopwatch two_cameras_time;
    AdjustmentOptions stoppable = AdjustmentOptionsOf(options);
    stoppable.should_stop = options.should_stop;
    result.two_cameras = FindTwoCameras(start.split.training, pattern,
                                        start.adjusted, stoppable);
    if (ShouldStop(options)) result.two_cameras.reset();
    result.seconds["two_cameras"] = two_cameras_time.Seconds();
  }
  if (options.progress) options.progress("bundle adjustment", 0.8);
  const Adjusted parametric = start.adjusted;
  const Stopwatch adjustment_time;
  AdjustmentOptions adjustment = AdjustmentOptionsOf(options);
  adjustment.should_stop = options.should_stop;
  AdjustModel(pattern, options.model, {result.cell_px}, adjustment,
              &start.adjusted);
  AdjustInCameraFrames(adjustment, &start.adjusted);
  AlignBoards(pattern, &start.adjusted);
  FillResult(pattern, start.adjusted, 0, options.num_threads, &result);
  result.seconds["adjustment"] = adjustment_time.Seconds();

  if (!options.hold_out.empty()) {
    result.held_out = EvaluateCamera(*result.camera.camera, start.split.test,
                                     result.pattern, options.num_threads)
                          .residuals;
    result.cross_validated = false;
  }
  if (options.compare_models && !ShouldStop(options)) {
    if (options.progress) options.progress("other models", 0.85);
    const Stopwatch comparison_time;
    result.parametric_models =
        CompareParametricModels(start.split, pattern, options, parametric);
    if (!ShouldStop(options) && NeighborsErrAlike(result))
      if (auto figures = TryAnotherGrid(start.split, pattern, options,
                                        parametric, result.cell_px))
        result.parametric_models.push_back(std::move(*figures));
    result.seconds["comparison"] = comparison_time.Seconds();
  }
  if (ShouldStop(options)) result.checkpoint = std::move(start.checkpoint);
  NameUnusedImages(measured, options.skipped, &result);
  JudgeResult(options.num_threads, &result);
  if (options.progress) options.progress("done", 1);
  return result;
}

}  // namespace raygrid
