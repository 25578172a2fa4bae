#include "operating_point_follower.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "camera_support.h"

namespace raygrid {
namespace {

rg_camera OpenStack() {
  rg_camera camera;
  EXPECT_EQ(rg_camera_open(&camera, kStackBlob, sizeof(kStackBlob)), RG_OK);
  return camera;
}

rg_ray RayOf(const rg_camera& camera) {
  rg_ray ray = {};
  EXPECT_EQ(rg_unproject(&camera, {RG_PIXEL(40), RG_PIXEL(30)}, &ray), RG_OK);
  return ray;
}

rg_ray RayAt(int32_t value_q16) {
  rg_camera camera = OpenStack();
  const rg_status status = rg_set_operating_point(&camera, value_q16);
  EXPECT_TRUE(status == RG_OK || status == RG_EXTRAPOLATED);
  return RayOf(camera);
}

bool IsSame(const rg_ray& a, const rg_ray& b) {
  return std::memcmp(&a, &b, sizeof(a)) == 0;
}

FrameInfo FrameAt(std::optional<float> lens_position) {
  FrameInfo info = {};
  info.lens_position = lens_position;
  return info;
}

// The golden stack reaches from -0.5 to 6.19 dioptres.
TEST(OperatingPointFollower, FollowsTheLensFrameByFrame) {
  rg_camera camera = OpenStack();
  OperatingPointFollower follower(&camera);
  EXPECT_FALSE(follower.is_idle());
  const rg_ray before = RayOf(camera);
  follower.Follow(FrameAt(5));
  EXPECT_TRUE(IsSame(RayOf(camera), RayAt(5 << 16)));
  EXPECT_FALSE(IsSame(RayOf(camera), before));
  follower.Follow(FrameAt(0.25f));
  EXPECT_TRUE(IsSame(RayOf(camera), RayAt(1 << 14)));
  EXPECT_EQ(follower.counts().num_missing + follower.counts().outside, 0u);
}

TEST(OperatingPointFollower, StaysWhereFramesDoNotTell) {
  rg_camera camera = OpenStack();
  OperatingPointFollower follower(&camera);
  follower.Follow(FrameAt(5));
  follower.Follow(FrameAt(std::nullopt));
  follower.Follow(FrameAt(NAN));
  EXPECT_TRUE(IsSame(RayOf(camera), RayAt(5 << 16)));
  EXPECT_EQ(follower.counts().num_missing, 2u);
}

TEST(OperatingPointFollower, TakesTheEndOfTheRangeBeyondIt) {
  rg_camera camera = OpenStack();
  OperatingPointFollower follower(&camera);
  follower.Follow(FrameAt(1e30f));
  EXPECT_TRUE(IsSame(RayOf(camera), RayAt(100 << 16)));
  EXPECT_EQ(follower.counts().outside, 1u);
}

TEST(OperatingPointFollower, LeavesOtherBlobsAlone) {
  rg_camera camera = OpenLens();
  OperatingPointFollower follower(&camera);
  EXPECT_TRUE(follower.is_idle());
  follower.Follow(FrameAt(3));
  EXPECT_EQ(follower.counts().num_missing, 0u);
}

}  // namespace
}  // namespace raygrid
