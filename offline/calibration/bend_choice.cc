#include "calibration/bend_choice.h"

#include "calibration/grid_choice.h"
#include "camera/model_fitting.h"

namespace raygrid {

void ChooseBends(const Pattern& pattern, const CalibrationOptions& options,
                 CameraInProgress* camera) {
  // Errors of other kinds, too, are a little like bends.
  constexpr double kBetterBy = 0.1;
  camera->boards_bend = false;
  if (options.rigid_board || options.flat_board ||
      IsParametricModel(options.model))
    return;
  const std::vector<Split> cameras = {camera->split};
  const int num_folds = NumFoldsToTry(cameras);
  const double cell_px = camera->result.cell_px;
  std::vector<Trial>& trials = camera->checkpoint.trials;
  ValidationOptions validation = ValidationOptionsOf(options);
  validation.on_done = [camera] { camera->Keep(); };
  double losses[2] = {};
  for (const bool rigid : {true, false}) {
    validation.rigid_boards = rigid;
    CrossValidate(cameras, pattern, validation, {{cell_px}}, &trials);
    const HeldOut held_out = JoinFolds(trials, num_folds, {cell_px}, rigid);
    if (held_out.flexed.empty()) return;
    losses[rigid] = Summarize(cell_px, held_out.flexed.front()).loss;
  }
  camera->boards_bend = losses[false] < (1 - kBetterBy) * losses[true];
}

}  // namespace raygrid
