#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "calibration/calibration_steps.h"
#include "calibration/camera_result.h"
#include "calibration/deformation_selection.h"
#include "calibration/frame_adjustment.h"
#include "calibration/knot_spacing_selection.h"
#include "calibration/model_selection.h"
#include "calibration/restart.h"
#include "calibration/rig_evaluation.h"
#include "calibration/rig_initialization.h"
#include "calibration/rig_motion.h"
#include "calibration/rig_uncertainty.h"
#include "calibration/rigid_target_search.h"
#include "calibration/stopwatch.h"
#include "camera/model_registry.h"

namespace raygrid {

// ---- Knot spacing ----------------------------------------------------------

void Calibration::SelectKnotSpacings() {
  const Stopwatch stopwatch(&result_.seconds["cross_validation"]);
  ForEachCamera({"cross-validation", 0.1, 0.6}, [&](CameraInProgress* camera,
                                                    const auto& report) {
    camera->folds = MakeFolds({camera->split}, {&camera->lens.state.camera()});
    camera->folds.base_model = camera->lens.problem.base_model;
    if (camera->HasKnownIntrinsics()) return;
    camera->folds.whole = std::make_shared<AdjustmentResult>(camera->lens);
    SelectKnotSpacing(pattern_, options_, report, camera);
    SelectDeformation(pattern_, options_, camera);
    for (Folds::Fold& fold : camera->folds.folds) fold.rigid.clear();
  });
  if (!selects_model_ || options_.ShouldStop()) return;
  ModelSelection selection =
      raygrid::SelectModel(pattern_, options_, &cameras_);
  options_.model = selection.model;
  model_trials_ = std::move(selection.trials);
  do_trials_fix_target_ = selection.fix_target_geometry;
  for (CameraInProgress& camera : cameras_) {
    if (camera.HasKnownIntrinsics()) continue;
    camera.grid_knot_spacing_px = camera.result.knot_spacing_px;
    if (IsParametricModel(options_.model)) {
      camera.result.knot_spacing_px = 0;
      camera.per_view_deformation = false;
    } else if (options_.model == models::kNonCentralGeneric) {
      camera.result.knot_spacing_px =
          std::max(camera.grid_knot_spacing_px,
                   MediumKnotSpacingPx(camera.split.training, options_.model));
    }
  }
}

// ---- Adjustment ------------------------------------------------------------

AdjustmentResult Calibration::AdjustTogether(
    const std::vector<int>& cameras,
    std::vector<std::vector<RejectedImage>>* rejected) {
  std::vector<std::string> names;
  std::vector<AdjustmentResult> camera_results;
  std::vector<double> knot_spacings_px;
  for (const int c : cameras) {
    names.push_back(cameras_[c].input->name);
    camera_results.push_back(cameras_[c].lens);
    knot_spacings_px.push_back(cameras_[c].result.knot_spacing_px);
  }
  if (IsRig()) Report("rig initialization", 0.6);
  rejected->clear();
  AdjustmentResult adjusted =
      InitializeRig(names, camera_results, bodies_,
                    MakeAdjustmentOptions(options_), rejected);
  Report("bundle adjustment", 0.65);
  AdjustmentOptions adjustment = MakeStoppableOptions(options_);
  adjustment.rigid_boards = AreBoardsRigid();
  if (!IsRig() && bodies_.empty() && cameras_.front().folds.whole)
    adjusted =
        OptimizeWholeModel(pattern_, options_.model, knot_spacings_px.front(),
                           adjustment, &cameras_.front().folds);
  else
    OptimizeModel(pattern_, options_.model, knot_spacings_px, adjustment,
                  &adjusted);
  OptimizeInCameraFrames(adjustment, &adjusted);
  AlignBoards(pattern_, &adjusted);
  return adjusted;
}

void Calibration::OptimizeWithRigidTargets(
    std::vector<std::vector<RejectedImage>>* rejected) {
  std::vector<AdjustmentResult> camera_results;
  std::vector<std::string> names;
  std::vector<int> all;
  for (const CameraInProgress& camera : cameras_) {
    names.push_back(camera.input->name);
    all.push_back(static_cast<int>(all.size()));
    camera_results.push_back(camera.lens);
  }
  const auto groups = ConnectedGroups(camera_results);
  const bool can_detect = !options_.independent_boards &&
                          CanDetectRigidTargets(camera_results) &&
                          (groups.size() > 1 || !DoBoardsDeform());
  std::vector<AdjustmentResult> apart;
  if (groups.size() == 1 || !can_detect)
    apart.push_back(AdjustTogether(all, rejected));
  else
    for (const std::vector<int>& group : groups)
      apart.push_back(AdjustTogether(group, rejected));
  if (can_detect)
    result_.board_pairs =
        CompareBoardPoses(apart, pattern_, options_.num_threads, &bodies_);
  if (apart.size() == 1 && bodies_.empty()) {
    adjusted_ = std::move(apart.front());
    return;
  }
  try {
    if (groups.size() > 1 && can_detect)
      ConnectByMotion(names, groups, apart, pattern_, result_.board_pairs,
                      &bodies_);
    adjusted_ = AdjustTogether(all, rejected);
  } catch (const Error& error) {
    const auto descriptions = DescribeRigidTargets({}, result_.board_pairs);
    if (error.code() != ExitCode::kInitializationFailed || descriptions.empty())
      throw;
    throw Error(error.code(),
                fmt::format("{}; {}", error.what(), descriptions.front()));
  }
}

void Calibration::OptimizeCameras() {
  const Stopwatch stopwatch(&result_.seconds["adjustment"]);
  OptimizeWithRigidTargets(&rejected_);
  FillResults();
}

void Calibration::FillResults() {
  result_.rigid_targets.clear();
  for (const std::vector<int>& group : bodies_.Groups()) {
    const RigidTargets found = UpdateRigidTargets(
        bodies_, adjusted_.problem, adjusted_.state.target_from_board);
    RigidTarget& body = result_.rigid_targets.emplace_back();
    for (const int b : group) {
      body.boards.push_back(pattern_.boards[b].id);
      body.first_from_board.push_back(
          found.frame_from_board[group.front()].Inverse() *
          found.frame_from_board[b]);
    }
  }
  AdjustmentOptions adjustment = MakeStoppableOptions(options_);
  adjustment.rigid_boards = AreBoardsRigid();

  for (size_t c = 0; c < cameras_.size(); ++c) {
    CalibrationResult& result = cameras_[c].result;
    result.rejected_images = cameras_[c].lens.rejected_images;
    result.rejected_images.insert(result.rejected_images.end(),
                                  rejected_[c].begin(), rejected_[c].end());
    result.poses.clear();
    FillResult(pattern_, adjusted_, static_cast<int>(c),
               cameras_[c].input->image_circle, options_.num_threads, &result);
    if (cameras_[c].HasKnownIntrinsics())
      KeepKnownCamera(*cameras_[c].input->intrinsics, &result);
  }
  result_.pattern = MakeEstimatedPattern(pattern_, adjusted_);
  result_.pattern.rigid_targets = result_.rigid_targets;
  result_.camera_from_rig = adjusted_.state.camera_from_rig;
  result_.baselines = EstimateBaselines(adjusted_, adjustment);
  result_.converged = adjusted_.summary.converged;
}

// ---- Evaluation ------------------------------------------------------------

void Calibration::EvaluateHeldOutImages() {
  const Stopwatch stopwatch(&result_.seconds["cross_validation"]);
  CameraInProgress& first = cameras_.front();
  // The checkpoint stores the trials of the initial model, not those of a
  // non-central model that was selected later.
  const bool stores_trials =
      !IsRig() &&
      !(selects_model_ && options_.model == models::kNonCentralGeneric);
  std::vector<Trial> temporary_trials;
  std::vector<Trial>& trials =
      stores_trials ? first.checkpoint.trials : temporary_trials;
  ValidationOptions validation = MakeValidationOptions(options_);
  validation.rigid_boards = AreBoardsRigid();
  validation.rigid_targets = bodies_;
  validation.progress = [this](double done) {
    Report("cross-validation", 0.7 + 0.15 * done);
  };
  if (!IsRig()) validation.on_done = [&first] { first.Save(); };
  // Folds of single cameras were initialized before rigid targets were
  // detected.
  const bool creates_new_folds = IsRig() || !bodies_.empty();
  Folds new_folds;
  if (creates_new_folds)
    new_folds = MakeFolds(GetSplits(), GetInitialCameras());
  new_folds.base_model = adjusted_.problem.base_model;
  HeldOutResiduals held_out = EvaluateHeldOut(
      adjusted_, pattern_, GetSplits(), validation, KnotSpacingsPx(),
      creates_new_folds ? &new_folds : &first.folds, &trials);
  result_.held_out = std::move(held_out.together);
  result_.cross_validated = options_.hold_out.empty();
  for (size_t c = 0; c < held_out.alone.size(); ++c) {
    cameras_[c].result.held_out = std::move(held_out.alone[c]);
    if (!held_out.with_deformation[c].empty())
      cameras_[c].result.held_out_deformed =
          ComputeErrorMetrics(held_out.with_deformation[c]);
    cameras_[c].result.cross_validated = result_.cross_validated;
  }
  // Reports a fixed knot spacing in the same form as the candidates of the
  // selection.
  if (!IsRig() && first.result.cross_validated &&
      options_.knot_spacing_px > 0 && first.result.knot_spacing_px > 0)
    first.result.knot_spacing_candidates = {SummarizeCandidate(
        first.result.knot_spacing_px, first.result.held_out)};
}

void Calibration::RestartFromFolds() {
  CameraInProgress& camera = cameras_.front();
  if (IsRig() || !bodies_.empty() || options_.ShouldStop() ||
      !IsWorseThanFolds(camera, adjusted_, AreBoardsRigid(),
                        camera.result.knot_spacing_px))
    return;
  const Stopwatch stopwatch(&result_.seconds["adjustment"]);
  raygrid::RestartFromFolds(
      pattern_, options_, [this] { return AdjustTogether({0}, &rejected_); },
      &camera, &adjusted_);
  FillResults();
  if (!options_.hold_out.empty()) EvaluateHeldOutImages();
}

// Restarts the adjustment from a parametric model if that has smaller errors,
// which shows that the grid diverged.
void Calibration::RestartFromComparison() {
  CameraInProgress& camera = cameras_.front();
  if (IsRig() || !bodies_.empty() || options_.ShouldStop() ||
      IsParametricModel(options_.model) ||
      !raygrid::RestartFromComparison(pattern_, options_, AreBoardsRigid(),
                                      &camera, &adjusted_))
    return;
  FillResults();
  if (!options_.hold_out.empty()) EvaluateHeldOutImages();
  ReportUncertainty(&camera, options_.num_threads);
}

}  // namespace raygrid
