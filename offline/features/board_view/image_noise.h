#ifndef RAYGRID_FEATURES_BOARD_VIEW_IMAGE_NOISE_H
#define RAYGRID_FEATURES_BOARD_VIEW_IMAGE_NOISE_H

#include "features/board_view/detection.h"

namespace raygrid {

/// The standard deviation of the noise, grey levels, where the image is
/// smoothest: what Immerkaer's filter (1996), blind to edges, leaves there.
double NoiseOf(const GreyImage& image);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_BOARD_VIEW_IMAGE_NOISE_H
