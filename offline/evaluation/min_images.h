#ifndef RAYGRID_EVALUATION_MIN_IMAGES_H
#define RAYGRID_EVALUATION_MIN_IMAGES_H

namespace raygrid {

/// The minimum number of images from which the deviation from a parametric
/// model, and thus the uncertainty, can be estimated.
constexpr int kMinReliableImages = 10;

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_MIN_IMAGES_H
