#ifndef RAYGRID_CALIBRATION_DEFORMATION_EVALUATION_H
#define RAYGRID_CALIBRATION_DEFORMATION_EVALUATION_H

#include <vector>

#include "calibration/rig_evaluation.h"

namespace raygrid {

/// Computes the residuals of each camera with per-view board deformation: pose
/// and deformation are estimated from half of a view's features (even lattice
/// positions), the residuals from the other half. Cameras and pattern are
/// fixed; all views determine the deformation's variance. Views with fewer than
/// kMinViewFeatures in either half have no residuals; all are empty if no board
/// is flat. A single camera is a rig of one.
std::vector<std::vector<FeatureResidual>> EvaluateWithDeformation(
    const RigModel& rig, const std::vector<Dataset>& datasets,
    const Pattern& pattern, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_DEFORMATION_EVALUATION_H
