#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "dataset/files.h"
#include "features/feature_detection.h"
#include "support.h"

namespace raygrid {
namespace {

constexpr int kScale = 4;     // supersampling
constexpr int kSquare = 100;  // on the drawn board
const cv::Size kSize(640, 480);

// A chessboard with a white margin of one square.
cv::Mat DrawnBoard(const Board& board) {
  cv::Mat drawn((board.rows + 3) * kSquare, (board.columns + 3) * kSquare,
                CV_8U, cv::Scalar(230));
  for (int row = 0; row <= board.rows; ++row)
    for (int column = 0; column <= board.columns; ++column)
      if ((row + column) % 2 == 0)
        drawn(cv::Rect((column + 1) * kSquare, (row + 1) * kSquare, kSquare,
                       kSquare)) = 25;
  return drawn;
}

// Takes the drawing's corners to a quadrangle of the image.
cv::Matx33d ToImage(const Board& board, const std::vector<cv::Point2f>& quad) {
  const float w = (board.columns + 3) * kSquare - 0.5f;
  const float h = (board.rows + 3) * kSquare - 0.5f;
  return cv::Matx33d(cv::getPerspectiveTransform(
      std::vector<cv::Point2f>{{-0.5f, -0.5f}, {w, -0.5f}, {w, h}, {-0.5f, h}},
      quad));
}

Image ToGrey(const cv::Mat& mat) {
  Image image;
  image.size = {mat.cols, mat.rows};
  image.pixels.assign(mat.datastart, mat.dataend);
  return image;
}

// A photograph of the board, with a lens's blur.
Image Photograph(const Board& board, const cv::Matx33d& to_image) {
  const double offset = (kScale - 1) / 2.0;
  const cv::Matx33d enlarge(kScale, 0, offset, 0, kScale, offset, 0, 0, 1);
  cv::Mat large, small;
  cv::warpPerspective(DrawnBoard(board), large, enlarge * to_image,
                      kSize * kScale, cv::INTER_LINEAR, cv::BORDER_CONSTANT,
                      cv::Scalar(140));
  cv::resize(large, small, kSize, 0, 0, cv::INTER_AREA);
  cv::GaussianBlur(small, small, cv::Size(), 0.7);
  return ToGrey(small);
}

Eigen::Vector2d TrueCorner(const cv::Matx33d& to_image, int column, int row) {
  const cv::Vec3d p = to_image * cv::Vec3d((column + 2) * kSquare - 0.5,
                                           (row + 2) * kSquare - 0.5, 1);
  return {p[0] / p[2], p[1] / p[2]};
}

const std::vector<cv::Point2f> kFrontal = {
    {100, 80}, {540, 100}, {530, 400}, {110, 390}};
const std::vector<cv::Point2f> kTilted = {
    {60, 120}, {560, 30}, {600, 440}, {140, 380}};
const std::vector<cv::Point2f> kUpsideDown = {
    {530, 400}, {110, 390}, {100, 80}, {540, 100}};

Board TestBoard(int columns = 9, int rows = 6) {
  return ChessboardPattern(columns, rows, 0.025).boards[0];
}

TEST(DetectChessboard, FindsEveryCornerToATenthOfAPixel) {
  const Board board = TestBoard();
  for (const auto& quad : {kFrontal, kTilted, kUpsideDown}) {
    const cv::Matx33d to_image = ToImage(board, quad);
    const auto features = DetectChessboard(Photograph(board, to_image), board);
    ASSERT_EQ(features.size(), 54u);
    for (const Feature& f : features)
      EXPECT_LT((f.pixel - TrueCorner(to_image, f.column, f.row)).norm(), 0.1)
          << f.column << ' ' << f.row;
  }
}

Image TurnedAround(Image image) {
  std::reverse(image.pixels.begin(), image.pixels.end());
  return image;
}

TEST(DetectChessboard, FirstCornerIsThePlaceOnTheBoardWhicheverWayItIsHeld) {
  const Board board = TestBoard();
  const Image image = Photograph(board, ToImage(board, kTilted));
  const auto upright = DetectChessboard(image, board);
  const auto turned = DetectChessboard(TurnedAround(image), board);
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

TEST(DetectChessboard, NumbersCornersRowByRow) {
  const Board board = TestBoard(7, 4);
  const auto features =
      DetectChessboard(Photograph(board, ToImage(board, kFrontal)), board);
  ASSERT_EQ(features.size(), 28u);
  for (int i = 0; i < 28; ++i) {
    EXPECT_EQ(features[i].board, board.id);
    EXPECT_EQ(features[i].column, i % 7);
    EXPECT_EQ(features[i].row, i / 7);
  }
}

TEST(DetectChessboard, FindsNothingWhereThereIsNoBoard) {
  const cv::Mat empty(kSize, CV_8U, cv::Scalar(128));
  EXPECT_TRUE(DetectChessboard(ToGrey(empty), TestBoard()).empty());
  const Board other = TestBoard(5, 4);
  EXPECT_TRUE(
      DetectChessboard(Photograph(other, ToImage(other, kFrontal)), TestBoard())
          .empty());
}

TEST(DetectFeatures, GoesThroughAllImagesByName) {
  const TemporaryFolder folder;
  const Pattern pattern = ChessboardPattern(9, 6, 0.025);
  const Board& board = pattern.boards[0];
  WriteFile(folder / "a.png",
            EncodePng(Photograph(board, ToImage(board, kFrontal))));
  WriteFile(folder / "b.png",
            EncodePng(ToGrey(cv::Mat(kSize, CV_8U, cv::Scalar(128)))));
  std::vector<double> done;
  const Dataset dataset =
      DetectFeatures({folder / "a.png", folder / "b.png"}, pattern, 2,
                     [&](double d) { done.push_back(d); });
  EXPECT_EQ(dataset.image_size, (ImageSize{640, 480}));
  ASSERT_EQ(dataset.images.size(), 2u);
  EXPECT_EQ(dataset.images[0].image, "a.png");
  EXPECT_EQ(dataset.images[0].features.size(), 54u);
  EXPECT_TRUE(dataset.images[1].features.empty());
  EXPECT_EQ(done, (std::vector<double>{0.5, 1}));
}

TEST(DetectFeatures, RefusesImagesOfDifferentSizes) {
  const TemporaryFolder folder;
  WriteFile(folder / "a.png",
            EncodePng(ToGrey(cv::Mat(480, 640, CV_8U, cv::Scalar(1)))));
  WriteFile(folder / "b.png",
            EncodePng(ToGrey(cv::Mat(480, 641, CV_8U, cv::Scalar(1)))));
  ExpectError(ExitCode::kInput, {"b.png", "641 x 480"}, [&] {
    DetectFeatures({folder / "a.png", folder / "b.png"},
                   ChessboardPattern(9, 6, 0.025), 1, nullptr);
  });
}

TEST(DetectFeatures, RefusesOtherKindsOfBoardsAndUnreadableImages) {
  Pattern pattern = ChessboardPattern(9, 6, 0.025);
  ExpectError(ExitCode::kInput, {"nowhere.png"},
              [&] { DetectFeatures({"nowhere.png"}, pattern, 1, nullptr); });
  pattern.boards[0].kind = "circles";
  ExpectError(ExitCode::kInput, {"circles"},
              [&] { DetectFeatures({}, pattern, 1, nullptr); });
}

TEST(DrawFeatures, MarksEachFeatureAndNothingElse) {
  const Image grey = ToGrey(cv::Mat(kSize, CV_8U, cv::Scalar(128)));
  const Image drawn =
      DrawFeatures(grey, {{0, 0, 0, {100.5, 50.25}}, {0, 1, 0, {300, 400}}});
  ASSERT_EQ(drawn.channels, 3);
  ASSERT_EQ(drawn.size, grey.size);
  int near[2] = {0, 0}, elsewhere = 0;
  for (int i = 0; i < 640 * 480; ++i) {
    if (drawn.pixels[3 * i + 1] == 128 && drawn.pixels[3 * i + 2] == 128)
      continue;
    const Eigen::Vector2d pixel(i % 640, i / 640);
    if ((pixel - Eigen::Vector2d(100.5, 50.25)).norm() < 9)
      ++near[0];
    else if ((pixel - Eigen::Vector2d(300, 400)).norm() < 9)
      ++near[1];
    else
      ++elsewhere;
  }
  EXPECT_GT(near[0], 10);
  EXPECT_GT(near[1], 5);
  EXPECT_EQ(elsewhere, 0);
}

}  // namespace
}  // namespace raygrid
