#include "features/detection_overlays.h"
#include "photographs.h"

namespace raygrid {
namespace {

int CountNear(const Image& drawn, const Eigen::Vector2d& place, double radius,
              int channel) {
  int count = 0;
  for (int y = 0; y < drawn.size.height; ++y) {
    for (int x = 0; x < drawn.size.width; ++x) {
      const uint8_t* bgr = &drawn.pixels[3 * (y * drawn.size.width + x)];
      if ((Eigen::Vector2d(x, y) - place).norm() < radius &&
          bgr[channel] > bgr[(channel + 1) % 3] + 40 &&
          bgr[channel] > bgr[(channel + 2) % 3] + 40)
        ++count;
    }
  }
  return count;
}

TEST(DrawDetection, FeaturesAreGreenAndRejectedOnesRed) {
  const GreyImage grey =
      MakeGreyImage(ToGrey(cv::Mat(kSize, CV_8U, cv::Scalar(128))));
  ImageDetection detection;
  detection.features = {{0, 3, 2, {100.5, 50.25}}};
  detection.rejected = {{{0, 1, 0, {300, 400}}, "too dark"}};
  const Image drawn = DrawDetection(grey, detection);
  ASSERT_EQ(drawn.channels, 3);
  ASSERT_EQ(drawn.size, (ImageSize{1280, 960}));  // enlarged
  const Eigen::Vector2d found(201.5, 101), rejected(600.5, 800.5);
  EXPECT_GT(CountNear(drawn, found, 8, 1), 10);
  EXPECT_GT(CountNear(drawn, rejected, 8, 2), 10);
  EXPECT_EQ(CountNear(drawn, found, 2000, 1), CountNear(drawn, found, 8, 1));
  EXPECT_EQ(CountNear(drawn, rejected, 8, 1), 0);
}

TEST(DrawCoverage, IsBrightWhereFeaturesAre) {
  Dataset dataset;
  dataset.image_size = {640, 480};
  dataset.images.push_back({"a.png", {}});
  for (int i = 0; i < 50; ++i)
    dataset.images[0].features.push_back(
        {0, i, 0, {150.0 + i % 7, 120.0 + i % 5}});
  const Image drawn = DrawCoverage(dataset);
  const auto brightness = [&](int x, int y) {
    const uint8_t* bgr = &drawn.pixels[3 * (y * drawn.size.width + x)];
    return bgr[0] + bgr[1] + bgr[2];
  };
  EXPECT_GT(brightness(190, 185), brightness(600, 400) + 100);
}

}  // namespace
}  // namespace raygrid
