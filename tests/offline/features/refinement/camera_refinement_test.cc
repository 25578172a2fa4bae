#include "features/refinement/camera_refinement.h"

#include <cstdio>
#include <map>
#include <utility>

#include "features/refinement/feature_refinement.h"
#include "features/star/star_detection.h"
#include "features/star/star_scenes.h"
#include "simulation/image_rendering.h"
#include "simulation/simulated_camera_models.h"
#include "simulation/simulated_observations.h"
#include "support.h"

namespace raygrid {
namespace {

// Turned, and in the corner of the image, where a lens curves most.
Pose PoseInACorner(const CameraModel& camera, const Board& board,
                   double distance_m) {
  Pose pose;
  const Eigen::Vector3d direction = *camera.Unproject({450, 330});
  pose.rotation =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), direction) *
      Eigen::AngleAxisd(0.4, Eigen::Vector3d(0.5, 1, 0.8).normalized());
  pose.translation = distance_m * direction -
                     pose.rotation * Eigen::Vector3d(board.points.back() / 2);
  return pose;
}

double MaxDifference(const LocalMapping& mapping, const CameraModel& camera,
                     const Pose& pose, const Board& board, int index) {
  double largest = 0;
  const Eigen::Matrix2d inverse = mapping.linear.inverse();
  for (int y = -10; y <= 10; y += 5) {
    for (int x = -10; x <= 10; x += 5) {
      const Eigen::Vector2d s = inverse * Eigen::Vector2d(x, y);
      Eigen::Vector3d point = board.points[index];
      point.head<2>() += board.square_m * s;
      const auto pixel = camera.Project(pose * point);
      if (pixel) largest = std::max(largest, (mapping(s) - *pixel).norm());
    }
  }
  return largest;
}

TEST(ComputeCameraMapping, FollowsTheLensInTheWindow) {
  const Pattern pattern = StarPattern();
  const Board& board = pattern.boards[0];
  for (const std::string lens : {"pinhole", "wide", "fisheye"}) {
    const auto camera = MakeSimulatedCamera(lens, kSize);
    const Pose pose = PoseInACorner(*camera, board, 0.25);
    int count = 0;
    for (const Feature& feature : VisibleFeatures(*camera, board, pose)) {
      const auto mapping =
          ComputeCameraMapping(*camera, pose, board, feature, 21);
      if (!mapping) continue;
      ++count;
      EXPECT_LT(MaxDifference(*mapping, *camera, pose, board,
                              board.PointIndex(feature.column, feature.row)),
                0.01)
          << lens;
    }
    EXPECT_GT(count, 100) << lens;
  }
}

TEST(ComputeCameraMapping, TellsNothingWhereTheCameraDoesNot) {
  const Pattern pattern = StarPattern();
  const auto camera = MakeSimulatedCamera("pinhole", kSize);
  Pose behind;
  behind.translation = {0, 0, -1};
  EXPECT_FALSE(ComputeCameraMapping(*camera, behind, pattern.boards[0],
                                    {0, 3, 3, {100, 100}}, 21));
}

double RmsPx(const std::vector<Feature>& features,
             const std::vector<Feature>& truth) {
  double sum = 0;
  int count = 0;
  for (const Feature& feature : features) {
    for (const Feature& exact : truth) {
      if (exact.column != feature.column || exact.row != feature.row) continue;
      sum += (feature.pixel - exact.pixel).squaredNorm();
      ++count;
    }
  }
  return std::sqrt(sum / count / 2);
}

TEST(FeatureRefiner, IsMoreAccurateWithWhatTheCameraTells) {
  const Pattern pattern = StarPattern();
  const Board& board = pattern.boards[0];
  const BoardSurface surface(board);
  for (const std::string lens : {"wide", "fisheye"}) {
    const auto camera = MakeSimulatedCamera(lens, kSize);
    const Pose pose = PoseInACorner(*camera, board, 0.25);
    ImagingOptions imaging;
    imaging.read_noise = 2;
    const GreyImage image = MakeGreyImage(AddNoiseAndQuantize(
        RenderImage(PixelRays(*camera, 2), {{&surface, pose}}, imaging, 2),
        imaging));
    const std::vector<Feature> found =
        StarDetector(pattern, {}).Detect(image).features;
    const FeatureRefiner refiner(board, {});
    const auto tell = [&](const Feature& feature) {
      return ComputeCameraMapping(*camera, pose, board, feature, 21);
    };
    const std::vector<Feature> refined = refiner.RefineWith(image, found, tell);
    const auto truth = VisibleFeatures(*camera, board, pose);
    const double before = RmsPx(found, truth), after = RmsPx(refined, truth);
    std::printf(
        "%s, %zu features: RMS %.5f px by neighbours, %.5f px by the "
        "camera\n",
        lens.c_str(), found.size(), before, after);
    EXPECT_GT(found.size(), 100u);
    EXPECT_LT(after, 0.004) << lens;
    EXPECT_LT(after, before) << lens;
  }
}

// The stars are as a growth leaves them that has come upon the wrong ones on
// its way round the tag.
TEST(FeatureRefiner, RejectsStarsThatAreTakenForTheirNeighbours) {
  const Pattern pattern = StarPattern();
  const Board& board = pattern.boards[0];
  const BoardSurface surface(board);
  const auto camera = MakeSimulatedCamera("pinhole", kSize);
  const Pose pose = PoseInACorner(*camera, board, 0.25);
  const GreyImage image = MakeGreyImage(AddNoiseAndQuantize(
      RenderImage(PixelRays(*camera, 2), {{&surface, pose}}, {}, 2), {}));
  std::map<std::pair<int, int>, Eigen::Vector2d> truth;
  for (const Feature& f : VisibleFeatures(*camera, board, pose))
    truth[{f.column, f.row}] = f.pixel;
  std::vector<Feature> approximate;
  constexpr int kFirstRight = 5;
  for (const auto& [place, pixel] : truth) {
    const auto [column, row] = place;
    if (column >= kFirstRight)
      approximate.push_back({0, column, row, pixel});
    else if (column > 0 && column < kFirstRight - 1)
      approximate.push_back({0, column - 1, row, pixel});
  }
  const auto found = FeatureRefiner(board, {}).Refine(image, approximate);
  EXPECT_GT(found.features.size(), 80u);
  for (const Feature& f : found.features)
    EXPECT_LT((f.pixel - truth.at({f.column, f.row})).norm(), 0.5)
        << f.column << ", " << f.row;
}

}  // namespace
}  // namespace raygrid
