#include "features/star/board_identification.h"

#include <algorithm>
#include <cstdio>

#include "dataset/kinds/star.h"
#include "features/star/board_layout.h"
#include "support.h"

namespace raygrid {
namespace {

// 16 x 15 stars; its tag begins at column 5 and row 5 and is 4 squares wide.
Board BoardWithTag(int tag) {
  StarBoardOptions options;
  options.columns = 16;
  options.rows = 15;
  options.square_mm = 12;
  options.tag_id = tag;
  return StarBoards(options)[0];
}

constexpr int kSpacingPx = 20;

// A drawing of a board, as much of it as an area holds, and the lattice of its
// stars that are wholly in it.
class Drawing {
 public:
  // In pixels from the board's first star.
  Drawing(const Board& board, const Area& area)
      : lattice_board_(board), lattice_(Lattice()) {
    const BoardAppearance appearance(board);
    image_.size = {static_cast<int>(area.x1 - area.x0),
                   static_cast<int>(area.y1 - area.y0)};
    for (int y = 0; y < image_.size.height; ++y)
      for (int x = 0; x < image_.size.width; ++x)
        image_.levels.push_back(
            appearance.IsBlack(
                board.square_m / kSpacingPx *
                Eigen::Vector2d(area.x0 + x + 0.3, area.y0 + y + 0.4))
                ? 30
                : 200);
    for (int row = 0; row < board.rows; ++row)
      for (int column = 0; column < board.columns; ++column)
        AddStar(board, column, row, area);
  }

  const FeatureLattice& lattice() const { return lattice_; }

  std::optional<LatticePlacement> IdentifyAmong(
      const std::vector<Board>& boards) const {
    std::vector<TaggedBoard> tagged(boards.begin(), boards.end());
    std::vector<const TaggedBoard*> pointers;
    for (const TaggedBoard& board : tagged) pointers.push_back(&board);
    return IdentifyBoard(image_, lattice_, {}, pointers);
  }
  std::optional<LatticePlacement> LocateInLattice(const Board& board) const {
    return AssignWithLayout(image_, lattice_, board);
  }
  // Whether a placement is the true one.
  static bool IsTrue(const LatticePlacement& placement) {
    return placement.quarter_turns == 0 && placement.column == -kShift &&
           placement.row == -kShift;
  }

 private:
  static constexpr int kShift = 7;

  FeatureLattice Lattice() {
    lattice_board_.tags.clear();
    lattice_board_.columns = lattice_board_.rows = 40;
    return FeatureLattice(lattice_board_);
  }
  void AddStar(const Board& board, int column, int row, const Area& area) {
    const Eigen::Vector2d pixel(column * kSpacingPx, row * kSpacingPx);
    if (board.HasFeature(column, row) && area.Contains(pixel, -kSpacingPx / 2))
      lattice_.Set(column + kShift, row + kShift,
                   pixel - Eigen::Vector2d(area.x0 + 0.3, area.y0 + 0.4));
  }

  Board lattice_board_;
  FeatureLattice lattice_;
  GreyImage image_;
};

// The whole board with a part of the paper around it.
Area Whole(const Board& board) {
  return {-40, -40, (board.columns + 1.0) * kSpacingPx,
          (board.rows + 1.0) * kSpacingPx};
}

Drawing CutAtLeft(const Board& board, int first_pixel) {
  Area area = Whole(board);
  area.x0 = first_pixel;
  return Drawing(board, area);
}

TEST(IdentifyBoard, IsSureWhileHalfOfTheTagIsSeen) {
  const Board board = BoardWithTag(0);
  for (int first_pixel = 0; first_pixel <= 7 * kSpacingPx; first_pixel += 10) {
    const auto placement = CutAtLeft(board, first_pixel).IdentifyAmong({board});
    ASSERT_TRUE(placement.has_value()) << first_pixel;
    EXPECT_TRUE(Drawing::IsTrue(*placement)) << first_pixel;
  }
}

TEST(IdentifyBoard, SaysNothingWhereLittleOfTheTagIsSeen) {
  const Board board = BoardWithTag(0);
  for (int first_pixel = 160; first_pixel < 240; first_pixel += 5)
    EXPECT_FALSE(
        CutAtLeft(board, first_pixel).IdentifyAmong({board}).has_value())
        << first_pixel;
}

TEST(IdentifyBoard, TakesNoOtherTagForTheBoards) {
  for (const int first_pixel : {0, 110, 130, 140}) {
    const Drawing drawing = CutAtLeft(BoardWithTag(0), first_pixel);
    for (int tag = 1; tag < 587; tag += 12)
      EXPECT_FALSE(drawing.IdentifyAmong({BoardWithTag(tag)}).has_value())
          << first_pixel << " " << tag;
  }
}

// Cut at one side, or at two that meet.
Area RandomCut(const Board& board, TestRandom* random) {
  Area area = Whole(board);
  const int side = random->Index(4);
  for (int k = 0; k < 1 + random->Index(2); ++k) {
    switch ((side + k) & 3) {
      case 0:
        area.x0 = random->Index(static_cast<int>(area.x1) - 60);
        break;
      case 1:
        area.y0 = random->Index(static_cast<int>(area.y1) - 60);
        break;
      case 2:
        area.x1 -= random->Index(static_cast<int>(area.x1 - area.x0) - 60);
        break;
      default:
        area.y1 -= random->Index(static_cast<int>(area.y1 - area.y0) - 60);
    }
  }
  return area;
}

TEST(IdentifyBoard, NamesNoBoardOfAnotherPattern) {
  TestRandom random(3);
  const std::vector<Board> boards = {BoardWithTag(0), BoardWithTag(1)};
  for (int trial = 0; trial < 250; ++trial) {
    const Board other = BoardWithTag(2 + random.Index(585));
    const Area area = RandomCut(other, &random);
    EXPECT_FALSE(Drawing(other, area).IdentifyAmong(boards).has_value())
        << "tag " << other.tags[0].id << ", " << area.x0 << " " << area.y0
        << " to " << area.x1 << " " << area.y1;
  }
}

TEST(AssignWithLayout, IsNeverWrongAndOftenSure) {
  TestRandom random(4);
  const Board board = BoardWithTag(0);
  int num_sure = 0;
  constexpr int kNumTrials = 150;
  for (int trial = 0; trial < kNumTrials; ++trial) {
    const Area area = RandomCut(board, &random);
    const auto placement = Drawing(board, area).LocateInLattice(board);
    if (!placement) continue;
    ++num_sure;
    EXPECT_TRUE(Drawing::IsTrue(*placement))
        << area.x0 << " " << area.y0 << " to " << area.x1 << " " << area.y1;
  }
  std::printf("%d of %d placed\n", num_sure, kNumTrials);
  EXPECT_GT(num_sure, kNumTrials / 2);
}

TEST(AssignWithLayout, SaysNothingWhereTheBoardLooksTheSameTurned) {
  Board board = BoardWithTag(0);  // stars of 16 segments
  board.columns = board.rows = 15;
  Area corner = Whole(board);
  corner.x1 = corner.y1 = 4.6 * kSpacingPx;  // before the tag
  EXPECT_FALSE(Drawing(board, corner).LocateInLattice(board).has_value());
}

TEST(AssignWithLayout, SaysNothingInTheMidstOfStars) {
  const Board board = BoardWithTag(0);
  const Area midst = {10.6 * kSpacingPx, 0, 15.4 * kSpacingPx, 14 * kSpacingPx};
  EXPECT_FALSE(Drawing(board, midst).LocateInLattice(board).has_value());
}

TEST(AreOnBoard, ButNotBesideIt) {
  const Board board = BoardWithTag(0);
  const Drawing drawing = CutAtLeft(board, 180);
  const LatticePlacement placement = *drawing.LocateInLattice(board);
  const auto row_of_stars = [](double x) {
    std::vector<Feature> stars;
    for (int k = 0; k < 5; ++k)
      stars.push_back({1, 0, k, Eigen::Vector2d(x, 100 + kSpacingPx * k)});
    return stars;
  };
  const double last_px = 15 * kSpacingPx - 180;
  EXPECT_TRUE(AreOnBoard(row_of_stars(-2 * kSpacingPx), drawing.lattice(),
                         placement, board));
  EXPECT_FALSE(AreOnBoard(row_of_stars(last_px + 2 * kSpacingPx),
                          drawing.lattice(), placement, board));
}

}  // namespace
}  // namespace raygrid
