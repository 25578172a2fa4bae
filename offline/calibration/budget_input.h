#ifndef RAYGRID_CALIBRATION_BUDGET_INPUT_H
#define RAYGRID_CALIBRATION_BUDGET_INPUT_H

#include "calibration/calibration.h"
#include "evaluation/calibration_result.h"
#include "evaluation/residual_budget.h"

namespace raygrid {

/// The training residuals of a calibration, with what they depend on.
BudgetInput MakeBudgetInput(const CalibrationResult& result,
                            const BudgetFacts& facts);

/// The steps that a calibration with these options has done.
BudgetFacts MakeBudgetFacts(const CalibrationResult& result,
                            const CalibrationOptions& options);

/// The residuals of images that a camera localises as it is.
BudgetInput MakeBudgetInput(const CameraModel& camera, const Dataset& dataset,
                            const Pattern& pattern, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_BUDGET_INPUT_H
