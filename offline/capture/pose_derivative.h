#ifndef RAYGRID_CAPTURE_POSE_DERIVATIVE_H
#define RAYGRID_CAPTURE_POSE_DERIVATIVE_H

#include <Eigen/Core>

namespace raygrid {

using MotionMatrix = Eigen::Matrix<double, 6, 6>;

/// Returns the skew-symmetric matrix of v -> vector x v.
inline Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& vector) {
  Eigen::Matrix3d cross;
  cross << 0, -vector.z(), vector.y(),  //
      vector.z(), 0, -vector.x(),       //
      -vector.y(), vector.x(), 0;
  return cross;
}

/// Computes the Jacobian of a point with respect to a small rotation (radians)
/// and translation (metres) in camera axes: point -> point + rotation x point +
/// translation. Three rows, six columns.
inline Eigen::Matrix<double, 3, 6> ComputePointJacobian(
    const Eigen::Vector3d& point) {
  Eigen::Matrix<double, 3, 6> J_motion;
  J_motion << -CrossMatrix(point), Eigen::Matrix3d::Identity();
  return J_motion;
}

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_POSE_DERIVATIVE_H
