#include "features/refinement/window_mapping.h"

#include <gtest/gtest.h>

#include "close_board.h"
#include "simulation/simulated_camera_models.h"

namespace raygrid {
namespace {

constexpr double kMappedWindowPx = 21;
constexpr double kBoardDistance = 4;  // of the board, squares

// How far the middle of two places half a square to each side of a feature is
// seen from it, along columns.
std::optional<Eigen::Vector2d> BendAt(const CameraModel& camera,
                                      const Eigen::Vector2d& place) {
  const Eigen::Vector2d step(0.5, 0);
  const auto center = SeenAt(camera, CloseBoard(kBoardDistance), place);
  const auto before = SeenAt(camera, CloseBoard(kBoardDistance), place - step);
  const auto after = SeenAt(camera, CloseBoard(kBoardDistance), place + step);
  if (!center || !before || !after) return std::nullopt;
  return (*before + *after) / 2 - *center;
}

Eigen::Vector2d BendAt(const LocalMapping& mapping) {
  const Eigen::Vector2d step(0.5, 0);
  return (mapping(-step) + mapping(step)) / 2 - mapping.center;
}

TEST(WindowMappings, FollowALensThatBendsMuch) {
  const auto camera = MakeSimulatedCamera("fisheye190", kCloseViewSize);
  const Board board = StarsOfOneMetre();
  const FeatureLattice lattice =
      SeenLattice(*camera, CloseBoard(kBoardDistance), board);
  WindowMappings windows(board, lattice, kCloseViewSize, kMappedWindowPx);
  int num_by_lens = 0;
  double by_polynomial = 0, by_windows = 0;
  for (const Feature& f : lattice.Features()) {
    const auto truth = BendAt(*camera, Eigen::Vector2d(f.column, f.row));
    LocalMapping polynomial;
    const int degree = FitLocalMapping(lattice.Around(f.column, f.row, 3, true),
                                       3, &polynomial);
    if (!truth || degree <= 1) continue;
    const WindowMapping window = windows.At(f.column, f.row);
    if (window.mapping.curvature == polynomial.curvature) continue;
    ++num_by_lens;
    by_polynomial += (BendAt(polynomial) - *truth).squaredNorm();
    by_windows += (BendAt(window.mapping) - *truth).squaredNorm();
    EXPECT_LT((BendAt(window.mapping) - *truth).norm(),
              3 * window.sagitta_stddev_px)
        << f.column << " " << f.row;
  }
  EXPECT_GT(num_by_lens, 10);
  EXPECT_LT(by_windows, 0.1 * by_polynomial);
}

TEST(WindowMappings, AreTheNeighboursPolynomialsWhereALensBendsLittle) {
  const Board board = StarsOfOneMetre();
  FeatureLattice lattice(board);
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column)
      lattice.Set(column, row,
                  Eigen::Vector2d(100 + 40 * column, 80 + 40 * row));
  WindowMappings windows(board, lattice, kCloseViewSize, kMappedWindowPx);
  const WindowMapping window = windows.At(5, 5);
  EXPECT_EQ(window.degree, 3);
  EXPECT_EQ(window.sagitta_stddev_px, 0);
  EXPECT_NEAR(window.mapping.linear(0, 0), 40, 1e-9);
  EXPECT_LT(window.mapping.curvature.norm(), 1e-6);
}

TEST(WindowMappings, AreUnknownWithoutNeighbours) {
  const Board board = StarsOfOneMetre();
  FeatureLattice lattice(board);
  lattice.Set(3, 3, Eigen::Vector2d(100, 100));
  WindowMappings windows(board, lattice, kCloseViewSize, kMappedWindowPx);
  EXPECT_EQ(windows.At(3, 3).degree, 0);
}

TEST(LocalMapping, CircleIsNarrowWhereASquareIsForeshortenedAlongItsDiagonal) {
  LocalMapping mapping;
  mapping.linear << 10, 8, 0, 4;
  EXPECT_GT(mapping.SpacingPx(), 8.9);
  EXPECT_LT(mapping.CircleWidthPx(), 3.1);
  mapping.linear << 10, 0, 0, 4;
  EXPECT_DOUBLE_EQ(mapping.CircleWidthPx(), mapping.SpacingPx());
}

}  // namespace
}  // namespace raygrid
