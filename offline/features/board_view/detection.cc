#include "features/board_view/detection.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace raygrid {

GreyImage MakeGreyImage(GreyLevels grey) {
  GreyImage image;
  image.size = grey.size;
  image.level_step = grey.level_step;
  image.was_mosaic = grey.was_mosaic;
  image.bytes.reserve(grey.levels.size());
  for (const float level : grey.levels)
    image.bytes.push_back(static_cast<uint8_t>(std::lround(level)));
  image.levels = std::move(grey.levels);
  return image;
}

GreyImage MakeGreyImage(const Image& image) {
  GreyLevels grey;
  grey.size = image.size;
  const size_t count = image.pixels.size() / image.channels;
  grey.levels.resize(count);
  for (size_t i = 0; i < count; ++i) {
    const uint8_t* pixel = &image.pixels[i * image.channels];
    grey.levels[i] =
        image.channels == 1
            ? pixel[0]
            : 0.114f * pixel[0] + 0.587f * pixel[1] + 0.299f * pixel[2];
  }
  return MakeGreyImage(std::move(grey));
}

bool IsLargeEnough(const ImageSize& size) {
  constexpr int kMinSidePx = 32;
  return std::min(size.width, size.height) >= kMinSidePx;
}

GreyImage MirrorImage(GreyImage image) {
  const int width = image.size.width;
  for (int row = 0; row < image.size.height; ++row) {
    const auto level = image.levels.begin() + row * width;
    const auto byte = image.bytes.begin() + row * width;
    std::reverse(level, level + width);
    std::reverse(byte, byte + width);
  }
  return image;
}

GreyImage HalveImage(const GreyImage& image) {
  GreyLevels half;
  half.size = {image.size.width / 2, image.size.height / 2};
  half.levels.reserve(static_cast<size_t>(half.size.width) * half.size.height);
  for (int y = 0; y < half.size.height; ++y) {
    const float* upper =
        &image.levels[static_cast<size_t>(2 * y) * image.size.width];
    const float* lower = upper + image.size.width;
    for (int x = 0; x < half.size.width; ++x, upper += 2, lower += 2)
      half.levels.push_back((upper[0] + upper[1] + lower[0] + lower[1]) / 4);
  }
  return MakeGreyImage(std::move(half));
}

}  // namespace raygrid
