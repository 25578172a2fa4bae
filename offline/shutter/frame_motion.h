/// How a board moves before the camera while a frame is read, from where it
/// stood in the frames before and after.
#ifndef RAYGRID_SHUTTER_FRAME_MOTION_H
#define RAYGRID_SHUTTER_FRAME_MOTION_H

#include <Eigen/Core>
#include <vector>

#include "camera/pose.h"

namespace raygrid {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// A motion as UpdatedPose() takes it: rotation vector, then translation, in
/// the camera's axes.
struct FrameMotion {
  Vector6d velocity = Vector6d::Zero();      ///< rad/s, m/s
  Vector6d acceleration = Vector6d::Zero();  ///< rad/s^2, m/s^2
  /// The velocity by the nearest two frames instead of four. Their difference
  /// tells how far the motion is from what frames so far apart can follow.
  Vector6d coarse_velocity = Vector6d::Zero();
  /// By how much the five poses are not those of a motion of degree three. Time
  /// stamps that scatter by s seconds make its variance the square of s times
  /// the velocity.
  Vector6d unevenness = Vector6d::Zero();

  /// The pose so long after that of the frame.
  Pose After(double seconds, const Pose& pose) const {
    return UpdatedPose(
        pose, seconds * velocity + seconds * seconds / 2 * acceleration);
  }
  Vector6d VelocityAfter(double seconds) const {
    return velocity + seconds * acceleration;
  }
};

/// The update, as UpdatedPose() takes it, that leads from one pose to another.
Vector6d UpdateBetween(const Pose& from, const Pose& to);

/// Five frames in time, and one of them whose motion they tell.
struct MotionStencil {
  int first = 0;  ///< of five frames in a row
  int frame = 0;
  /// By which the poses of the five enter velocity and acceleration.
  Eigen::Matrix<double, 5, 1> by_velocity, by_acceleration, by_coarse_velocity,
      by_unevenness;

  /// Whether there are two frames before it and two behind.
  bool IsCentral() const { return frame == first + 2; }
};

/// Frames further apart are no neighbours.
constexpr double kMaxFrameGapS = 0.125;

/// The stencils of frames in the order of time, which grows: of all that have
/// four more in a row, each at most kMaxFrameGapS from the next one. Frames in
/// shorter rows have none.
std::vector<MotionStencil> MakeStencils(const std::vector<double>& times_s);

/// The motion at a stencil's frame: the polynomial of degree four through five
/// poses, seen from the frame's.
FrameMotion MotionAt(const MotionStencil& stencil,
                     const std::vector<Pose>& poses);

}  // namespace raygrid

#endif  // RAYGRID_SHUTTER_FRAME_MOTION_H
