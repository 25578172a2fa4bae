#include "dataset/mosaic.h"

#include <opencv2/imgcodecs.hpp>

#include "features/pattern_detector.h"
#include "photographs.h"

namespace raygrid {
namespace {

// The image of a sensor with colour filters, of a scene without colours in
// light of a colour: the parts of the light that pixels (0, 0), (1, 0), (0, 1)
// and (1, 1) get.
cv::Mat Mosaic(const cv::Mat& photograph, const cv::Vec4d& parts, double black,
               double noise) {
  cv::Mat mosaic(photograph.size(), CV_64F), disturbance(mosaic.size(), CV_64F);
  cv::theRNG().state = 1;
  cv::randn(disturbance, 0, noise);
  for (int y = 0; y < mosaic.rows; ++y)
    for (int x = 0; x < mosaic.cols; ++x)
      mosaic.at<double>(y, x) =
          black + parts[2 * (y % 2) + x % 2] * photograph.at<uint8_t>(y, x);
  mosaic += disturbance;
  cv::Mat bytes;
  mosaic.convertTo(bytes, CV_8U);
  return bytes;
}

double RmsErrorPx(const Photograph& photograph,
                  const std::vector<Feature>& features) {
  double sum = 0;
  for (const Feature& f : features)
    sum += (f.pixel - photograph.Truth(f)).squaredNorm();
  return std::sqrt(sum / static_cast<double>(features.size()));
}

TEST(Mosaic, MosaicIsAsGoodAsGreyInLightOfAnyColour) {
  const Pattern pattern = ChessboardPattern(9, 6, 0.025);
  const Photograph photograph(pattern.boards[0], kTilted);
  const std::vector<cv::Vec4d> casts = {
      {0.6, 1, 1, 0.5}, {0.9, 1, 1, 0.35}, {1, 0.4, 0.4, 0.8},  {1, 1, 0.95, 1},
      {1, 0.7, 0.5, 1}, {0.93, 1, 1, 0.9}, {1.3, 0.9, 0.9, 1.2}};
  for (const cv::Vec4d& cast : casts) {
    for (const double black : {0, 12}) {
      const cv::Mat mosaic = Mosaic(photograph.mat, cast, black, 1.5);
      const auto features = FeaturesInFile(mosaic, pattern);
      ASSERT_EQ(features.size(), 54u) << cast;
      EXPECT_LT(RmsErrorPx(photograph, features), 0.05) << cast;
    }
  }
}

TEST(Mosaic, MosaicIsSaidAndNothingElseIsTakenForOne) {
  const TemporaryFolder folder;
  const Pattern pattern = ChessboardPattern(9, 6, 0.025);
  const Photograph photograph(pattern.boards[0], kTilted);
  cv::Mat stripes = photograph.mat.clone(), jpeg;
  for (int y = 0; y < stripes.rows; ++y)
    for (int x = 0; x < 100; ++x)
      stripes.at<uint8_t>(y, x) = x % 2 == 0 ? 60 : 180;
  std::vector<uint8_t> bytes;
  cv::imencode(".jpg", photograph.mat, bytes, {cv::IMWRITE_JPEG_QUALITY, 40});
  jpeg = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
  for (const auto& [image, is_mosaic] :
       {std::pair{Mosaic(photograph.mat, {0.6, 1, 1, 0.5}, 0, 1.5), true},
        {photograph.mat, false},
        {stripes, false},
        {jpeg, false}}) {
    ASSERT_TRUE(cv::imwrite(folder / "a.png", image));
    const GreyLevels grey = ReadGreyLevels(folder / "a.png");
    EXPECT_EQ(grey.was_mosaic, is_mosaic);
    if (!is_mosaic)
      EXPECT_EQ(MakeGreyImage(grey).bytes,
                ReadImage(folder / "a.png", true).pixels);
    const ImageDetection found =
        PatternDetector(pattern, {}).Detect(MakeGreyImage(grey));
    EXPECT_EQ(!found.warnings.empty(), is_mosaic);
  }
}

}  // namespace
}  // namespace raygrid
