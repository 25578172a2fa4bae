#ifndef RAYGRID_CALIBRATION_MIXED_CAMERAS_H
#define RAYGRID_CALIBRATION_MIXED_CAMERAS_H

#include <optional>

#include "calibration/model_adjustment.h"
#include "dataset/dataset.h"

namespace raygrid {

/// Detects images of two cameras that were passed as images of one camera:
/// residuals of neighbouring features are correlated with a single parametric
/// camera, but not with two cameras, each fitted to a subset of the images. The
/// subsets follow from two kinds of names (left01.jpg, right01.jpg), or else
/// from the residuals. A lens that a parametric camera cannot model also has
/// correlated residuals, which any split reduces, so the gain must be much
/// larger than for random subsets. Returns nullopt if all images are from one
/// camera.
std::optional<MixedCameras> DetectMixedCameras(
    const Dataset& training, const Pattern& pattern,
    const AdjustmentResult& joint, const AdjustmentOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_MIXED_CAMERAS_H
