#ifndef RAYGRID_CALIBRATION_ROLLING_SHUTTER_H
#define RAYGRID_CALIBRATION_ROLLING_SHUTTER_H

#include <optional>
#include <vector>

#include "calibration/camera_in_progress.h"

namespace raygrid {

/// Features of all images with the motion during readout compensated, as if all
/// rows had been read at the same time.
struct CompensatedFeatures {
  LineDelay line_delay;  ///< line delay used
  Dataset features;
};

/// Compensates rolling shutter with the line delay estimated with a first
/// camera. Returns nullopt if it is not observable, not significantly different
/// from a global shutter's, or if the calibration is stopped.
std::optional<CompensatedFeatures> ComputeCompensatedFeatures(
    const Pattern& pattern, const CalibrationOptions& options,
    const CameraInProgress& camera);

/// Estimates the line delay with the calibrated camera and the estimated
/// pattern.
LineDelayEstimate EstimateFinalLineDelay(const CameraInProgress& camera,
                                         const CameraModel& calibrated,
                                         const Pattern& found, int num_threads);

/// Sets the reason of images that were rejected because their motion is not
/// known.
void ReportExcludedImages(const CameraInProgress& camera,
                          const Pattern& pattern,
                          std::vector<RejectedImage>* rejected);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_ROLLING_SHUTTER_H
