#include <gtest/gtest.h>

#include <random>

#include "close_board.h"
#include "features/board_view/lattice_camera.h"
#include "simulation/simulated_camera_models.h"

namespace raygrid {
namespace {

bool IsInTheHole(int column, int row) {
  return column >= 9 && column <= 13 && row >= 4 && row <= 8;
}

// Those in the image, but for a hole as of a tag.
std::vector<Feature> FeaturesAround(const CameraModel& camera,
                                    const Pose& pose) {
  std::vector<Feature> features;
  const Board board = StarsOfOneMetre();
  for (const Feature& f : SeenLattice(camera, pose, board).Features())
    if (!IsInTheHole(f.column, f.row)) features.push_back(f);
  return features;
}

void ExpectKnowsTheHole(const std::string& lens, double distance,
                        double tolerance_px) {
  const auto camera = MakeSimulatedCamera(lens, kCloseViewSize);
  const Pose pose = CloseBoard(distance);
  const auto fit =
      LatticeCamera::Fit(FeaturesAround(*camera, pose), kCloseViewSize);
  ASSERT_TRUE(fit) << lens;
  int count = 0;
  for (int row = 4; row <= 8; ++row) {
    for (int column = 9; column <= 13; ++column) {
      const auto truth = SeenAt(*camera, pose, Eigen::Vector2d(column, row));
      if (!truth) continue;
      const auto seen = fit->Project(Eigen::Vector2d(column, row));
      ASSERT_TRUE(seen) << lens << " " << column << " " << row;
      EXPECT_LT((*seen - *truth).norm(), tolerance_px) << lens;
      ++count;
    }
  }
  EXPECT_GT(count, 10) << lens;
}

TEST(LatticeCamera, KnowsWhereAHoleIsSeenBehindAnyLens) {
  ExpectKnowsTheHole("pinhole", 14, 0.1);
  ExpectKnowsTheHole("wide", 8, 3);
  ExpectKnowsTheHole("fisheye", 6, 3);
  ExpectKnowsTheHole("fisheye190", 4, 3);
}

TEST(LatticeCamera, SaysHowTheBoardAppears) {
  const auto camera = MakeSimulatedCamera("pinhole", kCloseViewSize);
  const Pose pose = CloseBoard(14);
  const auto fit =
      LatticeCamera::Fit(FeaturesAround(*camera, pose), kCloseViewSize);
  ASSERT_TRUE(fit);
  const Eigen::Vector2d place(11, 6);
  const auto mapping = fit->Around(place);
  ASSERT_TRUE(mapping);
  EXPECT_EQ(mapping->center, *fit->Project(place));
  const Eigen::Vector2d right =
      *camera->Project(pose * Eigen::Vector3d(11.1, 6, 0)) -
      *camera->Project(pose * Eigen::Vector3d(10.9, 6, 0));
  EXPECT_LT((5 * right - mapping->linear.col(0)).norm(), 0.5);
}

// A polynomial leads anywhere beyond what it was fitted to.
TEST(LatticeCamera, SaysNothingFarBeyondTheFeatures) {
  const auto camera = MakeSimulatedCamera("wide", kCloseViewSize);
  std::vector<Feature> middle;
  for (const Feature& feature : FeaturesAround(*camera, CloseBoard(14)))
    if (feature.column >= 4 && feature.column <= 9) middle.push_back(feature);
  const auto fit = LatticeCamera::Fit(middle, kCloseViewSize);
  ASSERT_TRUE(fit);
  EXPECT_TRUE(fit->Project(Eigen::Vector2d(10, 6)));
  EXPECT_FALSE(fit->Project(Eigen::Vector2d(60, 6)));
  EXPECT_FALSE(fit->Around(Eigen::Vector2d(60, 6)));
}

TEST(LatticeCamera, IsNotFittedToFewOrToNoLattice) {
  const auto camera = MakeSimulatedCamera("pinhole", kCloseViewSize);
  std::vector<Feature> features = FeaturesAround(*camera, CloseBoard(14));
  std::mt19937 random(1);
  std::vector<Feature> scattered = features;
  for (Feature& feature : scattered)
    feature.pixel = {random() % 1280, random() % 800};
  EXPECT_FALSE(LatticeCamera::Fit(scattered, kCloseViewSize));
  features.resize(19);
  EXPECT_FALSE(LatticeCamera::Fit(features, kCloseViewSize));
  EXPECT_FALSE(LatticeCamera::Fit({}, kCloseViewSize));
}

}  // namespace
}  // namespace raygrid
