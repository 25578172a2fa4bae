// A camera is fitted to the features from a lens that starts it.

#include "calibration/model_adjustment.h"

#include <cmath>
#include <filesystem>
#include <string>

#include "calibration/calibration.h"
#include "calibration/camera_initialization.h"
#include "calibration/divergence.h"
#include "calibration/restart.h"
#include "gtest/gtest.h"
#include "random_calibration.h"
#include "simulation/simulated_camera.h"
#include "simulation/simulated_observations.h"
#include "support.h"
#include "test_boards.h"

namespace raygrid {
namespace {

// A few of those that convergence_bench tries.
TEST(OptimizeModel, ParametricModelsConverge) {
  for (int seed = 0; seed < 8; ++seed) {
    const RandomCalibration c = MakeRandomCalibration(seed, 10, 30);
    AdjustmentOptions options;
    options.num_threads = 2;
    options.fix_points = c.fix_target_geometry;
    AdjustmentResult adjusted = InitializeCamera(c.dataset, c.pattern, options);
    OptimizeModel(c.pattern, c.model, {0}, options, &adjusted);
    EXPECT_TRUE(adjusted.summary.converged) << seed << ": " << c.model;
  }
}

// The folds of a resumed calibration are not initialized.
TEST(RestartFromFolds, StartsFromEachFold) {
  CameraInProgress camera;
  SimulationOptions simulation;
  simulation.num_images = 8;
  simulation.features_per_image = 30;
  camera.split.training =
      SimulateObservations(ExampleLens(), TestBoard(), simulation).dataset;
  camera.lens = InitializeCamera(camera.split.training, TestBoard(), {});
  camera.folds = MakeFolds({camera.split}, {&camera.lens.state.camera()});
  ASSERT_GT(camera.folds.count(), 1);
  CalibrationOptions options;
  for (const char* model : {"opencv", "central-generic"}) {
    options.model = model;
    AdjustmentResult adjusted = camera.lens;
    int num_starts = 0;
    const auto adjust = [&] {
      ++num_starts;
      return camera.lens;
    };
    RestartFromFolds(TestBoard(), options, adjust, &camera, &adjusted);
    EXPECT_EQ(num_starts, camera.folds.count()) << model;
  }
}

TEST(OptimizeModel, CountsLostFeaturesAsErrors) {
  SimulationOptions simulation;
  simulation.num_images = 8;
  simulation.features_per_image = 80;
  const Pattern pattern = TestBoard();
  const AdjustmentResult start = InitializeCamera(
      SimulateObservations(ExampleSimulatedCamera(), pattern, simulation)
          .dataset,
      pattern, {});
  EXPECT_LT(ComputeMeanErrorPx(start, start), 0.5);
  EXPECT_FALSE(HasDiverged(start, start));
  // Those that are still seen would be as near as ever.
  AdjustmentResult lost = start;
  for (size_t i = 1; i < lost.state.rig_from_pattern.size(); ++i)
    lost.state.rig_from_pattern[i].translation.x() += 100;
  EXPECT_GT(ComputeMeanErrorPx(lost, start), 0.8 * ErrorCapPx({640, 480}));
  EXPECT_TRUE(HasDiverged(lost, start));
  // Features that were removed have the errors that they had.
  AdjustmentResult removed = start;
  for (Observation& observation : removed.problem.views[0].observations)
    removed.rejected_features[0].push_back(
        {"", 0, 0, 0, observation.pixel, {0.5, 0}});
  removed.problem.views[0].observations.clear();
  EXPECT_NEAR(ComputeMeanErrorPx(removed, start),
              ComputeMeanErrorPx(start, start), 0.06);
}

// Strong fisheyes whose adjustments lost nearly all features.
TEST(OptimizeModel, DoesNotDivergeOnPhotographs) {
  const std::string path = std::string(RAYGRID_REAL_DATA) +
                           "/../cases/boards/fisheye_diverges_features.csv";
  if (!std::filesystem::exists(path))
    GTEST_SKIP() << path
                 << ": missing; real observations are not part of "
                    "the repository (-DRAYGRID_REAL_DATA)";
  Dataset dataset = ReadFeatures(path).at("");
  dataset.image_size = {1032, 778};
  const Pattern pattern = ChessboardPattern(8, 6, 0.0325);
  CalibrationOptions options;
  options.num_threads = 2;
  options.knot_spacing_px = 64.5;
  const CalibrationResult result = Calibrate(dataset, pattern, options);
  EXPECT_LT(result.camera.training->median_px, 0.2);
  EXPECT_GT(result.camera.training->count, 500);
  EXPECT_NE(result.assessment.word, "fail");
}

// A feature behind a wide lens that steps lose and find again: after 50 steps
// none may be lost, or they would go round in a circle.
TEST(OptimizeModel, ConvergesWhereFeaturesAreLostAndFound) {
  const RandomCalibration c = MakeRandomCalibration(289, 10, 300);
  AdjustmentOptions options;
  options.num_threads = 2;
  AdjustmentResult adjusted = InitializeCamera(c.dataset, c.pattern, options);
  OptimizeModel(c.pattern, c.model, {0}, options, &adjusted);
  EXPECT_TRUE(adjusted.summary.converged);
}

// Beside outliers the scatter of points is lost at first. It must be found once
// these have left.
TEST(OptimizeModel, FindsAPrintsScatterOnceOutliersHaveLeft) {
  constexpr double kScatterM = 0.0001;
  const Pattern nominal = ChessboardPattern(30, 24, 0.02);
  TestRandom random(4);
  Pattern printed = nominal;
  for (Eigen::Vector3d& point : printed.boards[0].points)
    point += kScatterM * random.NormalVector<3>();
  SimulationOptions simulation;
  simulation.num_images = 20;
  simulation.features_per_image = 80;
  simulation.noise_px = 0.05;
  Dataset dataset =
      SimulateObservations(ExampleSimulatedCamera(), printed, simulation)
          .dataset;
  for (ImageFeatures& image : dataset.images)
    for (size_t k = 0; k < image.features.size(); k += 20)
      image.features[k].pixel += 2 * random.NormalVector<2>();
  AdjustmentOptions options;
  options.num_threads = 2;
  AdjustmentResult adjusted = InitializeCamera(dataset, nominal, options);
  OptimizeModel(nominal, "central-generic", {80}, options, &adjusted);
  EXPECT_GT(adjusted.rejected_features[0].size(), 40u);
  EXPECT_NEAR(
      adjusted.summary.noise_px / std::sqrt(adjusted.prior.points_precision),
      kScatterM, 0.3 * kScatterM);
}

}  // namespace
}  // namespace raygrid
