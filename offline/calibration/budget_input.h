#ifndef RAYGRID_CALIBRATION_BUDGET_INPUT_H
#define RAYGRID_CALIBRATION_BUDGET_INPUT_H

#include "calibration/calibration.h"
#include "evaluation/calibration_result.h"
#include "evaluation/residual_budget.h"

namespace raygrid {

/// Collects the training residuals of a calibration and their covariates.
BudgetInput MakeBudgetInput(const CalibrationResult& result,
                            const BudgetSummary& facts);

/// Lists the calibration steps that were enabled by the options.
BudgetSummary MakeBudgetSummary(const CalibrationResult& result,
                                const CalibrationOptions& options);

/// Collects the residuals of images localized with a fixed camera.
BudgetInput MakeBudgetInput(const CameraModel& camera, const Dataset& dataset,
                            const Pattern& pattern, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_BUDGET_INPUT_H
