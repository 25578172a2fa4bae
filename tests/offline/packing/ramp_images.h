#ifndef RAYGRID_TESTS_OFFLINE_PACKING_RAMP_IMAGES_H
#define RAYGRID_TESTS_OFFLINE_PACKING_RAMP_IMAGES_H

#include <cstdint>
#include <optional>

#include "dataset/image_files.h"

namespace raygrid {

// Levels of 16 bits that tell a pixel's column or row, from 1 on: 0 is border.
constexpr double kLevelsPerPx = 100;

inline double LevelAt(const Image& image, int x, int y) {
  const size_t at = 2 * (static_cast<size_t>(y) * image.size.width + x);
  return image.pixels[at] + 256 * image.pixels[at + 1];
}

inline void AddLevel(double level, Image* image) {
  const auto rounded = static_cast<uint16_t>(std::lround(level));
  image->pixels.push_back(static_cast<uint8_t>(rounded & 255));
  image->pixels.push_back(static_cast<uint8_t>(rounded >> 8));
}

inline Image RampImage(const ImageSize& size, int axis) {
  Image image;
  image.size = size;
  image.sample_bytes = 2;
  for (int k = 0; k < size.width * size.height; ++k)
    AddLevel(kLevelsPerPx * (1 + (axis == 0 ? k % size.width : k / size.width)),
             &image);
  return image;
}

// The source that an undistorted pixel of both ramps tells; nothing if it is
// border.
// Levels round x and y to a hundredth of a pixel.
inline std::optional<Eigen::Vector2d> SourceInRamps(const Image shown[2], int x,
                                                    int y) {
  if (LevelAt(shown[0], x, y) == 0) return std::nullopt;
  return Eigen::Vector2d(LevelAt(shown[0], x, y) / kLevelsPerPx - 1,
                         LevelAt(shown[1], x, y) / kLevelsPerPx - 1);
}

}  // namespace raygrid

#endif  // RAYGRID_TESTS_OFFLINE_PACKING_RAMP_IMAGES_H
