#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "calibration/calibration.h"
#include "calibration/camera_evaluation.h"
#include "calibration/camera_initialization.h"
#include "calibration/deformation_evaluation.h"
#include "calibration/deformation_selection.h"
#include "calibration/deformation_share.h"
#include "simulation/simulated_camera.h"
#include "simulation/simulated_observations.h"
#include "support.h"
#include "test_boards.h"

namespace raygrid {
namespace {

CalibrationOptions WithCells(double knot_spacing_px) {
  CalibrationOptions options;
  options.knot_spacing_px = knot_spacing_px;
  options.num_threads = 2;
  return options;
}

SimulatedObservations SimulateDeformation(double flex_m, int num_images = 16) {
  SimulationOptions options;
  options.num_images = num_images;
  options.features_per_image = 130;
  options.noise_px = 0.02;
  options.board_deformation_m = flex_m;
  return SimulateObservations(ExampleSimulatedCamera(), TestBoard(), options);
}

TEST(Calibrate, FollowsBoardsThatBendFromImageToImage) {
  const Dataset dataset = SimulateDeformation(0.0004).dataset;
  CalibrationOptions options = WithCells(80);
  options.hold_out = {dataset.images[3].image, dataset.images[9].image};
  const CalibrationResult bent = Calibrate(dataset, TestBoard(), options);
  options.rigid_board = true;
  const CalibrationResult rigid = Calibrate(dataset, TestBoard(), options);
  ASSERT_TRUE(bent.bends.has_value());
  EXPECT_FALSE(rigid.bends.has_value());
  EXPECT_EQ(bent.bends->views.size(), 14u);
  // More at the lattice than over the area, whose mean is 0.4 mm.
  EXPECT_NEAR(bent.bends->rms_m, 0.0005, 0.00012);
  EXPECT_EQ(bent.bends->heights_m.size(),
            static_cast<size_t>(TestBoard().boards[0].num_points()));
  EXPECT_LT(bent.camera.training->rms_px, 0.04);
  EXPECT_GT(rigid.camera.training->rms_px, 0.1);
  // The verdict does not take bends for a camera that is little known.
  for (const std::string& reason : bent.assessment.reasons)
    EXPECT_EQ(reason.find("add images"), std::string::npos) << reason;
  // Held-out images are localised with boards that are not bent, and bent.
  EXPECT_GT(bent.camera.held_out->rms_px, 0.1);
  EXPECT_LT(bent.held_out_deformed->rms_px, 0.6 * bent.camera.held_out->rms_px);
  EXPECT_LT(bent.held_out_deformed->rms_px, rigid.held_out_deformed->rms_px);
}

// A camera follows a board that is bent and taken for flat, and leaves no
// residuals that would tell.
TEST(Calibrate, SaysThatABoardIsNotFlatAsTold) {
  for (const double bend_m : {0.0, 0.0005}) {
    SimulationOptions simulation;
    simulation.num_images = 16;
    simulation.features_per_image = 130;
    simulation.board_sagitta_m = bend_m;
    CalibrationOptions options = WithCells(160);
    options.fix_target_geometry = true;
    const CalibrationResult result = Calibrate(
        SimulateObservations(ExampleSimulatedCamera(), TestBoard(), simulation)
            .dataset,
        TestBoard(), options);
    EXPECT_EQ(result.flatness_error_m > 0, bend_m > 0);
    EXPECT_LT(result.flatness_error_m, bend_m + 1e-9);
    EXPECT_EQ(result.assessment.reasons.front().find("--fix-target-geometry") !=
                  std::string::npos,
              bend_m > 0);
  }
}

TEST(Calibrate, KeepsBoardsRigidThatAreRigid) {
  const CalibrationResult result =
      Calibrate(SimulateDeformation(0).dataset, TestBoard(), WithCells(160));
  EXPECT_FALSE(result.bends.has_value());
}

// One camera's errors in twelve images: by so many pixels where boards may
// bend, and where they may not. They go up and down from image to image by a
// spread.
HeldOutResiduals HeldOutErrors(double flexed_px, double alone_px,
                               double spread_px = 0) {
  HeldOutResiduals errors = {{{}}, {}, {{}}};
  for (int image = 0; image < 12; ++image)
    for (int i = 0; i < 50; ++i) {
      const double spread = image % 2 ? spread_px : -spread_px;
      FeatureResidual residual;
      residual.image = "image_" + std::to_string(image);
      residual.column = i;
      residual.error_px = {flexed_px + spread / 4, 0};
      errors.with_deformation[0].push_back(residual);
      residual.error_px.x() = alone_px + spread;
      errors.alone[0].push_back(residual);
    }
  return errors;
}

TEST(IsDeformationBetter, WeighsGainsByWhatChanceMakesOfTheBoardsOwnBends) {
  const HeldOutResiduals rigid = HeldOutErrors(0.05, 0.1);
  // A loss of 2 % that the spread makes 0.3 deviations, and of 5 % in each
  // image.
  EXPECT_TRUE(IsDeformationBetter(HeldOutErrors(0.04, 0.1, 0.01), rigid));
  EXPECT_FALSE(IsDeformationBetter(HeldOutErrors(0.04, 0.105, 0.001), rigid));
  // A gain that is no more than chance.
  EXPECT_FALSE(IsDeformationBetter(HeldOutErrors(0.0495, 0.1, 0.02), rigid));
  EXPECT_FALSE(IsDeformationBetter(HeldOutErrors(0.051, 0.09, 0.001), rigid));
}

// The share in a camera that was adjusted with rigid boards, and whose cells
// follow the lens. Bends would take some of what coarser ones leave.
double ShareOf(double flex_m, int num_images = 16,
               size_t max_features = SIZE_MAX) {
  AdjustmentOptions options;
  options.num_threads = 2;
  Dataset dataset = SimulateDeformation(flex_m, num_images).dataset;
  for (ImageFeatures& image : dataset.images)
    if (image.features.size() > max_features)
      image.features.resize(max_features);
  AdjustmentResult adjusted = InitializeCamera(dataset, TestBoard(), options);
  OptimizeModel(TestBoard(), "central-generic", {40}, options, &adjusted);
  return ComputeDeformationShare(adjusted, 2);
}

// The camera was adjusted to the same noise, and has taken some of what bends
// would: -0.006 to -0.017 of 16 images, by their seed, half of that of 32.
TEST(ComputeDeformationShare, TellsBendsFromNoise) {
  EXPECT_NEAR(ShareOf(0, 32), 0, 0.01);
  EXPECT_GT(ShareOf(0.0004), 0.5);
}

TEST(ComputeDeformationShare, IsAllWhereViewsHaveTooFewFeaturesToTell) {
  EXPECT_EQ(ShareOf(0, 16, 17), 1);
}

// Half of the features tell how the boards are bent.
TEST(EvaluateWithDeformation, FindsTheNoiseWhereBoardsBend) {
  const SimulatedObservations seen = SimulateDeformation(0.0004);
  const SimulatedCamera camera = ExampleSimulatedCamera();
  const RigModel rig = {{&camera}, {Pose()}};
  const auto with_deformation =
      EvaluateWithDeformation(rig, {seen.dataset}, TestBoard(), 2).front();
  const Evaluation rigid = EvaluateCamera(camera, seen.dataset, TestBoard(), 2);
  EXPECT_GT(ComputeErrorMetrics(rigid.residuals).rms_px, 0.1);
  EXPECT_LT(ComputeErrorMetrics(with_deformation).rms_px,
            0.02 * std::sqrt(2) * 1.2);
  for (const FeatureResidual& residual : with_deformation)
    EXPECT_EQ((residual.column + residual.row) % 2, 1);
}

TEST(EvaluateWithDeformation, HasNothingOfBoardsThatAreNotFlat) {
  const Dataset dataset = SimulateDeformation(0).dataset;
  Pattern deep = TestBoard();
  for (size_t i = 0; i < deep.boards[0].points.size(); i += 2)
    deep.boards[0].points[i].z() = 0.05;
  const SimulatedCamera camera = ExampleSimulatedCamera();
  const RigModel rig = {{&camera}, {Pose()}};
  EXPECT_TRUE(EvaluateWithDeformation(rig, {dataset}, deep, 2).front().empty());
}

}  // namespace
}  // namespace raygrid
