/// Images of low contrast, e.g. of thermal cameras or with a lens cap.
#ifndef RAYGRID_FEATURES_BOARD_VIEW_LOW_CONTRAST_H
#define RAYGRID_FEATURES_BOARD_VIEW_LOW_CONTRAST_H

#include <optional>

#include "features/board_view/detection.h"

namespace raygrid {

/// Amplifies an image with more than 8 bits whose noise is far below one 8-bit
/// grey level and in which a board may span too few levels for detection.
/// `levels` are multiplied by a power of two such that the noise is about one
/// level, and may exceed the range 0 to 255; `bytes` contain the differences
/// from the local mean. Returns nullopt for images with more noise, or without
/// finer quantization.
std::optional<GreyImage> AmplifyLowContrast(const GreyImage& image);

/// Whether an image contains only noise, so that no board can be detected.
bool IsPureNoise(const GreyImage& image);

/// Smooths an image if its noise is not small compared with its contrast,
/// because marker detectors are slow on noise.
GreyImage Denoise(const GreyImage& image);

/// Whether the contrast hardly exceeds the noise or the quantization step of
/// the file.
bool HasLowContrast(const GreyImage& image);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_BOARD_VIEW_LOW_CONTRAST_H
