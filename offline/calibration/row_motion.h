#ifndef RAYGRID_CALIBRATION_ROW_MOTION_H
#define RAYGRID_CALIBRATION_ROW_MOTION_H

#include <optional>
#include <vector>

#include "calibration/camera_in_progress.h"

namespace raygrid {

/// The features of all images where they would have been seen, had each frame
/// been read at one instant.
struct StillFeatures {
  RowTime row_time;  ///< by which they were moved
  Dataset features;
};

/// Still features by the row time that a first camera tells. Nothing if it
/// cannot be told, or may be that of a global shutter, or if the calibration is
/// told to stop.
std::optional<StillFeatures> FeaturesWithoutRowMotion(
    const Pattern& pattern, const CalibrationOptions& options,
    const CameraInProgress& camera);

/// The row time by a calibrated camera, and the pattern as it was found.
RowTimeEstimate RowTimeOf(const CameraInProgress& camera,
                          const CameraModel& calibrated, const Pattern& found,
                          int num_threads);

/// Tells of rejected images that they were left out since their motion is not
/// known, where it is so.
void NameImagesLeftOut(const CameraInProgress& camera, const Pattern& pattern,
                       std::vector<RejectedImage>* rejected);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_ROW_MOTION_H
