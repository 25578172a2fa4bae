#include "features/board_view/image_noise.h"

#include <algorithm>
#include <cmath>

namespace raygrid {
namespace {

constexpr int kBlockPx = 16;
constexpr int kStridePx = 32;  // from block to block
constexpr double kQuantile = 0.2;

// Response of the filter (1 -2 1)^T (1 -2 1), which multiplies the standard
// deviation of white noise by 6.
double Response(const GreyImage& image, int x, int y) {
  const auto row = [&](int r) {
    return image.at(x - 1, r) - 2 * image.at(x, r) + image.at(x + 1, r);
  };
  return row(y - 1) - 2 * row(y) + row(y + 1);
}

// Returns the mean grey level of a block and the standard deviation of its
// noise.
NoiseAtGreyLevel EstimateBlockNoise(const GreyImage& image, int x0, int y0) {
  double sum = 0, levels = 0;
  for (int y = y0; y < y0 + kBlockPx; ++y) {
    for (int x = x0; x < x0 + kBlockPx; ++x) {
      sum += std::pow(Response(image, x, y), 2);
      levels += image.at(x, y);
    }
  }
  return {levels / kBlockPx / kBlockPx, std::sqrt(sum) / kBlockPx / 6};
}

std::vector<NoiseAtGreyLevel> EstimateBlockNoises(const GreyImage& image) {
  std::vector<NoiseAtGreyLevel> blocks;
  for (int y = 1; y + kBlockPx < image.size.height; y += kStridePx)
    for (int x = 1; x + kBlockPx < image.size.width; x += kStridePx)
      blocks.push_back(EstimateBlockNoise(image, x, y));
  return blocks;
}

double SmoothestNoise(std::vector<NoiseAtGreyLevel> blocks) {
  if (blocks.empty()) return 0;
  const auto chosen =
      blocks.begin() + static_cast<ptrdiff_t>(
                           kQuantile * static_cast<double>(blocks.size() - 1));
  std::nth_element(blocks.begin(), chosen, blocks.end(),
                   [](const NoiseAtGreyLevel& a, const NoiseAtGreyLevel& b) {
                     return a.noise < b.noise;
                   });
  return chosen->noise;
}

}  // namespace

double EstimateNoise(const GreyImage& image) {
  return SmoothestNoise(EstimateBlockNoises(image));
}

std::vector<NoiseAtGreyLevel> EstimateNoiseByGreyLevel(const GreyImage& image) {
  constexpr size_t kNumGreyLevels = 8, kMinBlocks = 12;
  std::vector<NoiseAtGreyLevel> blocks = EstimateBlockNoises(image);
  std::stable_sort(blocks.begin(), blocks.end(),
                   [](const NoiseAtGreyLevel& a, const NoiseAtGreyLevel& b) {
                     return a.level < b.level;
                   });
  const size_t num_grey_levels =
      std::clamp<size_t>(blocks.size() / kMinBlocks, 1, kNumGreyLevels);
  std::vector<NoiseAtGreyLevel> noise_by_grey_level;
  for (size_t k = 0; k < num_grey_levels && !blocks.empty(); ++k) {
    const auto begin = blocks.begin() + k * blocks.size() / num_grey_levels;
    const auto end = blocks.begin() + (k + 1) * blocks.size() / num_grey_levels;
    const double level = (begin + (end - begin) / 2)->level;
    double noise = SmoothestNoise({begin, end});
    for (const NoiseAtGreyLevel& other : noise_by_grey_level)
      noise = std::min(
          noise, other.noise * std::sqrt(std::max(
                                   1.0, level / std::max(1.0, other.level))));
    for (NoiseAtGreyLevel& darker : noise_by_grey_level)
      darker.noise = std::min(darker.noise, noise);
    noise_by_grey_level.push_back({level, noise});
  }
  return noise_by_grey_level;
}

}  // namespace raygrid
