#include "calibration/bend_choice.h"

#include "calibration/grid_choice.h"
#include "camera/model_fitting.h"

namespace raygrid {

void ChooseBends(const Pattern& pattern, const CalibrationOptions& options,
                 CameraInProgress* camera) {
  // Squared errors must fall by so much where held-out boards may bend, and
  // not rise where they may not: a camera nearer to the truth does both.
  constexpr double kBetterBy = 0.02;
  camera->boards_bend = false;
  if (options.rigid_board || options.flat_board ||
      IsParametricModel(options.model))
    return;
  Folds& folds = camera->folds;
  const double cell_px = camera->result.cell_px;
  std::vector<Trial>& trials = camera->checkpoint.trials;
  ValidationOptions validation = ValidationOptionsOf(options);
  validation.on_done = [camera] { camera->Keep(); };
  double flexed[2] = {}, alone[2] = {};
  for (const bool rigid : {true, false}) {
    validation.rigid_boards = rigid;
    validation.keep_rigid = rigid;
    CrossValidate(pattern, validation, {{cell_px}}, &folds, &trials);
    const HeldOut held_out = JoinFolds(trials, folds.count(), {cell_px}, rigid);
    if (held_out.flexed.empty()) return;
    flexed[rigid] = Summarize(cell_px, held_out.flexed.front()).loss;
    alone[rigid] = Summarize(cell_px, held_out.alone.front()).loss;
  }
  camera->boards_bend = flexed[false] < (1 - kBetterBy) * flexed[true] &&
                        alone[false] <= alone[true];
}

}  // namespace raygrid
