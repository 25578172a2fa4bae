#ifndef RAYGRID_FEATURES_IMAGE_NOISE_H
#define RAYGRID_FEATURES_IMAGE_NOISE_H

#include "features/detection.h"

namespace raygrid {

/// The standard deviation of the noise, grey levels, where the image is
/// smoothest: what Immerkaer's filter (1996), blind to edges, leaves there.
double NoiseOf(const GreyImage& image);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_IMAGE_NOISE_H
