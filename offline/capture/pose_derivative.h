#ifndef RAYGRID_CAPTURE_POSE_DERIVATIVE_H
#define RAYGRID_CAPTURE_POSE_DERIVATIVE_H

#include <Eigen/Core>

namespace raygrid {

using MotionMatrix = Eigen::Matrix<double, 6, 6>;

/// The matrix of v -> vector x v.
inline Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& vector) {
  Eigen::Matrix3d cross;
  cross << 0, -vector.z(), vector.y(),  //
      vector.z(), 0, -vector.x(),       //
      -vector.y(), vector.x(), 0;
  return cross;
}

/// How a point moves, by the small rotation (radians) and translation (metres)
/// of all that stands before the camera: point -> point + rotation x point +
/// translation. Three rows, six columns.
inline Eigen::Matrix<double, 3, 6> PointByMotion(const Eigen::Vector3d& point) {
  Eigen::Matrix<double, 3, 6> by_motion;
  by_motion << -CrossMatrix(point), Eigen::Matrix3d::Identity();
  return by_motion;
}

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_POSE_DERIVATIVE_H
