#ifndef RAYGRID_CALIBRATION_DEFORMATION_EVALUATION_H
#define RAYGRID_CALIBRATION_DEFORMATION_EVALUATION_H

#include <vector>

#include "calibration/rig_evaluation.h"

namespace raygrid {

/// The residuals of each camera where boards may bend from view to view: half
/// of a view's features, in even places of the lattice, tell how its board
/// stands and bends; the residuals are those of the other half. The cameras and
/// the pattern stay as they are, and all views together tell how far boards
/// bend. Views with fewer than kMinViewFeatures in a half have no residuals,
/// and none has any where no board is flat. A single camera is a rig of one.
std::vector<std::vector<FeatureResidual>> EvaluateWithDeformation(
    const RigModel& rig, const std::vector<Dataset>& datasets,
    const Pattern& pattern, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_DEFORMATION_EVALUATION_H
