#include "dataset/mosaic.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace raygrid {
namespace {

constexpr int kNumPhases = 4;  // phases of a 2 x 2 mosaic: 2 (y % 2) + x % 2

int GetPhase(int x, int y) { return 2 * (y % 2) + x % 2; }

float At(const GreyLevels& image, int x, int y) {
  return image.levels[static_cast<size_t>(y) * image.size.width + x];
}

// Returns the local mean around a pixel with equal weights of the phases; exact
// for linear gradients.
float ComputeNeighborMean(const GreyLevels& image, int x, int y) {
  const auto row = [&](int r) {
    return At(image, x - 1, r) + 2 * At(image, x, r) + At(image, x + 1, r);
  };
  return (row(y - 1) + 2 * row(y) + row(y + 1)) / 16;
}

template <typename T>
T ComputeMedian(std::vector<T> values) {
  const auto median = values.begin() + values.size() / 2;
  std::nth_element(values.begin(), median, values.end());
  return *median;
}

// Relative difference of each phase from the local mean, in a block of the
// image.
using Excess = std::array<double, kNumPhases>;

constexpr int kBlockPx = 16;

std::vector<Excess> ComputeBlockExcess(const GreyLevels& image) {
  constexpr int kMaxAcross = 40;
  constexpr double kMinLevel = 4;
  const auto stride = [](int side) {
    return std::max(kBlockPx, side / kMaxAcross / 2 * 2);
  };
  std::vector<Excess> blocks;
  for (int top = 2; top + kBlockPx < image.size.height;
       top += stride(image.size.height)) {
    for (int left = 2; left + kBlockPx < image.size.width;
         left += stride(image.size.width)) {
      Excess excess = {};
      double sum = 0;
      for (int y = top; y < top + kBlockPx; ++y) {
        for (int x = left; x < left + kBlockPx; ++x) {
          const double mean = ComputeNeighborMean(image, x, y);
          excess[GetPhase(x, y)] += At(image, x, y) - mean;
          sum += mean;
        }
      }
      if (sum < kMinLevel * kBlockPx * kBlockPx) continue;
      for (double& e : excess) e *= kNumPhases / sum;
      blocks.push_back(excess);
    }
  }
  return blocks;
}

// Whether a phase is consistently brighter or darker than the local mean over
// the image.
bool IsMosaic(const GreyLevels& image) {
  constexpr size_t kMinBlocks = 20;
  constexpr double kMinExcess = 0.02, kMinBlockFraction = 0.8;
  const std::vector<Excess> blocks = ComputeBlockExcess(image);
  if (blocks.size() < kMinBlocks) return false;
  for (int phase = 0; phase < kNumPhases; ++phase) {
    std::vector<double> excess;
    for (const Excess& block : blocks) excess.push_back(block[phase]);
    const double median = ComputeMedian(excess);
    const auto num_same_sign = std::count_if(
        excess.begin(), excess.end(), [&](double e) { return e * median > 0; });
    if (std::fabs(median) > kMinExcess &&
        static_cast<double>(num_same_sign) >
            kMinBlockFraction * static_cast<double>(blocks.size()))
      return true;
  }
  return false;
}

// Models the levels of a phase as a linear function of the local mean.
struct Line {
  double slope = 1, offset = 0;
};

struct Sample {
  double around, level;
};

std::vector<Sample> CollectPhaseSamples(const GreyLevels& image, int phase) {
  constexpr int kMaxAcross = 300;
  constexpr float kSaturated = 254;
  const int step_x = 2 * std::max(1, image.size.width / kMaxAcross / 2);
  const int step_y = 2 * std::max(1, image.size.height / kMaxAcross / 2);
  std::vector<Sample> samples;
  for (int y = 2 + phase / 2; y + 1 < image.size.height; y += step_y) {
    for (int x = 2 + phase % 2; x + 1 < image.size.width; x += step_x) {
      bool is_saturated = false;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
          is_saturated |= At(image, x + dx, y + dy) > kSaturated;
      if (!is_saturated)
        samples.push_back({ComputeNeighborMean(image, x, y), At(image, x, y)});
    }
  }
  return samples;
}

// Fits the line by robust (iteratively reweighted) least squares: outliers such
// as colours and edges are downweighted.
Line FitLine(const std::vector<Sample>& samples) {
  constexpr int kNumRounds = 8;
  Line line;
  for (int round = 0; round < kNumRounds; ++round) {
    std::vector<double> residuals;
    residuals.reserve(samples.size());
    for (const Sample& s : samples)
      residuals.push_back(
          std::fabs(s.level - line.slope * s.around - line.offset));
    const double scale = std::max(0.5, ComputeMedian(residuals));
    double w = 0, x = 0, y = 0, xx = 0, xy = 0;
    for (size_t i = 0; i < samples.size(); ++i) {
      const Sample& s = samples[i];
      const double weight =
          round == 0 ? 1 : 1 / (1 + std::pow(residuals[i] / scale, 2));
      w += weight;
      x += weight * s.around;
      y += weight * s.level;
      xx += weight * s.around * s.around;
      xy += weight * s.around * s.level;
    }
    const double determinant = w * xx - x * x;
    if (!(determinant > 1e-6 * w * w)) return line;
    line.slope = (w * xy - x * y) / determinant;
    line.offset = (y - line.slope * x) / w;
  }
  return line;
}

}  // namespace

bool BalanceMosaic(GreyLevels* image) {
  if (!IsMosaic(*image)) return false;
  constexpr double kMinSlope = 0.02, kFullScale = 255;
  constexpr size_t kMinSamples = 100;
  std::array<Line, kNumPhases> lines;
  double brightest = kFullScale;  // maximum level that all phases can represent
  for (int phase = 0; phase < kNumPhases; ++phase) {
    const std::vector<Sample> samples = CollectPhaseSamples(*image, phase);
    if (samples.size() < kMinSamples) return false;
    lines[phase] = FitLine(samples);
    if (!(lines[phase].slope > kMinSlope)) return false;
    brightest = std::min(
        brightest, (kFullScale - lines[phase].offset) / lines[phase].slope);
  }
  for (int y = 0; y < image->size.height; ++y) {
    for (int x = 0; x < image->size.width; ++x) {
      float& level =
          image->levels[static_cast<size_t>(y) * image->size.width + x];
      const Line& line = lines[GetPhase(x, y)];
      level = static_cast<float>(
          std::clamp((level - line.offset) / line.slope, 0.0, brightest));
    }
  }
  return true;
}

}  // namespace raygrid
