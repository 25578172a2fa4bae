#ifndef RAYGRID_CALIBRATION_INPUT_CHECKS_H
#define RAYGRID_CALIBRATION_INPUT_CHECKS_H

#include <vector>

#include "calibration/calibration.h"
#include "calibration/model_adjustment.h"

namespace raygrid {

/// Checks what can be told before anything that takes long. Throws Error:
/// kUsage for no camera, an unknown model, images to hold out that there are
/// not, and two cameras of one name; kInitialization for a rig that does not
/// hang together.
void RequireValidInput(const std::vector<CalibrationInput>& cameras,
                       const Pattern& pattern,
                       const CalibrationOptions& options);

/// Boards that are mostly far away have their lengths in another unit: the
/// images do not tell. Throws Error(kUsage).
void RequirePlausibleDistances(const AdjustmentResult& adjusted);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_INPUT_CHECKS_H
