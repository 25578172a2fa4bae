#ifndef RAYGRID_CALIBRATION_RIG_UNCERTAINTY_H
#define RAYGRID_CALIBRATION_RIG_UNCERTAINTY_H

#include <vector>

#include "calibration/model_adjustment.h"
#include "evaluation/rig_result.h"

namespace raygrid {

/// Fills in the baselines' standard deviations from an adjustment's equations
/// and residuals, all other parameters being free. Leaves them empty if the
/// equations are singular.
void AddDeviations(const Adjusted& adjusted, const AdjustmentOptions& options,
                   std::vector<Baseline>* baselines);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_RIG_UNCERTAINTY_H
