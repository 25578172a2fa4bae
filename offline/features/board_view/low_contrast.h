/// Images of low contrast: those of thermal cameras, and of a lens cap.
#ifndef RAYGRID_FEATURES_BOARD_VIEW_LOW_CONTRAST_H
#define RAYGRID_FEATURES_BOARD_VIEW_LOW_CONTRAST_H

#include <optional>

#include "features/board_view/detection.h"

namespace raygrid {

/// An image of more than 8 bits whose noise is far below a grey level may show
/// a board within a few levels, too little for the bounds of detection. This is
/// it with levels, from below 0 to above 255, that are larger by a power of
/// two, so that its noise is about one level. Its bytes show the differences
/// from the mean around each pixel. Nothing for images with more noise, or
/// where the file has no finer levels.
std::optional<GreyImage> AmplifyLowContrast(const GreyImage& image);

/// Whether an image shows noise alone: no board could be found in it.
bool IsPureNoise(const GreyImage& image);

/// An image so smoothed that its noise is a small part of its contrast, where
/// it is not: libraries that read markers take long for noise.
GreyImage Denoise(const GreyImage& image);

/// Whether hardly anything stands out from the noise, or from the steps of the
/// file's levels.
bool HasLowContrast(const GreyImage& image);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_BOARD_VIEW_LOW_CONTRAST_H
