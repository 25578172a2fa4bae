#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "calibration/base_model.h"
#include "calibration/calibration_steps.h"
#include "calibration/camera_initialization.h"
#include "calibration/divergence.h"
#include "calibration/input_checks.h"
#include "calibration/model_based_refinement.h"
#include "calibration/model_selection.h"
#include "calibration/near_duplicates.h"
#include "calibration/rig_initialization.h"
#include "calibration/rolling_shutter.h"
#include "calibration/stopwatch.h"
#include "camera/model_registry.h"

namespace raygrid {
namespace {

// Whether each camera has enough images without near-duplicates and held-out
// images.
bool HasEnoughViews(const std::vector<Dataset>& cameras,
                    const std::vector<NearDuplicates>& groups,
                    const std::vector<std::string>& held_out) {
  return std::all_of(
      cameras.begin(), cameras.end(), [&](const Dataset& dataset) {
        const Dataset views =
            SplitImages("", RemoveDuplicates(dataset, groups), held_out)
                .training;
        return std::count_if(views.images.begin(), views.images.end(),
                             [](const ImageFeatures& image) {
                               return image.features.size() >= kMinViewFeatures;
                             }) >= kMinImages;
      });
}

}  // namespace

Calibration::Calibration(const std::vector<CalibrationInput>& inputs,
                         const Pattern& pattern,
                         const CalibrationOptions& options)
    : pattern_(pattern),
      options_(options),
      selects_model_(options.model == kAutoModel),
      model_trials_(inputs.size()) {
  if (selects_model_) options_.model = models::kCentralGeneric;
  selects_model_ &= options.knot_spacing_px == 0 && !options.like;
  if (std::all_of(inputs.begin(), inputs.end(),
                  [](const auto& input) { return input.intrinsics; })) {
    // No camera has parameters: the steps of parametric models, which neither
    // fit base models nor refit cameras, are the shortest.
    options_.model = kModelOfKnownCameras;
    selects_model_ = options_.compare_models = false;
  }
  for (const CalibrationInput& input : inputs) {
    CameraInProgress& camera = cameras_.emplace_back();
    camera.input = &input;
    if (input.resume) camera.checkpoint = *input.resume;
    camera.result.camera.name = input.name;
  }
  DetectNearDuplicates();
}

// Detects near-duplicates: any camera predicts them well from each other, so
// each group counts as one image from here on. If too few images remain, all
// are kept, and the assessment reports their similarity.
void Calibration::DetectNearDuplicates() {
  std::vector<Dataset> datasets;
  for (const CameraInProgress& camera : cameras_)
    datasets.push_back(camera.input->dataset);
  std::vector<NearDuplicates> groups =
      FindNearDuplicates(datasets, options_.hold_out, options_.duplicate_px);
  std::vector<std::string> copies =
      FindHeldOutDuplicates(datasets, options_.hold_out, options_.duplicate_px);
  if (!HasEnoughViews(datasets, groups, options_.hold_out)) {
    groups.clear();
    copies.clear();
  }
  const auto has_image = [](const Dataset& dataset, const std::string& name) {
    return std::any_of(
        dataset.images.begin(), dataset.images.end(),
        [&name](const ImageFeatures& image) { return image.image == name; });
  };
  for (CameraInProgress& camera : cameras_) {
    const Dataset& input_dataset = camera.input->dataset;
    camera.dataset = RemoveDuplicates(input_dataset, groups);
    camera.split =
        SplitImages(camera.input->name, camera.dataset, options_.hold_out);
    camera.result.near_duplicates = FilterGroups(input_dataset, groups);
    for (const std::string& copy : copies)
      if (has_image(input_dataset, copy))
        camera.result.held_out_duplicates.push_back(copy);
  }
}

std::vector<Split> Calibration::GetSplits() const {
  std::vector<Split> splits;
  for (const CameraInProgress& camera : cameras_)
    splits.push_back(camera.split);
  return splits;
}

std::vector<const CameraModel*> Calibration::GetInitialCameras() const {
  std::vector<const CameraModel*> lenses;
  for (const CameraInProgress& camera : cameras_)
    lenses.push_back(&camera.lens.state.camera());
  return lenses;
}

std::vector<double> Calibration::KnotSpacingsPx() const {
  std::vector<double> knot_spacings_px;
  for (const CameraInProgress& camera : cameras_)
    knot_spacings_px.push_back(camera.result.knot_spacing_px);
  return knot_spacings_px;
}

bool Calibration::DoBoardsDeform() const {
  const auto count = std::count_if(
      cameras_.begin(), cameras_.end(),
      [](const auto& camera) { return camera.per_view_deformation; });
  return 2 * static_cast<size_t>(count) > cameras_.size();
}

// ---- Initialization --------------------------------------------------------

void Calibration::InitializeFromImages(CameraInProgress* camera) const {
  // Camera from before the feature refinement, if any.
  const auto& known = camera->lens.state.cameras;
  const std::string base_model = camera->lens.problem.base_model;
  try {
    camera->lens =
        camera->HasKnownIntrinsics()
            ? InitializeKnownCamera(*camera->input->intrinsics->camera,
                                    camera->split.training, pattern_,
                                    options_.area, options_.num_threads)
            : InitializeCamera(camera->split.training, pattern_,
                               MakeAdjustmentOptions(options_), options_.area,
                               known.empty() ? nullptr : known.front().get());
    camera->lens.problem.base_model = base_model;
    camera->lens.problem.like = options_.like;
    camera->lens.problem.prior_population = options_.prior_population;
  } catch (const Error& error) {
    const size_t num_others = CountDuplicates(camera->result.near_duplicates);
    if (error.code() != ExitCode::kInsufficientData || num_others == 0) throw;
    throw Error(error.code(),
                fmt::format("{}; {} more are near-duplicate views: move and "
                            "tilt the target between images",
                            error.what(), num_others));
  }
}

void Calibration::Start() {
  const Stopwatch stopwatch(&result_.seconds["start"]);
  ForEachCamera(
      {"initialization", 0, 0.05}, [&](CameraInProgress* camera, auto) {
        InitializeFromImages(camera);
        if (!IsParametricModel(options_.model) && !camera->HasKnownIntrinsics())
          camera->lens.problem.base_model =
              ChooseBaseModel(MakeAdjustmentOptions(options_), camera->lens);
        if (!options_.allow_large_distance)
          RequirePlausibleDistances(camera->lens);
      });
}

// ---- Feature refinement ----------------------------------------------------

void Calibration::RefineFeatures() {
  if (std::none_of(cameras_.begin(), cameras_.end(), [](const auto& camera) {
        return camera.input->refine_features != nullptr;
      }))
    return;
  const Stopwatch stopwatch(&result_.seconds["measuring_again"]);
  ForEachCamera({"refining features", 0.05, 0.1}, [&](CameraInProgress* camera,
                                                      auto) {
    if (!camera->input->refine_features || options_.ShouldStop()) return;
    std::optional<Dataset>& again = camera->checkpoint.refined_features;
    if (!again) again = RefineFeaturesWithModel(pattern_, options_, *camera);
    if (!again) return;
    camera->Save();
    camera->result.refinement_rms_px =
        ComputeRmsShiftPx(camera->dataset, *again);
    camera->split = SplitImages(camera->input->name, *again, options_.hold_out);
    InitializeFromImages(camera);
  });
}

// ---- Board rotations -------------------------------------------------------

// Applies additional rotations to the boards of a camera, and repeats its
// initialization.
void Calibration::RotateBoards(const BoardRotations& turns,
                               CameraInProgress* camera) const {
  BoardRotations own;  // rotations in images of this camera
  for (const ImageFeatures& image : camera->input->dataset.images)
    for (const Board& board : pattern_.boards)
      if (const auto found = turns.find({image.image, board.id});
          found != turns.end())
        own.insert(*found);
  if (own.empty()) return;
  camera->turns = ComposeRotations(camera->turns, own, pattern_);
  camera->dataset = Rotated(camera->dataset, pattern_, own);
  camera->split.training = Rotated(camera->split.training, pattern_, own);
  camera->split.test = Rotated(camera->split.test, pattern_, own);
  InitializeFromImages(camera);
}

void Calibration::RotateBoardsAcrossCameras() {
  std::vector<AdjustmentResult> cameras;
  for (const CameraInProgress& camera : cameras_)
    cameras.push_back(LocalizeDatasetViews(camera.lens.state.camera(),
                                           CollectFeatures(camera, pattern_),
                                           pattern_, options_.num_threads));
  RigRotations found =
      ResolveRotationsAcrossCameras(cameras, pattern_, options_.num_threads);
  for (size_t c = 0; c < cameras_.size(); ++c)
    RotateBoards(found.by_camera[c], &cameras_[c]);
  result_.ambiguous_pairs = std::move(found.ambiguous);
}

// Resolves board rotations from the estimated geometry; the nominal geometry is
// invariant to them.
void Calibration::RotateBoardsByGeometry() {
  CalibrationOptions nominal = options_;
  nominal.fix_target_geometry = true;
  std::vector<AdjustmentResult> cameras;
  for (const CameraInProgress& camera : cameras_) {
    const FirstCamera first = EstimateFirstCamera(pattern_, nominal, camera);
    if (options_.ShouldStop()) return;
    cameras.push_back(first.adjusted);
    AddViews(
        LocalizeDatasetViews(first.adjusted.state.camera(), camera.split.test,
                             pattern_, options_.num_threads),
        &cameras.back());
  }
  const auto [turns, doubtful] = ResolveRotationsByGeometry(cameras, pattern_);
  WarnAboutAmbiguousRotations(doubtful);
  if (turns.empty()) return;
  // Model errors may resemble board errors, so that rotations are kept only if
  // the estimated points support them.
  struct PreviousState {
    BoardRotations turns;
    Dataset dataset;
    Split split;
    AdjustmentResult lens;
  };
  constexpr double kMinImprovementRatio = 0.98;
  std::vector<PreviousState> previous;
  double before_px = 0, after_px = 0;
  const auto error_px = [this](const CameraInProgress& camera,
                               const AdjustmentResult& start) {
    return ComputeMeanErrorPx(
        EstimateFirstCamera(pattern_, options_, camera).adjusted, start);
  };
  for (CameraInProgress& camera : cameras_) {
    before_px += error_px(camera, camera.lens);
    previous.push_back(
        {camera.turns, camera.dataset, camera.split, camera.lens});
    RotateBoards(turns, &camera);
    after_px += error_px(camera, previous.back().lens);
  }
  if (after_px < kMinImprovementRatio * before_px && !options_.ShouldStop())
    return;
  for (size_t c = 0; c < cameras_.size(); ++c) {
    cameras_[c].turns = std::move(previous[c].turns);
    cameras_[c].dataset = std::move(previous[c].dataset);
    cameras_[c].split = std::move(previous[c].split);
    cameras_[c].lens = std::move(previous[c].lens);
    cameras_[c].result.ambiguous_rotation_images.clear();
  }
}

void Calibration::WarnAboutAmbiguousRotations(
    const std::vector<std::pair<std::string, int>>& doubtful) {
  for (CameraInProgress& camera : cameras_)
    for (const ImageFeatures& image : camera.dataset.images)
      if (std::any_of(doubtful.begin(), doubtful.end(), [&](const auto& view) {
            return view.first == image.image;
          }))
        camera.result.ambiguous_rotation_images.push_back(image.image);
}

void Calibration::RotateBoards() {
  if (!HasSymmetricBoards(pattern_) || options_.ShouldStop()) return;
  const Stopwatch stopwatch(&result_.seconds["start"]);
  if (IsRig()) RotateBoardsAcrossCameras();
  if (!options_.fix_target_geometry) RotateBoardsByGeometry();
}

// ---- Rolling shutter -------------------------------------------------------

bool Calibration::AreLineDelaysRequested() const {
  return std::any_of(cameras_.begin(), cameras_.end(), [](const auto& camera) {
    return camera.input->times.has_value();
  });
}

// Estimates the line delay and compensates the rolling shutter. The initial
// camera and board poses absorb part of the motion, which biases the line delay
// towards zero; the estimation is therefore repeated on features from which
// most of the motion was removed.
void Calibration::CompensateRollingShutter(CameraInProgress* camera) const {
  constexpr int kMaxRounds = 6;
  double before_s = 0;
  for (int round = 0; round < kMaxRounds; ++round) {
    auto still = ComputeCompensatedFeatures(pattern_, options_, *camera);
    if (!still) return;
    camera->still = std::move(still->features);
    camera->split = SplitImages(
        camera->input->name,
        RemoveDuplicates(*camera->still, camera->result.near_duplicates),
        options_.hold_out);
    InitializeFromImages(camera);
    const LineDelay& now = still->line_delay;
    if (std::abs(now.seconds - before_s) < now.stddev_s / 2) return;
    before_s = now.seconds;
  }
}

void Calibration::CompensateRollingShutter() {
  if (!AreLineDelaysRequested()) return;
  const Stopwatch stopwatch(&result_.seconds["row_time"]);
  ForEachCamera({"line delay", 0.1, 0.12}, [&](CameraInProgress* camera, auto) {
    if (!camera->input->times || options_.ShouldStop()) return;
    CompensateRollingShutter(camera);
  });
}

void Calibration::EstimateLineDelays() {
  if (!AreLineDelaysRequested()) return;
  const Stopwatch stopwatch(&result_.seconds["row_time"]);
  for (CameraInProgress& camera : cameras_) {
    if (!camera.input->times || options_.ShouldStop()) continue;
    CalibrationResult& result = camera.result;
    result.line_delay = EstimateFinalLineDelay(
        camera, *result.camera.camera, result_.pattern, options_.num_threads);
    if (result.line_delay->IsDetermined())
      result.camera.line_delay = result.line_delay->value;
  }
}

}  // namespace raygrid
