#ifndef RAYGRID_CALIBRATION_CAMERA_CHECK_H
#define RAYGRID_CALIBRATION_CAMERA_CHECK_H

#include <vector>

#include "dataset/camera_file.h"
#include "dataset/dataset.h"
#include "evaluation/calibration_result.h"
#include "evaluation/camera_change.h"

namespace raygrid {

struct CameraCheck {
  CameraChange change;
  int num_images = 0;
  std::vector<RejectedImage> rejected_images;
};

/// Tests whether a camera has changed since its calibration: its images are
/// localized, then tested (evaluation/camera_change.h). Near-duplicates are
/// rejected, as they add no information. Throws InputError if the file has no
/// uncertainty, Error(kInsufficientData).
CameraCheck CheckCamera(const CameraFile& file, const Dataset& dataset,
                        const Pattern& pattern, int num_threads);

/// Estimates how far the errors in a camera's images exceed the uncertainty in
/// its file (evaluation/camera_change.h, ComputeExcessErrors), from held-out
/// residuals: each image is predicted by a camera calibrated with the fraction
/// training_share of the images. Returns zeros if the file has no uncertainty,
/// or for fewer than eight images.
MovementErrors EstimateExcessErrors(
    const CameraFile& file, const std::vector<FeatureResidual>& held_out,
    double training_share, const Pattern& pattern, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CAMERA_CHECK_H
