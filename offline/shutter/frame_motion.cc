#include "shutter/frame_motion.h"

#include <Eigen/LU>
#include <algorithm>

namespace raygrid {
namespace {

constexpr int kFrames = 5;

MotionStencil MakeStencil(const std::vector<double>& times_s, int first,
                          int frame) {
  MotionStencil stencil;
  stencil.first = first;
  stencil.frame = frame;
  const double step_s = (times_s[first + kFrames - 1] - times_s[first]) / 4;
  Eigen::Matrix<double, kFrames, kFrames> powers;
  for (int j = 0; j < kFrames; ++j) {
    const double t = (times_s[first + j] - times_s[frame]) / step_s;
    powers.row(j) << 1, t, t * t, t * t * t, t * t * t * t;
  }
  // The inverse maps values at the frame times to polynomial coefficients.
  const Eigen::Matrix<double, kFrames, kFrames> inverse = powers.inverse();
  stencil.velocity_coefficients = inverse.row(1).transpose() / step_s;
  stencil.acceleration_coefficients =
      2 * inverse.row(2).transpose() / (step_s * step_s);
  stencil.unevenness_coefficients = inverse.row(4).transpose().normalized();
  stencil.coarse_velocity_coefficients.setZero();
  if (!stencil.IsCentral()) return stencil;
  const double before = times_s[frame] - times_s[frame - 1];
  const double behind = times_s[frame + 1] - times_s[frame];
  stencil.coarse_velocity_coefficients[1] =
      -behind / (before * (before + behind));
  stencil.coarse_velocity_coefficients[3] =
      before / (behind * (before + behind));
  return stencil;
}

}  // namespace

Vector6d ComputeUpdate(const Pose& from, const Pose& to) {
  const Eigen::AngleAxisd turn(to.rotation * from.rotation.conjugate());
  Vector6d update;
  update << turn.angle() * turn.axis(), to.translation - from.translation;
  return update;
}

std::vector<MotionStencil> MakeStencils(const std::vector<double>& times_s) {
  std::vector<MotionStencil> stencils;
  const int count = static_cast<int>(times_s.size());
  for (int begin = 0, end; begin < count; begin = end) {
    for (end = begin + 1;
         end < count && times_s[end] - times_s[end - 1] <= kMaxFrameGapS;)
      ++end;
    if (end - begin < kFrames) continue;
    for (int frame = begin; frame < end; ++frame)
      stencils.push_back(MakeStencil(
          times_s, std::clamp(frame - 2, begin, end - kFrames), frame));
  }
  return stencils;
}

FrameMotion ComputeMotion(const MotionStencil& stencil,
                          const std::vector<Pose>& poses) {
  FrameMotion motion;
  for (int j = 0; j < kFrames; ++j) {
    const Vector6d update =
        ComputeUpdate(poses[stencil.frame], poses[stencil.first + j]);
    motion.velocity += stencil.velocity_coefficients[j] * update;
    motion.acceleration += stencil.acceleration_coefficients[j] * update;
    motion.coarse_velocity += stencil.coarse_velocity_coefficients[j] * update;
    motion.unevenness += stencil.unevenness_coefficients[j] * update;
  }
  return motion;
}

}  // namespace raygrid
