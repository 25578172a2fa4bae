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
/// are localised, then tested (evaluation/camera_change.h). Throws InputError
/// if the file says nothing of the camera's errors, Error(kTooFew).
CameraCheck CheckCamera(const CameraFile& file, const Dataset& dataset,
                        const Pattern& pattern, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CAMERA_CHECK_H
