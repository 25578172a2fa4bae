#include "initialization/localization.h"

#include "simulation/simulated_camera.h"
#include "support.h"

namespace raygrid {
namespace {

// A board of 8 x 6 points around its origin.
std::vector<Eigen::Vector3d> BoardPoints() {
  std::vector<Eigen::Vector3d> points;
  for (int row = 0; row < 6; ++row)
    for (int column = 0; column < 8; ++column)
      points.emplace_back(0.03 * (column - 3.5), 0.03 * (row - 2.5), 0);
  return points;
}

// The board's centre seen in a direction, tilted by up to 50 degrees.
Pose PoseAlong(const Eigen::Vector3d& direction, TestRandom* random) {
  const Eigen::Quaterniond facing =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), direction);
  const double axis = random->Uniform(0, 2 * M_PI);
  const Eigen::Vector3d tilt =
      random->Uniform(0, 50) * M_PI / 180 *
      Eigen::Vector3d(std::cos(axis), std::sin(axis), 0);
  const Eigen::Vector3d turn(0, 0, random->Uniform(-3, 3));
  return {facing * RotationFromVector(tilt) * RotationFromVector(turn),
          direction.normalized() * random->Uniform(0.4, 0.9)};
}

// The points of the board that the camera sees.
std::vector<PointPixelMatch> Seen(const CameraModel& camera, const Pose& pose) {
  std::vector<PointPixelMatch> matches;
  for (const Eigen::Vector3d& point : BoardPoints()) {
    const auto pixel = camera.Project(pose * point);
    if (pixel) matches.push_back({point, *pixel});
  }
  return matches;
}

// Calls visit(pose, matches, &random) for this many boards with enough points
// in the image.
template <typename Visit>
void ForBoardsInView(const CameraModel& camera, int seed, int count,
                     size_t min_points, const Visit& visit) {
  TestRandom random(seed);
  while (count > 0) {
    const Pose pose =
        PoseAlong(*camera.Unproject(random.PixelIn(camera.area())), &random);
    const auto matches = Seen(camera, pose);
    if (matches.size() < min_points) continue;
    --count;
    visit(pose, matches, &random);
  }
}

void ExpectPose(const std::optional<Pose>& found, const Pose& truth,
                double tolerance) {
  ASSERT_TRUE(found);
  EXPECT_LT((found->translation - truth.translation).norm(), tolerance);
  EXPECT_LT(
      (found->rotation.toRotationMatrix() - truth.rotation.toRotationMatrix())
          .norm(),
      tolerance);
}

TEST(Localize, RecoversExactPoses) {
  const SimulatedCamera camera = ExampleSimulatedCamera();
  ForBoardsInView(camera, 1, 60, 20, [&](auto& pose, auto& matches, auto) {
    ExpectPose(Localize(camera, matches), pose, 1e-6);
  });
}

// Boards under a microscope, and boards seen from far away.
TEST(Localize, FindsBoardsOfAnySize) {
  const SimulatedCamera camera = ExampleSimulatedCamera();
  ForBoardsInView(camera, 4, 60, 20, [&](auto& pose, auto& matches, auto) {
    for (const double scale : {1e-4, 1e-2, 1e3}) {
      auto scaled = matches;
      for (PointPixelMatch& match : scaled) match.point *= scale;
      auto found = Localize(camera, scaled);
      ASSERT_TRUE(found) << scale;
      found->translation /= scale;
      ExpectPose(found, pose, 1e-6);
    }
  });
}

// Exactly, as if they were not there.
TEST(Localize, IsNotMovedByGrossOutliers) {
  const SimulatedCamera camera = ExampleSimulatedCamera();
  ForBoardsInView(
      camera, 5, 60, 24, [&](auto& pose, auto matches, auto* random) {
        for (int i = 0; i < 2; ++i) {
          Eigen::Vector2d& pixel =
              matches[random->Index(static_cast<int>(matches.size()))].pixel;
          const Eigen::Vector2d elsewhere = random->PixelIn(camera.area());
          if ((elsewhere - pixel).norm() > 50) pixel = elsewhere;
        }
        ExpectPose(Localize(camera, matches), pose, 1e-6);
      });
}

TEST(Localize, RecoversPosesFarOffTheAxisOfAFisheye) {
  const CentralGeneric camera = ExampleFisheye();
  TestRandom random(2);
  for (int i = 0; i < 30; ++i) {
    const double theta = (i % 2 ? 80 : 89) * M_PI / 180;
    const double phi = random.Uniform(0, 2 * M_PI);
    const Pose pose =
        PoseAlong({std::sin(theta) * std::cos(phi),
                   std::sin(theta) * std::sin(phi), std::cos(theta)},
                  &random);
    const auto matches = Seen(camera, pose);
    ASSERT_GE(matches.size(), 15u);
    ExpectPose(Localize(camera, matches), pose, 1e-6);
  }
}

TEST(Localize, RecoversPosesOfACameraWhoseLinesDoNotMeet) {
  const NonCentralGeneric camera = ExampleLines();
  ForBoardsInView(camera, 6, 30, 20, [&](auto& pose, auto& matches, auto) {
    ExpectPose(Localize(camera, matches), pose, 1e-6);
  });
}

TEST(Localize, WithstandsGrossOutliers) {
  const SimulatedCamera camera = ExampleSimulatedCamera();
  TestRandom random(3);
  for (int i = 0; i < 20; ++i) {
    const Pose pose = PoseAlong(*camera.Unproject({320, 240}), &random);
    auto matches = Seen(camera, pose);
    ASSERT_EQ(matches.size(), 48u);
    for (auto& match : matches) match.pixel += 0.05 * random.NormalVector<2>();
    for (size_t k = 0; k < matches.size(); k += 10) {
      const double angle = random.Uniform(0, 2 * M_PI);
      matches[k].pixel +=
          20 * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    }
    const auto found = Localize(camera, matches);
    ASSERT_TRUE(found);
    // In pixels, since how well the tilt of a frontal board can be told varies.
    // Least squares would be off by several.
    for (const Eigen::Vector3d& point : BoardPoints())
      EXPECT_LT(
          (*camera.Project(*found * point) - *camera.Project(pose * point))
              .norm(),
          0.5);
  }
}

TEST(Localize, NeedsFourMatchesInTheArea) {
  const SimulatedCamera camera = ExampleSimulatedCamera();
  TestRandom random(4);
  const Pose pose = PoseAlong(*camera.Unproject({320, 240}), &random);
  const auto seen = Seen(camera, pose);
  const std::vector<PointPixelMatch> four = {seen[0], seen[7], seen[40],
                                             seen[47]};
  std::vector<PointPixelMatch> three(four.begin(), four.end() - 1);
  EXPECT_TRUE(Localize(camera, four));
  EXPECT_FALSE(Localize(camera, three));
  EXPECT_FALSE(Localize(camera, {}));
  three.push_back({seen[47].point, {-30, 100}});
  EXPECT_FALSE(Localize(camera, three));
}

TEST(Localize, LeavesOutPixelsBeyondTheArea) {
  const SimulatedCamera camera = ExampleSimulatedCamera();
  TestRandom random(5);
  const Pose pose = PoseAlong(*camera.Unproject({320, 240}), &random);
  auto matches = Seen(camera, pose);
  matches.push_back({{0, 0, 0}, {700, 100}});
  matches.push_back({{0.1, 0, 0}, {100, -3}});
  ExpectPose(Localize(camera, matches), pose, 1e-6);
}

}  // namespace
}  // namespace raygrid
