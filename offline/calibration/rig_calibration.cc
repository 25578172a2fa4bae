#include "calibration/rig_calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "calibration/camera_evaluation.h"
#include "calibration/camera_preparation.h"
#include "calibration/camera_result.h"
#include "calibration/frame_adjustment.h"
#include "calibration/parametric_comparison.h"
#include "calibration/rig_evaluation.h"
#include "calibration/rig_start.h"
#include "calibration/rig_uncertainty.h"
#include "calibration/starting_lens.h"
#include "calibration/stopwatch.h"
#include "dataset/error.h"
#include "dataset/parallel_for.h"

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

// The names of a rig's images, each once.
Names Instants(const std::vector<Dataset>& datasets) {
  std::set<std::string> instants;
  for (const Dataset& dataset : datasets)
    for (const ImageFeatures& image : dataset.images)
      instants.insert(image.image);
  return {instants.begin(), instants.end()};
}

void RequireInstantsExist(const std::vector<RigCameraInput>& cameras,
                          const Names& hold_out) {
  std::vector<Dataset> datasets;
  for (const RigCameraInput& camera : cameras)
    datasets.push_back(camera.dataset);
  const Names instants = Instants(datasets);
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

// ---- Held-out error --------------------------------------------------------

// The held-out residuals of each camera: of images localised alone, and by the
// rig.
struct RigHeldOut {
  std::vector<std::vector<FeatureResidual>> alone, together;

  void Append(const RigHeldOut& other) {
    alone.resize(other.alone.size());
    together.resize(other.together.size());
    for (size_t c = 0; c < other.alone.size(); ++c) {
      alone[c].insert(alone[c].end(), other.alone[c].begin(),
                      other.alone[c].end());
      together[c].insert(together[c].end(), other.together[c].begin(),
                         other.together[c].end());
    }
  }
};

RigHeldOut EvaluateHeldOut(const Adjusted& adjusted, const Pattern& pattern,
                           const std::vector<Dataset>& test, int num_threads) {
  const Pattern adjusted_pattern = AdjustedPattern(pattern, adjusted);
  RigModel rig;
  for (const auto& camera : adjusted.state.cameras)
    rig.cameras.push_back(camera.get());
  rig.camera_from_rig = adjusted.state.camera_from_rig;
  RigHeldOut held_out;
  for (const Evaluation& evaluation :
       EvaluateRig(rig, test, adjusted_pattern, num_threads))
    held_out.together.push_back(evaluation.residuals);
  for (size_t c = 0; c < test.size(); ++c)
    held_out.alone.push_back(
        EvaluateCamera(*rig.cameras[c], test[c], adjusted_pattern, num_threads)
            .residuals);
  return held_out;
}

// All stages but the choice of resolutions, on the other folds' instants. A
// rig that hangs together by few views may fall apart without some of them:
// then there is nothing.
RigHeldOut EvaluateFold(const Names& names,
                        const std::vector<Dataset>& datasets,
                        const Pattern& pattern, const std::string& model,
                        const std::vector<double>& cells_px,
                        const Names& test_instants,
                        const AdjustmentOptions& options) {
  std::vector<Adjusted> starts;
  std::vector<Dataset> test;
  try {
    for (const Dataset& dataset : datasets) {
      const Split split = SplitImages(dataset, test_instants);
      starts.push_back(AdjustStartingLens(split.training, pattern, options));
      test.push_back(split.test);
    }
    std::vector<std::vector<RejectedImage>> rejected;
    Adjusted adjusted = StartRig(names, starts, options, &rejected);
    AdjustModel(pattern, model, cells_px, options, &adjusted);
    AlignBoards(pattern, &adjusted);
    return EvaluateHeldOut(adjusted, pattern, test, options.num_threads);
  } catch (const Error& error) {
    if (error.code() != ExitCode::kTooFew &&
        error.code() != ExitCode::kInitialization)
      throw;
    return {};
  }
}

// Four folds of instants, as for a single camera.
RigHeldOut CrossValidateRig(const Names& names,
                            const std::vector<Dataset>& datasets,
                            const Pattern& pattern,
                            const CalibrationOptions& options,
                            const std::vector<double>& cells_px) {
  constexpr size_t kNumFolds = 4;
  const Names instants = Instants(datasets);
  Dataset counted;
  counted.images.resize(instants.size());
  const int num_folds = NumFoldsToTry(counted);
  AdjustmentOptions serial = AdjustmentOptionsOf(options);
  const int num_threads = serial.num_threads;
  serial.num_threads = 1;
  std::vector<RigHeldOut> folds(num_folds);
  ParallelFor(num_folds, num_threads, [&](int fold) {
    if (ShouldStop(options)) return;
    Names test;
    for (size_t i = 0; i < instants.size(); ++i)
      if (i % kNumFolds == static_cast<size_t>(fold))
        test.push_back(instants[i]);
    folds[fold] = EvaluateFold(names, datasets, pattern, options.model,
                               cells_px, test, serial);
  });
  RigHeldOut all;
  for (const RigHeldOut& fold : folds)
    if (!fold.alone.empty()) all.Append(fold);
  return all;
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

void AddHeldOut(RigHeldOut held_out, bool cross_validated, RigResult* result) {
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
  std::vector<Dataset> training, test;
  std::vector<double> cells_px;
  for (size_t c = 0; c < cameras.size(); ++c) {
    PreparedCamera& start = starts[c];
    start.result.camera.name = names[c];
    start.result.held_out.clear();  // of the camera without the rig
    alone.push_back(std::move(start.adjusted));
    training.push_back(std::move(start.split.training));
    test.push_back(std::move(start.split.test));
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
  if (options.hold_out.empty())
    AddHeldOut(CrossValidateRig(names, training, pattern, options, cells_px),
               true, &result);
  else
    AddHeldOut(EvaluateHeldOut(adjusted, pattern, test, options.num_threads),
               false, &result);
  result.seconds["held_out"] = validation_time.Seconds();

  if (options.compare_models && !ShouldStop(options)) {
    report("other models", 0.85);
    const Stopwatch comparison_time;
    for (size_t c = 0; c < cameras.size(); ++c)
      result.cameras[c].parametric_models = CompareParametricModels(
          {training[c], test[c]}, pattern, options, alone[c]);
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
