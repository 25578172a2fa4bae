#ifndef RAYGRID_CALIBRATION_RIG_UNCERTAINTY_H
#define RAYGRID_CALIBRATION_RIG_UNCERTAINTY_H

#include <vector>

#include "calibration/model_adjustment.h"
#include "evaluation/rig_result.h"

namespace raygrid {

/// Computes the baselines of all pairs of cameras. Their covariances and
/// standard deviations follow from the adjustment's equations and residuals,
/// marginalized over all other parameters; none if the equations are singular.
std::vector<Baseline> EstimateBaselines(const AdjustmentResult& adjusted,
                                        const AdjustmentOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_RIG_UNCERTAINTY_H
