#ifndef RAYGRID_CALIBRATION_MIXED_CAMERAS_H
#define RAYGRID_CALIBRATION_MIXED_CAMERAS_H

#include <optional>

#include "calibration/model_adjustment.h"
#include "dataset/dataset.h"

namespace raygrid {

/// Whether images taken for one camera's are those of two: neighbouring
/// features err alike with the one parametric camera, and no longer with two,
/// each adjusted to a part of the images. The parts are those of two kinds of
/// names (left01.jpg, right01.jpg), or else what residuals suggest. A lens that
/// a parametric camera does not follow errs alike in parts, too, and is
/// followed better in any parts: two cameras do much better than parts by
/// chance.
std::optional<MixedCameras> DetectMixedCameras(
    const Dataset& training, const Pattern& pattern,
    const AdjustmentResult& joint, const AdjustmentOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_MIXED_CAMERAS_H
