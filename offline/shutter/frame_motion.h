/// The motion of a board relative to the camera during the readout of a frame,
/// from its poses in neighbouring frames.
#ifndef RAYGRID_SHUTTER_FRAME_MOTION_H
#define RAYGRID_SHUTTER_FRAME_MOTION_H

#include <Eigen/Core>
#include <vector>

#include "camera/pose.h"

namespace raygrid {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Velocity in the parametrization of UpdatedPose(): rotation vector, then
/// translation, in camera axes.
struct FrameMotion {
  Vector6d velocity = Vector6d::Zero();      ///< rad/s, m/s
  Vector6d acceleration = Vector6d::Zero();  ///< rad/s^2, m/s^2
  /// Velocity from the nearest two frames instead of four. The difference
  /// indicates the interpolation error.
  Vector6d coarse_velocity = Vector6d::Zero();
  /// Deviation of the five poses from a cubic motion. A standard deviation of s
  /// seconds of timestamps results in a variance of (s velocity)^2.
  Vector6d unevenness = Vector6d::Zero();

  /// Extrapolates a pose by an interval in seconds.
  Pose PoseAfter(double seconds, const Pose& pose) const {
    return UpdatedPose(
        pose, seconds * velocity + seconds * seconds / 2 * acceleration);
  }
  Vector6d VelocityAt(double seconds) const {
    return velocity + seconds * acceleration;
  }
};

/// Computes the update from one pose to another, as in UpdatedPose().
Vector6d ComputeUpdate(const Pose& from, const Pose& to);

/// Five successive frames, and the one at which motion is evaluated.
struct MotionStencil {
  int first = 0;  ///< index of the first of five frames
  int frame = 0;
  /// Finite-difference coefficients for velocity and acceleration.
  Eigen::Matrix<double, 5, 1> velocity_coefficients, acceleration_coefficients,
      coarse_velocity_coefficients, unevenness_coefficients;

  /// Whether two of the frames are before this frame, and two after it.
  bool IsCentral() const { return frame == first + 2; }
};

/// Maximum interval between neighbouring frames.
constexpr double kMaxFrameGapS = 0.125;

/// Makes the stencils of frames with ascending times: one for each frame in a
/// sequence of at least five, with gaps of at most kMaxFrameGapS. Frames of
/// shorter sequences have none.
std::vector<MotionStencil> MakeStencils(const std::vector<double>& times_s);

/// Computes the motion at a stencil's frame: the derivatives of the quartic
/// through five poses, relative to the frame's.
FrameMotion ComputeMotion(const MotionStencil& stencil,
                          const std::vector<Pose>& poses);

}  // namespace raygrid

#endif  // RAYGRID_SHUTTER_FRAME_MOTION_H
