#include "features/board_view/low_contrast.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "features/board_view/image_noise.h"

namespace raygrid {
namespace {

// Returns the smallest difference between grey levels in use, at most 1 (8
// bits): some 16-bit files contain only 8 bits of information.
double ComputeGreyLevelRange(const GreyImage& image) {
  float step = 1;
  for (size_t i = 1; i < image.levels.size(); ++i) {
    const float difference = std::fabs(image.levels[i] - image.levels[i - 1]);
    if (difference > 0) step = std::min(step, difference);
  }
  return std::max(step, image.level_step);
}

// Estimates the noise, but at least the quantization noise.
double EstimateNoise(const GreyImage& image, double step) {
  return std::max(EstimateNoise(image), step / std::sqrt(12.0));
}

double Quantile(std::vector<float> values, double part) {
  const auto at =
      values.begin() +
      static_cast<ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// Returns the range of grey levels without a fraction of outliers on each side.
double ComputeContrast(const GreyImage& image, double few = 0.01) {
  return Quantile(image.levels, 1 - few) - Quantile(image.levels, few);
}

cv::Mat MakeLevels(const GreyImage& image) {
  return cv::Mat(image.size.height, image.size.width, CV_32F,
                 const_cast<float*>(image.levels.data()));
}

// Subtracts the local mean from each pixel.
cv::Mat LocalDifferences(const GreyImage& image) {
  constexpr int kWindowsAcross = 6;
  const int side =
      std::max(image.size.width, image.size.height) / kWindowsAcross / 2 * 2 +
      1;
  cv::Mat mean;
  cv::blur(MakeLevels(image), mean, cv::Size(side, side));
  return MakeLevels(image) - mean;
}

// Returns the 85 % quantile of the absolute differences: up to about a tenth of
// the image may be a hot object.
double ComputeLargeDifference(const cv::Mat& differences) {
  constexpr double kLarge = 0.85, kManyDeviations = 10;
  const std::vector<float> sizes = cv::Mat(cv::abs(differences)).reshape(1, 1);
  return std::max(kManyDeviations, Quantile(sizes, kLarge));
}

// Estimates the noise of means over 8 x 8 pixels. Noise may be correlated
// between neighbouring pixels, due to compression or demosaicing.
std::vector<NoiseAtGreyLevel> EstimateCellNoise(const GreyImage& image) {
  std::vector<NoiseAtGreyLevel> noise = EstimateNoiseByGreyLevel(image);
  const std::vector<NoiseAtGreyLevel> halved =
      EstimateNoiseByGreyLevel(HalveImage(image));
  for (NoiseAtGreyLevel& n : noise) n.noise /= 7;
  for (size_t k = 0; k < std::min(noise.size(), halved.size()); ++k)
    noise[k].noise = std::max(noise[k].noise, halved[k].noise / 4);
  return noise;
}

// Interpolates the noise linearly between grey levels.
double InterpolateNoise(const std::vector<NoiseAtGreyLevel>& noise,
                        double level) {
  constexpr double kLeast = 1e-6;
  size_t k = 0;
  while (k < noise.size() && noise[k].level <= level) ++k;
  if (k == 0) return std::max(kLeast, noise.front().noise);
  if (k == noise.size()) return std::max(kLeast, noise.back().noise);
  const NoiseAtGreyLevel &a = noise[k - 1], &b = noise[k];
  const double part = (level - a.level) / (b.level - a.level);
  return std::max(kLeast, a.noise + part * (b.noise - a.noise));
}

// Replaces dead pixels, which exceed all their neighbours by far, by the local
// median, because they would dominate the correlation within a window. The
// image is scaled such that its noise is about one grey level.
void CorrectDeadPixels(GreyImage* image) {
  constexpr double kMinHotPixelStep = 20;
  cv::Mat around = cv::Mat::ones(3, 3, CV_8U);
  around.at<uint8_t>(1, 1) = 0;
  cv::Mat levels = MakeLevels(*image), lowest, highest, median;
  cv::erode(levels, lowest, around);
  cv::dilate(levels, highest, around);
  cv::medianBlur(levels, median, 3);
  const cv::Mat is_dead = (levels > highest + kMinHotPixelStep) |
                          (levels < lowest - kMinHotPixelStep);
  median.copyTo(levels, is_dead);
}

}  // namespace

std::optional<GreyImage> AmplifyLowContrast(const GreyImage& image) {
  const double step = ComputeGreyLevelRange(image);
  const int exponent = std::min(
      static_cast<int>(std::lround(-std::log2(EstimateNoise(image, step)))),
      static_cast<int>(std::floor(-std::log2(step))));
  if (exponent < 1) return std::nullopt;
  GreyImage amplified = image;
  for (float& level : amplified.levels) level = std::ldexp(level, exponent);
  constexpr double kLargeBytes = 80, kGreyByte = 128;
  CorrectDeadPixels(&amplified);
  const cv::Mat differences = LocalDifferences(amplified);
  cv::Mat bytes(differences.size(), CV_8U, amplified.bytes.data());
  differences.convertTo(bytes, CV_8U,
                        kLargeBytes / ComputeLargeDifference(differences),
                        kGreyByte);
  return amplified;
}

bool IsPureNoise(const GreyImage& image) {
  // The 3 x 3 median filter removes hot pixels. The mean over a cell reduces
  // white noise by a factor of 7, and noise correlated over two pixels by 4.
  // For pure noise, 0.05 % of the differences from the surrounding cells exceed
  // 3.5 standard deviations; corners cause larger ones.
  constexpr int kCellPx = 8, kAroundCells = 5;
  constexpr double kTailFraction = 5e-4, kMaxSigmas = 4.5;
  cv::Mat median, cells, around;
  cv::medianBlur(MakeLevels(image), median, 3);
  cv::resize(median, cells, cv::Size(), 1.0 / kCellPx, 1.0 / kCellPx,
             cv::INTER_AREA);
  cv::blur(cells, around, cv::Size(kAroundCells, kAroundCells),
           cv::Point(-1, -1), cv::BORDER_REFLECT);
  const std::vector<NoiseAtGreyLevel> noise = EstimateCellNoise(image);
  if (noise.empty()) return false;
  std::vector<float> differences;
  differences.reserve(cells.total());
  for (int y = 0; y < cells.rows; ++y)
    for (int x = 0; x < cells.cols; ++x)
      differences.push_back(static_cast<float>(
          std::fabs(cells.at<float>(y, x) - around.at<float>(y, x)) /
          InterpolateNoise(noise, around.at<float>(y, x))));
  return Quantile(std::move(differences), 1 - kTailFraction) < kMaxSigmas;
}

GreyImage Denoise(const GreyImage& image) {
  // Contrast to which ReadableImage() amplifies.
  constexpr double kReadableContrast = 120;
  constexpr double kMaxNoise = 3, kWantedNoise = 1.5, kMaxBlurPx = 4;
  // Compression and demosaicing cause noise that is correlated between pixels.
  const double noise =
      std::max(EstimateNoise(image), EstimateNoise(HalveImage(image))) *
      std::max(1.0, kReadableContrast / ComputeContrast(image));
  if (!(noise > kMaxNoise)) return image;
  // A Gaussian filter reduces white noise by a factor of 2 sqrt(pi) sigma.
  const double blur_px =
      std::min(kMaxBlurPx, noise / kWantedNoise / 2 / std::sqrt(M_PI));
  GreyLevels smooth = {image.size, image.levels};
  cv::Mat levels(image.size.height, image.size.width, CV_32F,
                 smooth.levels.data());
  cv::GaussianBlur(levels, levels, cv::Size(), blur_px);
  return MakeGreyImage(std::move(smooth));
}

bool HasLowContrast(const GreyImage& image) {
  // A distant board covers a hundredth of the image. White noise spans 6.2
  // deviations without a thousandth at either end.
  constexpr double kMinSteps = 8, kMinSigmas = 8, kTailFraction = 0.001;
  const double step = ComputeGreyLevelRange(image);
  return ComputeContrast(image, kTailFraction) <
         std::max(kMinSteps * step, kMinSigmas * EstimateNoise(image, step));
}

}  // namespace raygrid
