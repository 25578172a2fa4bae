#ifndef RAYGRID_CALIBRATION_CAMERA_INITIALIZATION_H
#define RAYGRID_CALIBRATION_CAMERA_INITIALIZATION_H

#include "calibration/model_adjustment.h"
#include "dataset/dataset.h"

namespace raygrid {

/// The fewest images that tell a lens.
constexpr int kMinImages = 3;

/// A starting lens from nothing but the observations, adjusted; area is what
/// the camera is to be calibrated over. If the lens is already known of nearly
/// the same observations, it is adjusted instead of looked for. Throws Error:
/// kTooFew, kInitialization.
AdjustmentResult InitializeCamera(const Dataset& dataset,
                                  const Pattern& pattern,
                                  const AdjustmentOptions& options,
                                  AreaChoice area = AreaChoice::kWholeImage,
                                  const CameraModel* known = nullptr);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CAMERA_INITIALIZATION_H
