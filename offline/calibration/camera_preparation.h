#ifndef RAYGRID_CALIBRATION_CAMERA_PREPARATION_H
#define RAYGRID_CALIBRATION_CAMERA_PREPARATION_H

#include <string>

#include "calibration/calibration.h"
#include "calibration/cross_validation.h"
#include "calibration/model_adjustment.h"

namespace raygrid {

/// A camera ready for its model.
struct PreparedCamera {
  Split split;               ///< features as measured last
  Adjusted adjusted;         ///< a parametric camera, by the training images
  CalibrationResult result;  ///< what is known so far
  Checkpoint checkpoint;     ///< what is done so far
};

/// Throws Error(kUsage).
void RequireKnownModel(const std::string& model);

bool ShouldStop(const CalibrationOptions& options);

AdjustmentOptions AdjustmentOptionsOf(const CalibrationOptions& options);

/// Parametric start, features measured again, resolution of the grid.
/// Cross-validates where it takes this to choose the resolution or, if wanted,
/// to know the held-out error. Throws Error: kTooFew, kInitialization.
PreparedCamera PrepareCamera(const Dataset& measured, const Pattern& pattern,
                             const CalibrationOptions& options,
                             bool want_held_out_error);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CAMERA_PREPARATION_H
