#include "calibration/restart.h"

#include <algorithm>
#include <string>
#include <utility>

#include "calibration/divergence.h"
#include "calibration/frame_adjustment.h"
#include "calibration/grid_choice.h"
#include "calibration/starting_lens.h"
#include "camera/model_fitting.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

// The model that was asked for, around a lens of another model.
Adjusted AdjustAround(const std::string& other, const Pattern& pattern,
                      const CalibrationOptions& calibration,
                      bool are_boards_rigid, double cell_px,
                      const CameraInProgress& camera) {
  Adjusted adjusted = camera.lens;
  AdjustmentOptions options = StoppableAdjustment(calibration);
  options.fix_points = true;
  AdjustModel(pattern, other, {0}, options, &adjusted);
  adjusted.base_lenses.clear();
  options.fix_points = calibration.flat_board;
  options.rigid_boards = are_boards_rigid;
  AdjustRigidly(pattern, calibration.model, {cell_px}, options, &adjusted);
  if (!options.rigid_boards) LetBoardsBend(pattern, options, &adjusted);
  FinishCameras(&adjusted);
  AdjustInCameraFrames(options, &adjusted);
  AlignBoards(pattern, &adjusted);
  return adjusted;
}

}  // namespace

bool IsWorseThanFolds(const CameraInProgress& camera, const Adjusted& adjusted,
                      bool are_boards_rigid, double cell_px) {
  HeldOut held_out;
  for (const bool rigid : {are_boards_rigid, true})
    if (held_out.alone.empty())
      held_out = JoinFolds(camera.checkpoint.trials, camera.folds.count(),
                           {cell_px}, rigid);
  if (held_out.alone.empty() || held_out.alone.front().empty()) return false;
  const double cap_px = ErrorCapPx(camera.dataset.image_size);
  double sum = 0;
  for (const FeatureResidual& residual : held_out.alone.front())
    sum += std::min(residual.error_px.norm(), cap_px);
  const double mean_px =
      sum / static_cast<double>(held_out.alone.front().size());
  return IsAstray(MeanErrorPx(adjusted, camera.lens), mean_px);
}

void AdjustFromFolds(const Pattern& pattern, const CalibrationOptions& options,
                     const std::function<Adjusted()>& adjust,
                     CameraInProgress* camera, Adjusted* adjusted) {
  const Adjusted given = camera->lens;
  Adjusted best_lens = given;
  double least_px = MeanErrorPx(*adjusted, given);
  for (const Folds::Fold& fold : camera->folds.folds) {
    const auto& start = fold.lenses ? fold.lenses : fold.start;
    if (!start || options.ShouldStop()) continue;
    try {
      camera->lens = AdjustStartingLens(camera->split.training, pattern,
                                        AdjustmentOptionsOf(options),
                                        options.area, &start->state.camera());
      camera->lens.problem.base_model = given.problem.base_model;
      camera->lens.problem.like = options.like;
      camera->lens.problem.like_spread = options.like_spread;
      Adjusted again = adjust();
      const double error_px = MeanErrorPx(again, given);
      if (error_px >= least_px) continue;
      least_px = error_px;
      *adjusted = std::move(again);
      best_lens = camera->lens;
    } catch (const Error&) {  // this fold's lens is no start
    }
  }
  camera->lens = std::move(best_lens);
}

bool AdjustFromComparison(const Pattern& pattern,
                          const CalibrationOptions& options,
                          bool are_boards_rigid, CameraInProgress* camera,
                          Adjusted* adjusted) {
  const double own_px = camera->result.camera.training->median_px;
  // With few images there are no folds to choose the cells by.
  std::vector<double> cells_px = {camera->result.cell_px};
  if (camera->folds.count() == 0 && options.cell_px == 0)
    cells_px.push_back(MediumCellPx(camera->split.training, options.model));
  Adjusted best;
  double best_cell_px = 0;
  double least_px = MeanErrorPx(*adjusted, camera->lens);
  for (const ModelFigures& other : camera->result.parametric_models) {
    if (!IsParametricModel(other.model) ||
        !IsAstray(own_px, other.training.median_px))
      continue;
    for (const double cell_px : cells_px) {
      Adjusted around = AdjustAround(other.model, pattern, options,
                                     are_boards_rigid, cell_px, *camera);
      const double error_px = MeanErrorPx(around, camera->lens);
      if (kAstrayRatio * error_px >= least_px) continue;
      least_px = error_px;
      best = std::move(around);
      best_cell_px = cell_px;
    }
  }
  if (best.state.cameras.empty()) return false;
  *adjusted = std::move(best);
  camera->result.cell_px = best_cell_px;
  return true;
}

}  // namespace raygrid
