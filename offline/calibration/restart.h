#ifndef RAYGRID_CALIBRATION_RESTART_H
#define RAYGRID_CALIBRATION_RESTART_H

#include <functional>
#include <vector>

#include "calibration/camera_in_progress.h"

namespace raygrid {

/// Restarts of a single camera whose adjustment diverged: from the initial
/// cameras of its cross-validation folds, or from a parametric model of the
/// comparison. Errors are defined as in ComputeMeanErrorPx().

/// Returns whether the training error is much larger than the cross-validation
/// error, which indicates divergence. knot_spacing_px is the spacing of the
/// result.
bool IsWorseThanFolds(const CameraInProgress& camera,
                      const AdjustmentResult& adjusted, bool are_boards_rigid,
                      double knot_spacing_px);

/// Runs adjust() with camera->lens set to the initial camera of each fold in
/// turn. Keeps the best result and its initial camera.
void RestartFromFolds(const Pattern& pattern, const CalibrationOptions& options,
                      const std::function<AdjustmentResult()>& adjust,
                      CameraInProgress* camera, AdjustmentResult* adjusted);

/// Optimizes a grid from each parametric model of the comparison with a much
/// smaller error. Returns whether one was better; its result is then kept, and
/// its knot spacing is set in camera->result.
bool RestartFromComparison(const Pattern& pattern,
                           const CalibrationOptions& options,
                           bool are_boards_rigid, CameraInProgress* camera,
                           AdjustmentResult* adjusted);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_RESTART_H
