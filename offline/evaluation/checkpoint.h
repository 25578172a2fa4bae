#ifndef RAYGRID_EVALUATION_CHECKPOINT_H
#define RAYGRID_EVALUATION_CHECKPOINT_H

#include <optional>
#include <vector>

#include "dataset/dataset.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {

/// The held-out residuals of each camera.
struct HeldOutResiduals {
  std::vector<std::vector<FeatureResidual>> alone;  ///< localized by one camera
  /// For rigs: residuals if each board is localized once per frame, by all
  /// cameras that observe it.
  std::vector<std::vector<FeatureResidual>> together;
  /// With per-view deformation: residuals of half of the features, predicted
  /// from the others; in a rig, by all cameras.
  std::vector<std::vector<FeatureResidual>> with_deformation;
};

/// One fold of a cross-validation: the knot spacing of each camera, and the
/// held-out residuals of the fold.
struct Trial {
  int fold = 0;
  std::vector<double> knot_spacings_px;
  bool rigid_boards = false;       ///< false: per-view deformation is estimated
  HeldOutResiduals held_out;       ///< empty if the rig is disconnected
  bool has_rigid_targets = false;  ///< rigid multi-board targets
  /// With rigid boards: the fraction of the squared residuals that per-view
  /// deformation would explain.
  double deformation_share = 1;
};

/// The finished stages of an interrupted calibration, whose results are reused.
/// An optimization in progress is repeated from its start; from its last state,
/// it would converge to a result that differs within its tolerance.
struct Checkpoint {
  /// Features as refined with a first camera.
  std::optional<Dataset> refined_features;

  std::vector<Trial> trials;
};

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_CHECKPOINT_H
