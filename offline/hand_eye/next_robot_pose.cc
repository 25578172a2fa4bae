#include "hand_eye/next_robot_pose.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "hand_eye/linear_hand_eye.h"

namespace raygrid {
namespace {

constexpr double kRadians = M_PI / 180;

// Negative on one side of the target's plane, positive on the other one.
double GetSideSign(const Pose& camera_from_target) {
  return (camera_from_target.rotation * Eigen::Vector3d::UnitZ())
      .dot(camera_from_target.translation);
}

// The angle between the line of sight to the target and its normal.
double ComputeTilt(const Pose& camera_from_target) {
  const Eigen::Vector3d normal =
      camera_from_target.rotation * Eigen::Vector3d::UnitZ();
  const double cosine =
      std::abs(normal.dot(camera_from_target.translation.normalized()));
  return std::acos(std::min(cosine, 1.0));
}

double RotationStdDevFromCovariance(const Matrix12d& covariance) {
  return std::sqrt(covariance.topLeftCorner<3, 3>().trace());
}

double TranslationStdDevFromCovariance(const Matrix12d& covariance) {
  return std::sqrt(covariance.block<3, 3>(3, 3).trace());
}

// The robot's pose for a pose of the target.
Pose ComputeRobotPose(const HandEye& hand_eye, Mounting mounting,
                      const Pose& camera_from_target) {
  const Pose mount_from_anchor = hand_eye.camera_from_mount.Inverse() *
                                 camera_from_target *
                                 hand_eye.anchor_from_target.Inverse();
  return MountFromAnchor(mounting, mount_from_anchor);  // an involution
}

// The covariance with a further observation (Woodbury).
Matrix12d UpdateCovariance(const HandEyeFit& fit, Mounting mounting,
                           const HandEyeObservation& observation) {
  const LinearizedHandEye linear =
      LinearizeHandEye(fit.hand_eye, mounting, observation);
  const auto& J = linear.J_hand_eye;
  const PoseCovariance innovation =
      ErrorCovariance(linear, observation.covariance, fit.noise) +
      J * fit.covariance * J.transpose();
  const Eigen::Matrix<double, 6, 12> JC = J * fit.covariance;
  return fit.covariance - JC.transpose() * innovation.ldlt().solve(JC);
}

}  // namespace

std::optional<SuggestedPose> SuggestRobotPose(
    const std::vector<HandEyeObservation>& observations, Mounting mounting,
    const std::vector<int>& subset, const HandEyeFit& fit) {
  constexpr size_t kMaxSources = 30;
  constexpr double kAnglesRad[] = {20 * kRadians, -20 * kRadians,
                                   40 * kRadians, -40 * kRadians,
                                   90 * kRadians, -90 * kRadians};
  const double lever_m = MedianDistance(observations);
  double max_tilt = 45 * kRadians;
  for (const int i : subset)
    max_tilt =
        std::max(max_tilt, ComputeTilt(observations[i].camera_from_target));
  const auto cost = [&](const Matrix12d& covariance) {
    return std::pow(RotationStdDevFromCovariance(covariance), 2) +
           std::pow(TranslationStdDevFromCovariance(covariance) / lever_m, 2);
  };
  double least = cost(fit.covariance);
  std::optional<SuggestedPose> best;
  for (size_t k = 0; k < subset.size(); k += subset.size() / kMaxSources + 1)
    for (int axis = 0; axis < 3; ++axis)
      for (const double angle : kAnglesRad) {
        const HandEyeObservation& source = observations[subset[k]];
        HandEyeObservation next = source;
        next.camera_from_target = source.camera_from_target *
                                  Pose{Eigen::Quaterniond(Eigen::AngleAxisd(
                                           angle, Eigen::Vector3d::Unit(axis))),
                                       Eigen::Vector3d::Zero()};
        if (ComputeTilt(next.camera_from_target) > max_tilt ||
            GetSideSign(next.camera_from_target) *
                    GetSideSign(source.camera_from_target) <=
                0)
          continue;
        next.base_from_gripper =
            ComputeRobotPose(fit.hand_eye, mounting, next.camera_from_target);
        const Matrix12d covariance = UpdateCovariance(fit, mounting, next);
        if (!(cost(covariance) < least)) continue;
        least = cost(covariance);
        best = {next.base_from_gripper,
                source.image,
                "xyz"[axis],
                angle,
                RotationStdDevFromCovariance(fit.covariance),
                TranslationStdDevFromCovariance(fit.covariance),
                RotationStdDevFromCovariance(covariance),
                TranslationStdDevFromCovariance(covariance)};
      }
  return best;
}

}  // namespace raygrid
