#ifndef RAYGRID_CALIBRATION_MEASURING_AGAIN_H
#define RAYGRID_CALIBRATION_MEASURING_AGAIN_H

#include <optional>
#include <vector>

#include "calibration/camera_in_progress.h"

namespace raygrid {

/// A first camera of medium resolution, and the pattern as it was found.
struct FirstCamera {
  Adjusted adjusted;
  Pattern pattern;
};
FirstCamera AdjustFirstCamera(const Pattern& pattern,
                              const CalibrationOptions& options,
                              const CameraInProgress& camera);

/// The boards of all images, those held out among them, where a camera
/// localises them.
std::vector<BoardPose> LocalizedBoards(const CameraModel& camera,
                                       const Dataset& dataset,
                                       const Pattern& pattern, int num_threads);

/// Measures a camera's features again, through a first camera: what bends the
/// mapping within a window is mostly the lens's distortion. Nothing if it is
/// told to stop first.
std::optional<Dataset> MeasureFeaturesAgain(const Pattern& pattern,
                                            const CalibrationOptions& options,
                                            const CameraInProgress& camera);

/// The RMS distance between features before and after; both datasets have the
/// same features.
double RmsMovePx(const Dataset& before, const Dataset& after);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_MEASURING_AGAIN_H
