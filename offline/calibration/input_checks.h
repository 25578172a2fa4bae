#ifndef RAYGRID_CALIBRATION_INPUT_CHECKS_H
#define RAYGRID_CALIBRATION_INPUT_CHECKS_H

#include <vector>

#include "calibration/calibration.h"
#include "calibration/model_adjustment.h"

namespace raygrid {

/// Checks the input before any expensive step. Throws Error: kUsage for no
/// camera, an unknown model, unknown held-out images, and two cameras of one
/// name; kInitializationFailed for a rig whose cameras are not connected by
/// shared views.
void RequireValidInput(const std::vector<CalibrationInput>& cameras,
                       const Pattern& pattern,
                       const CalibrationOptions& options);

/// Checks the distances of boards: if most are far away, lengths probably have
/// the wrong unit, which images cannot reveal. Throws Error(kUsage).
void RequirePlausibleDistances(const AdjustmentResult& adjusted);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_INPUT_CHECKS_H
