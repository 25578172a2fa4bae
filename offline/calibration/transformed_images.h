#ifndef RAYGRID_CALIBRATION_TRANSFORMED_IMAGES_H
#define RAYGRID_CALIBRATION_TRANSFORMED_IMAGES_H

#include <optional>

#include "calibration/model_adjustment.h"
#include "dataset/dataset.h"

namespace raygrid {

/// Detects images that were rotated by 180 degrees or scaled: a
/// single camera explains all images much better if the pixel coordinates of
/// some of them are transformed back. The group and the camera are estimated
/// alternately. Returns nullopt if no transformation suffices.
std::optional<TransformedImages> DetectTransformedImages(
    const Dataset& training, const Pattern& pattern,
    const AdjustmentResult& joint, const AdjustmentOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_TRANSFORMED_IMAGES_H
