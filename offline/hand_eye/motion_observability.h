#ifndef RAYGRID_HAND_EYE_MOTION_OBSERVABILITY_H
#define RAYGRID_HAND_EYE_MOTION_OBSERVABILITY_H

#include <Eigen/Core>
#include <string>
#include <vector>

#include "camera/pose.h"

namespace raygrid {

/// What the motion of a rigid body determines about the pose X of a sensor in
/// the body's frame, by A X = X B for relative motions A = (R, t) of the body
/// and B of the sensor. A rotation w and a translation v of X change the
/// equation by (Ad_A - I) (w, v): by (R - I) w and [t]x R w + (R - I) v. The
/// eigenvalues of the information matrix are given as RMS angles over pairs of
/// poses, in ascending order, with their axes (columns) in the body's frame:
/// for the position, and for the orientation, marginalized over the position.
struct MotionObservability {
  Eigen::Vector3d position_rad = Eigen::Vector3d::Zero();
  Eigen::Matrix3d position_axes = Eigen::Matrix3d::Identity();
  Eigen::Vector3d orientation_rad = Eigen::Vector3d::Zero();
  Eigen::Matrix3d orientation_axes = Eigen::Matrix3d::Identity();

  /// Whether the pose is determined: RMS angles of at least kMinRotationRad.
  bool IsDetermined() const;
};

/// @param body_from_world poses of the body
/// @param lever_m         distance at which a length corresponds to an angle
MotionObservability MeasureObservability(
    const std::vector<Pose>& body_from_world, double lever_m);

/// Describes the motion that is missing and the directions in which the pose of
/// the sensor is undetermined: "the rig rotates about one axis only, ...".
/// "" if the pose is determined.
struct MotionNames {
  std::string body, frame, sensor;  ///< "the rig", "camera a", "camera b"
};
std::string DescribeMissingMotion(const MotionObservability& observability,
                                  const MotionNames& names);

}  // namespace raygrid

#endif  // RAYGRID_HAND_EYE_MOTION_OBSERVABILITY_H
