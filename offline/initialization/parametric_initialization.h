#ifndef RAYGRID_INITIALIZATION_PARAMETRIC_INITIALIZATION_H
#define RAYGRID_INITIALIZATION_PARAMETRIC_INITIALIZATION_H

#include <optional>

#include "camera/opencv.h"
#include "dataset/dataset.h"

namespace raygrid {

/// Initializes a camera from planar boards (Z. Zhang, "A flexible new technique
/// for camera calibration", 2000, as in OpenCV), with radial and tangential
/// distortion, from a sample of the images. The area is the whole image.
/// Returns nullopt on failure: few images, or a lens far from a pinhole.
std::optional<OpenCvModel> InitializeFromPlanarBoards(const Dataset& dataset,
                                                      const Pattern& pattern);

}  // namespace raygrid

#endif  // RAYGRID_INITIALIZATION_PARAMETRIC_INITIALIZATION_H
