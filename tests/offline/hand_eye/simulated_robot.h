// Robots with a camera, whose poses have known noise.
#ifndef RAYGRID_TESTS_OFFLINE_HAND_EYE_SIMULATED_ROBOT_H
#define RAYGRID_TESTS_OFFLINE_HAND_EYE_SIMULATED_ROBOT_H

#include <Eigen/Cholesky>
#include <string>
#include <vector>

#include "hand_eye/hand_eye_calibration.h"
#include "support.h"

namespace raygrid {

struct SimulatedRobotOptions {
  Mounting mounting = Mounting::kEyeInHand;
  int num_poses = 20;
  RobotNoise noise = {0.05 * M_PI / 180, 0.3e-3};
  /// Standard deviations of the target's poses: rotation and translation.
  double camera_rad = 3e-4, camera_m = 1e-4;
  /// Tilts of the target and its turn about its normal, either way.
  double tilt_rad = 0.6, turn_rad = 1;
  /// Tilt of all targets in one direction.
  double common_tilt_rad = 0;
};

struct SimulatedRobot {
  HandEye truth;
  std::vector<HandEyeObservation> observations;
};

inline Pose RandomPose(double range_m, TestRandom* random) {
  Pose pose;
  pose.rotation = RotationFromVector(random->NormalVector<3>());
  for (int k = 0; k < 3; ++k)
    pose.translation[k] = random->Uniform(-range_m, range_m);
  return pose;
}

/// The covariance of a target's pose: lateral translations are correlated with
/// rotations, and the distance is uncertain.
inline PoseCovariance CameraCovariance(const SimulatedRobotOptions& options) {
  PoseCovariance covariance = PoseCovariance::Zero();
  const double r = options.camera_rad, t = options.camera_m;
  covariance.diagonal() << r * r, r * r, r * r / 25, t * t, t * t, 9 * t * t;
  covariance(0, 4) = covariance(4, 0) = 0.7 * r * t;
  covariance(1, 3) = covariance(3, 1) = -0.7 * r * t;
  return covariance;
}

inline SimulatedRobot SimulateRobot(const SimulatedRobotOptions& options,
                                    unsigned seed) {
  TestRandom random(seed);
  SimulatedRobot robot;
  robot.truth = {RandomPose(0.1, &random), RandomPose(0.8, &random)};
  const PoseCovariance covariance = CameraCovariance(options);
  const PoseCovariance root = covariance.llt().matrixL();
  for (int k = 0; k < options.num_poses; ++k) {
    const double tilt = options.tilt_rad, turn = options.turn_rad;
    Pose target;
    target.rotation = RotationFromVector({options.common_tilt_rad, 0, 0}) *
                      RotationFromVector({random.Uniform(-tilt, tilt),
                                          random.Uniform(-tilt, tilt), 0}) *
                      RotationFromVector({0, 0, random.Uniform(-turn, turn)});
    target.translation = {random.Uniform(-0.1, 0.1), random.Uniform(-0.1, 0.1),
                          random.Uniform(0.35, 0.7)};
    const Pose mount_from_anchor = robot.truth.camera_from_mount.Inverse() *
                                   target *
                                   robot.truth.anchor_from_target.Inverse();
    Vector6d noise;
    noise << options.noise.rotation_rad * random.NormalVector<3>(),
        options.noise.translation_m * random.NormalVector<3>();
    HandEyeObservation& observation = robot.observations.emplace_back();
    observation.image = "im" + std::to_string(k) + ".png";
    observation.base_from_gripper = UpdatedPose(
        MountFromAnchor(options.mounting, mount_from_anchor), noise);
    observation.camera_from_target =
        UpdatedPose(target, root * random.NormalVector<6>());
    observation.covariance = covariance;
    observation.feature_variance = 0.01;
    observation.num_features = 88;
  }
  return robot;
}

/// The error of both transformations, as the update that corrects them.
inline Vector12d ErrorOf(const HandEye& estimate, const HandEye& truth) {
  Vector12d error;
  error << PoseDifference(estimate.camera_from_mount, truth.camera_from_mount),
      PoseDifference(estimate.anchor_from_target, truth.anchor_from_target);
  return error;
}

}  // namespace raygrid

#endif  // RAYGRID_TESTS_OFFLINE_HAND_EYE_SIMULATED_ROBOT_H
