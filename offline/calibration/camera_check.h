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

/// Whether the camera still sees a board as when it was calibrated: its images
/// are localised, then tested (evaluation/camera_change.h). Copies of an image
/// tell nothing more than it does, and are rejected. Throws InputError
/// if the file says nothing of the camera's errors, Error(kTooFew).
CameraCheck CheckCamera(const CameraFile& file, const Dataset& dataset,
                        const Pattern& pattern, int num_threads);

/// The errors that the images of a camera show beyond those that its file
/// states (evaluation/camera_change.h, ComputeExcessErrors), by how the images
/// were predicted without having calibrated the camera: each by a camera that
/// as large a part of the images as training_share has calibrated. Zeros if the
/// file states nothing, and for fewer than eight images.
MovementErrors EstimateExcessErrors(
    const CameraFile& file, const std::vector<FeatureResidual>& held_out,
    double training_share, const Pattern& pattern, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CAMERA_CHECK_H
