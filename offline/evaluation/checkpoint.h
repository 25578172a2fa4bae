#ifndef RAYGRID_EVALUATION_CHECKPOINT_H
#define RAYGRID_EVALUATION_CHECKPOINT_H

#include <optional>
#include <vector>

#include "dataset/dataset.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {

/// The finished stages that an interrupted calibration of one camera need not
/// do again, each of which gives the same again. An adjustment that was under
/// way starts anew; from where it was it would end elsewhere, by what its
/// tolerance allows.
struct Checkpoint {
  /// Features as measured through a first camera.
  std::optional<Dataset> measured_again;

  /// Parts of the cross-validation that are done.
  struct Trial {
    int fold = 0;
    double cell_px = 0;
    std::vector<FeatureResidual> held_out;
  };
  std::vector<Trial> trials;
};

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_CHECKPOINT_H
