#ifndef RAYGRID_CAMERA_POSE_H
#define RAYGRID_CAMERA_POSE_H

#include <Eigen/Geometry>

namespace raygrid {

/// Rigid transformation, named b_from_a: point_b = b_from_a * point_a.
struct Pose {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const {
    return rotation * point + translation;
  }
  /// Returns c_from_a = c_from_b * b_from_a.
  Pose operator*(const Pose& b_from_a) const {
    return {(rotation * b_from_a.rotation).normalized(),
            rotation * b_from_a.translation + translation};
  }
  /// Returns a_from_b.
  Pose Inverse() const {
    const Eigen::Quaterniond back = rotation.conjugate();
    return {back, -(back * translation)};
  }
};

/// Returns the rotation of an axis-angle vector.
inline Eigen::Quaterniond RotationFromVector(const Eigen::Vector3d& vector) {
  const double angle = vector.norm();
  if (angle < 1e-12)
    return Eigen::Quaterniond(1, vector.x() / 2, vector.y() / 2, vector.z() / 2)
        .normalized();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, vector / angle));
}

/// Returns the pose after a local update (rotation vector, translation) on the
/// left of the rotation: point -> exp(update[0..2]) R point + t + update[3..5].
inline Pose UpdatedPose(const Pose& pose,
                        const Eigen::Matrix<double, 6, 1>& update) {
  return {(RotationFromVector(update.head<3>()) * pose.rotation).normalized(),
          pose.translation + update.tail<3>()};
}

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_POSE_H
