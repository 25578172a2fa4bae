#include <opencv2/imgcodecs.hpp>

#include "dataset/files.h"
#include "features/pattern_detector.h"
#include "photographs.h"

namespace raygrid {
namespace {

TEST(GreyLevels, SixteenBitsAreScaledByTheBitsInUse) {
  const TemporaryFolder folder;
  for (const int bits : {10, 12, 14, 16}) {
    cv::Mat deep(4, 5, CV_16U, cv::Scalar(100));
    deep.at<uint16_t>(1, 2) = static_cast<uint16_t>((1 << bits) - 10);
    for (const char* name : {"a.png", "a.pgm", "a.tif"}) {
      ASSERT_TRUE(cv::imwrite(folder / name, deep));
      const GreyLevels grey = ReadGreyLevels(folder / name);
      const double unit = 255.0 / ((1 << bits) - 1);
      EXPECT_EQ(grey.size, (ImageSize{5, 4}));
      EXPECT_NEAR(grey.levels[0], 100 * unit, 1e-4);
      EXPECT_NEAR(grey.levels[7], ((1 << bits) - 10) * unit, 1e-4);
    }
  }
}

TEST(GreyLevels, ColourAndEightBitsAreAsReadImageHasThem) {
  const TemporaryFolder folder;
  cv::Mat color(40, 50, CV_8UC3);
  cv::randu(color, 0, 256);
  for (const char* name : {"a.png", "a.jpg"}) {
    ASSERT_TRUE(cv::imwrite(folder / name, color));
    const GreyImage grey = MakeGreyImage(ReadGreyLevels(folder / name));
    EXPECT_EQ(grey.bytes, ReadImage(folder / name, true).pixels);
  }
  color.convertTo(color, CV_16U, 257);
  ASSERT_TRUE(cv::imwrite(folder / "deep.png", color));
  const GreyImage deep = MakeGreyImage(ReadGreyLevels(folder / "deep.png"));
  const GreyImage flat = MakeGreyImage(ReadImage(folder / "a.png", false));
  for (size_t i = 0; i < flat.levels.size(); ++i)
    ASSERT_NEAR(deep.levels[i], flat.levels[i], 1.1);
}

TEST(GreyLevels, DamagedFilesAreRefused) {
  const TemporaryFolder folder;
  WriteFile(folder / "a.png", "this is no image");
  ExpectError(ExitCode::kInvalidInput, {"a.png", "not an image"},
              [&] { ReadGreyLevels(folder / "a.png"); });
}

TEST(GreyLevels, BoardInATwelveBitImageIsFound) {
  const TemporaryFolder folder;
  const Pattern pattern = ChessboardPattern(9, 6, 0.025);
  const Photograph photograph(pattern.boards[0], kTilted);
  cv::Mat deep;
  photograph.mat.convertTo(deep, CV_16U, 4095.0 / 255);
  ASSERT_TRUE(cv::imwrite(folder / "a.png", deep));
  const Dataset dataset =
      DetectFeatures({folder / "a.png"}, pattern, 1, nullptr);
  ASSERT_EQ(dataset.num_features(), 54u);
  EXPECT_LT(photograph.WorstErrorPx(dataset.images[0].features), 0.05);
}

}  // namespace
}  // namespace raygrid
