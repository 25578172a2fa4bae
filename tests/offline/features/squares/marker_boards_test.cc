#include <fmt/format.h>

#include "features/pattern_detector.h"
#include "photographs.h"
#include "simulation/image_rendering.h"
#include "simulation/simulated_camera_models.h"
#include "simulation/simulated_observations.h"

namespace raygrid {
namespace {

// Drawings are made of whole pixels; the rendered image below is exact.
constexpr double kDrawingErrorPx = 0.15;

void ExpectEveryCorner(const Pattern& pattern, size_t count, double error_px) {
  for (const auto& quad : {kFrontal, kTilted, kUpsideDown, kOnItsSide}) {
    const Photograph photograph(pattern.boards[0], quad);
    const ImageDetection detection = Detected(photograph.image(), pattern);
    EXPECT_EQ(detection.features.size(), count);
    EXPECT_TRUE(IsInBoardOrder(detection.features));
    EXPECT_LT(photograph.WorstErrorPx(detection.features), error_px);
    EXPECT_TRUE(detection.warnings.empty());
  }
}

TEST(Charuco, EveryCornerIsFound) {
  const Pattern pattern = CharucoPattern(7, 5);
  ExpectEveryCorner(pattern, 35, kDrawingErrorPx);
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
      EXPECT_EQ(detection.warnings.empty(), is_legacy == is_said_to_be);
    }
  }
}

TEST(Charuco, CornersInRenderedImagesAreExact) {
  const Pattern pattern = CharucoPattern(9, 7);
  const Board& board = pattern.boards[0];
  const auto camera = MakeSimulatedCamera("pinhole", {640, 480});
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
  ExpectEveryCorner(pattern, 80, 0.05);
}

TEST(AprilGrid, TagsOfEachFamilyAreRead) {
  for (const std::string family : {"tag36h11", "tag25h9", "tag16h5"}) {
    Board board = AprilGridPattern().boards[0];
    board.tag_family = family;
    Pattern pattern;
    pattern.boards = {board};
    for (const auto& quad : {kFrontal, kTilted, kOnItsSide}) {
      const Photograph photograph(board, quad);
      const auto features = Detected(photograph.image(), pattern).features;
      EXPECT_EQ(features.size(), 80u) << family;
      EXPECT_LT(photograph.WorstErrorPx(features), 0.1) << family;
    }
  }
}

TEST(AprilGrid, TagsWithoutSquaresAtTheirCornersAreNamed) {
  const Pattern pattern = AprilGridPattern();
  Photograph photograph(pattern.boards[0], kFrontal);
  const double gap = pattern.boards[0].spacing_ratio;
  for (int row = 0; row <= 4; ++row) {
    for (int column = 0; column <= 5; ++column) {
      // The square's corners, in tags from the first feature.
      const double x = column * (1 + gap) - gap, y = row * (1 + gap) - gap;
      std::vector<cv::Point> square;
      for (const auto& [dx, dy] :
           {std::pair{0.0, 0.0}, {gap, 0.0}, {gap, gap}, {0.0, gap}})
        square.push_back(photograph.ToImage(x + dx, y + dy));
      cv::fillConvexPoly(photograph.mat, square, cv::Scalar(230));
    }
  }
  const ImageDetection detection = Detected(photograph.image(), pattern);
  EXPECT_TRUE(detection.features.empty());
  ASSERT_EQ(detection.warnings.size(), 1u);
  EXPECT_NE(detection.warnings[0].find("no black squares"), std::string::npos);
}

Board TagGridOf(const std::string& keys) {
  return ParsePattern("grid",
                      "raygrid_pattern: 1\nboards:\n  - {id: 1, kind: "
                      "aprilgrid, columns: 12, rows: 8, square_m: 0.03, "
                      "spacing_ratio: 0.3, corner_squares: false" +
                          keys + "}\n")
      .boards[0];
}

// Small tags as well as large ones: cells of 3.6 to 12 px.
TEST(PlainTagGrid, CornersInRenderedImagesAreExact) {
  const auto camera = MakeSimulatedCamera("pinhole", {640, 480});
  const PixelRays rays(*camera, 3);
  for (const std::string keys :
       {"", ", tag_family: tag25h9", ", tag_family: DICT_4X4_50",
        ", tag_family: DICT_6X6_100, border_cells: 2",
        ", border_cells: 2, numbered_from: bottom"}) {
    const Board board = TagGridOf(keys);
    Pattern pattern;
    pattern.boards = {board};
    const BoardSurface surface(board, 0);
    const Eigen::Vector3d center(3.8 * board.square_m, 2.5 * board.square_m, 0);
    for (const double distance : {0.32, 0.6}) {
      const Pose facing = {
          Eigen::Quaterniond(Eigen::AngleAxisd(
              0.35, Eigen::Vector3d(1, -0.6, 0.4).normalized())),
          Eigen::Vector3d(0.005, -0.003, distance)};
      const Pose pose = {facing.rotation,
                         facing.translation - facing.rotation * center};
      const Image image =
          AddNoiseAndQuantize(RenderImage(rays, {{&surface, pose}}, {}, 2), {});
      const auto features = Detected(image, pattern).features;
      const auto truth = VisibleFeatures(*camera, board, pose);
      EXPECT_GE(features.size(), 0.9 * truth.size()) << keys;
      Eigen::Vector2d sum(0, 0);
      for (const Feature& f : features) {
        const auto right =
            std::find_if(truth.begin(), truth.end(), [&](const Feature& t) {
              return t.column == f.column && t.row == f.row;
            });
        ASSERT_NE(right, truth.end());
        const Eigen::Vector2d error = f.pixel - right->pixel;
        EXPECT_LT(error.norm(), 0.06) << keys;
        // Outwards from the tag's middle: what blur does to corners.
        sum += error.cwiseProduct(Eigen::Vector2d(f.column % 2 == 0 ? -1 : 1,
                                                  f.row % 2 == 0 ? -1 : 1));
      }
      EXPECT_LT((sum / static_cast<double>(features.size())).norm(), 0.005)
          << keys;
    }
  }
}

TEST(PlainTagGrid, EveryCornerIsFound) {
  Pattern pattern;
  pattern.boards = {TagGridOf("")};
  ExpectEveryCorner(pattern, 96, kDrawingErrorPx);
}

// Paper with a shadow's edge, a finger: no corner is reported where it is not.
TEST(PlainTagGrid, CoveredCornersAreLeftOut) {
  Pattern pattern;
  pattern.boards = {TagGridOf("")};
  Photograph photograph(pattern.boards[0], kFrontal);
  for (const double column : {0.0, 1.3, 3.9})
    cv::circle(photograph.mat, photograph.ToImage(column, 0), 9, cv::Scalar(90),
               cv::FILLED);
  const auto features = Detected(photograph.image(), pattern).features;
  EXPECT_LE(features.size(), 93u);
  EXPECT_LT(photograph.WorstErrorPx(features), 0.2);
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
  ASSERT_EQ(detection.warnings.size(), 1u);
  EXPECT_NE(detection.warnings[0].find("does not belong to board 1"),
            std::string::npos);
}

TEST(FindMarkerBoards, MirroredOnesAreRemarkedUpon) {
  for (const Pattern& pattern : {CharucoPattern(7, 5), AprilGridPattern()}) {
    const Photograph photograph(pattern.boards[0], kTilted);
    const ImageDetection detection = Detected(MirrorImage(photograph), pattern);
    EXPECT_TRUE(detection.features.empty());
    ASSERT_FALSE(detection.warnings.empty());
    EXPECT_EQ(detection.warnings.back(),
              fmt::format("board {} is mirrored", pattern.boards[0].id));
  }
}

}  // namespace
}  // namespace raygrid
