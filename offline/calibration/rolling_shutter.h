#ifndef RAYGRID_CALIBRATION_ROLLING_SHUTTER_H
#define RAYGRID_CALIBRATION_ROLLING_SHUTTER_H

#include <optional>
#include <vector>

#include "calibration/camera_in_progress.h"

namespace raygrid {

/// The features of all images where they would have been seen, had each frame
/// been read at one instant.
struct CompensatedFeatures {
  LineDelay line_delay;  ///< by which they were moved
  Dataset features;
};

/// Still features by the row time that a first camera tells. Nothing if it
/// cannot be told, or may be that of a global shutter, or if the calibration is
/// told to stop.
std::optional<CompensatedFeatures> ComputeCompensatedFeatures(
    const Pattern& pattern, const CalibrationOptions& options,
    const CameraInProgress& camera);

/// The row time by a calibrated camera, and the pattern as it was found.
LineDelayEstimate EstimateFinalLineDelay(const CameraInProgress& camera,
                                         const CameraModel& calibrated,
                                         const Pattern& found, int num_threads);

/// Tells of rejected images that they were left out since their motion is not
/// known, where it is so.
void ReportExcludedImages(const CameraInProgress& camera,
                          const Pattern& pattern,
                          std::vector<RejectedImage>* rejected);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_ROLLING_SHUTTER_H
