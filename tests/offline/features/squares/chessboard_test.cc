#include "features/pattern_detector.h"
#include "photographs.h"
#include "simulation/image_rendering.h"
#include "simulation/simulated_camera_models.h"

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
  EXPECT_TRUE(Detected(photograph.image(), pattern).warnings.empty());
  ImageDetection mirrored = Detected(MirrorImage(photograph), pattern);
  ASSERT_EQ(mirrored.features.size(), 45u);
  ASSERT_EQ(mirrored.warnings.size(), 1u);
  EXPECT_NE(mirrored.warnings[0].find("mirrored"), std::string::npos);
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
    EXPECT_TRUE(detection.warnings.empty());
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
  ASSERT_EQ(detection.warnings.size(), 1u);
  EXPECT_NE(detection.warnings[0].find("may be any part"),
            std::string::npos);
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
  EXPECT_EQ(detection.warnings.size(), 1u);
}

// A board with a rim of paper a twelfth of a square wide, in a room of medium
// brightness. Beyond one edge, to the left of or above the board, something
// there continues like squares, faintly.
void SurroundByRoom(int edge, Photograph* photograph) {
  constexpr double kRim = 0.08;
  constexpr int kColumns = 9, kRows = 6;
  const auto polygon = [&](double left, double top, double right,
                           double bottom) {
    std::vector<cv::Point> points;
    for (const auto& [x, y] :
         {std::pair{left, top}, {right, top}, {right, bottom}, {left, bottom}})
      points.push_back(photograph->ToImage(x, y));
    return points;
  };
  cv::Mat room(photograph->mat.size(), CV_8U, cv::Scalar(125));
  for (int k = -1; k < (edge == 0 ? kRows : kColumns); ++k) {
    const cv::Scalar level(k % 2 == 0 ? 100 : 150);
    if (edge == 0)
      cv::fillConvexPoly(room, polygon(-2, k, -1, k + 1), level);
    else
      cv::fillConvexPoly(room, polygon(k, -2, k + 1, -1), level);
  }
  cv::Mat is_board(photograph->mat.size(), CV_8U, cv::Scalar(0));
  cv::fillConvexPoly(
      is_board, polygon(-1 - kRim, -1 - kRim, kColumns + kRim, kRows + kRim),
      cv::Scalar(255));
  photograph->mat.copyTo(room, is_board);
  cv::GaussianBlur(room, photograph->mat, cv::Size(), 0.7);
}

TEST(Chessboard, FalseCornersBeyondARimAreNoneOfIts) {
  const Pattern pattern = ChessboardPattern(9, 6, 0.025);
  for (const int edge : {0, 1}) {
    for (const auto& quad : {kFrontal, kTilted, kUpsideDown, kOnItsSide}) {
      Photograph photograph(pattern.boards[0], quad);
      SurroundByRoom(edge, &photograph);
      const auto features = Detected(photograph.image(), pattern).features;
      EXPECT_EQ(features.size(), 54u);
      EXPECT_LT(photograph.WorstErrorPx(features), 0.1);
    }
  }
}

TEST(Chessboard, FalseCornersDoNotStandForHiddenOnes) {
  const Pattern pattern = ChessboardPattern(9, 6, 0.025);
  for (const int edge : {0, 1}) {
    for (const auto& quad : {kFrontal, kTilted, kUpsideDown, kOnItsSide}) {
      Photograph photograph(pattern.boards[0], quad);
      SurroundByRoom(edge, &photograph);
      const bool is_left = edge == 0;
      cv::fillConvexPoly(
          photograph.mat,
          std::vector<cv::Point>{
              photograph.ToImage(is_left ? 7.5 : -1.2, is_left ? -1.2 : 4.5),
              photograph.ToImage(9.2, is_left ? -1.2 : 4.5),
              photograph.ToImage(9.2, 6.2),
              photograph.ToImage(is_left ? 7.5 : -1.2, 6.2)},
          cv::Scalar(125));
      const ImageDetection detection = Detected(photograph.image(), pattern);
      EXPECT_TRUE(detection.features.empty());
      EXPECT_EQ(detection.warnings.size(), 1u);
    }
  }
}

// Whatever numbers a whole board seems to have.
TEST(Chessboard, LatticeWiderThanTheBoardIsNamed) {
  const Photograph photograph(ChessboardPattern(10, 6, 0.025).boards[0],
                              kTilted);
  const ImageDetection detection =
      Detected(photograph.image(), ChessboardPattern(9, 6, 0.025));
  EXPECT_TRUE(detection.features.empty());
  ASSERT_EQ(detection.warnings.size(), 1u);
  EXPECT_NE(
      detection.warnings[0].find("10 x 6 corners, which does not match board"),
      std::string::npos);
}

// Squares shrink by 1.6 from one to the next.
TEST(Chessboard, GrowsToTheRimOfAFisheye) {
  const ImageSize size = {1280, 800};
  const auto camera = MakeSimulatedCamera("fisheye190", size);
  const PixelRays rays(*camera, 2);
  constexpr double kSquareM = 0.03, kDistanceSquares = 2;
  for (const auto& [columns, rows, left_squares] :
       {std::tuple{8, 6, -0.5}, {9, 6, -6.5}, {6, 8, -0.5}}) {
    const Pattern pattern = ChessboardPattern(columns, rows, kSquareM);
    const Board& board = pattern.boards[0];
    const BoardSurface surface(board);
    Pose pose;
    pose.translation =
        kSquareM *
        Eigen::Vector3d(left_squares, 0.5 - rows / 2.0, kDistanceSquares);
    const auto features =
        Detected(AddNoiseAndQuantize(
                     RenderImage(rays, {{&surface, pose}}, {}, 2), {}),
                 pattern)
            .features;
    int num_visible = 0;
    for (const Eigen::Vector3d& point : board.points) {
      const auto pixel = camera->Project(pose * point);
      num_visible += pixel && WholeImage(size).Contains(*pixel, -12);
    }
    EXPECT_GT(features.size(), 0.95 * num_visible);
    for (const Feature& f : features) {
      const auto pixel = camera->Project(
          pose * board.points[board.PointIndex(f.column, f.row)]);
      ASSERT_TRUE(pixel);
      EXPECT_LT((f.pixel - *pixel).norm(), 0.2);
    }
  }
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
