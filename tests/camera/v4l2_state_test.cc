#include "v4l2_state.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <mutex>
#include <thread>

#include "fake_v4l2_source.h"

namespace raygrid {
namespace {

using Texts = std::vector<std::string>;
using Settings = std::vector<std::pair<uint32_t, int32_t>>;
using Control = FakeV4l2State::Control;

Control StateOf(uint32_t id, long long minimum, long long maximum,
                long long value) {
  return {id, V4L2_CTRL_TYPE_INTEGER, "", minimum, maximum, 1, value, 0, {}};
}

Control GovernedBy(uint32_t mode, long long manual, Control control) {
  control.mode = mode;
  control.manual = manual;
  return control;
}

// A USB camera whose modes are automatic.
void MakeAutomatic(FakeV4l2State* state) {
  MakeGrey(state);
  state->controls = {
      StateOf(V4L2_CID_AUTO_WHITE_BALANCE, 0, 1, 1),
      StateOf(V4L2_CID_GAIN, 0, 255, 64),
      GovernedBy(V4L2_CID_AUTO_WHITE_BALANCE, 0,
                 StateOf(V4L2_CID_WHITE_BALANCE_TEMPERATURE, 2000, 6500, 4600)),
      StateOf(V4L2_CID_EXPOSURE_AUTO, 0, 3, V4L2_EXPOSURE_APERTURE_PRIORITY),
      GovernedBy(V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL,
                 StateOf(V4L2_CID_EXPOSURE_ABSOLUTE, 3, 2047, 83)),
      GovernedBy(V4L2_CID_FOCUS_AUTO, 0,
                 StateOf(V4L2_CID_FOCUS_ABSOLUTE, 0, 250, 40)),
      StateOf(V4L2_CID_FOCUS_AUTO, 0, 1, 1)};
}

Control& ControlOf(FakeV4l2State* state, uint32_t id) {
  return *std::find_if(
      state->controls.begin(), state->controls.end(),
      [id](const Control& control) { return control.id == id; });
}

const Settings kManual = {{V4L2_CID_FOCUS_AUTO, 0},
                          {V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL},
                          {V4L2_CID_AUTO_WHITE_BALANCE, 0}};

TEST(V4l2State, AutomaticModesEndAndComeBack) {
  FakeV4l2State state;
  MakeAutomatic(&state);
  FakeV4l2Device device(&state);
  V4l2StateLock state_lock(&device);
  const StateLock lock = state_lock.Lock();
  EXPECT_EQ(lock.locked,
            (Texts{"focus at 40 (0 to 250)", "exposure 8.3 ms",
                   "gain at 64 (0 to 255)", "white balance 4600 K"}));
  EXPECT_EQ(lock.open, Texts());
  EXPECT_EQ(state.settings, kManual);
  // Locked again, nothing is set.
  EXPECT_EQ(state_lock.Lock().locked, lock.locked);
  EXPECT_EQ(state.settings, kManual);

  state.settings.clear();
  state_lock.Unlock();
  EXPECT_EQ(state.settings,
            (Settings{{V4L2_CID_AUTO_WHITE_BALANCE, 1},
                      {V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_APERTURE_PRIORITY},
                      {V4L2_CID_FOCUS_AUTO, 1}}));
  state.settings.clear();
  state_lock.Unlock();
  EXPECT_EQ(state.settings, Settings());
}

TEST(V4l2State, TheLensGoesBackToAFocusOfBefore) {
  for (const bool is_manual : {false, true}) {
    FakeV4l2State state;
    MakeAutomatic(&state);
    if (is_manual) ControlOf(&state, V4L2_CID_FOCUS_AUTO).value = 0;
    FakeV4l2Device device(&state);
    V4l2StateLock state_lock(&device);
    state_lock.FocusAt(47);
    EXPECT_EQ(state_lock.Lock().locked[0], "focus at 47 (0 to 250)");
    EXPECT_EQ(ControlOf(&state, V4L2_CID_FOCUS_ABSOLUTE).value, 47);
    state_lock.Unlock();
    EXPECT_EQ(ControlOf(&state, V4L2_CID_FOCUS_AUTO).value, is_manual ? 0 : 1);
    // A lens that nothing moves by itself is put back, too.
    if (is_manual) {
      EXPECT_EQ(ControlOf(&state, V4L2_CID_FOCUS_ABSOLUTE).value, 40);
    }
  }
}

TEST(V4l2State, ModesThatWereManualStaySo) {
  FakeV4l2State state;
  MakeAutomatic(&state);
  ControlOf(&state, V4L2_CID_FOCUS_AUTO).value = 0;
  ControlOf(&state, V4L2_CID_EXPOSURE_AUTO).value = V4L2_EXPOSURE_MANUAL;
  ControlOf(&state, V4L2_CID_AUTO_WHITE_BALANCE).value = 0;
  FakeV4l2Device device(&state);
  {
    V4l2StateLock state_lock(&device);
    EXPECT_EQ(state_lock.Lock().locked.size(), 4u);
  }
  EXPECT_EQ(state.settings, Settings());
}

TEST(V4l2State, WhatACameraRefusesStaysOpen) {
  FakeV4l2State state;
  MakeAutomatic(&state);
  ControlOf(&state, V4L2_CID_FOCUS_AUTO).error = EBUSY;
  ControlOf(&state, V4L2_CID_EXPOSURE_AUTO).is_stubborn = true;
  FakeV4l2Device device(&state);
  {
    V4l2StateLock state_lock(&device);
    const StateLock lock = state_lock.Lock();
    EXPECT_EQ(lock.locked, Texts{"white balance 4600 K"});
    EXPECT_EQ(
        lock.open,
        (Texts{
            "focus: cannot disable the automatic mode (Device or resource "
            "busy)",
            "exposure: cannot disable the automatic mode (Input/output error)",
            "gain: controlled by auto exposure"}));
  }
  EXPECT_EQ(ControlOf(&state, V4L2_CID_EXPOSURE_AUTO).value,
            V4L2_EXPOSURE_APERTURE_PRIORITY);
  EXPECT_EQ(ControlOf(&state, V4L2_CID_AUTO_WHITE_BALANCE).value, 1);
}

TEST(V4l2State, WhatThereIsNoControlForStaysOpen) {
  FakeV4l2State state;
  MakeGrey(&state);
  state.controls = {StateOf(V4L2_CID_EXPOSURE, 1, 1000, 500)};
  state.controls.push_back(StateOf(V4L2_CID_ANALOGUE_GAIN, 16, 160, 32));
  FakeV4l2Device device(&state);
  V4l2StateLock state_lock(&device);
  const StateLock lock = state_lock.Lock();
  EXPECT_EQ(lock.locked,
            (Texts{"exposure at 500 (1 to 1000)", "gain at 32 (16 to 160)"}));
  EXPECT_EQ(lock.open, (Texts{"focus: the camera has no control for it",
                              "white balance: the camera has no control for "
                              "it"}));
  // A mode alone.
  state.controls = {StateOf(V4L2_CID_FOCUS_AUTO, 0, 1, 1)};
  EXPECT_EQ(state_lock.Lock().locked,
            Texts{"focus at a value the camera does not report"});
  EXPECT_EQ(state.controls[0].value, 0);
}

TEST(V4l2State, ShutterPriorityFixesAnExposureToo) {
  FakeV4l2State state;
  MakeGrey(&state);
  state.controls = {
      StateOf(V4L2_CID_EXPOSURE_AUTO, 0, 3, V4L2_EXPOSURE_SHUTTER_PRIORITY),
      StateOf(V4L2_CID_EXPOSURE_ABSOLUTE, 3, 2047, 5)};
  state.controls[0].error = EINVAL;
  FakeV4l2Device device(&state);
  V4l2StateLock state_lock(&device);
  EXPECT_EQ(state_lock.Lock().locked, Texts{"exposure 0.50 ms"});
}

// Cameras may go to a value that was set before, as soon as a mode ends.
TEST(V4l2State, ValuesThatFollowTheModeAreKept) {
  FakeV4l2State state;
  MakeAutomatic(&state);
  Control& exposure = ControlOf(&state, V4L2_CID_EXPOSURE_ABSOLUTE);
  exposure.stored = 250;
  exposure.flags = V4L2_CTRL_FLAG_VOLATILE;
  Control& focus = ControlOf(&state, V4L2_CID_FOCUS_ABSOLUTE);
  focus.stored = 0;
  FakeV4l2Device device(&state);
  V4l2StateLock state_lock(&device);
  const StateLock lock = state_lock.Lock();
  EXPECT_EQ(exposure.value, 83);
  EXPECT_EQ(lock.locked[1], "exposure 8.3 ms");
  // The driver does not say that its value was in effect: it is not set.
  EXPECT_EQ(focus.value, 0);
  EXPECT_EQ(lock.locked[0], "focus at 0 (0 to 250)");
}

TEST(V4l2State, OfASourceIsLockedWhileFramesCome) {
  FakeV4l2State state;
  MakeAutomatic(&state);
  const auto source = Open(&state);
  EXPECT_EQ(source->LockState().open,
            MakeUnlockedState("no frame received yet").open);
  EXPECT_EQ(state.settings, Settings());
  const auto play = [&](uint8_t value) {
    const std::lock_guard<std::mutex> lock(state.mutex);
    state.events = {Frame(value, value)};
  };
  source->Start();
  play(1);
  const auto before = source->Next(kSoon);
  ASSERT_TRUE(before);
  EXPECT_FALSE(before->info.exposure_us);
  EXPECT_EQ(before->info.focus_steps, 40);
  source->Release(*before);

  EXPECT_EQ(source->LockState().locked.size(), 4u);
  play(2);
  const auto after = source->Next(kSoon);
  ASSERT_TRUE(after);
  EXPECT_EQ(after->info.exposure_us, 8300.0f);
  EXPECT_FALSE(after->info.analogue_gain);
  source->Release(*after);

  source->UnlockState();
  play(3);
  const auto unlocked = source->Next(kSoon);
  ASSERT_TRUE(unlocked);
  EXPECT_FALSE(unlocked->info.exposure_us);
  source->Release(*unlocked);

  source->LockState();
  source->Stop();
  EXPECT_EQ(ControlOf(&state, V4L2_CID_FOCUS_AUTO).value, 1);
  EXPECT_EQ(ControlOf(&state, V4L2_CID_EXPOSURE_AUTO).value,
            V4L2_EXPOSURE_APERTURE_PRIORITY);
  EXPECT_EQ(source->LockState().open,
            MakeUnlockedState("the stream has ended").open);
}

TEST(V4l2State, ARefusalEndsNoStream) {
  FakeV4l2State state;
  MakeAutomatic(&state);
  for (Control& control : state.controls) control.error = EIO;
  state.events = {Frame(1), Frame(2)};
  const auto source = Open(&state);
  source->Start();
  EXPECT_EQ(NextValue(source.get()), 1);
  EXPECT_EQ(source->LockState().open.size(), 4u);
  EXPECT_EQ(NextValue(source.get()), 2);
  EXPECT_EQ(source->fault(), "");
}

TEST(V4l2State, AnUnpluggedCameraLocksNothing) {
  FakeV4l2State state;
  MakeAutomatic(&state);
  state.events = {Frame(1), Failure(ENODEV)};
  const auto source = Open(&state);
  source->Start();
  EXPECT_EQ(NextValue(source.get()), 1);
  EXPECT_EQ(NextValue(source.get()), -1);
  EXPECT_EQ(source->LockState().locked, Texts());
}

TEST(V4l2State, IsLockedByAnyThreadWhileFramesAreTaken) {
  FakeV4l2State state;
  MakeAutomatic(&state);
  for (int i = 0; i < 2000; ++i)
    state.events.push_back(Frame(static_cast<uint8_t>(i), 0));
  const auto source = Open(&state);
  source->Start();
  std::atomic<bool> is_done{false};
  std::thread locking([&] {
    while (!is_done) {
      source->LockState();
      source->UnlockState();
    }
  });
  for (int i = 0; i < 2000; ++i) EXPECT_EQ(NextValue(source.get()), i % 256);
  is_done = true;
  locking.join();
  source->Stop();
  EXPECT_EQ(ControlOf(&state, V4L2_CID_FOCUS_AUTO).value, 1);
}

}  // namespace
}  // namespace raygrid
