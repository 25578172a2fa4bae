// Rigs whose cameras are known, with known truth.

#include <cmath>

#include "calibration/calibration.h"
#include "camera/fixed_camera.h"
#include "simulation/simulated_rig.h"
#include "support.h"
#include "test_boards.h"

namespace raygrid {
namespace {

SimulatedRigObservations SeenBy(const SimulatedRig& rig, int num_images,
                                int num_features, uint64_t seed = 1) {
  SimulationOptions options;
  options.num_images = num_images;
  options.features_per_image = num_features;
  options.seed = seed;
  return SimulateRig(rig, TestBoard(), options);
}

// Three cameras, of which the outer two have the smallest overlap.
SimulatedRig ThreeCameras() {
  const auto lens = std::make_shared<OpenCvModel>(ExampleLens());
  return {{lens, lens, lens},
          {{},
           {RotationFromVector({0.02, -0.15, 0.05}), {-0.12, 0.01, 0.03}},
           {RotationFromVector({0.01, -0.3, -0.02}), {-0.25, 0, 0.06}}}};
}

SimulatedRig TwoCameras() {
  SimulatedRig rig = ThreeCameras();
  rig.cameras.pop_back();
  rig.camera_from_rig.pop_back();
  return rig;
}

std::vector<CalibrationInput> InputsOf(const SimulatedRig& rig,
                                       const SimulatedRigObservations& seen,
                                       const std::vector<bool>& are_known) {
  const char* names[] = {"left", "right", "rear"};
  std::vector<CalibrationInput> inputs;
  for (size_t c = 0; c < seen.datasets.size(); ++c) {
    inputs.push_back({names[c], seen.datasets[c]});
    if (!are_known[c]) continue;
    CameraFile file;
    file.name = "of another rig";
    file.camera = rig.cameras[c];
    inputs.back().intrinsics = std::make_shared<CameraFile>(file);
  }
  return inputs;
}

// Holds one frame out, which is cheaper than a cross-validation.
CalibrationOptions HoldingOut(const SimulatedRigObservations& seen) {
  CalibrationOptions options;
  options.model = "opencv";
  options.num_threads = 2;
  options.hold_out = {seen.datasets[0].images.front().image};
  return options;
}

// The update of UpdatedPose() from an estimate to the truth.
Eigen::Matrix<double, 6, 1> ErrorOf(const RigResult& result,
                                    const SimulatedRig& truth,
                                    const Baseline& pair) {
  const auto relative = [&](const std::vector<Pose>& camera_from_rig) {
    return camera_from_rig[pair.second] * camera_from_rig[pair.first].Inverse();
  };
  const Pose found = relative(result.camera_from_rig),
             expected = relative(truth.camera_from_rig);
  const Eigen::AngleAxisd turn(expected.rotation * found.rotation.conjugate());
  Eigen::Matrix<double, 6, 1> error;
  error << turn.angle() * turn.axis(), expected.translation - found.translation;
  return error;
}

TEST(FixedCamera, ProjectsAsTheCameraWithoutParameters) {
  const OpenCvModel lens = ExampleLens();
  const NonCentralGeneric lines = ExampleLines();
  for (const CameraModel* camera : {static_cast<const CameraModel*>(&lens),
                                    static_cast<const CameraModel*>(&lines)}) {
    const std::unique_ptr<CameraModel> fixed = FixedCamera(*camera).Clone();
    EXPECT_TRUE(IsFixed(*fixed));
    EXPECT_FALSE(IsFixed(*camera));
    EXPECT_EQ(fixed->NumParameters(), 0);
    EXPECT_EQ(fixed->IsCentral(), camera->IsCentral());
    const auto line = camera->Line(camera->area().center());
    const Eigen::Vector3d point = line->origin + line->direction;
    EXPECT_EQ(*fixed->Project(point), *camera->Project(point));
    LinearizedProjection own, given;
    ASSERT_TRUE(fixed->Linearize(point, nullptr, 0, &own));
    ASSERT_TRUE(camera->Linearize(point, nullptr, 0, &given));
    EXPECT_EQ(own.J_point, given.J_point);
    EXPECT_EQ(own.num_nodes + own.num_global, 0);
  }
}

TEST(KnownIntrinsics, ImproveTheRelativePose) {
  const SimulatedRig rig = TwoCameras();
  const SimulatedRigObservations seen = SeenBy(rig, 8, 80);
  const RigResult joint = Calibrate(InputsOf(rig, seen, {false, false}),
                                    TestBoard(), HoldingOut(seen));
  const RigResult known = Calibrate(InputsOf(rig, seen, {true, true}),
                                    TestBoard(), HoldingOut(seen));
  for (size_t c = 0; c < 2; ++c) {
    const CalibrationResult& camera = known.cameras[c];
    EXPECT_EQ(camera.camera.camera, rig.cameras[c]);
    EXPECT_EQ(camera.camera.name, c == 0 ? "left" : "right");
    EXPECT_TRUE(camera.has_known_intrinsics);
    EXPECT_EQ(camera.num_parameters, 0);
    EXPECT_FALSE(camera.held_out.empty());
  }
  EXPECT_TRUE(known.converged);
  EXPECT_NE(known.assessment.word, "fail");
  EXPECT_NEAR(ComputeTrainingMetrics(known).rms_px, 0.05 * std::sqrt(2), 0.01);
  const Baseline &of_joint = joint.baselines[0], &of_known = known.baselines[0];
  EXPECT_LT(*of_known.rotation_stddev_rad, 0.6 * *of_joint.rotation_stddev_rad);
  EXPECT_LT(ErrorOf(known, rig, of_known).head<3>().norm(),
            4 * *of_known.rotation_stddev_rad);
}

// Sums of squares over seeds, in units of the stated covariances: of pairs with
// and without the first camera, which is the rig's frame.
TEST(KnownIntrinsics, CovariancesOfRelativePosesAreThoseOfTheErrors) {
  constexpr int kSeeds = 8, kPairs = 3;
  const SimulatedRig rig = ThreeCameras();
  double squares[kPairs] = {}, distances = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const SimulatedRigObservations seen =
        SeenBy(rig, 10, 60, static_cast<uint64_t>(seed));
    CalibrationOptions options = HoldingOut(seen);
    options.fix_target_geometry = seed % 2 == 0;
    const RigResult result = Calibrate(InputsOf(rig, seen, {true, true, true}),
                                       TestBoard(), options);
    ASSERT_EQ(result.baselines.size(), kPairs);
    for (int k = 0; k < kPairs; ++k) {
      const Baseline& pair = result.baselines[k];
      ASSERT_TRUE(pair.covariance);
      const Eigen::Matrix<double, 6, 1> error = ErrorOf(result, rig, pair);
      squares[k] += error.dot(pair.covariance->ldlt().solve(error));
      EXPECT_NEAR(pair.covariance->diagonal().head<3>().sum(),
                  std::pow(*pair.rotation_stddev_rad, 2), 1e-15);
      const double true_m = (rig.camera_from_rig[pair.second] *
                             rig.camera_from_rig[pair.first].Inverse())
                                .translation.norm();
      distances +=
          std::pow((pair.distance_m - true_m) / *pair.distance_stddev_m, 2);
    }
  }
  for (const double sum : squares) {  // chi^2 of 48 degrees of freedom, 99.99 %
    EXPECT_GT(sum, 20);
    EXPECT_LT(sum, 95);
  }
  EXPECT_GT(distances, 6);
  EXPECT_LT(distances, 60);
}

TEST(KnownIntrinsics, OfOneCameraStayWhileTheOtherIsEstimated) {
  const SimulatedRig rig = TwoCameras();
  const SimulatedRigObservations seen = SeenBy(rig, 8, 80);
  CalibrationOptions options = HoldingOut(seen);
  options.model = "central-generic";
  options.knot_spacing_px = 213;
  options.fix_target_geometry = true;
  const RigResult result =
      Calibrate(InputsOf(rig, seen, {false, true}), TestBoard(), options);
  EXPECT_EQ(result.cameras[1].camera.camera, rig.cameras[1]);
  EXPECT_FALSE(result.cameras[0].has_known_intrinsics);
  EXPECT_EQ(result.cameras[0].camera.camera->Name(), options.model);
  EXPECT_GT(result.cameras[0].num_parameters, 0);
  EXPECT_TRUE(result.cameras[0].camera.uncertainty);
  EXPECT_NEAR(ComputeTrainingMetrics(result).rms_px, 0.05 * std::sqrt(2), 0.01);
  EXPECT_LT(std::abs(result.baselines[0].distance_m -
                     rig.camera_from_rig[1].translation.norm()),
            4 * *result.baselines[0].distance_stddev_m);
}

TEST(KnownIntrinsics, OfTheWrongCameraAreReported) {
  const SimulatedRig rig = TwoCameras();
  const SimulatedRigObservations seen = SeenBy(rig, 10, 60);
  std::vector<CalibrationInput> inputs = InputsOf(rig, seen, {true, true});
  CameraFile other = *inputs[1].intrinsics;
  auto shifted = rig.cameras[1]->Clone();
  Eigen::VectorXd parameters = shifted->Parameters();
  parameters[0] *= 1.02;
  parameters[1] *= 1.02;
  shifted->SetParameters(parameters);
  other.camera = std::move(shifted);
  inputs[1].intrinsics = std::make_shared<CameraFile>(other);
  const RigResult result = Calibrate(inputs, TestBoard(), HoldingOut(seen));
  EXPECT_NE(result.assessment.word, "pass");
}

TEST(KnownIntrinsics, AreForImagesOfTheSameSize) {
  const SimulatedRig rig = TwoCameras();
  const SimulatedRigObservations seen = SeenBy(rig, 4, 60);
  std::vector<CalibrationInput> inputs = InputsOf(rig, seen, {true, true});
  inputs[1].dataset.image_size.width += 1;
  ExpectError(ExitCode::kUsage, {"right", "known intrinsics"},
              [&] { Calibrate(inputs, TestBoard(), CalibrationOptions()); });
}

}  // namespace
}  // namespace raygrid
