#ifndef RAYGRID_CALIBRATION_CAMERA_INITIALIZATION_H
#define RAYGRID_CALIBRATION_CAMERA_INITIALIZATION_H

#include "calibration/model_adjustment.h"
#include "dataset/dataset.h"

namespace raygrid {

/// Minimum number of images to initialize a camera.
constexpr int kMinImages = 3;

/// Initializes and optimizes a parametric camera from the observations alone;
/// area is the calibrated area. If `known`, a camera of almost the same
/// observations, is given, it is the initial value. Throws Error: kTooFew,
/// kInitialization.
AdjustmentResult InitializeCamera(const Dataset& dataset,
                                  const Pattern& pattern,
                                  const AdjustmentOptions& options,
                                  AreaChoice area = AreaChoice::kWholeImage,
                                  const CameraModel* known = nullptr);

/// Estimates the target poses of a camera with known intrinsics, which the
/// returned state holds as FixedCamera, in place of InitializeCamera(). Throws
/// Error(kTooFew) if there are none.
AdjustmentResult InitializeKnownCamera(const CameraModel& camera,
                                       const Dataset& dataset,
                                       const Pattern& pattern, AreaChoice area,
                                       int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CAMERA_INITIALIZATION_H
