// Images of two cameras taken for one's, and boards too far away.

#include <fmt/format.h>

#include "calibration/calibration.h"
#include "simulation/simulated_observations.h"
#include "support.h"
#include "test_boards.h"

namespace raygrid {
namespace {

constexpr int kImages = 7;  // of each camera

Dataset Observe(const CameraModel& camera, uint64_t seed, int num_images) {
  SimulationOptions options;
  options.num_images = num_images;
  options.features_per_image = 100;
  options.seed = seed;
  return SimulateObservations(camera, TestBoard(), options).dataset;
}

// Another unit: a little longer, and not in the middle.
OpenCvModel OtherLens() {
  const ImageSize size = {640, 480};
  return OpenCvModel(
      size, WholeImage(size),
      {522, 527, 330, 232, -0.12, 0.06, 0.01, 0.1, 0.02, 0.005, 1e-3, -8e-4});
}

// Images of both, under names of one kind or of two.
Dataset BothCameras(bool has_two_stems) {
  Dataset both = Observe(ExampleLens(), 1, kImages);
  const Dataset other = Observe(OtherLens(), 2, kImages);
  both.images.insert(both.images.end(), other.images.begin(),
                     other.images.end());
  for (size_t i = 0; i < both.images.size(); ++i)
    both.images[i].image = fmt::format(
        "{}{:02}.png", has_two_stems ? (i < kImages ? "left" : "right") : "",
        has_two_stems ? i % kImages : i);
  return both;
}

CalibrationResult Calibrated(const Dataset& dataset) {
  CalibrationOptions options;
  options.model = "opencv";
  options.fix_target_geometry = true;
  options.hold_out = {dataset.images.front().image};
  return Calibrate(dataset, TestBoard(), options);
}

TEST(MixedCameras, AreNamedByTheirImages) {
  for (const bool has_two_stems : {true, false}) {
    const CalibrationResult result = Calibrated(BothCameras(has_two_stems));
    EXPECT_EQ(result.assessment.word, "warn");
    ASSERT_TRUE(result.mixed_cameras) << has_two_stems;
    const auto& [first, second] = *result.mixed_cameras;
    EXPECT_EQ(first.size(), kImages - 1u);  // one is held out
    EXPECT_EQ(second.size(), kImages + 0u);
    EXPECT_EQ(first.back(), has_two_stems ? "left06.png" : "06.png");
    EXPECT_NE(result.assessment.reasons[0].find(
                  "these images appear to come from two cameras"),
              std::string::npos);
  }
}

TEST(MixedCameras, AreNotSeenInOne) {
  Dataset dataset = Observe(ExampleLens(), 1, 2 * kImages);
  for (size_t i = 0; i < dataset.images.size(); ++i)
    dataset.images[i].image =
        fmt::format("{}{:02}.png", i % 2 == 0 ? "left" : "right", i);
  EXPECT_FALSE(Calibrated(dataset).mixed_cameras);
}

// Errs alike with any parametric camera.
TEST(MixedCameras, AreNotSeenInALensWithBumps) {
  const Dataset dataset =
      Observe(*MakeSimulatedCamera("wide", {640, 480}), 1, 20);
  EXPECT_FALSE(Calibrated(dataset).mixed_cameras);
}

TEST(Distance, IsAskedAboutBeyondTwentyMetres) {
  const Pattern board = ChessboardPattern(14, 10, 3);
  SimulationOptions simulation;
  simulation.num_images = 6;
  simulation.features_per_image = 60;
  const Dataset dataset =
      SimulateObservations(ExampleLens(), board, simulation).dataset;
  CalibrationOptions options;
  options.model = "opencv";
  options.fix_target_geometry = true;
  options.hold_out = {dataset.images.front().image};
  ExpectError(ExitCode::kUsage, {"median distance", "square_m", "--yes"},
              [&] { Calibrate(dataset, board, options); });
  options.allow_large_distance = true;
  EXPECT_GT(Calibrate(dataset, board, options)
                .poses[0]
                .camera_from_board.translation.norm(),
            20);
}

}  // namespace
}  // namespace raygrid
