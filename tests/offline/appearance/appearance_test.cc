#include <opencv2/aruco/charuco.hpp>

#include "appearance/board_appearance.h"
#include "dataset/pattern.h"
#include "support.h"
#include "target/board_spec.h"

namespace raygrid {
namespace {

Board ParsedBoard(const std::string& keys) {
  return ParsePattern("p.yaml", "raygrid_pattern: 1\nboards:\n  - {id: 0, " +
                                    keys + "}\n")
      .boards[0];
}

void ExpectBoardRefused(const std::string& keys,
                        const std::vector<std::string>& words) {
  ExpectError(ExitCode::kInvalidInput, words, [&] { ParsedBoard(keys); });
}

Board StarBoard(int segments) {
  return ParsedBoard(
      "kind: star, columns: 7, rows: 6, square_m: 0.01, segments: " +
      std::to_string(segments) +
      ", tags: [{id: 7, column: 2, row: 1, squares: 3}]");
}

const char kCharuco[] =
    "kind: charuco, columns: 6, rows: 3, square_m: 0.08, marker_m: 0.06, "
    "dictionary: DICT_4X4_50";
const char kAprilGrid[] =
    "kind: aprilgrid, columns: 6, rows: 4, square_m: 0.05, spacing_ratio: 0.3";

std::vector<Board> BoardsOfAllKinds() {
  std::vector<Board> boards = {
      StarBoard(16),
      StarBoard(6),
      ParsedBoard(kCharuco),
      ParsedBoard(std::string(kCharuco) + ", legacy: true"),
      ParsedBoard(kAprilGrid),
      ParsedBoard("kind: chessboard, columns: 4, rows: 3, square_m: 0.02")};
  for (const auto& kind : TargetKinds())
    if (kind->is_drawable)
      boards.push_back(ParseBoardSpec(kind->specification).boards[0]);
  return boards;
}

double AreaOf(const Polygon& polygon) {
  double twice = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d& b = polygon[(i + 1) % polygon.size()];
    twice += a.x() * b.y() - b.x() * a.y();
  }
  return std::abs(twice) / 2;
}

// Over plain numbers, since test code is not optimized.
bool IsInside(const Polygon& polygon, const Eigen::Vector2d& p) {
  const double x = p.x(), y = p.y();
  const double* vertex = polygon.front().data();
  const size_t count = polygon.size();
  bool is_inside = false;
  for (size_t i = 0, last = count - 1; i < count; last = i++) {
    const double *a = vertex + 2 * last, *b = vertex + 2 * i;
    if ((a[1] > y) != (b[1] > y) &&
        x < a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]))
      is_inside = !is_inside;
  }
  return is_inside;
}

bool IsPainted(const std::vector<InkLayer>& layers, const Eigen::Vector2d& p) {
  bool is_black = false;
  for (const InkLayer& layer : layers)
    for (const Polygon& polygon : layer.polygons)
      if (IsInside(polygon, p)) is_black = layer.is_black;
  return is_black;
}

TEST(BoardAppearance, FirstSegmentFromUpCounterClockwiseIsBlack) {
  const BoardAppearance appearance(StarBoard(16));
  const Eigen::Vector2d feature(0.01, 0.04);
  const auto is_black = [&](double right, double down) {
    return appearance.IsBlack(feature + Eigen::Vector2d(right, down));
  };
  EXPECT_TRUE(is_black(-1e-4, -4e-3));
  EXPECT_FALSE(is_black(1e-4, -4e-3));
  EXPECT_TRUE(is_black(-4e-3, 1e-4));  // segment 4 starts at the left
  EXPECT_FALSE(is_black(-4e-3, -1e-4));
  EXPECT_TRUE(is_black(1e-4, 4e-3));  // segment 8 starts below
  EXPECT_TRUE(is_black(4e-3, -1e-4));
}

TEST(BoardAppearance, HalfOfTheStarsIsBlackWithAnyNumberOfSegments) {
  for (int segments = 4; segments <= 32; segments += 2) {
    const BoardAppearance appearance(StarBoard(segments));
    double area_m2 = 0;
    const InkLayer stars = appearance.Layers()[0];
    for (const Polygon& polygon : stars.polygons) area_m2 += AreaOf(polygon);
    EXPECT_NEAR(area_m2, 0.08 * 0.07 / 2, 1e-12) << segments;
  }
}

TEST(BoardAppearance, LayersPaintWhatIsBlack) {
  for (const Board& board : BoardsOfAllKinds()) {
    const BoardAppearance appearance(board);
    const std::vector<InkLayer> layers = appearance.Layers();
    TestRandom random(5);
    for (int i = 0; i < 20000; ++i) {
      const Eigen::Vector2d p = random.PixelIn(appearance.extent_m());
      ASSERT_EQ(IsPainted(layers, p), appearance.IsBlack(p))
          << board.kind << " " << p.transpose();
    }
  }
}

TEST(BoardAppearance, NothingIsBlackBeyondTheExtent) {
  for (const Board& board : BoardsOfAllKinds()) {
    const BoardAppearance appearance(board);
    const Area& extent = appearance.extent_m();
    EXPECT_FALSE(appearance.IsBlack({extent.x0 - 1e-6, extent.center().y()}));
    EXPECT_FALSE(appearance.IsBlack({extent.center().x(), extent.y1 + 1e-6}));
  }
}

// Eight cells to a square: the marker's six and a margin of one around them.
TEST(BoardAppearance, CharucoIsAsOpenCvDrawsIt) {
  constexpr int kCellPx = 10;
  for (const int rows : {3, 4}) {
    Board board = ParsedBoard(kCharuco);
    board.rows = rows;
    const BoardAppearance appearance(board);
    const int cells_x = 8 * (board.columns + 1), cells_y = 8 * (rows + 1);
    cv::Mat drawn;
    cv::aruco::CharucoBoard::create(
        board.columns + 1, rows + 1, 0.08f, 0.06f,
        cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_50))
        ->draw({cells_x * kCellPx, cells_y * kCellPx}, drawn);
    int num_different = 0;
    for (int y = 0; y < cells_y; ++y)
      for (int x = 0; x < cells_x; ++x) {
        const Eigen::Vector2d p((x + 0.5) * 0.01 - 0.08,
                                (y + 0.5) * 0.01 - 0.08);
        const bool is_black =
            drawn.at<uint8_t>(y * kCellPx + kCellPx / 2,
                              x * kCellPx + kCellPx / 2) < 128;
        num_different += is_black != appearance.IsBlack(p);
      }
    EXPECT_EQ(num_different, 0) << rows << " rows";
  }
}

TEST(BoardAppearance, LegacyCharucoDiffersForEvenNumbersOfSquaresOnly) {
  for (const int rows : {3, 4}) {
    Board board = ParsedBoard(kCharuco);
    board.rows = rows;
    const Eigen::Vector2d first_square(-0.079, -0.079);
    EXPECT_TRUE(BoardAppearance(board).IsBlack(first_square));
    board.is_legacy = true;
    EXPECT_EQ(BoardAppearance(board).IsBlack(first_square), rows == 4);
  }
}

TEST(BoardAppearance, AprilGridHasKalibrsNumbersAndSquares) {
  const BoardAppearance appearance(ParsedBoard(kAprilGrid));
  const std::vector<PlacedMarker>& tags = appearance.markers();
  ASSERT_EQ(tags.size(), 6u);
  EXPECT_EQ(tags[3].id, 0);  // bottom left
  EXPECT_EQ(tags[2].id, 5);  // top right
  EXPECT_TRUE(appearance.IsBlack({-0.001, -0.001}));
  EXPECT_FALSE(appearance.IsBlack({-0.001, 0.025}));
  EXPECT_TRUE(appearance.IsBlack({0.004, 0.025}));
  EXPECT_TRUE(appearance.IsBlack({0.006, 0.025}));  // two cells of border
}

TEST(BoardAppearance, TagsWithoutCornerSquaresAreOpenCvs) {
  const BoardAppearance appearance(
      ParsedBoard(std::string(kAprilGrid) + ", corner_squares: false"));
  const std::vector<PlacedMarker>& tags = appearance.markers();
  ASSERT_EQ(tags.size(), 6u);
  EXPECT_EQ(tags[0].id, 0);  // top left
  EXPECT_EQ(tags[5].id, 5);
  EXPECT_EQ(tags[0].bits.size, 8);
  EXPECT_FALSE(appearance.IsBlack({0.0575, 0.0575}));
  EXPECT_TRUE(appearance.IsBlack({0.005, 0.025}));  // one cell of border
  EXPECT_EQ(appearance.extent_m().x0, 0);
  for (const InkLayer& layer : appearance.Layers())
    for (const Polygon& polygon : layer.polygons)
      for (const Eigen::Vector2d& p : polygon)
        EXPECT_TRUE(appearance.extent_m().Contains(p));
}

TEST(BoardAppearance, TagsHaveTheBorderAndNumbersThatAreStated) {
  const Board board = ParsedBoard(
      std::string(kAprilGrid) +
      ", corner_squares: false, tag_family: DICT_4X4_50, border_cells: 2, "
      "numbered_from: bottom");
  const BoardAppearance appearance(board);
  EXPECT_EQ(appearance.markers()[3].id, 0);
  EXPECT_EQ(appearance.markers()[3].bits.size, 8);  // 4 + 2 * 2
  EXPECT_FALSE(board.HasSymmetricFeatures());
}

TEST(BoardAppearance, UnknownTagFamiliesAreRefused) {
  ExpectError(ExitCode::kInvalidInput, {"tag36h9", "tag25h9"}, [&] {
    ParsePattern("p",
                 "raygrid_pattern: 1\nboards:\n  - {id: 1, kind: aprilgrid, "
                 "columns: 10, rows: 8, square_m: 0.03, spacing_ratio: 0.3, "
                 "tag_family: tag36h9}\n");
  });
}

TEST(BoardAppearance, UnknownMarkersAreRefused) {
  Board star = StarBoard(16);
  star.tags[0].id = 587;
  ExpectError(ExitCode::kInvalidInput, {"587"}, [&] { BoardAppearance{star}; });
  Board charuco = ParsedBoard(kCharuco);
  charuco.dictionary = "DICT_9X9";
  ExpectError(ExitCode::kInvalidInput, {"DICT_9X9"},
              [&] { BoardAppearance{charuco}; });
  charuco = ParsedBoard(kCharuco);
  charuco.first_marker = 45;
  ExpectError(ExitCode::kInvalidInput, {"marker 50"},
              [&] { BoardAppearance{charuco}; });
  Board points;
  points.kind = "points";
  ExpectError(ExitCode::kInvalidInput, {"'points'"},
              [&] { BoardAppearance{points}; });
}

TEST(Pattern, StarBoardsHaveNoFeaturesUnderTags) {
  const Board board = StarBoard(16);
  EXPECT_FALSE(board.HasFeature(2, 1));
  EXPECT_FALSE(board.HasFeature(5, 4));
  EXPECT_TRUE(board.HasFeature(1, 1));
  EXPECT_TRUE(board.HasFeature(6, 4));
}

TEST(Pattern, AprilGridFeaturesAreTheTagsCorners) {
  const Board board = ParsedBoard(kAprilGrid);
  EXPECT_LT(
      (board.points[board.PointIndex(3, 2)] - Eigen::Vector3d(0.115, 0.065, 0))
          .norm(),
      1e-12);
}

TEST(Pattern, ImpossibleTagGridsAreRefused) {
  const std::string start(kAprilGrid);
  ExpectBoardRefused(start + ", border_cells: 3", {"border_cells"});
  ExpectBoardRefused(start + ", numbered_from: left", {"left", "top"});
  ExpectBoardRefused(start + ", corner_squares: maybe", {"corner_squares"});
  ExpectBoardRefused(start + ", tag_family: DICT_4X4_50",
                     {"corner_squares: false"});
}

TEST(Pattern, ImpossibleStarsAreRefused) {
  const std::string start = "kind: star, columns: 7, rows: 6, square_m: 0.01";
  const std::string tag = ", tags: [{id: 0, column: 2, row: 1, squares: 3}]";
  for (const char* bad : {"2", "5", "66", "-4"})
    ExpectBoardRefused(start + ", segments: " + bad + tag, {"segments"});
  ExpectBoardRefused(start, {"tags"});
  ExpectBoardRefused(start + ", tags: []", {"tags"});
  ExpectBoardRefused(start + ", tags: [{id: 0, column: 5, row: 1, squares: 3}]",
                     {"outside"});
  ExpectBoardRefused(start +
                         ", tags: [{family: tag16h5, id: 0, column: 1, row: 1, "
                         "squares: 3}]",
                     {"tag16h5"});
}

TEST(Pattern, BoardsNeedDifferentTags) {
  const std::string keys =
      ", kind: star, columns: 7, rows: 6, square_m: 0.01, "
      "tags: [{id: 3, column: 2, row: 1, squares: 3}]}\n";
  ExpectError(ExitCode::kInvalidInput, {"tag 3", "board 0", "board 1"}, [&] {
    ParsePattern("p", "raygrid_pattern: 1\nboards:\n  - {id: 0" + keys +
                          "  - {id: 1" + keys);
  });
}

TEST(Pattern, ImpossibleMarkersAreRefused) {
  ExpectBoardRefused("kind: charuco, columns: 6, rows: 3, square_m: 0.08",
                     {"marker_m"});
  ExpectBoardRefused(
      "kind: charuco, columns: 6, rows: 3, square_m: 0.08, marker_m: 0.08, "
      "dictionary: DICT_4X4_50",
      {"marker_m"});
  ExpectBoardRefused(
      "kind: aprilgrid, columns: 5, rows: 4, square_m: 0.05, "
      "spacing_ratio: 0.3",
      {"even"});
  ExpectBoardRefused("kind: aprilgrid, columns: 6, rows: 4, square_m: 0.05",
                     {"spacing_ratio"});
}

}  // namespace
}  // namespace raygrid
