#include "features/pattern_detector.h"
#include "photographs.h"

namespace raygrid {
namespace {

TEST(Chessboard, EveryCornerIsFoundToAFewHundredthsOfAPixel) {
  const Pattern pattern = ChessboardPattern(9, 6, 0.025);
  for (const auto& quad : {kFrontal, kTilted, kUpsideDown, kOnItsSide}) {
    const Photograph photograph(pattern.boards[0], quad);
    const auto features = Detected(photograph.image(), pattern).features;
    ASSERT_EQ(features.size(), 54u);
    EXPECT_TRUE(IsInBoardOrder(features));
    EXPECT_LT(photograph.WorstErrorPx(features), 0.04);
  }
}

TEST(Chessboard, FirstCornerIsThePlaceOnTheBoardWhicheverWayItIsHeld) {
  const Pattern pattern = ChessboardPattern(9, 6, 0.025);
  const Photograph photograph(pattern.boards[0], kTilted);
  const auto upright = Detected(photograph.image(), pattern).features;
  const auto turned =
      Detected(TurnedAround(photograph.image()), pattern).features;
  ASSERT_EQ(upright.size(), 54u);
  ASSERT_EQ(turned.size(), 54u);
  for (size_t i = 0; i < upright.size(); ++i) {
    EXPECT_EQ(upright[i].column, turned[i].column);
    EXPECT_EQ(upright[i].row, turned[i].row);
    EXPECT_LT(
        (Eigen::Vector2d(639, 479) - turned[i].pixel - upright[i].pixel).norm(),
        0.05);
  }
}

TEST(Chessboard, SquareBoardIsTurnedToItsColours) {
  const Pattern pattern = ChessboardPattern(7, 7, 0.025);
  const Photograph photograph(pattern.boards[0], kFrontal);
  const auto features = Detected(photograph.image(), pattern).features;
  ASSERT_EQ(features.size(), 49u);
  EXPECT_LT(photograph.WorstErrorPx(features), 0.05);
}

TEST(Chessboard, MirroredBoardOfOddSidesIsRemarkedUponAndNumberedAsItIs) {
  const Pattern pattern = ChessboardPattern(9, 5, 0.025);
  const Photograph photograph(pattern.boards[0], kFrontal);
  EXPECT_TRUE(Detected(photograph.image(), pattern).remarks.empty());
  ImageDetection mirrored = Detected(Mirrored(photograph), pattern);
  ASSERT_EQ(mirrored.features.size(), 45u);
  ASSERT_EQ(mirrored.remarks.size(), 1u);
  EXPECT_NE(mirrored.remarks[0].find("mirrored"), std::string::npos);
  // A mirrored board turned around looks the same.
  for (Feature& f : mirrored.features) {
    f.pixel.x() = 639 - f.pixel.x();
    f.column = 8 - f.column;
    f.row = 4 - f.row;
  }
  EXPECT_LT(photograph.WorstErrorPx(mirrored.features), 0.05);
}

TEST(Chessboard, PartIsNumberedByTheEndsOfTheBoard) {
  const Pattern pattern = ChessboardPattern(9, 6, 0.025);
  const Photograph photograph(pattern.boards[0], kHalfOutside);
  for (const Image& image :
       {photograph.image(), TurnedAround(photograph.image())}) {
    ImageDetection detection = Detected(image, pattern);
    EXPECT_GE(static_cast<int>(detection.features.size()),
              photograph.NumVisible(pattern.boards[0], 8));
    EXPECT_LT(detection.features.size(), 54u);
    EXPECT_TRUE(detection.remarks.empty());
    if (image.pixels != photograph.image().pixels)
      for (Feature& f : detection.features)
        f.pixel = Eigen::Vector2d(639, 479) - f.pixel;
    EXPECT_LT(photograph.WorstErrorPx(detection.features), 0.05);
  }
}

TEST(Chessboard, PartThatMayBeAnyIsLeftOutWithARemark) {
  const Pattern pattern = ChessboardPattern(11, 8, 0.025);
  const Photograph photograph(pattern.boards[0], kAllAround);
  const ImageDetection detection = Detected(photograph.image(), pattern);
  EXPECT_TRUE(detection.features.empty());
  ASSERT_EQ(detection.remarks.size(), 1u);
  EXPECT_NE(detection.remarks[0].find("but not which"), std::string::npos);
}

TEST(Chessboard, WhatCoversABoardIsNotItsEnd) {
  const Pattern pattern = ChessboardPattern(9, 6, 0.025);
  Photograph photograph(pattern.boards[0], kHalfOutside);
  // Along the edges of squares: two columns are hidden.
  const std::vector<cv::Point> cover = {{640, 480},
                                        {640, 0},
                                        photograph.ToImage(7, -2),
                                        photograph.ToImage(7, 7)};
  cv::fillConvexPoly(photograph.mat, cover, cv::Scalar(150));
  const ImageDetection detection = Detected(photograph.image(), pattern);
  EXPECT_TRUE(detection.features.empty());
  EXPECT_EQ(detection.remarks.size(), 1u);
}

TEST(Chessboard, BlurredDarkAndSmallBoardsAreFound) {
  const Pattern pattern = ChessboardPattern(9, 6, 0.025);
  for (const auto& quad : {kTilted, kSmall}) {
    const Photograph photograph(pattern.boards[0], quad);
    cv::Mat blurred, dark;
    cv::GaussianBlur(photograph.mat, blurred, cv::Size(), 2.5);
    photograph.mat.convertTo(dark, CV_8U, 0.08);
    for (const cv::Mat& mat : {blurred, dark}) {
      const auto features = Detected(ToGrey(mat), pattern).features;
      EXPECT_EQ(features.size(), 54u);
      EXPECT_LT(photograph.WorstErrorPx(features), 0.2);
    }
  }
}

TEST(Chessboard, NothingIsFoundWhereThereIsNoBoard) {
  const Pattern pattern = ChessboardPattern(9, 6, 0.025);
  const cv::Mat empty(kSize, CV_8U, cv::Scalar(128));
  EXPECT_TRUE(Detected(ToGrey(empty), pattern).features.empty());
  const Photograph other(ChessboardPattern(5, 4, 0.025).boards[0], kFrontal);
  EXPECT_TRUE(Detected(other.image(), pattern).features.empty());
}

TEST(Chessboard, BoardInALargeImageIsFound) {
  const Pattern pattern = ChessboardPattern(9, 6, 0.025);
  const Photograph photograph(pattern.boards[0], kTilted);
  cv::Mat large;
  cv::resize(photograph.mat, large, cv::Size(), 5, 5, cv::INTER_CUBIC);
  // The enlarged image is so blurred that it wants a large window.
  std::vector<Feature> features =
      Detected(ToGrey(large), pattern, {Refinement::kIntensities, 51}).features;
  ASSERT_EQ(features.size(), 54u);
  for (Feature& f : features) f.pixel = (f.pixel.array() - 2) / 5;
  EXPECT_LT(photograph.WorstErrorPx(features), 0.05);
}

}  // namespace
}  // namespace raygrid
