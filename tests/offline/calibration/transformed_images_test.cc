// Image files that were rotated or scaled before calibration.

#include "calibration/transformed_images.h"

#include <functional>

#include "calibration/calibration.h"
#include "calibration/camera_initialization.h"
#include "simulation/simulated_camera_models.h"
#include "simulation/simulated_observations.h"
#include "simulation/simulated_rig.h"
#include "support.h"
#include "test_boards.h"

namespace raygrid {
namespace {

using Kind = TransformedImages::Kind;

constexpr int kViews = 12;

Dataset SimulateImages(const CameraModel& camera, int num_images = kViews) {
  SimulationOptions options;
  options.num_images = num_images;
  options.features_per_image = 100;
  return SimulateObservations(camera, TestBoard(), options).dataset;
}

using PixelChange = std::function<Eigen::Vector2d(const Eigen::Vector2d&)>;

// Changes the images from the first one on, every `stride`th.
std::vector<std::string> ChangeImages(int stride, const PixelChange& change,
                                      Dataset* dataset) {
  std::vector<std::string> names;
  for (size_t i = 0; i < dataset->images.size(); i += stride) {
    ImageFeatures& image = dataset->images[i];
    names.push_back(image.image);
    for (Feature& feature : image.features)
      feature.pixel = change(feature.pixel);
  }
  return names;
}

std::optional<TransformedImages> DetectIn(const Dataset& dataset) {
  AdjustmentOptions options;
  options.num_threads = 1;
  return DetectTransformedImages(
      dataset, TestBoard(), InitializeCamera(dataset, TestBoard(), options),
      options);
}

Eigen::Vector2d Rotate(const Eigen::Vector2d& pixel) {
  return {639 - pixel.x(), 479 - pixel.y()};
}

Eigen::Vector2d Halve(const Eigen::Vector2d& pixel) {
  return (pixel.array() + 0.5) / 2 - 0.5;
}

// Half of the images is the hardest case: the principal point of a camera
// fitted to all of them is the image centre, which no image prefers.
TEST(TransformedImages, AreNamedIfRotated) {
  for (const int stride : {2, 6}) {
    Dataset dataset = SimulateImages(ExampleLens());
    const auto rotated = ChangeImages(stride, Rotate, &dataset);
    const auto found = DetectIn(dataset);
    ASSERT_TRUE(found) << stride;
    EXPECT_EQ(found->kind, Kind::kRotated);
    EXPECT_EQ(found->num_images, dataset.images.size());
    // With half of the images, either half may be named.
    if (stride > 2) EXPECT_EQ(found->images, rotated);
  }
}

TEST(TransformedImages, AreNamedAmongManyImages) {
  Dataset dataset = SimulateImages(ExampleLens(), 60);
  const auto rotated = ChangeImages(3, Rotate, &dataset);
  const auto found = DetectIn(dataset);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->kind, Kind::kRotated);
  EXPECT_EQ(found->images, rotated);
}

TEST(TransformedImages, AreNamedIfScaled) {
  Dataset dataset = SimulateImages(ExampleLens());
  const auto scaled = ChangeImages(3, Halve, &dataset);
  const auto found = DetectIn(dataset);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->kind, Kind::kScaled);
  EXPECT_EQ(found->scale, 0.5);
  EXPECT_EQ(found->images, scaled);
}

// Small targets of the other images may lie within the scaled image, too, and a
// pinhole camera absorbs most of the change.
TEST(TransformedImages, AreNamedBesideSmallTargets) {
  Dataset dataset =
      SimulateImages(*MakeSimulatedCamera("pinhole", {640, 480}), 15);
  const auto scaled = ChangeImages(3, Halve, &dataset);
  const auto found = DetectIn(dataset);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->scale, 0.5);
  EXPECT_EQ(found->images, scaled);
}

// Residuals are also correlated if no parametric model fits the lens.
TEST(TransformedImages, AreNotSeenInALensWithBumps) {
  EXPECT_FALSE(
      DetectIn(SimulateImages(*MakeSimulatedCamera("wide", {640, 480}))));
}

TEST(TransformedImages, AreReported) {
  Dataset dataset = SimulateImages(ExampleLens());
  const auto rotated = ChangeImages(3, Rotate, &dataset);
  CalibrationOptions options;
  options.model = "opencv";
  options.fix_target_geometry = true;
  options.hold_out = {dataset.images.back().image};
  const CalibrationResult result = Calibrate(dataset, TestBoard(), options);
  EXPECT_EQ(result.assessment.word, "fail");
  EXPECT_EQ(result.assessment.failure,
            "4 of 11 images (" + rotated.front() +
                ", ...) are rotated by 180 degrees relative to the others; "
                "undo this in the image files, or calibrate without them");
}

// In a rig, the other camera disagrees, too.
TEST(TransformedImages, AreReportedInARig) {
  const auto lens = std::make_shared<OpenCvModel>(ExampleLens());
  SimulationOptions simulation;
  simulation.num_images = 10;
  simulation.features_per_image = 40;
  SimulatedRigObservations seen =
      SimulateRig({{lens, lens}, {{}, {{1, 0, 0, 0}, {-0.12, 0, 0}}}},
                  TestBoard(), simulation);
  ChangeImages(3, Halve, &seen.datasets[0]);
  for (const bool are_known : {false, true}) {
    std::vector<CalibrationInput> inputs = {{"left", seen.datasets[0]},
                                            {"right", seen.datasets[1]}};
    for (CalibrationInput& input : inputs) {
      if (!are_known) continue;
      CameraFile file;
      file.camera = lens;
      input.intrinsics = std::make_shared<CameraFile>(file);
    }
    CalibrationOptions options;
    options.model = "opencv";
    options.fix_target_geometry = true;
    options.compare_models = false;
    options.hold_out = {seen.datasets[0].images[1].image};
    const RigResult result = Calibrate(inputs, TestBoard(), options);
    EXPECT_EQ(result.assessment.word, "fail") << are_known;
    EXPECT_NE(result.cameras[0].assessment.failure.find(
                  "4 of 9 images (" + seen.datasets[0].images[0].image +
                  ", ...) are scaled by 0.5 (another resolution)"),
              std::string::npos)
        << are_known << ": " << result.cameras[0].assessment.failure;
    EXPECT_FALSE(result.cameras[1].transformed_images) << are_known;
  }
}

}  // namespace
}  // namespace raygrid
