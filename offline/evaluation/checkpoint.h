#ifndef RAYGRID_EVALUATION_CHECKPOINT_H
#define RAYGRID_EVALUATION_CHECKPOINT_H

#include <optional>
#include <vector>

#include "dataset/dataset.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {

/// The held-out residuals of each camera.
struct HeldOut {
  std::vector<std::vector<FeatureResidual>> alone;  ///< by each camera alone
  /// Of a rig: each board localised once for all cameras that see it.
  std::vector<std::vector<FeatureResidual>> together;
  /// With boards that may bend: of half of the features, predicted from the
  /// others; of a rig by all cameras.
  std::vector<std::vector<FeatureResidual>> flexed;
};

/// A part of a cross-validation: cells of the grid of each camera, tested with
/// the images of one fold.
struct Trial {
  int fold = 0;
  std::vector<double> cells_px;
  bool rigid_boards = false;  ///< in calibrating; or else they may bend
  HeldOut held_out;         ///< empty where a rig falls apart without the fold
  bool has_bodies = false;  ///< of several boards
  /// With rigid boards: the part of the squared residuals that bends would
  /// take.
  double share_of_bends = 1;
};

/// The finished stages that an interrupted calibration of one camera need not
/// do again, each of which gives the same again. An adjustment that was under
/// way starts anew; from where it was it would end elsewhere, by what its
/// tolerance allows.
struct Checkpoint {
  /// Features as measured through a first camera.
  std::optional<Dataset> measured_again;

  std::vector<Trial> trials;
};

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_CHECKPOINT_H
