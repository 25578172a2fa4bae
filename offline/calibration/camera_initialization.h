#ifndef RAYGRID_CALIBRATION_CAMERA_INITIALIZATION_H
#define RAYGRID_CALIBRATION_CAMERA_INITIALIZATION_H

#include "calibration/model_adjustment.h"
#include "dataset/dataset.h"

namespace raygrid {

/// Minimum number of images to initialize a camera.
constexpr int kMinImages = 3;

/// Initializes and optimizes a parametric camera from the observations alone;
/// area is the calibrated area. The optional camera `known`, estimated from
/// almost the same observations, is used as the initial value. Throws Error:
/// kInsufficientData, kInitializationFailed.
AdjustmentResult InitializeCamera(const Dataset& dataset,
                                  const Pattern& pattern,
                                  const AdjustmentOptions& options,
                                  AreaChoice area = AreaChoice::kWholeImage,
                                  const CameraModel* known = nullptr);

/// Replaces InitializeCamera() for a camera with known intrinsics: estimates
/// only the target poses. The returned state contains the camera as
/// FixedCamera. Throws Error(kInsufficientData) if there are none.
AdjustmentResult InitializeKnownCamera(const CameraModel& camera,
                                       const Dataset& dataset,
                                       const Pattern& pattern, AreaChoice area,
                                       int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CAMERA_INITIALIZATION_H
