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

// The step between the levels that are in use, at most that of 8 bits: some
// files have 16 bits of which 8 are always the same.
double UsedLevelStep(const GreyImage& image) {
  float step = 1;
  for (size_t i = 1; i < image.levels.size(); ++i) {
    const float difference = std::fabs(image.levels[i] - image.levels[i - 1]);
    if (difference > 0) step = std::min(step, difference);
  }
  return std::max(step, image.level_step);
}

// At least what rounding adds.
double NoiseOf(const GreyImage& image, double step) {
  return std::max(NoiseOf(image), step / std::sqrt(12.0));
}

double Quantile(std::vector<float> values, double part) {
  const auto at =
      values.begin() +
      static_cast<ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// Between the darkest and the brightest pixels, but for a few.
double ContrastOf(const GreyImage& image) {
  constexpr double kFew = 0.01;
  return Quantile(image.levels, 1 - kFew) - Quantile(image.levels, kFew);
}

cv::Mat LevelsOf(const GreyImage& image) {
  return cv::Mat(image.size.height, image.size.width, CV_32F,
                 const_cast<float*>(image.levels.data()));
}

// Differences from the mean around each pixel.
cv::Mat LocalDifferences(const GreyImage& image) {
  constexpr int kWindowsAcross = 6;
  const int side =
      std::max(image.size.width, image.size.height) / kWindowsAcross / 2 * 2 +
      1;
  cv::Mat mean;
  cv::blur(LevelsOf(image), mean, cv::Size(side, side));
  return LevelsOf(image) - mean;
}

// The size of the larger differences, of which something hot may be a tenth.
double LargeDifference(const cv::Mat& differences) {
  constexpr double kLarge = 0.85, kManyDeviations = 10;
  const std::vector<float> sizes = cv::Mat(cv::abs(differences)).reshape(1, 1);
  return std::max(kManyDeviations, Quantile(sizes, kLarge));
}

// Single pixels far beyond all around them would outweigh the rest of a window:
// they become as their neighbours are. The image's noise is about one level.
void MendDeadPixels(GreyImage* image) {
  constexpr double kFarBeyond = 20;
  cv::Mat around = cv::Mat::ones(3, 3, CV_8U);
  around.at<uint8_t>(1, 1) = 0;
  cv::Mat levels = LevelsOf(*image), lowest, highest, median;
  cv::erode(levels, lowest, around);
  cv::dilate(levels, highest, around);
  cv::medianBlur(levels, median, 3);
  const cv::Mat is_dead =
      (levels > highest + kFarBeyond) | (levels < lowest - kFarBeyond);
  median.copyTo(levels, is_dead);
}

}  // namespace

std::optional<GreyImage> WithNoiseOfOneLevel(const GreyImage& image) {
  const double step = UsedLevelStep(image);
  const int exponent =
      std::min(static_cast<int>(std::lround(-std::log2(NoiseOf(image, step)))),
               static_cast<int>(std::floor(-std::log2(step))));
  if (exponent < 1) return std::nullopt;
  GreyImage amplified = image;
  for (float& level : amplified.levels) level = std::ldexp(level, exponent);
  constexpr double kLargeBytes = 80, kGreyByte = 128;
  MendDeadPixels(&amplified);
  const cv::Mat differences = LocalDifferences(amplified);
  cv::Mat bytes(differences.size(), CV_8U, amplified.bytes.data());
  differences.convertTo(bytes, CV_8U,
                        kLargeBytes / LargeDifference(differences), kGreyByte);
  return amplified;
}

bool IsNoiseAlone(const GreyImage& image) {
  // The median of 3 x 3 pixels takes hot ones out. In cells a seventh of white
  // noise is left, of which 3.3 deviations to each side are a twentieth of a
  // percent. A corner needs more contrast than that.
  constexpr int kCellPx = 8;
  constexpr double kFew = 5e-4, kMaxDeviations = 1.3;
  cv::Mat median, cells;
  cv::medianBlur(LevelsOf(image), median, 3);
  cv::resize(median, cells, cv::Size(), 1.0 / kCellPx, 1.0 / kCellPx,
             cv::INTER_AREA);
  const std::vector<float> levels = cells.reshape(1, 1);
  return Quantile(levels, 1 - kFew) - Quantile(levels, kFew) <
         kMaxDeviations * NoiseOf(image);
}

GreyImage WithLittleNoise(const GreyImage& image) {
  // ReadableImage() raises the contrast to this.
  constexpr double kReadableContrast = 120;
  constexpr double kMaxNoise = 3, kWantedNoise = 1.5, kMaxBlurPx = 4;
  // Compression and demosaicing leave noise that is wider than a pixel.
  const double noise = std::max(NoiseOf(image), NoiseOf(Halved(image))) *
                       std::max(1.0, kReadableContrast / ContrastOf(image));
  if (!(noise > kMaxNoise)) return image;
  // A Gaussian leaves 1 / (2 sqrt(pi) sigma) of white noise.
  const double blur_px =
      std::min(kMaxBlurPx, noise / kWantedNoise / 2 / std::sqrt(M_PI));
  GreyLevels smooth = {image.size, image.levels};
  cv::Mat levels(image.size.height, image.size.width, CV_32F,
                 smooth.levels.data());
  cv::GaussianBlur(levels, levels, cv::Size(), blur_px);
  return MakeGreyImage(std::move(smooth));
}

bool HasHardlyAnyContrast(const GreyImage& image) {
  constexpr double kMinSteps = 8, kMinDeviations = 6;
  const double step = UsedLevelStep(image);
  return ContrastOf(image) <
         std::max(kMinSteps * step, kMinDeviations * NoiseOf(image, step));
}

}  // namespace raygrid
