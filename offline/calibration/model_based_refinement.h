#ifndef RAYGRID_CALIBRATION_MODEL_BASED_REFINEMENT_H
#define RAYGRID_CALIBRATION_MODEL_BASED_REFINEMENT_H

#include <optional>
#include <vector>

#include "calibration/camera_in_progress.h"

namespace raygrid {

/// A first camera of medium resolution, and the estimated pattern.
struct FirstCamera {
  AdjustmentResult adjusted;
  Pattern pattern;
};
FirstCamera EstimateFirstCamera(const Pattern& pattern,
                                const CalibrationOptions& options,
                                const CameraInProgress& camera);

/// Localizes the boards of all images, including held-out ones; images that
/// cannot be localized are omitted.
std::vector<BoardPose> LocalizeAllBoards(const CameraModel& camera,
                                         const Dataset& dataset,
                                         const Pattern& pattern,
                                         int num_threads);

/// Refines a camera's features with a first camera model: the mapping within a
/// window is non-linear mostly because of lens distortion. Returns nullopt if
/// stopped before.
std::optional<Dataset> RefineFeaturesWithModel(
    const Pattern& pattern, const CalibrationOptions& options,
    const CameraInProgress& camera);

/// Returns the RMS distance between the features of two datasets, which must
/// have the same features.
double ComputeRmsShiftPx(const Dataset& before, const Dataset& after);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_MODEL_BASED_REFINEMENT_H
