#include "shutter/frame_motion.h"

#include <cmath>

#include "support.h"

namespace raygrid {
namespace {

// Polynomials of the fourth degree in time.
Pose PoseAt(double t) {
  return {RotationFromVector({0.3 * t, 0, 0}),
          {1 + 2 * t - t * t * t, t * t, 3 - t * t * t * t}};
}

TEST(FrameMotion, OfAPolynomialIsExact) {
  const std::vector<double> times_s = {1, 1.03, 1.07, 1.1, 1.13, 1.2, 1.22};
  std::vector<Pose> poses;
  for (const double t : times_s) poses.push_back(PoseAt(t));
  const auto stencils = MakeStencils(times_s);
  ASSERT_EQ(stencils.size(), times_s.size());
  for (const MotionStencil& stencil : stencils) {
    const FrameMotion motion = ComputeMotion(stencil, poses);
    const double t = times_s[stencil.frame];
    EXPECT_EQ(stencil.IsCentral(), stencil.frame >= 2 && stencil.frame <= 4);
    EXPECT_NEAR(motion.velocity[0], 0.3, 1e-9);
    EXPECT_NEAR(motion.velocity[3], 2 - 3 * t * t, 1e-9);
    EXPECT_NEAR(motion.velocity[5], -4 * t * t * t, 1e-9);
    EXPECT_NEAR(motion.acceleration[4], 2, 1e-7);
    EXPECT_NEAR(motion.acceleration[5], -12 * t * t, 1e-7);
    const Pose later = motion.PoseAfter(0.01, PoseAt(t));
    EXPECT_LT((later.translation - PoseAt(t + 0.01).translation).norm(), 1e-5);
  }
}

TEST(FrameMotion, FramesFarApartAreNoNeighbours) {
  EXPECT_TRUE(MakeStencils({}).empty());
  EXPECT_TRUE(MakeStencils({0, 0.03, 0.06, 0.09}).empty());
  EXPECT_TRUE(MakeStencils({0, 1, 2, 3, 4, 5}).empty());
  const auto stencils = MakeStencils(
      {0, 0.03, 0.06, 0.5, 0.53, 0.56, 0.6, 0.63, 2, 2.03, 2.06, 2.1});
  ASSERT_EQ(stencils.size(), 5u);
  for (const MotionStencil& stencil : stencils) EXPECT_EQ(stencil.first, 3);
}

TEST(FrameMotion, TwoNeighboursSeeALineAsFourDo) {
  std::vector<Pose> poses(5);
  const std::vector<double> times_s = {0, 0.02, 0.05, 0.06, 0.1};
  for (size_t i = 0; i < poses.size(); ++i)
    poses[i].translation = Eigen::Vector3d(1, 2, 3) * times_s[i];
  const FrameMotion motion = ComputeMotion(MakeStencils(times_s)[2], poses);
  EXPECT_LT((motion.velocity - motion.coarse_velocity).norm(), 1e-9);
}

}  // namespace
}  // namespace raygrid
