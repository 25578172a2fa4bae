#ifndef RAYGRID_HAND_EYE_HAND_EYE_MODEL_H
#define RAYGRID_HAND_EYE_HAND_EYE_MODEL_H

#include <Eigen/Core>
#include <string>
#include <vector>

#include "dataset/target_pose.h"

namespace raygrid {

/// Where the camera is mounted: on the gripper, with the target fixed to the
/// robot's base, or fixed to the base, with the target in the gripper.
enum class Mounting { kEyeInHand, kEyeToHand };

/// A pose of the target relative to the camera, and the pose that the robot
/// reported.
struct HandEyeObservation {
  std::string image;
  Pose camera_from_target;
  /// Covariance of the update of UpdatedPose(), as of TargetPose.
  PoseCovariance covariance = PoseCovariance::Identity();
  Pose base_from_gripper;
  /// Variance of a feature's coordinate (px^2) and number of features, which
  /// relate the covariance to reprojection errors.
  double feature_variance = 0;
  int num_features = 0;
};

/// Standard deviation per axis of the poses that the robot reports: of the
/// gripper's orientation (rad) and of its position in the base's frame (m).
struct RobotNoise {
  double rotation_rad = 0, translation_m = 0;
};

/// The two constant transformations. The mount is what carries the camera, and
/// the anchor is what carries the target:
///   camera_from_target = camera_from_mount * mount_from_anchor *
///                        anchor_from_target
/// In the eye-in-hand case, the mount is the gripper and the anchor the base;
/// in the eye-to-hand case, it is the other way round.
struct HandEye {
  Pose camera_from_mount, anchor_from_target;
};

/// Returns mount_from_anchor of a robot's pose.
Pose MountFromAnchor(Mounting mounting, const Pose& base_from_gripper);

/// Returns the predicted camera_from_target.
Pose PredictTargetPose(const HandEye& hand_eye, Mounting mounting,
                       const Pose& base_from_gripper);

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix12d = Eigen::Matrix<double, 12, 12>;
using Vector12d = Eigen::Matrix<double, 12, 1>;

/// Returns the update of UpdatedPose() that turns a pose into another one.
Vector6d PoseDifference(const Pose& from, const Pose& to);

/// The observed minus the predicted pose of one observation, as the update of
/// UpdatedPose(), and the Jacobians of the prediction.
struct LinearizedHandEye {
  Vector6d error;
  /// With respect to the updates of camera_from_mount and anchor_from_target.
  Eigen::Matrix<double, 6, 12> J_hand_eye;
  /// With respect to the robot's pose: rotation and translation.
  Eigen::Matrix<double, 6, 3> J_rotation, J_translation;
  /// With respect to the scale of the robot's lengths.
  Vector6d J_scale;
};
LinearizedHandEye LinearizeHandEye(const HandEye& hand_eye, Mounting mounting,
                                   const HandEyeObservation& observation);

/// Returns the covariance of the error: that of the target's pose and that
/// which follows from the robot's noise.
PoseCovariance ErrorCovariance(const LinearizedHandEye& linear,
                               const PoseCovariance& camera_covariance,
                               const RobotNoise& noise);

/// Returns the covariance of a pose's inverse, both of the update of
/// UpdatedPose().
PoseCovariance InverseCovariance(const Pose& pose,
                                 const PoseCovariance& covariance);

/// Returns the names of camera_from_mount and anchor_from_target, such as
/// "camera_from_gripper" and "base_from_target", and of the mount and the
/// anchor.
struct HandEyeNames {
  std::string camera_from_mount, mount_from_camera, anchor_from_target;
  std::string mount, anchor;
};
HandEyeNames GetFrameNames(Mounting mounting);

}  // namespace raygrid

#endif  // RAYGRID_HAND_EYE_HAND_EYE_MODEL_H
