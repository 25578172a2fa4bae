#include "initialization/radial_initialization.h"

#include "evaluation/model_difference.h"
#include "simulation/simulated_camera_models.h"
#include "simulation/simulated_observations.h"
#include "support.h"
#include "test_boards.h"

namespace raygrid {
namespace {

Dataset Observations(const CameraModel& camera, double noise_px) {
  SimulationOptions options;
  options.num_images = 15;
  options.features_per_image = 60;
  options.noise_px = noise_px;
  options.seed = 3;
  return SimulateObservations(camera, TestBoard(), options).dataset;
}

double MedianRayError(const CameraModel& camera, const Dataset& dataset) {
  const auto start = InitializeFromRadialLines(dataset, TestBoard());
  if (!start) return INFINITY;
  return CompareModels(camera, *start, 8).median_px;
}

// Linear equations alone; what they have no terms for remains.
TEST(RadialInitialization, IsNearlyTheLensOfAnyFieldOfView) {
  const ImageSize size = {640, 480};
  for (const char* lens : {"pinhole", "wide", "fisheye", "fisheye190"}) {
    const auto camera = MakeSimulatedCamera(lens, size);
    EXPECT_LT(MedianRayError(*camera, Observations(*camera, 0.05)), 3) << lens;
  }
}

TEST(RadialInitialization, IsNotMovedByGrossOutliers) {
  const auto camera = MakeSimulatedCamera("fisheye190", {640, 480});
  Dataset dataset = Observations(*camera, 0.05);
  TestRandom random(7);
  for (ImageFeatures& image : dataset.images)
    for (int i = 0; i < 2; ++i)
      image.features[random.Index(60)].pixel = random.PixelIn({0, 0, 639, 479});
  EXPECT_LT(MedianRayError(*camera, dataset), 3);
}

TEST(RadialInitialization, NeedsTwoViews) {
  const auto camera = MakeSimulatedCamera("fisheye190", {640, 480});
  Dataset dataset = Observations(*camera, 0);
  dataset.images.resize(1);
  EXPECT_FALSE(InitializeFromRadialLines(dataset, TestBoard()));
  EXPECT_FALSE(InitializeFromRadialLines(Dataset(), TestBoard()));
}

}  // namespace
}  // namespace raygrid
