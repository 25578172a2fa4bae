#include "libcamera_state.h"

#include <gtest/gtest.h>
#include <libcamera/control_ids.h>
#include <libcamera/version.h>

#include <utility>

namespace raygrid {
namespace {

namespace ids = libcamera::controls;
using libcamera::ControlIdMap;
using libcamera::ControlInfo;
using libcamera::ControlInfoMap;
using libcamera::ControlList;
using LockTexts = std::vector<std::string>;

// These are libcamera's own since 0.5.
#if LIBCAMERA_VERSION_MAJOR == 0 && LIBCAMERA_VERSION_MINOR < 4
const libcamera::ControlId kTimeMode(70001, "ExposureTimeMode",
                                     libcamera::ControlTypeInteger32),
    kGainMode(70002, "AnalogueGainMode", libcamera::ControlTypeInteger32);
#else
const libcamera::ControlId &kTimeMode = ids::ExposureTimeMode,
                           &kGainMode = ids::AnalogueGainMode;
#endif

ControlInfo Numbers(int32_t minimum, int32_t maximum) {
  return ControlInfo(minimum, maximum);
}

// Which exposes, focuses and balances by itself.
ControlInfoMap::Map AutomaticCamera() {
  return {{&ids::AfMode,
           ControlInfo(ids::AfModeValues, libcamera::ControlValue(
                                              int32_t{ids::AfModeContinuous}))},
          {&ids::LensPosition, ControlInfo(0.0f, 12.0f)},
          {&ids::AeEnable, ControlInfo(false, true)},
          {&ids::ExposureTime, Numbers(100, 33333)},
          {&ids::AnalogueGain, ControlInfo(1.0f, 16.0f)},
          {&ids::AwbEnable, ControlInfo(false, true)}};
}

ControlInfoMap Listed(ControlInfoMap::Map controls) {
  static const ControlIdMap known = [] {
    ControlIdMap all = ids::controls;
    all.insert({kTimeMode.id(), &kTimeMode});
    all.insert({kGainMode.id(), &kGainMode});
    return all;
  }();
  return ControlInfoMap(std::move(controls), known);
}

FrameInfo Told() {
  FrameInfo info = {};
  info.lens_position = 1.25f;
  info.exposure_us = 8300.0f;
  info.analogue_gain = 2.125f;
  return info;
}

TEST(LibcameraState, IsFixedAtThatOfTheLastFrame) {
  const ControlInfoMap camera = Listed(AutomaticCamera());
  const LibcameraLock lock =
      MakeLibcameraLock(camera, ControlList(camera), Told());
  EXPECT_EQ(lock.lock_state.locked,
            (LockTexts{"focus at 1.25 dioptres", "exposure 8.3 ms", "gain 2.1",
                       "white balance"}));
  EXPECT_EQ(lock.lock_state.open, LockTexts());
  EXPECT_EQ(lock.lock_controls.size(), 6u);
  EXPECT_EQ(lock.lock_controls.get(ids::AfMode), ids::AfModeManual);
  EXPECT_EQ(lock.lock_controls.get(ids::LensPosition), 1.25f);
  EXPECT_EQ(lock.lock_controls.get(ids::AeEnable), false);
  EXPECT_EQ(lock.lock_controls.get(ids::ExposureTime), 8300);
  EXPECT_EQ(lock.lock_controls.get(ids::AnalogueGain), 2.125f);
  EXPECT_EQ(lock.lock_controls.get(ids::AwbEnable), false);
  EXPECT_EQ(lock.unlock_controls.size(), 3u);
  EXPECT_EQ(lock.unlock_controls.get(ids::AfMode), ids::AfModeContinuous);
  EXPECT_EQ(lock.unlock_controls.get(ids::AeEnable), true);
  EXPECT_EQ(lock.unlock_controls.get(ids::AwbEnable), true);
}

TEST(LibcameraState, GoesBackToWhatWasGiven) {
  const ControlInfoMap camera = Listed(AutomaticCamera());
  ControlList given(camera);
  given.set(ids::AfMode, ids::AfModeAuto);
  given.set(ids::ExposureTime, 5000);
  given.set(ids::AwbEnable, false);
  const LibcameraLock lock = MakeLibcameraLock(camera, given, Told());
  EXPECT_EQ(lock.lock_controls.size(), 6u);
  // An exposure time that is given ended the mode.
  EXPECT_EQ(lock.unlock_controls.size(), 2u);
  EXPECT_EQ(lock.unlock_controls.get(ids::AfMode), ids::AfModeAuto);
  EXPECT_EQ(lock.unlock_controls.get(ids::ExposureTime), 5000);
}

TEST(LibcameraState, ExposureAndGainMayHaveModesOfTheirOwn) {
  ControlInfoMap::Map controls = AutomaticCamera();
  controls[&kTimeMode] = Numbers(0, 1);
  controls[&kGainMode] = Numbers(0, 1);
  const ControlInfoMap camera = Listed(controls);
  const LibcameraLock lock =
      MakeLibcameraLock(camera, ControlList(camera), Told());
  EXPECT_EQ(lock.lock_state.locked.size(), 4u);
  EXPECT_EQ(lock.lock_controls.get(kTimeMode.id()).get<int32_t>(), 1);
  EXPECT_EQ(lock.lock_controls.get(kGainMode.id()).get<int32_t>(), 1);
  EXPECT_EQ(lock.lock_controls.get(ids::ExposureTime), 8300);
  EXPECT_FALSE(lock.lock_controls.contains(ids::AeEnable.id()));
  EXPECT_EQ(lock.unlock_controls.get(kTimeMode.id()).get<int32_t>(), 0);
  EXPECT_EQ(lock.unlock_controls.get(kGainMode.id()).get<int32_t>(), 0);
}

TEST(LibcameraState, WhatTheCameraDoesNotTellStaysWhereItIs) {
  const ControlInfoMap camera = Listed(AutomaticCamera());
  const LibcameraLock lock =
      MakeLibcameraLock(camera, ControlList(camera), FrameInfo{});
  EXPECT_EQ(lock.lock_controls.size(), 3u);
  EXPECT_EQ(lock.lock_controls.get(ids::AeEnable), false);
  EXPECT_EQ(lock.lock_state.locked,
            (LockTexts{"focus at a value the camera does not report",
                       "exposure at a value the camera does not report",
                       "gain at a value the camera does not report",
                       "white balance"}));
}

TEST(LibcameraState, OnlyControlsOfTheCameraAreSet) {
  const ControlInfoMap none = Listed({});
  LibcameraLock lock = MakeLibcameraLock(none, ControlList(none), Told());
  EXPECT_TRUE(lock.lock_controls.empty());
  EXPECT_EQ(lock.lock_state.open,
            MakeUnlockedState("libcamera has no control for it").open);

  // Modes that it does not end, and values out of its range.
  const ControlInfoMap other =
      Listed({{&ids::AeEnable, ControlInfo(true)},
              {&ids::AfMode, ControlInfo(int32_t{1}, int32_t{2})},
              {&ids::ExposureTime, Numbers(100, 5000)},
              {&ids::AnalogueGain, ControlInfo(4.0f, 16.0f)}});
  lock = MakeLibcameraLock(other, ControlList(other), Told());
  EXPECT_EQ(lock.lock_controls.size(), 2u);
  EXPECT_EQ(lock.lock_controls.get(ids::ExposureTime), 5000);
  EXPECT_EQ(lock.lock_controls.get(ids::AnalogueGain), 4.0f);
  EXPECT_TRUE(lock.unlock_controls.empty());
  EXPECT_EQ(lock.lock_state.open,
            (LockTexts{"focus: libcamera has no control for it",
                       "white balance: libcamera has no control for it"}));
}

}  // namespace
}  // namespace raygrid
