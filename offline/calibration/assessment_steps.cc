#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "calibration/budget_input.h"
#include "calibration/calibration_steps.h"
#include "calibration/camera_result.h"
#include "calibration/deformation_selection.h"
#include "calibration/frame_adjustment.h"
#include "calibration/input_checks.h"
#include "calibration/mixed_cameras.h"
#include "calibration/near_duplicates.h"
#include "calibration/parametric_comparison.h"
#include "calibration/rig_evaluation.h"
#include "calibration/rolling_shutter.h"
#include "calibration/stopwatch.h"
#include "calibration/transformed_images.h"

namespace raygrid {
namespace {

// Returns the in-plane RMS distance in metres between a board's estimated
// points and its pattern, after alignment with a similarity transform.
double ComputeShiftM(const Board& given, const Board& found) {
  const auto count = static_cast<Eigen::Index>(given.points.size());
  if (count < 3 || found.points.size() != given.points.size()) return 0;
  Eigen::Matrix3Xd from(3, count), to(3, count);
  for (Eigen::Index k = 0; k < count; ++k) {
    from.col(k) = given.points[k];
    to.col(k) = found.points[k];
  }
  const Eigen::Matrix4d similarity = Eigen::umeyama(from, to, true);
  const Eigen::Vector3d normal =
      similarity.topLeftCorner<3, 3>().col(2).normalized();
  const Eigen::Matrix3Xd moves =
      to - (similarity * from.colwise().homogeneous()).topRows<3>();
  return (moves - normal * (normal.transpose() * moves)).norm() /
         std::sqrt(static_cast<double>(count));
}

// Warns about boards whose estimated points are far from the pattern. Such
// differences exceed the tolerances of printers, and the prior keeps the
// estimates close to the nominal geometry.
void WarnAboutTargetGeometry(const Pattern& given, const Pattern& found,
                             Assessment* assessment) {
  constexpr double kMaxFraction = 0.01;  // relative to the square size
  for (size_t b = 0; b < given.boards.size(); ++b) {
    const Board& board = given.boards[b];
    const double shift_m = ComputeShiftM(board, found.boards[b]);
    if (!(shift_m > kMaxFraction * board.square_m) || board.IsPointSet())
      continue;
    if (assessment->word == "pass") assessment->word = "warn";
    assessment->reasons.push_back(fmt::format(
        "the estimated points of board {} deviate from the pattern by {:.2g} "
        "mm RMS, {:.2g} % of a square: the print is stretched, or the pattern "
        "describes another board, which biases the camera; measure the print "
        "in both directions, and correct the pattern",
        board.id, 1e3 * shift_m, 100 * shift_m / board.square_m));
  }
}

}  // namespace

void Calibration::CheckForTransformedImages() {
  if (options_.ShouldStop()) return;
  const Stopwatch stopwatch(&result_.seconds["two_cameras"]);
  for (CameraInProgress& camera : cameras_) {
    if (IsSingleCamera(camera.result) && camera.lens.rejected_images.empty())
      continue;
    camera.result.transformed_images =
        DetectTransformedImages(camera.split.training, pattern_, camera.lens,
                                MakeStoppableOptions(options_));
    if (options_.ShouldStop()) camera.result.transformed_images.reset();
  }
}

// Detects mixed cameras for single-camera input only; the images of a rig are
// already grouped by camera.
void Calibration::CheckForMixedCameras() {
  if (IsRig() || options_.ShouldStop()) return;
  const Stopwatch stopwatch(&result_.seconds["two_cameras"]);
  CameraInProgress& camera = cameras_.front();
  if (IsSingleCamera(camera.result) || camera.result.transformed_images) return;
  camera.result.mixed_cameras =
      DetectMixedCameras(camera.split.training, pattern_, camera.lens,
                         MakeStoppableOptions(options_));
  if (options_.ShouldStop()) camera.result.mixed_cameras.reset();
}

void Calibration::ReportUncertainty(CameraInProgress* camera,
                                    int num_threads) const {
  if (camera->HasKnownIntrinsics()) return;
  FillUncertainty(adjusted_, static_cast<int>(camera - cameras_.data()),
                  camera->input->image_circle, options_.valid_px, num_threads,
                  &camera->result);
}

// Compares parametric models while the uncertainty, which hardly benefits from
// a second thread, is estimated concurrently.
void Calibration::CompareModels() {
  if (!options_.compare_models || options_.ShouldStop()) {
    const Stopwatch stopwatch(&result_.seconds["uncertainty"]);
    for (CameraInProgress& camera : cameras_)
      ReportUncertainty(&camera, options_.num_threads);
    return;
  }
  const Stopwatch stopwatch(&result_.seconds["comparison"]);
  // Whether boards are flat does not depend on the camera model.
  CalibrationOptions options = options_;
  options.fix_target_geometry =
      options.fix_target_geometry ||
      (!HavePointsMoved(adjusted_) && !adjusted_.state.HasStaticDeformation());
  if (options.fix_target_geometry != do_trials_fix_target_)
    model_trials_.assign(cameras_.size(), {});
  ForEachCamera({"other models", 0.85, 1}, [&](CameraInProgress* camera, auto) {
    if (camera->HasKnownIntrinsics()) return;
    CalibrationResult& result = camera->result;
    const ModelTrials& done = model_trials_[camera - cameras_.data()];
    result.parametric_models = CompareParametricModels(
        *camera, pattern_, options, done,
        [&](int num_threads) { ReportUncertainty(camera, num_threads); });
    if (IsRig() || options.ShouldStop() || !HasSystematicErrors(result)) return;
    if (auto metrics = CompareAlternativeGrid(*camera, pattern_, options, done))
      result.parametric_models.push_back(std::move(*metrics));
  });
  RestartFromComparison();
  for (CameraInProgress& camera : cameras_)
    camera.result.model_error_px = EstimateModelErrorPx(camera.result);
}

void Calibration::CompareWithOthers() {
  CheckForTransformedImages();
  CheckForMixedCameras();
  CompareModels();
}

// ---- Assessment ------------------------------------------------------------

// Decomposes the residual variance of each camera by cause.
void Calibration::SplitResiduals() {
  const Stopwatch stopwatch(&result_.seconds["residual_budget"]);
  for (CameraInProgress& camera : cameras_)
    if (!camera.HasKnownIntrinsics())
      camera.result.budget = ComputeResidualBudget(MakeBudgetInput(
          camera.result, MakeBudgetSummary(camera.result, options_)));
}

// Estimates board poses in near-duplicate images with the calibrated cameras.
void Calibration::LocalizeDuplicates() {
  RigModel rig = {{}, result_.camera_from_rig, {}};
  std::vector<Dataset> others;
  bool are_any = false;
  for (size_t c = 0; c < cameras_.size(); ++c) {
    rig.cameras.push_back(result_.cameras[c].camera.camera.get());
    const CameraInProgress& camera = cameras_[c];
    others.push_back(SelectDuplicates(
        camera.still ? *camera.still
                     : Rotated(camera.input->dataset, pattern_, camera.turns),
        result_.cameras[c].near_duplicates));
    are_any |= !others.back().images.empty();
  }
  if (!are_any || options_.ShouldStop()) return;
  const auto poses =
      LocalizeBoards(rig, others, result_.pattern, options_.num_threads);
  for (size_t c = 0; c < cameras_.size(); ++c)
    result_.cameras[c].poses.insert(result_.cameras[c].poses.end(),
                                    poses[c].begin(), poses[c].end());
}

// Estimates the deformation of boards that were assumed to be flat.
void Calibration::ReportFlatBoards() {
  const double height_m = EstimateFlatnessError(
      pattern_, MakeStoppableOptions(options_), adjusted_);
  for (CameraInProgress& camera : cameras_)
    camera.result.flatness_error_m = height_m;
}

RigResult Calibration::Assess() {
  if (options_.fix_target_geometry && !options_.ShouldStop())
    ReportFlatBoards();
  const bool is_interrupted = options_.ShouldStop();
  if (!is_interrupted) SplitResiduals();
  for (CameraInProgress& camera : cameras_) {
    if (is_interrupted) camera.result.checkpoint = std::move(camera.checkpoint);
    if (!is_interrupted && options_.like && options_.prior_population)
      FillFleetDistance(*options_.like, *options_.prior_population,
                        &camera.result);
    ListUnusedImages(camera.dataset, camera.input->skipped, &camera.result);
    ReportExcludedImages(camera, pattern_, &camera.result.rejected_images);
    if (!is_interrupted && !camera.HasKnownIntrinsics())
      FindUniqueCoverageImages(adjusted_,
                               static_cast<int>(&camera - cameras_.data()),
                               options_.num_threads, &camera.result);
    AssessResult(options_.num_threads, &camera.result);
    if (!is_interrupted)
      WarnAboutTargetGeometry(pattern_, camera.result.pattern,
                              &camera.result.assessment);
    camera.result.turns = camera.turns;
    result_.cameras.push_back(std::move(camera.result));
  }
  result_.assessment = AssessRig(result_);
  LocalizeDuplicates();
  Report("done", 1);
  return std::move(result_);
}

}  // namespace raygrid
