#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "appearance/board_appearance.h"
#include "dataset/files.h"
#include "features/detection_pictures.h"
#include "features/feature_detection.h"
#include "simulation/image_rendering.h"
#include "simulation/simulated_lenses.h"
#include "simulation/simulated_observations.h"
#include "support.h"

namespace raygrid {
namespace {

constexpr int kScale = 4;     // supersampling
constexpr int kSquare = 100;  // on the drawn board
const cv::Size kSize(640, 480);

// A board drawn pixel by pixel, with a white margin of one square.
class Drawing {
 public:
  explicit Drawing(const Board& board) : board_(board), appearance_(board) {
    const Area& extent = appearance_.extent_m();
    origin_m_ = Eigen::Vector2d(extent.x0, extent.y0).array() - board.square_m;
    const int margins = 2 * kSquare;
    image_ = cv::Mat(
        margins + static_cast<int>(std::lround(extent.height() * PerMetre())),
        margins + static_cast<int>(std::lround(extent.width() * PerMetre())),
        CV_8U);
    for (int y = 0; y < image_.rows; ++y)
      for (int x = 0; x < image_.cols; ++x)
        image_.at<uint8_t>(y, x) =
            appearance_.IsBlack(PointAt(x, y)) ? 25 : 230;
  }

  const cv::Mat& image() const { return image_; }
  cv::Vec3d Place(int column, int row) const {
    const Eigen::Vector2d point =
        board_.points[board_.PointIndex(column, row)].head<2>();
    const Eigen::Vector2d place =
        ((point - origin_m_) * PerMetre()).array() - 0.5;
    return {place.x(), place.y(), 1};
  }

 private:
  double PerMetre() const { return kSquare / board_.square_m; }
  Eigen::Vector2d PointAt(int x, int y) const {
    return origin_m_ + Eigen::Vector2d(x + 0.5, y + 0.5) / PerMetre();
  }

  Board board_;
  BoardAppearance appearance_;
  Eigen::Vector2d origin_m_;
  cv::Mat image_;
};

Image ToGrey(const cv::Mat& mat) {
  Image image;
  image.size = {mat.cols, mat.rows};
  image.pixels.assign(mat.datastart, mat.dataend);
  return image;
}

// A photograph of a board, with a lens's blur; the drawing's corners are at a
// quadrangle of the image.
class Photograph {
 public:
  Photograph(const Board& board, const std::vector<cv::Point2f>& quad)
      : drawing_(board) {
    const float w = drawing_.image().cols - 0.5f;
    const float h = drawing_.image().rows - 0.5f;
    to_image_ = cv::Matx33d(cv::getPerspectiveTransform(
        std::vector<cv::Point2f>{
            {-0.5f, -0.5f}, {w, -0.5f}, {w, h}, {-0.5f, h}},
        quad));
    const double offset = (kScale - 1) / 2.0;
    const cv::Matx33d enlarge(kScale, 0, offset, 0, kScale, offset, 0, 0, 1);
    cv::Mat large;
    cv::warpPerspective(drawing_.image(), large, enlarge * to_image_,
                        kSize * kScale, cv::INTER_LINEAR, cv::BORDER_CONSTANT,
                        cv::Scalar(140));
    cv::resize(large, mat, kSize, 0, 0, cv::INTER_AREA);
    cv::GaussianBlur(mat, mat, cv::Size(), 0.7);
  }

  Image image() const { return ToGrey(mat); }
  Eigen::Vector2d Truth(const Feature& f) const {
    const cv::Vec3d p = to_image_ * drawing_.Place(f.column, f.row);
    return {p[0] / p[2], p[1] / p[2]};
  }
  // A place in squares from the first feature.
  cv::Point2d ToImage(double column, double row) const {
    const cv::Vec3d origin = drawing_.Place(0, 0);
    const cv::Vec3d p = to_image_ * cv::Vec3d(origin[0] + column * kSquare,
                                              origin[1] + row * kSquare, 1);
    return {p[0] / p[2], p[1] / p[2]};
  }
  // How many features lie in the image, that far from its edge at least.
  int NumVisible(const Board& board, double margin_px) const {
    int count = 0;
    for (int row = 0; row < board.rows; ++row)
      for (int column = 0; column < board.columns; ++column)
        count += WholeImage({mat.cols, mat.rows})
                     .Contains(Truth({board.id, column, row, {}}), -margin_px);
    return count;
  }
  double WorstErrorPx(const std::vector<Feature>& features) const {
    double worst = 0;
    for (const Feature& f : features)
      worst = std::max(worst, (f.pixel - Truth(f)).norm());
    return worst;
  }

  cv::Mat mat;

 private:
  Drawing drawing_;
  cv::Matx33d to_image_;
};

const std::vector<cv::Point2f> kFrontal = {
    {100, 80}, {540, 100}, {530, 400}, {110, 390}};
const std::vector<cv::Point2f> kTilted = {
    {60, 120}, {560, 30}, {600, 440}, {140, 380}};
const std::vector<cv::Point2f> kUpsideDown = {
    {530, 400}, {110, 390}, {100, 80}, {540, 100}};
const std::vector<cv::Point2f> kOnItsSide = {
    {500, 20}, {510, 460}, {60, 450}, {80, 30}};
const std::vector<cv::Point2f> kHalfOutside = {
    {-300, 40}, {560, 60}, {550, 440}, {-280, 450}};

const std::vector<cv::Point2f> kAllAround = {
    {-300, -240}, {960, -200}, {930, 690}, {-280, 700}};
const std::vector<cv::Point2f> kSmall = {
    {200, 150}, {420, 155}, {415, 318}, {205, 310}};

Pattern CharucoPattern(int columns, int rows, bool is_legacy = false) {
  return ParsePattern(
      "charuco",
      "raygrid_pattern: 1\nboards:\n  - {id: 3, kind: charuco, columns: " +
          std::to_string(columns) + ", rows: " + std::to_string(rows) +
          ", square_m: 0.02, marker_m: 0.015, dictionary: DICT_4X4_1000, "
          "legacy: " +
          (is_legacy ? "true" : "false") + "}\n");
}

Pattern AprilGridPattern() {
  return ParsePattern("aprilgrid",
                      "raygrid_pattern: 1\nboards:\n  - {id: 1, kind: "
                      "aprilgrid, columns: 10, rows: 8, square_m: 0.03, "
                      "spacing_ratio: 0.3}\n");
}

ImageDetection Detected(const Image& image, const Pattern& pattern,
                        const DetectionOptions& options = {}) {
  return PatternDetector(pattern, options).Detect(MakeGreyImage(image));
}

bool IsInBoardOrder(const std::vector<Feature>& features) {
  return std::is_sorted(
      features.begin(), features.end(), [](const Feature& a, const Feature& b) {
        return std::tie(a.row, a.column) < std::tie(b.row, b.column);
      });
}

Image TurnedAround(Image image) {
  std::reverse(image.pixels.begin(), image.pixels.end());
  return image;
}

Image Mirrored(const Photograph& photograph) {
  cv::Mat mirrored;
  cv::flip(photograph.mat, mirrored, 1);
  return ToGrey(mirrored);
}

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
  // As blurred as it is, it wants a large window.
  std::vector<Feature> features =
      Detected(ToGrey(large), pattern, {Refinement::kIntensities, 51}).features;
  ASSERT_EQ(features.size(), 54u);
  for (Feature& f : features) f.pixel = (f.pixel.array() - 2) / 5;
  EXPECT_LT(photograph.WorstErrorPx(features), 0.05);
}

// Drawings are made of whole pixels; the rendered image below is exact.
constexpr double kDrawingErrorPx = 0.15;

TEST(Charuco, EveryCornerIsFound) {
  const Pattern pattern = CharucoPattern(7, 5);
  for (const auto& quad : {kFrontal, kTilted, kUpsideDown, kOnItsSide}) {
    const Photograph photograph(pattern.boards[0], quad);
    const ImageDetection detection = Detected(photograph.image(), pattern);
    EXPECT_EQ(detection.features.size(), 35u);
    EXPECT_TRUE(IsInBoardOrder(detection.features));
    EXPECT_LT(photograph.WorstErrorPx(detection.features), kDrawingErrorPx);
    EXPECT_TRUE(detection.remarks.empty());
  }
}

TEST(Charuco, PartOfABoardIsEnough) {
  const Pattern pattern = CharucoPattern(7, 5);
  const Photograph photograph(pattern.boards[0], kHalfOutside);
  const auto features = Detected(photograph.image(), pattern).features;
  EXPECT_GE(static_cast<int>(features.size()),
            photograph.NumVisible(pattern.boards[0], 8));
  EXPECT_LT(features.size(), 35u);
  EXPECT_LT(photograph.WorstErrorPx(features), kDrawingErrorPx);
}

TEST(Charuco, CornersAreFoundWhereNoMarkerCanBeRead) {
  const Pattern pattern = CharucoPattern(7, 5);
  Photograph photograph(pattern.boards[0], kTilted);
  // Erases the markers' middles but in the first columns.
  for (int row = -1; row < 5; ++row) {
    for (int column = 2; column < 7; ++column) {
      if ((row + column) % 2 == 0) continue;
      const cv::Point2d middle = photograph.ToImage(column + 0.5, row + 0.5);
      cv::circle(photograph.mat, middle, 12, cv::Scalar(230), cv::FILLED);
    }
  }
  const auto features = Detected(photograph.image(), pattern).features;
  EXPECT_EQ(features.size(), 35u);
  EXPECT_LT(photograph.WorstErrorPx(features), kDrawingErrorPx);
}

TEST(Charuco, EitherLayoutOfMarkersIsRecognised) {
  for (const bool is_legacy : {false, true}) {
    const Photograph photograph(CharucoPattern(7, 5, is_legacy).boards[0],
                                kTilted);
    for (const bool is_said_to_be : {false, true}) {
      const ImageDetection detection =
          Detected(photograph.image(), CharucoPattern(7, 5, is_said_to_be));
      EXPECT_EQ(detection.features.size(), 35u);
      EXPECT_LT(photograph.WorstErrorPx(detection.features), kDrawingErrorPx);
      EXPECT_EQ(detection.remarks.empty(), is_legacy == is_said_to_be);
    }
  }
}

TEST(Charuco, CornersInRenderedImagesAreExact) {
  const Pattern pattern = CharucoPattern(9, 7);
  const Board& board = pattern.boards[0];
  const auto camera = SimulatedLens("pinhole", {640, 480});
  const PixelRays rays(*camera, 2);
  const BoardSurface surface(board, 0);
  const Eigen::Vector3d center(4 * board.square_m, 3 * board.square_m, 0);
  const Pose facing = {Eigen::Quaterniond(Eigen::AngleAxisd(
                           0.3, Eigen::Vector3d(1, 0.5, 0.2).normalized())),
                       Eigen::Vector3d(0.005, -0.003, 0.25)};
  const Pose pose = {facing.rotation,
                     facing.translation - facing.rotation * center};
  const Image image =
      AddNoiseAndQuantize(RenderImage(rays, {{&surface, pose}}, {}, 2), {});
  const auto features = Detected(image, pattern).features;
  const auto truth = VisibleFeatures(*camera, board, pose);
  ASSERT_EQ(features.size(), 63u);
  ASSERT_EQ(truth.size(), 63u);
  for (size_t i = 0; i < truth.size(); ++i)
    EXPECT_LT((features[i].pixel - truth[i].pixel).norm(), 0.02);
}

TEST(Charuco, DarkBoardIsFound) {
  const Pattern pattern = CharucoPattern(7, 5);
  const Photograph photograph(pattern.boards[0], kTilted);
  cv::Mat dark;
  photograph.mat.convertTo(dark, CV_8U, 0.08);
  const auto features = Detected(ToGrey(dark), pattern).features;
  EXPECT_EQ(features.size(), 35u);
  EXPECT_LT(photograph.WorstErrorPx(features), 0.2);
}

TEST(Charuco, BoardWithOtherMarkersIsNotFound) {
  Pattern other = CharucoPattern(7, 5);
  other.boards[0].first_marker = 100;
  const Photograph photograph(other.boards[0], kFrontal);
  EXPECT_TRUE(
      Detected(photograph.image(), CharucoPattern(7, 5)).features.empty());
}

TEST(AprilGrid, EveryCornerIsFoundToAFewHundredthsOfAPixel) {
  const Pattern pattern = AprilGridPattern();
  for (const auto& quad : {kFrontal, kTilted, kUpsideDown, kOnItsSide}) {
    const Photograph photograph(pattern.boards[0], quad);
    const ImageDetection detection = Detected(photograph.image(), pattern);
    EXPECT_EQ(detection.features.size(), 80u);
    EXPECT_TRUE(IsInBoardOrder(detection.features));
    EXPECT_LT(photograph.WorstErrorPx(detection.features), 0.05);
    EXPECT_TRUE(detection.remarks.empty());
  }
}

TEST(AprilGrid, PartOfABoardIsEnough) {
  const Pattern pattern = AprilGridPattern();
  const Photograph photograph(pattern.boards[0], kHalfOutside);
  const auto features = Detected(photograph.image(), pattern).features;
  EXPECT_GE(static_cast<int>(features.size()),
            photograph.NumVisible(pattern.boards[0], 8));
  EXPECT_LT(features.size(), 80u);
  EXPECT_LT(photograph.WorstErrorPx(features), 0.05);
}

TEST(AprilGrid, TagsWithCellsOfThreePixelsAreRead) {
  const Pattern pattern = AprilGridPattern();
  const Photograph photograph(pattern.boards[0], kSmall);
  const auto features = Detected(photograph.image(), pattern).features;
  EXPECT_EQ(features.size(), 80u);
  EXPECT_LT(photograph.WorstErrorPx(features), 0.08);
}

TEST(AprilGrid, TagsOfAnotherBoardAreRemarkedUpon) {
  Pattern other = AprilGridPattern();
  other.boards[0].first_marker = 200;
  const Photograph photograph(other.boards[0], kFrontal);
  const ImageDetection detection =
      Detected(photograph.image(), AprilGridPattern());
  EXPECT_TRUE(detection.features.empty());
  ASSERT_EQ(detection.remarks.size(), 1u);
  EXPECT_NE(detection.remarks[0].find("not on board 1"), std::string::npos);
}

TEST(PatternDetector, MirroredMarkersAreRemarkedUpon) {
  for (const Pattern& pattern : {CharucoPattern(7, 5), AprilGridPattern()}) {
    const Photograph photograph(pattern.boards[0], kTilted);
    const ImageDetection detection =
        PatternDetector(pattern, {})
            .Detect(Mirrored(MakeGreyImage(photograph.image())));
    EXPECT_TRUE(detection.features.empty());
    ASSERT_FALSE(detection.remarks.empty());
    EXPECT_EQ(detection.remarks.back(),
              fmt::format("board {} is seen mirrored", pattern.boards[0].id));
  }
}

TEST(PatternDetector, TinyImagesShowNothing) {
  for (const Pattern& pattern : {ChessboardPattern(9, 6, 0.025),
                                 CharucoPattern(7, 5), AprilGridPattern()})
    for (const int side : {1, 2, 3, 7, 20})
      EXPECT_TRUE(
          Detected(ToGrey(cv::Mat(side, side, CV_8U, cv::Scalar(9))), pattern)
              .features.empty());
}

TEST(PatternDetector, OptionsOutOfRangeAreRefused) {
  for (const int window_px : {0, 3, 20, 103, -21})
    ExpectError(ExitCode::kInput, {"window", "odd"}, [&] {
      PatternDetector(CharucoPattern(7, 5),
                      {Refinement::kIntensities, window_px});
    });
}

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
  ExpectError(ExitCode::kInput, {"a.png", "not an image"},
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

// A folder with photographs and other things of one pattern.
class DetectFeaturesTest : public ::testing::Test {
 protected:
  std::string Add(const std::string& name, const Image& image) {
    WriteFile(folder_ / name, EncodePng(image));
    return folder_ / name;
  }
  std::string AddEmpty(const std::string& name, int width = 640) {
    return Add(name, ToGrey(cv::Mat(480, width, CV_8U, cv::Scalar(128))));
  }
  std::string AddBoard(const std::string& name) {
    return Add(name, Photograph(pattern_.boards[0], kFrontal).image());
  }
  FolderDetection Detect(const std::vector<std::string>& paths) {
    return DetectFeatures(paths, pattern_, {}, nullptr, 2, nullptr);
  }

  TemporaryFolder folder_;
  Pattern pattern_ = ChessboardPattern(9, 6, 0.025);
};

TEST_F(DetectFeaturesTest, GoesThroughAllImagesByName) {
  std::vector<double> done;
  const Dataset dataset =
      DetectFeatures({AddBoard("a.png"), AddEmpty("b.png")}, pattern_, 2,
                     [&](double d) { done.push_back(d); });
  EXPECT_EQ(dataset.image_size, (ImageSize{640, 480}));
  ASSERT_EQ(dataset.images.size(), 2u);
  EXPECT_EQ(dataset.images[0].image, "a.png");
  EXPECT_EQ(dataset.images[0].features.size(), 54u);
  EXPECT_TRUE(dataset.images[1].features.empty());
  EXPECT_EQ(done, (std::vector<double>{0.5, 1}));
}

TEST_F(DetectFeaturesTest, DamagedImagesAreNamedAndSkipped) {
  WriteFile(folder_ / "b.png", "this is no image");
  const FolderDetection found =
      Detect({AddBoard("a.png"), folder_ / "b.png", AddBoard("c.png"),
              folder_ / "nowhere.png"});
  ASSERT_EQ(found.dataset.images.size(), 2u);
  EXPECT_EQ(found.dataset.images[1].image, "c.png");
  EXPECT_EQ(found.paths[1], folder_ / "c.png");
  EXPECT_EQ(found.images[1].features.size(), 54u);
  ASSERT_EQ(found.skipped.size(), 2u);
  EXPECT_EQ(found.skipped[0].path, folder_ / "b.png");
  EXPECT_EQ(found.skipped[0].reason.find("not an image"), 0u);
  EXPECT_EQ(found.skipped[1].path, folder_ / "nowhere.png");
}

TEST_F(DetectFeaturesTest, MostImagesTellTheSize) {
  const FolderDetection found =
      Detect({AddEmpty("a.png", 641), AddEmpty("b.png"), AddEmpty("c.png")});
  EXPECT_EQ(found.dataset.image_size, (ImageSize{640, 480}));
  EXPECT_EQ(found.dataset.images.size(), 2u);
  ASSERT_EQ(found.skipped.size(), 1u);
  EXPECT_EQ(found.skipped[0].path, folder_ / "a.png");
  EXPECT_NE(found.skipped[0].reason.find("641 x 480"), std::string::npos);
}

TEST_F(DetectFeaturesTest, RefusesImagesOfWhichNoSizeIsTheMostFrequent) {
  const std::string a = AddEmpty("a.png"), b = AddEmpty("b.png", 641);
  const std::string c = AddEmpty("c.png"), d = AddEmpty("d.png", 641);
  ExpectError(ExitCode::kInput, {"b.png", "641 x 480"}, [&] {
    Detect({a, b});
  });
  ExpectError(ExitCode::kInput, {"b.png", "641 x 480"}, [&] {
    Detect({a, b, c, d});
  });
}

TEST_F(DetectFeaturesTest, RefusesWhatCannotBeDetectedOrRead) {
  ExpectError(ExitCode::kInput, {"nowhere.png"},
              [&] { Detect({"nowhere.png"}); });
  ExpectError(ExitCode::kInput, {"nowhere.png", "other 1 image"}, [&] {
    Detect({"nowhere.png", "neither.png"});
  });
  pattern_.boards[0].kind = "circles";
  ExpectError(ExitCode::kInput, {"circles"}, [&] { Detect({}); });
}

TEST_F(DetectFeaturesTest, RefusesTwoImagesOfOneName) {
  ExpectError(ExitCode::kInput, {"a.png", "one name"}, [&] {
    Detect({AddEmpty("a.png"), folder_ / "sub/../a.png"});
  });
}

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
