#ifndef RAYGRID_FEATURES_BOARD_VIEW_IMAGE_NOISE_H
#define RAYGRID_FEATURES_BOARD_VIEW_IMAGE_NOISE_H

#include <vector>

#include "features/board_view/detection.h"

namespace raygrid {

/// The standard deviation of the noise, grey levels, where the image is
/// smoothest: what Immerkaer's filter (1996), blind to edges, leaves there.
double EstimateNoise(const GreyImage& image);

/// The noise of pixels of about one level.
struct NoiseAtLevel {
  double level, noise;
};

/// How noise changes with brightness, by rising levels, as EstimateNoise()
/// estimates it from the parts of an image with about these levels. Noise grows
/// with the square root of the light at most: what exceeds that is the scene's.
std::vector<NoiseAtLevel> EstimateNoiseByLevel(const GreyImage& image);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_BOARD_VIEW_IMAGE_NOISE_H
