// Rigs whose cameras never share a view, with known truth.

#include <cmath>

#include "calibration/calibration.h"
#include "evaluation/rigid_target_text.h"
#include "hand_eye/motion_observability.h"
#include "simulation/simulated_camera_models.h"
#include "simulation/simulated_rig.h"
#include "support.h"

namespace raygrid {
namespace {

constexpr double kRightAngle = M_PI / 2;

Pattern BoardsAround(int count) {
  Pattern pattern = ChessboardPattern(8, 6, 0.03);
  for (int id = 1; id < count; ++id) {
    pattern.boards.push_back(pattern.boards.front());
    pattern.boards.back().id = id;
  }
  return pattern;
}

SimulatedRig Ring(int count, double turn_rad) {
  return MakeCameraRing(MakeSimulatedCamera("pinhole", {640, 480}), count, 0.1,
                        turn_rad);
}

SimulationOptions MovingFrames(int count) {
  SimulationOptions options;
  options.num_images = count;
  return options;
}

SimulatedRigObservations Observed(const SimulatedRig& rig,
                                  const RigMotion& motion = {}) {
  return SimulateRig(rig, BoardsAround(static_cast<int>(rig.cameras.size())),
                     motion, MovingFrames(40));
}

RigResult CalibrateKnown(const SimulatedRig& rig,
                         const SimulatedRigObservations& seen) {
  std::vector<CalibrationInput> inputs;
  for (size_t c = 0; c < rig.cameras.size(); ++c) {
    auto file = std::make_shared<CameraFile>();
    file->camera = rig.cameras[c];
    inputs.push_back({"cam" + std::to_string(c), seen.datasets[c]});
    inputs.back().intrinsics = file;
  }
  CalibrationOptions options;
  options.num_threads = 1;
  options.hold_out = {seen.datasets[0].images.front().image};
  return Calibrate(inputs, seen.true_pattern, options);
}

void ExpectUnconnected(const std::vector<std::string>& words,
                       const SimulatedRig& rig,
                       const SimulatedRigObservations& seen) {
  ExpectError(ExitCode::kInitializationFailed, words,
              [&] { CalibrateKnown(rig, seen); });
}

// Within the required accuracy, and within three standard deviations: the 99.7
// % quantile of chi-squared with six degrees of freedom.
void ExpectTruth(const RigResult& result, const SimulatedRig& truth) {
  constexpr double kMaxRotationRad = 0.02 * M_PI / 180, kMaxM = 0.5e-3,
                   kMaxSquared = 19.8;
  for (const Baseline& pair : result.baselines) {
    const auto relative = [&](const std::vector<Pose>& camera_from_rig) {
      return camera_from_rig[pair.second] *
             camera_from_rig[pair.first].Inverse();
    };
    const Pose found = relative(result.camera_from_rig),
               expected = relative(truth.camera_from_rig);
    const Eigen::AngleAxisd turn(expected.rotation *
                                 found.rotation.conjugate());
    Eigen::Matrix<double, 6, 1> error;
    error << turn.angle() * turn.axis(),
        expected.translation - found.translation;
    EXPECT_LT(error.head<3>().norm(), kMaxRotationRad);
    EXPECT_LT(error.tail<3>().norm(), kMaxM);
    ASSERT_TRUE(pair.covariance);
    EXPECT_LT(error.dot(pair.covariance->ldlt().solve(error)), kMaxSquared)
        << pair.first << " " << pair.second;
    EXPECT_LT(*pair.rotation_stddev_rad, kMaxRotationRad);
  }
}

void KeepImages(size_t first, size_t end, Dataset* dataset) {
  auto& images = dataset->images;
  images.erase(images.begin() + static_cast<std::ptrdiff_t>(end), images.end());
  images.erase(images.begin(),
               images.begin() + static_cast<std::ptrdiff_t>(first));
}

TEST(RigMotion, ConnectsCamerasBackToBack) {
  const SimulatedRig rig = Ring(2, M_PI);
  const RigResult result = CalibrateKnown(rig, Observed(rig));
  ExpectTruth(result, rig);
  EXPECT_NE(result.assessment.word, "fail");
  ASSERT_EQ(result.rigid_targets.size(), 1u);
  EXPECT_EQ(DescribeRigidTargets(result.rigid_targets, result.board_pairs),
            (std::vector<std::string>{
                "boards 0 and 1 are a rigid multi-board target, estimated as "
                "one body; boards that no camera observes together are assumed "
                "to be fixed"}));
}

TEST(RigMotion, ConnectsAChain) {
  const SimulatedRig rig = Ring(3, kRightAngle);
  SimulatedRigObservations seen = Observed(rig);
  KeepImages(0, 22, &seen.datasets[0]);
  KeepImages(18, 40, &seen.datasets[2]);
  ExpectTruth(CalibrateKnown(rig, seen), rig);
}

// The first and the last camera share views.
TEST(RigMotion, ConnectsGroupsOfCameras) {
  SimulatedRig rig = Ring(3, kRightAngle);
  rig.camera_from_rig[2] = {RotationFromVector({0.02, -0.15, 0.05}),
                            {-0.12, 0.01, 0.03}};
  ExpectTruth(CalibrateKnown(rig, Observed(rig)), rig);
}

TEST(RigMotion, NamesTheMissingMotion) {
  const SimulatedRig rig = Ring(2, kRightAngle);
  RigMotion motion;
  motion.rotation_rad = {0, 0.4, 0};
  ExpectUnconnected({"{cam0}, {cam1}", "39 common frames",
                     "rotates about one axis only, [0.00, 1.00, 0.00] in the "
                     "frame of camera cam0",
                     "position of camera cam1 along it is not determined"},
                    rig, Observed(rig, motion));
  motion.rotation_rad.setZero();
  ExpectUnconnected({"does not rotate", "(in all directions) is not", "20°"},
                    rig, Observed(rig, motion));
}

TEST(RigMotion, NamesBoardsThatMove) {
  const SimulatedRig rig = Ring(2, M_PI);
  SimulatedRigObservations seen = Observed(rig);
  auto& images = seen.datasets[1].images;
  for (size_t i = 0; i < images.size() / 2; ++i)
    std::swap(images[i].features, images[images.size() - 1 - i].features);
  ExpectUnconnected({"boards 0 and 1", "synchronized"}, rig, seen);
}

// A turntable leaves two directions of the pose open.
TEST(MotionObservability, OfOneAxisThroughThePose) {
  std::vector<Pose> poses;
  for (int k = 0; k < 10; ++k) {
    const Pose turn = {RotationFromVector({0, 0, 0.1 * k}), {0, 0, 0}};
    const Pose axis = {Eigen::Quaterniond::Identity(), {0.3, 0.1, 0}};
    poses.push_back(axis * turn * axis.Inverse());
  }
  const MotionObservability turntable = MeasureObservability(poses, 0.5);
  EXPECT_EQ(DescribeMissingMotion(turntable, {"the rig", "camera a",
                                              "camera "
                                              "b"}),
            "the rig rotates about one axis only, [0.00, 0.00, 1.00] in the "
            "frame of camera a, so the position of camera b along it and its "
            "orientation about it are not determined; add frames tilted by 20° "
            "or more about another axis");
  for (int k = 0; k < 10; ++k) poses[k].translation.x() += 0.05 * (k % 3);
  EXPECT_GT(MeasureObservability(poses, 0.5).orientation_rad[0], 0.02);
  for (int k = 0; k < 10; ++k)
    poses[k] = {Eigen::Quaterniond::Identity(), {0.1 * k, 0, 0}};
  const MotionObservability line = MeasureObservability(poses, 0.5);
  EXPECT_LT(line.position_rad[2], 1e-9);
  EXPECT_LT(line.orientation_rad[0], 1e-9);
  EXPECT_GT(line.orientation_rad[1], 0.05);
}

}  // namespace
}  // namespace raygrid
