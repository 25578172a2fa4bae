#include "calibration/bend_choice.h"

#include <vector>

#include "calibration/cell_search.h"
#include "calibration/grid_choice.h"
#include "camera/model_fitting.h"

namespace raygrid {
namespace {

// Whether bends could lower squared errors by a part, as far as the residuals
// of cameras with rigid boards tell.
bool MayBend(const std::vector<Trial>& trials, double cell_px, double part) {
  double sum = 0, count = 0;
  for (const Trial& trial : trials) {
    if (!trial.rigid_boards || trial.cells_px.front() != cell_px) continue;
    sum += trial.share_of_bends;
    ++count;
  }
  return sum > part * count;
}

// Cells that rigid boards chose coarser than the medium ones stay so if they
// surely predict flexed boards better, too: bends are noise to rigid boards.
void ChooseGridAgain(const Pattern& pattern, const CalibrationOptions& options,
                     const ValidationOptions& validation,
                     CameraInProgress* camera) {
  if (options.cell_px > 0) return;
  Folds& folds = camera->folds;
  std::vector<Trial>& trials = camera->checkpoint.trials;
  const auto flexed_with = [&](double cell_px) {
    CrossValidate(pattern, validation, {{cell_px}}, &folds, &trials);
    return JoinFolds(trials, folds.count(), {cell_px}, false).flexed;
  };
  const Dataset& images = camera->split.training;
  double& chosen_px = camera->result.cell_px;
  for (const double finer_px : CellCandidates(images, options.model)) {
    if (finer_px >= chosen_px || finer_px < MediumCellPx(images, options.model))
      continue;
    const auto coarser = flexed_with(chosen_px), finer = flexed_with(finer_px);
    if (coarser.empty() || finer.empty() ||
        GainOver(finer.front(), coarser.front()) >= kCoarserGain)
      return;
    chosen_px = finer_px;
  }
}

}  // namespace

bool BendsPredictBetter(const HeldOut& bent, const HeldOut& rigid) {
  // In deviations. An image that alone tells all of a gain makes it 1.
  constexpr double kWorse = -1.5, kBetter = 1;
  const double alone = GainOver(rigid.alone.front(), bent.alone.front());
  const double flexed = GainOver(rigid.flexed.front(), bent.flexed.front());
  return flexed > 0 && alone > kWorse && flexed + alone > kBetter;
}

void ChooseBends(const Pattern& pattern, const CalibrationOptions& options,
                 CameraInProgress* camera) {
  // Bends take more of the residuals that they are adjusted to than of others.
  constexpr double kLeastShare = 0.01;
  camera->boards_bend = false;
  if (options.rigid_board || options.flat_board ||
      IsParametricModel(options.model))
    return;
  Folds& folds = camera->folds;
  const double cell_px = camera->result.cell_px;
  std::vector<Trial>& trials = camera->checkpoint.trials;
  ValidationOptions validation = ValidationOptionsOf(options);
  validation.on_done = [camera] { camera->Keep(); };
  HeldOut held_out[2];
  for (const bool rigid : {true, false}) {
    validation.rigid_boards = rigid;
    validation.keep_rigid = rigid;
    CrossValidate(pattern, validation, {{cell_px}}, &folds, &trials);
    if (rigid && !MayBend(trials, cell_px, kLeastShare)) return;
    held_out[rigid] = JoinFolds(trials, folds.count(), {cell_px}, rigid);
    if (held_out[rigid].flexed.empty()) return;
  }
  camera->boards_bend = BendsPredictBetter(held_out[false], held_out[true]);
  if (camera->boards_bend)
    ChooseGridAgain(pattern, options, validation, camera);
}

}  // namespace raygrid
