#include "calibration/model_selection.h"

#include "evaluation/model_difference.h"
#include "lens_family.h"
#include "simulation/simulated_observations.h"
#include "support.h"

namespace raygrid {
namespace {

CalibrationResult CalibrateWith(const std::string& model,
                                const CameraModel& truth, int num_images,
                                uint64_t seed, double knot_spacing_px = 0) {
  SimulationOptions simulation;
  simulation.num_images = num_images;
  simulation.features_per_image = 60;
  simulation.noise_px = 0.2;
  simulation.seed = seed;
  const Pattern pattern = ChessboardPattern(10, 8, 0.04);
  CalibrationOptions options;
  options.model = model;
  options.knot_spacing_px = knot_spacing_px;
  options.fix_target_geometry = true;
  options.num_threads = 1;
  return Calibrate(SimulateObservations(truth, pattern, simulation).dataset,
                   pattern, options);
}

std::string ModelOf(const CalibrationResult& result) {
  return result.camera.camera->Name();
}

double ErrorPx(const CameraModel& truth, const CalibrationResult& result) {
  return CompareModels(truth, *result.camera.camera, 20).rms_px;
}

// A lens that parametric models follow, of five images.
TEST(AutoModel, IsNearerToTheTruthThanTheGridWhereThatFollowsNoise) {
  double auto_px = 0, grid_px = 0;
  int num_parametric = 0;
  for (const uint64_t seed : {1, 2, 3}) {
    const std::unique_ptr<CameraModel> truth =
        DrawLens(LensFamilyOf("smooth"), seed);
    const CalibrationResult result = CalibrateWith(kAutoModel, *truth, 5, seed);
    ASSERT_GE(result.model_candidates.size(), 2u);
    EXPECT_EQ(result.model_candidates.front().model, "central-generic");
    num_parametric += ModelOf(result) != "central-generic";
    auto_px += ErrorPx(*truth, result);
    grid_px +=
        ErrorPx(*truth, CalibrateWith("central-generic", *truth, 5, seed));
  }
  EXPECT_GE(num_parametric, 1);
  EXPECT_LT(auto_px, grid_px);
}

TEST(AutoModel, IsAGridWhereNoParametricModelFollowsTheLens) {
  const std::unique_ptr<CameraModel> truth = DrawLens(LensFamilyOf("wide"), 1);
  const CalibrationResult result = CalibrateWith(kAutoModel, *truth, 20, 1);
  EXPECT_EQ(ModelOf(result), "central-generic");
  EXPECT_GT(result.knot_spacing_px, 0);
  for (const ModelCandidate& candidate : result.model_candidates)
    if (candidate.model != "central-generic") EXPECT_LT(candidate.gain, 0);
}

TEST(AutoModel, IsCentralGenericWithGivenCells) {
  const std::unique_ptr<CameraModel> truth =
      DrawLens(LensFamilyOf("smooth"), 1);
  const CalibrationResult result = CalibrateWith(kAutoModel, *truth, 5, 1, 160);
  EXPECT_EQ(ModelOf(result), "central-generic");
  EXPECT_TRUE(result.model_candidates.empty());
}

}  // namespace
}  // namespace raygrid
