#include "hand_eye/hand_eye_model.h"

namespace raygrid {
namespace {

Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

}  // namespace

Pose MountFromAnchor(Mounting mounting, const Pose& base_from_gripper) {
  return mounting == Mounting::kEyeInHand ? base_from_gripper.Inverse()
                                          : base_from_gripper;
}

Pose PredictTargetPose(const HandEye& hand_eye, Mounting mounting,
                       const Pose& base_from_gripper) {
  return hand_eye.camera_from_mount *
         MountFromAnchor(mounting, base_from_gripper) *
         hand_eye.anchor_from_target;
}

Vector6d PoseDifference(const Pose& from, const Pose& to) {
  const Eigen::AngleAxisd turn(to.rotation * from.rotation.conjugate());
  Vector6d difference;
  difference << turn.angle() * turn.axis(), to.translation - from.translation;
  return difference;
}

LinearizedHandEye LinearizeHandEye(const HandEye& hand_eye, Mounting mounting,
                                   const HandEyeObservation& observation) {
  const Pose& robot = observation.base_from_gripper;
  const Pose mount_from_anchor = MountFromAnchor(mounting, robot);
  const Pose& target = hand_eye.anchor_from_target;
  const Pose predicted =
      hand_eye.camera_from_mount * mount_from_anchor * target;
  const Eigen::Matrix3d R_mount =
      hand_eye.camera_from_mount.rotation.toRotationMatrix();
  const Eigen::Matrix3d R_anchor =
      R_mount * mount_from_anchor.rotation.toRotationMatrix();

  LinearizedHandEye linear;
  linear.error = PoseDifference(predicted, observation.camera_from_target);
  auto& J = linear.J_hand_eye;
  J.setZero();
  J.block<3, 3>(0, 0).setIdentity();
  J.block<3, 3>(3, 0) = -CrossMatrix(predicted.translation -
                                     hand_eye.camera_from_mount.translation);
  J.block<3, 3>(3, 3).setIdentity();
  J.block<3, 3>(0, 6) = J.block<3, 3>(3, 9) = R_anchor;
  linear.J_translation.setZero();
  linear.J_scale.setZero();
  if (mounting == Mounting::kEyeInHand) {
    linear.J_rotation << -R_anchor,
        R_anchor * CrossMatrix(target.translation - robot.translation);
    linear.J_translation.bottomRows<3>() = -R_anchor;
  } else {
    linear.J_rotation << R_mount,
        -R_mount * CrossMatrix(robot.rotation * target.translation);
    linear.J_translation.bottomRows<3>() = R_mount;
  }
  linear.J_scale = linear.J_translation * robot.translation;
  return linear;
}

PoseCovariance ErrorCovariance(const LinearizedHandEye& linear,
                               const PoseCovariance& camera_covariance,
                               const RobotNoise& noise) {
  return camera_covariance +
         noise.rotation_rad * noise.rotation_rad * linear.J_rotation *
             linear.J_rotation.transpose() +
         noise.translation_m * noise.translation_m * linear.J_translation *
             linear.J_translation.transpose();
}

PoseCovariance InverseCovariance(const Pose& pose,
                                 const PoseCovariance& covariance) {
  const Eigen::Matrix3d back = pose.rotation.conjugate().toRotationMatrix();
  PoseCovariance J = PoseCovariance::Zero();
  J.topLeftCorner<3, 3>() = J.bottomRightCorner<3, 3>() = -back;
  J.bottomLeftCorner<3, 3>() = -back * CrossMatrix(pose.translation);
  return J * covariance * J.transpose();
}

HandEyeNames GetFrameNames(Mounting mounting) {
  if (mounting == Mounting::kEyeInHand)
    return {"camera_from_gripper", "gripper_from_camera", "base_from_target",
            "gripper", "base"};
  return {"camera_from_base", "base_from_camera", "gripper_from_target", "base",
          "gripper"};
}

}  // namespace raygrid
