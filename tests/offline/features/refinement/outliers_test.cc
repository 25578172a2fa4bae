#include "features/refinement/outliers.h"

#include <gtest/gtest.h>

#include "close_board.h"
#include "simulation/simulated_camera_models.h"

namespace raygrid {
namespace {

constexpr Tolerance kTolerance = {0.25, 0.03};
constexpr int kOutlierWindowPx = 21;

std::vector<RejectedFeature> OutliersOf(FeatureLattice lattice,
                                        const Board& board) {
  ImageDetection detection;
  RejectOutliers(board, kCloseViewSize, kTolerance, kOutlierWindowPx, &lattice,
                 &detection);
  return detection.rejected;
}

// From one large square to the next a wide lens bends the board by more than
// polynomials through the neighbours follow.
TEST(RejectOutliers, KeepsWhatTheLensExplains) {
  const Board board = StarsOfOneMetre();
  for (const char* lens : {"pinhole", "wide", "fisheye", "fisheye190"}) {
    const auto camera = MakeSimulatedCamera(lens, kCloseViewSize);
    for (const double distance : {2.0, 3.0, 6.0, 14.0}) {
      const FeatureLattice lattice =
          SeenLattice(*camera, CloseBoard(distance), board);
      if (lattice.num_found() < 20) continue;
      EXPECT_EQ(OutliersOf(lattice, board).size(), 0u)
          << lens << " at " << distance;
    }
  }
}

TEST(RejectOutliers, RemovesAStarThatIsAnothersWhateverTheLens) {
  const Board board = StarsOfOneMetre();
  for (const char* lens : {"pinhole", "wide", "fisheye", "fisheye190"}) {
    const auto camera = MakeSimulatedCamera(lens, kCloseViewSize);
    FeatureLattice lattice = SeenLattice(*camera, CloseBoard(4), board);
    const Eigen::Vector2d between = (lattice.at(8, 6) + lattice.at(9, 6)) / 2;
    lattice.Set(8, 6, between);
    const auto outliers = OutliersOf(lattice, board);
    ASSERT_EQ(outliers.size(), 1u) << lens;
    EXPECT_EQ(outliers[0].feature.column, 8);
    EXPECT_EQ(outliers[0].feature.row, 6);
    EXPECT_EQ(outliers[0].reason, kNotCollinear);
  }
}

}  // namespace
}  // namespace raygrid
