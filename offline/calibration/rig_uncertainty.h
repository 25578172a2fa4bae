#ifndef RAYGRID_CALIBRATION_RIG_UNCERTAINTY_H
#define RAYGRID_CALIBRATION_RIG_UNCERTAINTY_H

#include <vector>

#include "calibration/model_adjustment.h"
#include "evaluation/rig_result.h"

namespace raygrid {

/// The baselines of every two cameras. Their standard deviations are those of
/// the adjustment's equations and residuals, all other parameters being free;
/// without, if the equations are singular.
std::vector<Baseline> EstimateBaselines(const AdjustmentResult& adjusted,
                                        const AdjustmentOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_RIG_UNCERTAINTY_H
