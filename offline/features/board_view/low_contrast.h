/// Images of low contrast, such as from thermal cameras or with a lens cap.
#ifndef RAYGRID_FEATURES_BOARD_VIEW_LOW_CONTRAST_H
#define RAYGRID_FEATURES_BOARD_VIEW_LOW_CONTRAST_H

#include <optional>

#include "features/board_view/detection.h"

namespace raygrid {

/// Amplifies an image of more than 8 bits whose noise is far below a grey
/// level, and in which a board may span only a few levels, too few for
/// detection. Levels are scaled by a power of two, so that the noise is about
/// one level, and may exceed 0 to 255. Bytes contain differences from the local
/// mean. Returns nullopt for images with more noise, or without finer levels.
std::optional<GreyImage> AmplifyLowContrast(const GreyImage& image);

/// Whether an image contains only noise, so that no board can be detected.
bool IsPureNoise(const GreyImage& image);

/// Smooths an image unless its noise is a small part of its contrast, because
/// marker libraries are slow on noise.
GreyImage Denoise(const GreyImage& image);

/// Whether hardly any contrast exceeds the noise, or the quantization steps of
/// the file.
bool HasLowContrast(const GreyImage& image);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_BOARD_VIEW_LOW_CONTRAST_H
