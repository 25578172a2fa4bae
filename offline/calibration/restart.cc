#include "calibration/restart.h"

#include <algorithm>
#include <string>
#include <utility>

#include "calibration/camera_initialization.h"
#include "calibration/divergence.h"
#include "calibration/frame_adjustment.h"
#include "calibration/knot_spacing_selection.h"
#include "camera/model_fitting.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

// Optimizes the requested model, initialized from a camera of another model.
AdjustmentResult AdjustAround(const std::string& other, const Pattern& pattern,
                              const CalibrationOptions& calibration,
                              bool are_boards_rigid, double knot_spacing_px,
                              const CameraInProgress& camera) {
  AdjustmentResult adjusted = camera.lens;
  AdjustmentOptions options = MakeStoppableOptions(calibration);
  options.fix_points = true;
  OptimizeModel(pattern, other, {0}, options, &adjusted);
  adjusted.base_models.clear();
  options.fix_points = calibration.fix_target_geometry;
  options.rigid_boards = are_boards_rigid;
  OptimizeWithRigidBoards(pattern, calibration.model, {knot_spacing_px},
                          options, &adjusted);
  if (!options.rigid_boards) EstimateDeformation(pattern, options, &adjusted);
  FinalizeCameras(&adjusted);
  OptimizeInCameraFrames(options, &adjusted);
  AlignBoards(pattern, &adjusted);
  return adjusted;
}

}  // namespace

bool IsWorseThanFolds(const CameraInProgress& camera,
                      const AdjustmentResult& adjusted, bool are_boards_rigid,
                      double knot_spacing_px) {
  HeldOutResiduals held_out;
  for (const bool rigid : {are_boards_rigid, true})
    if (held_out.alone.empty())
      held_out = JoinFolds(camera.checkpoint.trials, camera.folds.count(),
                           {knot_spacing_px}, rigid);
  if (held_out.alone.empty() || held_out.alone.front().empty()) return false;
  const double cap_px = ErrorCapPx(camera.dataset.image_size);
  double sum = 0;
  for (const FeatureResidual& residual : held_out.alone.front())
    sum += std::min(residual.error_px.norm(), cap_px);
  const double mean_px =
      sum / static_cast<double>(held_out.alone.front().size());
  return ExceedsDivergenceRatio(ComputeMeanErrorPx(adjusted, camera.lens),
                                mean_px);
}

void RestartFromFolds(const Pattern& pattern, const CalibrationOptions& options,
                      const std::function<AdjustmentResult()>& adjust,
                      CameraInProgress* camera, AdjustmentResult* adjusted) {
  const AdjustmentResult initial_result = camera->lens;
  camera->folds.whole.reset();
  camera->folds.whole_results.clear();
  AdjustmentResult best_result = initial_result;
  double least_px = ComputeMeanErrorPx(*adjusted, initial_result);
  // A resumed calibration does not repeat the trials of its checkpoint, and has
  // not initialized their folds.
  InitializeFolds(pattern, MakeValidationOptions(options), &camera->folds);
  const bool is_grid = !IsParametricModel(options.model);
  for (const Folds::Fold& fold : camera->folds.folds) {
    const auto& start = is_grid ? fold.lenses : fold.start;
    if (!start || options.ShouldStop()) continue;
    try {
      camera->lens = InitializeCamera(camera->split.training, pattern,
                                      MakeAdjustmentOptions(options),
                                      options.area, &start->state.camera());
      camera->lens.problem.base_model = initial_result.problem.base_model;
      camera->lens.problem.like = options.like;
      camera->lens.problem.prior_population = options.prior_population;
      AdjustmentResult again = adjust();
      const double error_px = ComputeMeanErrorPx(again, initial_result);
      if (error_px >= least_px) continue;
      least_px = error_px;
      *adjusted = std::move(again);
      best_result = camera->lens;
    } catch (const Error&) {  // this fold has no usable camera
    }
  }
  camera->lens = std::move(best_result);
}

bool RestartFromComparison(const Pattern& pattern,
                           const CalibrationOptions& options,
                           bool are_boards_rigid, CameraInProgress* camera,
                           AdjustmentResult* adjusted) {
  const double own_px = camera->result.camera.training->median_px;
  // Without folds, the knot spacing could not be selected.
  std::vector<double> knot_spacings_px = {camera->result.knot_spacing_px};
  if (camera->folds.count() == 0 && options.knot_spacing_px == 0)
    knot_spacings_px.push_back(
        MediumKnotSpacingPx(camera->split.training, options.model));
  AdjustmentResult best;
  double best_knot_spacing_px = 0;
  double least_px = ComputeMeanErrorPx(*adjusted, camera->lens);
  for (const ModelMetrics& other : camera->result.parametric_models) {
    if (!IsParametricModel(other.model) ||
        !ExceedsDivergenceRatio(own_px, other.training.median_px))
      continue;
    for (const double knot_spacing_px : knot_spacings_px) {
      AdjustmentResult around =
          AdjustAround(other.model, pattern, options, are_boards_rigid,
                       knot_spacing_px, *camera);
      const double error_px = ComputeMeanErrorPx(around, camera->lens);
      if (kDivergenceRatio * error_px >= least_px) continue;
      least_px = error_px;
      best = std::move(around);
      best_knot_spacing_px = knot_spacing_px;
    }
  }
  if (best.state.cameras.empty()) return false;
  *adjusted = std::move(best);
  camera->result.knot_spacing_px = best_knot_spacing_px;
  return true;
}

}  // namespace raygrid
