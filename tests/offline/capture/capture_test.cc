#include <algorithm>
#include <cmath>
#include <string>

#include "capture/board_view.h"
#include "capture/camera_information.h"
#include "capture/live_camera.h"
#include "capture/next_view.h"
#include "capture/view_hint.h"
#include "evaluation/model_difference.h"
#include "simulation/random.h"
#include "simulation/simulated_camera.h"
#include "simulation/simulated_observations.h"
#include "support.h"
#include "test_boards.h"

namespace raygrid {
namespace {

constexpr ImageSize kCaptureSize = {640, 480};

Dataset ImagesOf(int num_images) {
  SimulationOptions options;
  options.num_images = num_images;
  options.features_per_image = 60;
  return SimulateObservations(ExampleSimulatedCamera(), TestBoard(), options)
      .dataset;
}

LiveCamera GetCamera(const std::vector<ImageFeatures>& images) {
  LiveCamera live(TestBoard(), kCaptureSize, 2);
  for (const ImageFeatures& image : images) live.Add(image);
  return live;
}

// ---- Views ------------------------------------------------------------------

TEST(BoardView, PutsTheMiddleAtItsPixel) {
  const SimulatedCamera camera = ExampleSimulatedCamera();
  const Board board = TestBoard().boards.front();
  for (const double tilt_rad : {0.0, 0.7}) {
    const BoardView view = {{500, 130}, 300, tilt_rad, 1.1, 0.4};
    const auto pose = ComputePose(view, board, camera);
    ASSERT_TRUE(pose);
    const auto pixel = camera.Project(*pose * ComputeBoardCenter(board));
    ASSERT_TRUE(pixel);
    EXPECT_LT((*pixel - view.pixel).norm(), 1e-6);
  }
}

TEST(BoardView, ShowsTheBoardAsWideAsAsked) {
  const SimulatedCamera camera = ExampleSimulatedCamera();
  const Board board = TestBoard().boards.front();
  const auto pose = ComputePose({{320, 240}, 100, 0, 0, 0}, board, camera);
  ASSERT_TRUE(pose);
  const Eigen::Vector3d center = ComputeBoardCenter(board);
  const Eigen::Vector3d half = {(board.columns - 1) * board.square_m / 2, 0, 0};
  const auto left = camera.Project(*pose * (center - half));
  const auto right = camera.Project(*pose * (center + half));
  ASSERT_TRUE(left && right);
  EXPECT_NEAR((*right - *left).norm(), 100, 3);
}

TEST(BoardView, IsNothingWhereTheCameraSeesNothing) {
  const Board board = TestBoard().boards.front();
  const SimulatedCamera camera = ExampleSimulatedCamera();
  EXPECT_FALSE(ComputePose({{-200, 240}, 100, 0, 0, 0}, board, camera));
  EXPECT_FALSE(ComputePose({{320, 240}, 0, 0, 0, 0}, board, camera));
}

// ---- The camera so far ------------------------------------------------------

TEST(LiveCamera, IsKnownFromFourImagesOn) {
  const std::vector<ImageFeatures> images = ImagesOf(4).images;
  LiveCamera live(TestBoard(), kCaptureSize, 1);
  for (const ImageFeatures& image : images) {
    EXPECT_FALSE(live.adjusted());
    live.Add(image);
  }
  ASSERT_TRUE(live.adjusted());
  EXPECT_NEAR(live.adjusted()->summary.noise_px, 0.05, 0.01);
}

TEST(LiveCamera, ComesNearTheTruthWithEachImage) {
  const LiveCamera live = GetCamera(ImagesOf(20).images);
  ASSERT_TRUE(live.adjusted());
  EXPECT_EQ(live.adjusted()->problem.views.size(), 20u);
  const ModelDifference difference = CompareModels(
      ExampleSimulatedCamera(), live.adjusted()->state.camera(), 20);
  EXPECT_LT(difference.median_px, 0.05);
}

TEST(LiveCamera, WaitsForImagesThatTellSomething) {
  const ImageFeatures image = ImagesOf(1).images.front();
  std::vector<ImageFeatures> images;
  for (int i = 0; i < 6; ++i) {
    images.push_back(image);
    images.back().image = std::to_string(i);
    images.back().features.resize(7);  // too few for a pose
  }
  EXPECT_FALSE(GetCamera(images).adjusted());
}

// ---- What is known ----------------------------------------------------------

// The gain foretold is what the view takes from the variance, the camera and
// its noise being as they were.
TEST(CameraInformation, ForetellsWhatAViewAdds) {
  const std::vector<ImageFeatures> images = ImagesOf(9).images;
  const LiveCamera live = GetCamera(images);
  ASSERT_TRUE(live.adjusted());
  const AdjustmentResult& all = *live.adjusted();
  for (size_t added = 0; added < 3; ++added) {
    AdjustmentResult others = all;
    std::vector<bool> remove(all.problem.views.size(), false);
    remove[added] = true;
    others.state.rig_from_pattern.erase(others.state.rig_from_pattern.begin() +
                                        all.problem.views[added].pose);
    RemoveViews(remove, &others.problem);
    const auto before = CameraInformation::Of(others);
    const auto after = CameraInformation::Of(all);
    ASSERT_TRUE(before && after);
    std::vector<Eigen::Vector3d> points;
    std::vector<Eigen::Vector2d> pixels;
    const View& view = all.problem.views[added];
    for (const Observation& o : view.observations) {
      points.push_back(all.state.points[o.point]);
      pixels.push_back(o.pixel);
    }
    const double gain = before->ComputeGain(
        points, pixels, all.state.ComputeCameraFromPattern(view));
    const double left =
        std::pow(after->RmsPx(), 2) / std::pow(before->RmsPx(), 2);
    // Rotation is taken out as of the observations, which are not the same.
    EXPECT_NEAR(1 - gain, left, 0.02) << added;
    EXPECT_GT(gain, 0.02);
  }
}

TEST(CameraInformation, GrowsWithImages) {
  const std::vector<ImageFeatures> images = ImagesOf(24).images;
  double last_px = INFINITY;
  for (const int count : {6, 12, 24}) {
    const LiveCamera live = GetCamera({images.begin(), images.begin() + count});
    ASSERT_TRUE(live.adjusted());
    const auto information = CameraInformation::Of(*live.adjusted());
    ASSERT_TRUE(information);
    EXPECT_LT(information->Percentile95Px(), last_px);
    EXPECT_LT(information->RmsPx(), 10);
    last_px = information->Percentile95Px();
  }
}

TEST(CameraInformation, GainsNothingFromNoFeatures) {
  const LiveCamera live = GetCamera(ImagesOf(5).images);
  ASSERT_TRUE(live.adjusted());
  const auto information = CameraInformation::Of(*live.adjusted());
  ASSERT_TRUE(information);
  EXPECT_EQ(information->ComputeGain({}, {}, {}), 0);
  Pose behind;
  behind.translation.z() = -5;
  EXPECT_EQ(information->PredictViewGain(TestBoard().boards.front(), behind),
            0);
}

// ---- What comes next --------------------------------------------------------

// Boards that were only held at the left.
TEST(NextView, LooksWhereNothingWasSeen) {
  const SimulatedCamera camera = ExampleSimulatedCamera();
  const Board board = TestBoard().boards.front();
  std::vector<ImageFeatures> images;
  for (int i = 0; i < 12; ++i) {
    const BoardView view = {{150.0 + 10 * (i % 3), 100.0 + 25 * i},
                            250.0 + 10 * i,
                            0.6,
                            1.3 * i,
                            0.5 * i};
    const auto pose = ComputePose(view, board, camera);
    ASSERT_TRUE(pose);
    images.push_back(
        {std::to_string(i), VisibleFeatures(camera, board, *pose)});
  }
  SimulationOptions noise;
  Random random(1);
  for (ImageFeatures& image : images) AddNoise(noise, &random, &image.features);
  const LiveCamera live = GetCamera(images);
  ASSERT_TRUE(live.adjusted());
  const auto information = CameraInformation::Of(*live.adjusted());
  ASSERT_TRUE(information);
  const auto next = FindBestNextView(*information, board);
  ASSERT_TRUE(next);
  double rightmost_px = 0;
  for (const Feature& feature :
       VisibleFeatures(camera, board, next->camera_from_board))
    rightmost_px = std::max(rightmost_px, feature.pixel.x());
  EXPECT_GT(rightmost_px, 550);
  EXPECT_GT(next->gain, 0.3);
  // More than any view that was.
  for (const Pose& pose : live.adjusted()->state.rig_from_pattern)
    EXPECT_GT(next->gain, 2 * information->PredictViewGain(board, pose));
}

TEST(NextView, IsAnotherOneWhereTheBestIsAvoided) {
  const LiveCamera live = GetCamera(ImagesOf(6).images);
  const auto information = CameraInformation::Of(*live.adjusted());
  ASSERT_TRUE(information);
  const Board board = TestBoard().boards.front();
  const auto best = FindBestNextView(*information, board);
  ASSERT_TRUE(best);
  const auto other =
      FindBestNextView(*information, board, {best->camera_from_board});
  ASSERT_TRUE(other);
  EXPECT_LE(other->gain, best->gain);
  EXPECT_FALSE(HasReachedView(information->camera(), board,
                              other->camera_from_board,
                              best->camera_from_board));
}

TEST(NextView, BeginsWithFourTiltedViews) {
  const SimulatedCamera camera = ExampleSimulatedCamera();
  const Board board = TestBoard().boards.front();
  LiveCamera live(TestBoard(), kCaptureSize, 1);
  for (int i = 0; i < kNumFirstViews; ++i) {
    const auto pose = ComputePose(FirstView(i, kCaptureSize), board, camera);
    ASSERT_TRUE(pose);
    live.Add({std::to_string(i), VisibleFeatures(camera, board, *pose)});
  }
  EXPECT_TRUE(live.adjusted());
}

}  // namespace
}  // namespace raygrid
