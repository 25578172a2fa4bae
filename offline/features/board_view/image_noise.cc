#include "features/board_view/image_noise.h"

#include <algorithm>
#include <cmath>

namespace raygrid {
namespace {

constexpr int kBlockPx = 16;
constexpr int kStridePx = 32;  // between blocks
constexpr double kQuantile = 0.2;

// (1 -2 1)^T (1 -2 1): the standard deviation of white noise grows six times.
double Response(const GreyImage& image, int x, int y) {
  const auto row = [&](int r) {
    return image.at(x - 1, r) - 2 * image.at(x, r) + image.at(x + 1, r);
  };
  return row(y - 1) - 2 * row(y) + row(y + 1);
}

double NoiseOfBlock(const GreyImage& image, int x0, int y0) {
  double sum = 0;
  for (int y = y0; y < y0 + kBlockPx; ++y)
    for (int x = x0; x < x0 + kBlockPx; ++x)
      sum += std::pow(Response(image, x, y), 2);
  return std::sqrt(sum) / kBlockPx / 6;
}

}  // namespace

double NoiseOf(const GreyImage& image) {
  std::vector<double> noise;
  for (int y = 1; y + kBlockPx < image.size.height; y += kStridePx)
    for (int x = 1; x + kBlockPx < image.size.width; x += kStridePx)
      noise.push_back(NoiseOfBlock(image, x, y));
  if (noise.empty()) return 0;
  const auto chosen =
      noise.begin() + static_cast<size_t>(kQuantile * (noise.size() - 1));
  std::nth_element(noise.begin(), chosen, noise.end());
  return *chosen;
}

}  // namespace raygrid
