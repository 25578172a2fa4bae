#ifndef RAYGRID_FEATURES_BOARD_VIEW_IMAGE_NOISE_H
#define RAYGRID_FEATURES_BOARD_VIEW_IMAGE_NOISE_H

#include <vector>

#include "features/board_view/detection.h"

namespace raygrid {

/// Estimates the standard deviation of the noise, grey levels, in the smoothest
/// parts of the image, with Immerkaer's filter (1996), which suppresses edges.
double EstimateNoise(const GreyImage& image);

/// Noise of pixels near a grey level.
struct NoiseAtLevel {
  double level, noise;
};

/// Estimates the noise by brightness, in ascending order, by EstimateNoise() on
/// the parts of the image near each level. Noise increases at most with the
/// square root of the light: larger values are attributed to the scene.
std::vector<NoiseAtLevel> EstimateNoiseByLevel(const GreyImage& image);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_BOARD_VIEW_IMAGE_NOISE_H
