#ifndef RAYGRID_CALIBRATION_RESTART_H
#define RAYGRID_CALIBRATION_RESTART_H

#include <functional>
#include <vector>

#include "calibration/camera_in_progress.h"

namespace raygrid {

/// Restarts of a single camera whose adjustment was led astray: from the lenses
/// of the folds of its cross-validation, or around a parametric model that it
/// is compared with. Errors are compared as ComputeMeanErrorPx() counts them.

/// Whether the adjustment has much more error than the features that the folds
/// held out, which is but by divergence. knot_spacings_px are those of the
/// result.
bool IsWorseThanFolds(const CameraInProgress& camera,
                      const AdjustmentResult& adjusted, bool are_boards_rigid,
                      double knot_spacing_px);

/// Adjusts from each fold's lens, which adjust takes from camera->lens. The
/// best stays, with its lens.
void RestartFromFolds(const Pattern& pattern, const CalibrationOptions& options,
                      const std::function<AdjustmentResult()>& adjust,
                      CameraInProgress* camera, AdjustmentResult* adjusted);

/// Adjusts a grid around the parametric models that it is compared with and
/// that have much less error. Returns whether one was better: that stays, and
/// its cells are those of camera->result.
bool RestartFromComparison(const Pattern& pattern,
                           const CalibrationOptions& options,
                           bool are_boards_rigid, CameraInProgress* camera,
                           AdjustmentResult* adjusted);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_RESTART_H
