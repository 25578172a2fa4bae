#include "features/board_view/low_contrast.h"

#include <cmath>
#include <ctime>
#include <opencv2/imgcodecs.hpp>

#include "features/board_guess.h"
#include "features/pattern_detector.h"
#include "photographs.h"

namespace raygrid {
namespace {

// A board of little contrast, as thermal cameras see it: on a slope, beside
// something far brighter, with noise and dead pixels.
cv::Mat Thermal(const cv::Mat& photograph, double contrast, double noise) {
  cv::Mat heat, slope(photograph.size(), CV_64F),
      disturbance(slope.size(), CV_64F);
  photograph.convertTo(heat, CV_64F, contrast / 205, 29000);
  for (int y = 0; y < slope.rows; ++y)
    for (int x = 0; x < slope.cols; ++x)
      slope.at<double>(y, x) = 2 * contrast * x / slope.cols;
  cv::theRNG().state = 1;
  cv::randn(disturbance, 0, noise);
  heat += slope + disturbance;
  cv::circle(heat, {610, 30}, 60, cv::Scalar(44000), cv::FILLED, cv::LINE_AA);
  for (int i = 0; i < 12; ++i)
    heat.at<double>(5 + 37 * i, 3 + 6 * i) = i % 2 == 0 ? 0 : 65535;
  cv::Mat deep;
  heat.convertTo(deep, CV_16U);
  return deep;
}

TEST(LowContrast, BoardsOfLittleContrastInSixteenBitsAreFound) {
  const Pattern chessboard = ChessboardPattern(9, 6, 0.025);
  for (const auto& [pattern, count] :
       {std::pair{chessboard, 54u}, {CharucoPattern(9, 6), 54u}}) {
    const Photograph photograph(pattern.boards[0], kFrontal);
    for (const double contrast : {100, 300, 600}) {
      const auto features = FeaturesInFile(
          Thermal(photograph.mat, contrast, contrast / 40), pattern);
      EXPECT_EQ(features.size(), count) << contrast;
      EXPECT_LT(photograph.WorstErrorPx(features), 0.15) << contrast;
    }
  }
}

TEST(LowContrast, HardlyAnyContrastIsSaid) {
  const Pattern pattern = ChessboardPattern(9, 6, 0.025);
  cv::Mat dark(kSize, CV_8U), deep(kSize, CV_16U), bright(kSize, CV_8U);
  cv::randn(dark, 12, 2);
  cv::randn(deep, 30000, 30);
  cv::randu(bright, 0, 255);
  cv::GaussianBlur(bright, bright, cv::Size(), 20);
  cv::normalize(bright, bright, 0, 255, cv::NORM_MINMAX);
  // Something small, such as a distant board.
  cv::Mat small(kSize, CV_8U, cv::Scalar(120));
  small(cv::Rect(20, 40, 60, 60)) = 220;
  small(cv::Rect(30, 50, 40, 40)) = 30;
  const TemporaryFolder folder;
  for (const auto& [image, is_said] :
       {std::pair{dark, true}, {deep, true}, {bright, false}, {small, false}}) {
    ASSERT_TRUE(cv::imwrite(folder / "a.png", image));
    const FolderDetection found =
        DetectFeatures({folder / "a.png"}, pattern, {}, nullptr, 1, nullptr);
    EXPECT_TRUE(found.images[0].features.empty());
    bool is_any = false;
    for (const std::string& warning : found.images[0].warnings)
      is_any |= warning.find("too little contrast") != std::string::npos;
    EXPECT_EQ(is_any, is_said);
  }
}

#ifdef RAYGRID_SANITIZED
constexpr double kTimes = 10;
#else
constexpr double kTimes = 1;
#endif

// Nothing stands out from the noise, however the light falls.
TEST(LowContrast, LitNoiseTakesLittleTime) {
  const Pattern pattern = ChessboardPattern(9, 6, 0.025);
  const TemporaryFolder folder;
  cv::theRNG().state = 2;
  cv::Mat light(1944, 2592, CV_32F), noise(light.size(), CV_32F);
  const cv::Point2d middle(light.cols / 2.0, light.rows / 2.0);
  for (const double vignetting : {0.0, 1.5}) {
    for (int y = 0; y < light.rows; ++y)
      for (int x = 0; x < light.cols; ++x)
        light.at<float>(y, x) = static_cast<float>(
            20 + 180 / std::pow(1 + vignetting *
                                        (std::pow(x - middle.x, 2) +
                                         std::pow(y - middle.y, 2)) /
                                        std::pow(middle.x, 2),
                                2));
    cv::randn(noise, 0, 1);
    cv::Mat deviation, frame;
    cv::sqrt(0.4 * light, deviation);  // of photons
    cv::Mat(light + noise.mul(deviation)).convertTo(frame, CV_8U);
    ASSERT_TRUE(cv::imwrite(folder / "a.png", frame));
    const std::clock_t start = std::clock();
    const FolderDetection found =
        DetectFeatures({folder / "a.png"}, pattern, {}, nullptr, 1, nullptr);
    EXPECT_FALSE(SuggestOtherBoard(found, pattern, "p.yaml", 1));
    EXPECT_TRUE(found.images[0].features.empty());
    EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC,
              kTimes * 1.5);
  }
}

// A night's frame, with and without a lamp in it.
TEST(LowContrast, NoiseTakesLittleTime) {
  const Pattern pattern = ChessboardPattern(9, 6, 0.025);
  const TemporaryFolder folder;
  cv::Mat night(1944, 2592, CV_8U);
  cv::theRNG().state = 1;
  cv::randn(night, 12, 4);
  for (const bool has_lamp : {false, true}) {
    if (has_lamp) night(cv::Rect(300, 300, 600, 400)) += 120;
    ASSERT_TRUE(cv::imwrite(folder / "a.png", night));
    const std::clock_t start = std::clock();
    const FolderDetection found =
        DetectFeatures({folder / "a.png"}, pattern, {}, nullptr, 1, nullptr);
    EXPECT_FALSE(SuggestOtherBoard(found, pattern, "p.yaml", 1));
    EXPECT_TRUE(found.images[0].features.empty());
    EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC,
              kTimes * (has_lamp ? 5 : 1.5));
  }
}

}  // namespace
}  // namespace raygrid
