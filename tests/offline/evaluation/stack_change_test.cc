#include "camera/model_registry.h"
#include "evaluation/operating_point_change.h"
#include "support.h"

namespace raygrid {
namespace {

// A grid of a lens with OpenCV's first radial coefficient.
CentralGeneric RadialGrid(double focal_px, const Eigen::Vector2d& center_px,
                          double k1) {
  Eigen::VectorXd parameters =
      Eigen::VectorXd::Zero(FindModelInfo("opencv")->parameters.size());
  parameters.head<5>() << focal_px, focal_px, center_px.x(), center_px.y(), k1;
  const auto lens = FindModelInfo("opencv")->make(
      {640, 480}, {-40, -40, 679, 519}, parameters);
  return FitCentralGeneric(*lens, {0, 0, 639, 479}, 20, 16);
}

const std::vector<Eigen::Vector2d> kPlaces =
    SampleCellCenters({0, 0, 639, 479}, 16, 12);

TEST(SampleCellCenters, AreTheCentresOfCells) {
  ASSERT_EQ(kPlaces.size(), 16u * 12u);
  EXPECT_LT((kPlaces[0] - Eigen::Vector2d(639 / 32.0, 479 / 24.0)).norm(),
            1e-9);
  EXPECT_LT((kPlaces[17] - 3 * kPlaces[0]).norm(), 1e-9);
}

TEST(MeasureDistortion, LeavesNothingOfGrowthAndShift) {
  const auto moves =
      MeasureDistortion(RadialGrid(500, {320, 240}, 0),
                        RadialGrid(506, {321.5, 238.7}, 0), kPlaces);
  for (const Eigen::Vector2d& move : moves) EXPECT_LT(move.norm(), 1e-3);
}

TEST(MeasureDistortion, IsThatOfTheRadialCoefficientByPlace) {
  constexpr double kFocalPx = 500, kK1 = 0.02;
  const Eigen::Vector2d center(319.5, 239.5);
  const auto moves =
      MeasureDistortion(RadialGrid(kFocalPx, center, 0),
                        RadialGrid(kFocalPx, center, kK1), kPlaces);
  // The growth that fits k1 r^3 best, over the places.
  double of_cube = 0, of_square = 0;
  for (const Eigen::Vector2d& place : kPlaces) {
    const double r2 = ((place - center) / kFocalPx).squaredNorm();
    of_cube += r2 * r2;
    of_square += r2;
  }
  for (size_t k = 0; k < kPlaces.size(); ++k) {
    const Eigen::Vector2d from = kPlaces[k] - center;
    const double r2 = (from / kFocalPx).squaredNorm();
    const Eigen::Vector2d expected = kK1 * (r2 - of_cube / of_square) * from;
    EXPECT_LT((moves[k] - expected).norm(), 0.01) << k;
  }
  // Corners move outwards, and what lies between inwards.
  EXPECT_GT(moves[0].dot(kPlaces[0] - center), 0);
  EXPECT_LT(moves[16 * 6 + 10].dot(kPlaces[16 * 6 + 10] - center), 0);
}

}  // namespace
}  // namespace raygrid
