#include "v4l2_capture.h"

#include <gtest/gtest.h>

#include <mutex>
#include <thread>

#include "fake_v4l2_source.h"

namespace raygrid {
namespace {

FrameInfo ReadInfo(FakeV4l2State* state) {
  FakeV4l2Device device(state);
  FrameInfo info = {};
  V4l2CaptureReader(&device).Read(&info);
  return info;
}

FakeV4l2State::Control Told(uint32_t id, long long minimum, long long value) {
  return {id, V4L2_CTRL_TYPE_INTEGER, "", minimum, 500, 1, value, 0, {}};
}

TEST(V4l2Capture, OfADeviceThatTellsNothingNothingIsTold) {
  FakeV4l2State state;
  // These have no unit.
  state.controls = {Told(V4L2_CID_EXPOSURE, 1, 40), Told(V4L2_CID_GAIN, 0, 2),
                    Told(V4L2_CID_ANALOGUE_GAIN, 0, 2)};
  const FrameInfo info = ReadInfo(&state);
  EXPECT_FALSE(info.crop || info.zoom || info.orientation ||
               info.lens_position || info.focus_steps || info.exposure_us ||
               info.analogue_gain);
}

TEST(V4l2Capture, AFocusIsToldInSteps) {
  FakeV4l2State state;
  state.controls = {Told(V4L2_CID_FOCUS_ABSOLUTE, 0, 40)};
  EXPECT_EQ(ReadInfo(&state).focus_steps, 40);
  EXPECT_FALSE(ReadInfo(&state).lens_position);
}

TEST(V4l2Capture, AnExposureIsToldWhileItIsInEffect) {
  FakeV4l2State state;
  state.controls = {Told(V4L2_CID_EXPOSURE_ABSOLUTE, 1, 83)};
  EXPECT_EQ(ReadInfo(&state).exposure_us, 8300.0f);
  state.controls[0].flags = V4L2_CTRL_FLAG_INACTIVE;
  EXPECT_FALSE(ReadInfo(&state).exposure_us);
  state.controls[0].flags = V4L2_CTRL_FLAG_INACTIVE | V4L2_CTRL_FLAG_VOLATILE;
  EXPECT_EQ(ReadInfo(&state).exposure_us, 8300.0f);
  state.controls[0].value = 0;
  EXPECT_FALSE(ReadInfo(&state).exposure_us);
}

TEST(V4l2Capture, ZoomIsThatOverTheSmallest) {
  FakeV4l2State state;
  state.controls = {Told(V4L2_CID_ZOOM_ABSOLUTE, 100, 150)};
  EXPECT_EQ(ReadInfo(&state).zoom, 1.5);
  state.controls = {Told(V4L2_CID_ZOOM_ABSOLUTE, 0, 0)};
  EXPECT_EQ(ReadInfo(&state).zoom, 1.0);
  // A number that is no focal length tells no zoom.
  state.controls = {Told(V4L2_CID_ZOOM_ABSOLUTE, 0, 3)};
  EXPECT_FALSE(ReadInfo(&state).zoom);
  state.controls[0].minimum = -5;
  EXPECT_FALSE(ReadInfo(&state).zoom);
  state.controls[0].flags = V4L2_CTRL_FLAG_DISABLED;
  state.controls[0].value = -5;
  EXPECT_FALSE(ReadInfo(&state).zoom);
}

TEST(V4l2Capture, FlipsAndTurnsAreAnOrientation) {
  FakeV4l2State state;
  const auto read = [&](int flip_x, int flip_y, int degrees) {
    state.controls = {Told(V4L2_CID_HFLIP, 0, flip_x),
                      Told(V4L2_CID_VFLIP, 0, flip_y),
                      Told(V4L2_CID_ROTATE, 0, degrees)};
    return ReadInfo(&state).orientation.value_or(0);
  };
  EXPECT_EQ(read(0, 0, 0), 1);
  EXPECT_EQ(read(1, 0, 0), 2);
  EXPECT_EQ(read(0, 1, 0), 4);
  EXPECT_EQ(read(1, 1, 0), 3);
  EXPECT_EQ(read(0, 0, 180), 3);
  EXPECT_EQ(read(1, 1, 180), 1);
  EXPECT_EQ(read(0, 0, 90), 8);
  EXPECT_EQ(read(0, 0, 270), 6);
  EXPECT_EQ(read(0, 0, 45), 0);
}

TEST(V4l2Capture, FramesComeWithTheDriversCrop) {
  FakeV4l2State state;
  MakeGrey(&state);
  state.crop = {8, -4, 64, 48};
  state.controls = {Told(V4L2_CID_HFLIP, 0, 1)};
  state.events = {Frame(7, 1)};
  const auto source = Open(&state);
  EXPECT_TRUE(source->reports_crops());
  source->Start();
  const auto frame = source->Next(kSoon);
  ASSERT_TRUE(frame);
  ASSERT_TRUE(frame->info.crop);
  EXPECT_EQ(*frame->info.crop, (SensorCrop{8, -4, 64, 48}));
  EXPECT_EQ(frame->info.orientation, 2);
  EXPECT_EQ(frame->info.sequence, 1u);
  source->Release(*frame);
}

TEST(V4l2Capture, ACropIsAskedForAgainAfterASecond) {
  FakeV4l2State state;
  MakeGrey(&state);
  state.crop = {0, 0, 64, 48};
  state.events = {Frame(7, 1)};
  const auto source = Open(&state);
  source->Start();
  EXPECT_EQ(NextValue(source.get()), 7);
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  {
    const std::lock_guard<std::mutex> lock(state.mutex);
    state.crop = {16, 12, 32, 24};
    state.events = {Frame(8, 2)};
  }
  const auto frame = source->Next(kSoon);
  ASSERT_TRUE(frame);
  EXPECT_EQ(*frame->info.crop, (SensorCrop{16, 12, 32, 24}));
  source->Release(*frame);
}

}  // namespace
}  // namespace raygrid
