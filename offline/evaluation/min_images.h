#ifndef RAYGRID_EVALUATION_MIN_IMAGES_H
#define RAYGRID_EVALUATION_MIN_IMAGES_H

namespace raygrid {

/// Minimum number of images for estimating the deviation from a parametric
/// model, and thus the uncertainty.
constexpr int kMinReliableImages = 10;

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_MIN_IMAGES_H
