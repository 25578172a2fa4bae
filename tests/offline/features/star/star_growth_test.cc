#include "features/star/star_growth.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

namespace raygrid {
namespace {

Board BoardOfOneTag() {
  return ParsePattern("pattern",
                      "raygrid_pattern: 1\n"
                      "boards:\n"
                      "  - {id: 0, kind: star, columns: 16, rows: 15, "
                      "square_m: 0.012, segments: 16, tags: [{family: "
                      "tag36h11, id: 3, column: 10, row: 9, squares: 4}]}\n")
      .boards[0];
}

// The pixel where a place on the board is seen: a square is 20 px at the tag's
// middle, and the horizon passes between the tag and the board's first star.
Eigen::Vector2d PixelOfPlace(const Eigen::Vector2d& place) {
  const Eigen::Vector2d offset = place - Eigen::Vector2d(12, 11);
  return Eigen::Vector2d(300, 200) +
         20 * offset / (1 + Eigen::Vector2d(0.06, 0.07).dot(offset));
}

DetectedTag TagOf(const Board& board) {
  DetectedTag tag;
  tag.id = board.tags[0].id;
  const auto corners = CornersOnBoard(board.tags[0]);
  for (int k = 0; k < 4; ++k) tag.corners[k] = PixelOfPlace(corners[k]);
  return tag;
}

TEST(FindVisibleTags, HoldsAroundATagWhoseBoardGoesOnBehindTheHorizon) {
  const Board board = BoardOfOneTag();
  const auto seen = FindVisibleTags(board, {TagOf(board)});
  ASSERT_EQ(seen.size(), 1);
  for (const Eigen::Vector2d& place :
       {Eigen::Vector2d(9, 8), {12, 8}, {15, 14}, {9, 13}}) {
    const Eigen::Vector3d image = seen[0].homography * place.homogeneous();
    EXPECT_GT(image.z(), 0.5);
    EXPECT_LT((image.hnormalized() - PixelOfPlace(place)).norm(), 1e-6);
  }
}

TEST(FitPerspectiveMapping, PredictsWhatAHomographyShows) {
  std::vector<Correspondence> columns;
  const Eigen::Vector2d place(8, 8);
  for (int column = 9; column < 12; ++column)
    for (int row = 8; row < 13; ++row)
      columns.push_back({Eigen::Vector2d(column, row) - place,
                         PixelOfPlace(Eigen::Vector2d(column, row))});
  LocalMapping mapping, polynomial;
  EXPECT_EQ(FitPerspectiveMapping(columns, 2, &mapping), 2);
  EXPECT_LT((mapping.center - PixelOfPlace(place)).norm(), 1e-3);
  EXPECT_EQ(FitLocalMapping(columns, 2, &polynomial), 2);
  EXPECT_GT((polynomial.center - PixelOfPlace(place)).norm(), 1);
}

TEST(FitPerspectiveMapping, NeedsMoreThanALine) {
  std::vector<Correspondence> line;
  for (int row = 0; row < 8; ++row)
    line.push_back({Eigen::Vector2d(1, row), Eigen::Vector2d(50, 20 * row)});
  LocalMapping mapping;
  EXPECT_EQ(FitPerspectiveMapping(line, 2, &mapping), 0);
}

// Stars around the tag, each where the star a row further is seen.
bool AgreesAfterASlip(int rows) {
  const Board board = BoardOfOneTag();
  GreyImage image;
  image.size = {640, 480};
  const StarTexture texture(board.segments);
  const std::vector<SymmetryMask> masks;
  const DetectionOptions options;
  StarGrowth growth(image, board, texture, masks, options,
                    FindVisibleTags(board, {TagOf(board)}));
  for (int column = 8; column < 16; ++column)
    for (const int row : {7, 8})
      growth.Set(column, row,
                 PixelOfPlace(Eigen::Vector2d(column, row + rows)));
  return growth.AgreesWithTags();
}

TEST(StarGrowth, AgreesWithTheTagUnlessARowIsSkipped) {
  EXPECT_TRUE(AgreesAfterASlip(0));
  EXPECT_FALSE(AgreesAfterASlip(1));
  EXPECT_FALSE(AgreesAfterASlip(-1));
}

}  // namespace
}  // namespace raygrid
