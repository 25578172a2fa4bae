#ifndef RAYGRID_FEATURES_BOARD_VIEW_IMAGE_NOISE_H
#define RAYGRID_FEATURES_BOARD_VIEW_IMAGE_NOISE_H

#include <vector>

#include "features/board_view/detection.h"

namespace raygrid {

/// Estimates the standard deviation of the image noise, in grey levels, from
/// the smoothest blocks of the image, with Immerkaer's filter (1996), which
/// suppresses edges.
double EstimateNoise(const GreyImage& image);

/// Standard deviation of the noise at a grey level.
struct NoiseAtGreyLevel {
  double level, noise;
};

/// Estimates the noise as a function of the grey level, in ascending order,
/// from the smoothest blocks at each level. Photon noise increases at most with
/// the square root of the intensity; larger values are attributed to texture
/// and limited accordingly.
std::vector<NoiseAtGreyLevel> EstimateNoiseByGreyLevel(const GreyImage& image);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_BOARD_VIEW_IMAGE_NOISE_H
