#include "calibration/rig_calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "calibration/camera_preparation.h"
#include "calibration/camera_result.h"
#include "calibration/frame_adjustment.h"
#include "calibration/parametric_comparison.h"
#include "calibration/rig_start.h"
#include "calibration/rig_uncertainty.h"
#include "calibration/stopwatch.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

using Names = std::vector<std::string>;

Names NamesOf(const std::vector<RigCameraInput>& cameras) {
  Names names;
  for (const RigCameraInput& camera : cameras) names.push_back(camera.name);
  return names;
}

void RequireCamerasWithNames(const Names& names) {
  if (names.size() < 2)
    throw Error(ExitCode::kUsage, "a rig needs two cameras or more");
  if (std::set<std::string>(names.begin(), names.end()).size() < names.size())
    throw Error(ExitCode::kUsage, "two cameras of one name; give them two");
}

// Before anything that takes long.
void RequireConnectedInputs(const std::vector<RigCameraInput>& cameras,
                            const Pattern& pattern) {
  std::vector<Dataset> datasets;
  for (const RigCameraInput& camera : cameras)
    datasets.push_back(camera.dataset);
  std::vector<RejectedImage> rejected;
  RequireConnected(NamesOf(cameras),
                   BuildProblem(datasets, pattern, &rejected));
}

void RequireInstantsExist(const std::vector<RigCameraInput>& cameras,
                          const Names& hold_out) {
  std::vector<Split> all;
  for (const RigCameraInput& camera : cameras)
    all.push_back({camera.name, camera.dataset, {}});
  const Names instants = Instants(all);
  for (const std::string& name : hold_out)
    if (!std::binary_search(instants.begin(), instants.end(), name))
      throw Error(
          ExitCode::kUsage,
          fmt::format("--hold-out {}: no features of such an instant", name));
}

// Calls a function for one camera; an Error that it throws then names the
// camera.
template <typename Function>
auto NamingCamera(const std::string& name, const Function& function) {
  try {
    return function();
  } catch (const Error& error) {
    throw Error(error.code(), fmt::format("camera {}: {}", name, error.what()));
  }
}

std::vector<PreparedCamera> PrepareCameras(
    const std::vector<RigCameraInput>& cameras, const Pattern& pattern,
    const CalibrationOptions& options) {
  std::vector<PreparedCamera> starts;
  for (size_t c = 0; c < cameras.size(); ++c) {
    CalibrationOptions own = options;
    own.measure_again = cameras[c].measure_again;
    own.resume = cameras[c].resume;
    own.keep = cameras[c].keep;
    own.progress = [&](const std::string& stage, double done) {
      if (options.progress)
        options.progress(cameras[c].name + ": " + stage,
                         0.6 * (static_cast<double>(c) + done) /
                             static_cast<double>(cameras.size()));
    };
    starts.push_back(NamingCamera(cameras[c].name, [&] {
      return PrepareCamera(cameras[c].dataset, pattern, own, false);
    }));
  }
  return starts;
}

// ---- Result ----------------------------------------------------------------

void FillRig(const Pattern& pattern, const CalibrationOptions& options,
             const Adjusted& adjusted, RigResult* result) {
  for (size_t c = 0; c < result->cameras.size(); ++c)
    FillResult(pattern, adjusted, static_cast<int>(c), options.num_threads,
               &result->cameras[c]);
  result->camera_from_rig = adjusted.state.camera_from_rig;
  result->pattern = AdjustedPattern(pattern, adjusted);
  result->baselines = ComputeBaselines(result->camera_from_rig);
  const auto num_shared = CountSharedViews(adjusted.problem);
  for (Baseline& baseline : result->baselines)
    baseline.num_shared_views = num_shared[baseline.first][baseline.second];
  AddDeviations(adjusted, AdjustmentOptionsOf(options), &result->baselines);
  result->converged = adjusted.summary.converged;
}

void AddHeldOut(HeldOut held_out, bool cross_validated, RigResult* result) {
  for (size_t c = 0; c < held_out.alone.size(); ++c) {
    result->cameras[c].held_out = std::move(held_out.alone[c]);
    result->cameras[c].cross_validated = cross_validated;
  }
  result->held_out = std::move(held_out.together);
  result->cross_validated = cross_validated;
}

}  // namespace

RigResult CalibrateRig(const std::vector<RigCameraInput>& cameras,
                       const Pattern& pattern,
                       const CalibrationOptions& options) {
  const auto report = [&options](const std::string& stage, double done) {
    if (options.progress) options.progress(stage, done);
  };
  const Names names = NamesOf(cameras);
  RequireKnownModel(options.model);
  RequireCamerasWithNames(names);
  RequireInstantsExist(cameras, options.hold_out);
  RequireConnectedInputs(cameras, pattern);

  RigResult result;
  const Stopwatch start_time;
  std::vector<PreparedCamera> starts =
      PrepareCameras(cameras, pattern, options);
  std::vector<Adjusted> alone;
  std::vector<Split> splits;
  std::vector<double> cells_px;
  for (size_t c = 0; c < cameras.size(); ++c) {
    PreparedCamera& start = starts[c];
    start.result.camera.name = names[c];
    start.result.held_out.clear();  // of the camera without the rig
    alone.push_back(std::move(start.adjusted));
    start.split.camera = names[c];
    splits.push_back(std::move(start.split));
    cells_px.push_back(start.result.cell_px);
    result.cameras.push_back(std::move(start.result));
  }
  result.seconds["cameras"] = start_time.Seconds();

  report("putting the rig together", 0.6);
  const Stopwatch adjustment_time;
  const AdjustmentOptions adjustment = AdjustmentOptionsOf(options);
  std::vector<std::vector<RejectedImage>> rejected;
  Adjusted adjusted = StartRig(names, alone, adjustment, &rejected);
  for (size_t c = 0; c < cameras.size(); ++c) {
    auto& images = result.cameras[c].rejected_images;
    images.insert(images.end(), rejected[c].begin(), rejected[c].end());
  }
  report("bundle adjustment", 0.65);
  AdjustmentOptions stoppable = adjustment;
  stoppable.should_stop = options.should_stop;
  AdjustModel(pattern, options.model, cells_px, stoppable, &adjusted);
  AdjustInCameraFrames(stoppable, &adjusted);
  AlignBoards(pattern, &adjusted);
  FillRig(pattern, options, adjusted, &result);
  result.seconds["adjustment"] = adjustment_time.Seconds();

  report("cross-validation", 0.75);
  const Stopwatch validation_time;
  if (options.hold_out.empty()) {
    std::vector<Trial> trials;
    CrossValidate(splits, pattern,
                  {options.model,
                   options.flat_board,
                   options.num_threads,
                   {},
                   options.should_stop,
                   {}},
                  {cells_px}, &trials);
    AddHeldOut(JoinFolds(trials, NumFoldsToTry(splits), cells_px), true,
               &result);
  } else {
    AddHeldOut(EvaluateHeldOut(adjusted, pattern, splits, options.num_threads),
               false, &result);
  }
  result.seconds["held_out"] = validation_time.Seconds();

  if (options.compare_models && !ShouldStop(options)) {
    report("other models", 0.85);
    const Stopwatch comparison_time;
    for (size_t c = 0; c < cameras.size(); ++c)
      result.cameras[c].parametric_models =
          CompareParametricModels(splits[c], pattern, options, alone[c]);
    result.seconds["comparison"] = comparison_time.Seconds();
  }

  if (ShouldStop(options))
    for (size_t c = 0; c < cameras.size(); ++c)
      result.cameras[c].checkpoint = std::move(starts[c].checkpoint);
  for (size_t c = 0; c < cameras.size(); ++c)
    NameUnusedImages(cameras[c].dataset, cameras[c].skipped,
                     &result.cameras[c]);
  for (CalibrationResult& camera : result.cameras)
    JudgeResult(options.num_threads, &camera);
  result.verdict = JudgeRig(result);
  report("done", 1);
  return result;
}

}  // namespace raygrid
