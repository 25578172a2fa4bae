#ifndef RAYGRID_CALIBRATION_MODEL_BASED_REFINEMENT_H
#define RAYGRID_CALIBRATION_MODEL_BASED_REFINEMENT_H

#include <optional>
#include <vector>

#include "calibration/camera_in_progress.h"

namespace raygrid {

/// A first camera of medium resolution, and the pattern as it was found.
struct FirstCamera {
  AdjustmentResult adjusted;
  Pattern pattern;
};
FirstCamera EstimateFirstCamera(const Pattern& pattern,
                                const CalibrationOptions& options,
                                const CameraInProgress& camera);

/// The boards of all images, those held out among them, where a camera
/// localises them.
std::vector<BoardPose> LocalizeAllBoards(const CameraModel& camera,
                                         const Dataset& dataset,
                                         const Pattern& pattern,
                                         int num_threads);

/// Measures a camera's features again, through a first camera: what bends the
/// mapping within a window is mostly the lens's distortion. Nothing if it is
/// told to stop first.
std::optional<Dataset> RefineFeaturesWithModel(
    const Pattern& pattern, const CalibrationOptions& options,
    const CameraInProgress& camera);

/// The RMS distance between features before and after; both datasets have the
/// same features.
double ComputeRmsShiftPx(const Dataset& before, const Dataset& after);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_MODEL_BASED_REFINEMENT_H
