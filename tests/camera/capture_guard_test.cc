#include "capture_guard.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "bytes.h"
#include "camera_error.h"
#include "camera_support.h"
#include "capture_guard_support.h"
#include "crc32.h"
#include "golden_blobs.h"
#include "stream_guard.h"

namespace raygrid {
namespace {

// A guard and what it said.
struct Heard {
  explicit Heard(const std::optional<rg_capture_section>& recorded,
                 bool is_strict = false)
      : guard(recorded, "the camera", is_strict,
              [this](const std::string& line) { lines.push_back(line); }) {}

  bool Check(const FrameInfo& info, bool shows_mode = true,
             std::chrono::milliseconds at = kNoTime,
             const rg_mode* in_use = nullptr) {
    return guard.Check(info, in_use, shows_mode, Clock::time_point(at));
  }
  // Whether a frame counts as calibrated.
  bool IsGood(const FrameInfo& info) {
    const uint64_t before = guard.num_not_as_calibrated();
    EXPECT_TRUE(Check(info));
    return guard.num_not_as_calibrated() == before;
  }

  std::vector<std::string> lines;
  CaptureGuard guard;
};

TEST(CaptureGuard, LensPositionsAreComparedWithinTheTolerance) {
  Heard heard(Recorded());
  FrameInfo info = AsCalibrated();
  for (const float at : {2.0f, 2.125f, 1.875f, std::nextafter(2.125f, 0.0f)}) {
    info.lens_position = at;
    EXPECT_TRUE(heard.IsGood(info)) << at;
  }
  // A step of q16 beyond.
  for (const float at : {2.125f + 1.0f / 65536, 1.875f - 1.0f / 65536, 0.0f,
                         -2.0f, 1e30f, INFINITY, -INFINITY, NAN}) {
    info.lens_position = at;
    EXPECT_FALSE(heard.IsGood(info)) << at;
  }
  EXPECT_EQ(heard.guard.num_not_as_calibrated(), 8u);
  ASSERT_EQ(heard.lines.size(), 1u);
  EXPECT_TRUE(
      Has(heard.lines[0],
          "capture settings differ from calibration: lens position is 2.125"));
  EXPECT_TRUE(Has(heard.lines[0], "calibrated at 2 +- 0.125; "));
  EXPECT_TRUE(Has(heard.lines[0], "LensPosition=2,"));
}

TEST(CaptureGuard, AToleranceOfNothingTakesTheSameLensPosition) {
  rg_capture_section recorded = Recorded();
  recorded.lens_tolerance_q16 = 0;
  Heard heard(recorded);
  FrameInfo info = AsCalibrated();
  EXPECT_TRUE(heard.IsGood(info));
  info.lens_position = 2 + 1.0f / 65536;
  EXPECT_FALSE(heard.IsGood(info));
}

TEST(CaptureGuard, EachFaultIsSaidOnceAndAllFramesAreCounted) {
  Heard heard(Recorded());
  for (int k = 0; k < 100; ++k) {
    FrameInfo info = AsCalibrated();
    info.lens_position = 3;
    info.orientation = 3;
    info.crop = SensorCrop{160, 120, 320, 240};
    EXPECT_TRUE(heard.Check(info, false));
    EXPECT_TRUE(heard.Check(AsCalibrated()));
  }
  heard.guard.Finish();
  EXPECT_EQ(heard.guard.num_not_as_calibrated(), 100u);
  EXPECT_EQ(heard.guard.num_held_back(), 0u);
  ASSERT_EQ(heard.lines.size(), 3u);
  EXPECT_TRUE(Has(heard.lines[0], "lens position is 3 dpt"));
  EXPECT_TRUE(Has(heard.lines[1], "160,120,320x240"));
  EXPECT_TRUE(Has(heard.lines[1], "0,0,640x480, zoom 2; "));
  EXPECT_TRUE(Has(heard.lines[2], "rotated by 180 degrees (3)"));
  EXPECT_TRUE(Has(heard.lines[2], "upright (1); "));
}

TEST(CaptureGuard, ZoomIsComparedWhereNoCropIsTold) {
  Heard heard(Recorded());
  FrameInfo info = AsCalibrated();
  info.crop.reset();
  for (const double zoom : {1.0, 1.0004, 0.9996}) {
    info.zoom = zoom;
    EXPECT_TRUE(heard.IsGood(info)) << zoom;
  }
  for (const double zoom :
       {1.0006, 0.9994, 2.0, 0.0, double{INFINITY}, double{NAN}}) {
    info.zoom = zoom;
    EXPECT_FALSE(heard.IsGood(info)) << zoom;
  }
  info.crop = kShown;
  EXPECT_TRUE(heard.IsGood(info));
  ASSERT_EQ(heard.lines.size(), 1u);
  EXPECT_TRUE(Has(heard.lines[0], "zoom is 1.0006, calibrated at 1;"))
      << heard.lines[0];
}

TEST(CaptureGuard, NothingIsComparedThatIsNotRecorded) {
  FrameInfo other = {};
  other.lens_position = 9;
  other.crop = SensorCrop{1, 2, 3, 4};
  other.zoom = 5;
  other.orientation = 6;
  Heard idle(std::nullopt);
  EXPECT_TRUE(idle.guard.is_idle());
  EXPECT_TRUE(idle.Check(other, false));
  idle.guard.Finish();
  EXPECT_TRUE(idle.lines.empty());
  for (const uint8_t bit : {RG_CAPTURE_HAS_LENS_POSITION, RG_CAPTURE_HAS_CROP,
                            RG_CAPTURE_HAS_ZOOM, RG_CAPTURE_HAS_ORIENTATION}) {
    Heard heard(Recorded(bit));
    EXPECT_TRUE(heard.Check(other, false));
    heard.guard.Finish();
    EXPECT_EQ(heard.guard.num_not_as_calibrated(), 1u);
    EXPECT_EQ(heard.lines.size(), 1u) << int{bit};
  }
}

TEST(CaptureGuard, WhatIsNotToldIsSaidOnceAndCountsForNothing) {
  Heard heard(Recorded());
  for (int k = 0; k < 9; ++k) EXPECT_TRUE(heard.Check({}));
  EXPECT_TRUE(heard.lines.empty());  // it may come late
  for (int k = 0; k < 20; ++k) EXPECT_TRUE(heard.Check({}));
  heard.guard.Finish();
  EXPECT_EQ(heard.guard.num_not_as_calibrated(), 0u);
  ASSERT_EQ(heard.lines.size(), 1u);
  EXPECT_TRUE(Has(
      heard.lines[0],
      "the camera does not report lens position, crop, zoom, orientation; "));
  // Few frames: at the end.
  Heard few(Recorded(RG_CAPTURE_HAS_LENS_POSITION));
  few.guard.Finish();
  EXPECT_TRUE(few.lines.empty());
  few.Check({});
  few.guard.Finish();
  ASSERT_EQ(few.lines.size(), 1u);
  EXPECT_TRUE(Has(few.lines[0], "does not report lens position; "));
  // A crop is enough.
  Heard crop(Recorded(RG_CAPTURE_HAS_CROP | RG_CAPTURE_HAS_ZOOM));
  FrameInfo info = {};
  info.crop = kShown;
  crop.Check(info);
  crop.guard.Finish();
  EXPECT_TRUE(crop.lines.empty());
}

TEST(CaptureGuard, AnotherTemperatureIsSaidOnceAndCountsForNothing) {
  rg_capture_section recorded = Recorded(RG_CAPTURE_HAS_TEMPERATURE);
  recorded.temperature_q16 = 35 << 16;
  Heard heard(recorded, true);
  FrameInfo info = {};
  EXPECT_TRUE(heard.Check(info));
  for (const float temperature_c : {35.f, 16.f, 54.f, 55.5f, 60.f}) {
    info.sensor_temperature_c = temperature_c;
    EXPECT_TRUE(heard.Check(info));
  }
  heard.guard.Finish();
  EXPECT_EQ(heard.guard.num_not_as_calibrated(), 0u);
  ASSERT_EQ(heard.lines.size(), 1u);
  EXPECT_TRUE(
      Has(heard.lines[0], "sensor temperature is 56 °C, calibrated at 35 °C;"))
      << heard.lines[0];
}

TEST(CaptureGuard, StrictStopsAtTheFirstFrameThatLeavesWhatWasCalibrated) {
  Heard heard(Recorded(), true);
  EXPECT_TRUE(heard.Check(AsCalibrated()));
  FrameInfo info = AsCalibrated();
  info.lens_position = 2.5;
  try {
    heard.Check(info);
    FAIL();
  } catch (const CameraError& error) {
    EXPECT_EQ(error.code(), CameraExit::kBlob);
    EXPECT_TRUE(Has(
        error.what(),
        "--strict: capture settings differ from calibration: lens position"));
  }
  EXPECT_EQ(heard.guard.num_not_as_calibrated(), 1u);
  EXPECT_TRUE(heard.lines.empty());
}

TEST(CaptureGuard, StrictHoldsFramesBackWhileACameraSettles) {
  FrameInfo info = AsCalibrated();
  info.lens_position = 0;
  // Many frames a second: two seconds; few: eight frames.
  for (const int step_ms : {10, 500, 3000}) {
    SCOPED_TRACE(step_ms);
    Heard heard(Recorded(), true);
    int num_held = 0;
    const auto check = [&] {
      return heard.Check(info, true,
                         std::chrono::milliseconds(num_held * step_ms));
    };
    const int expected = step_ms == 10 ? 200 : 8;
    for (; num_held < expected; ++num_held) EXPECT_FALSE(check());
    EXPECT_THROW(check(), CameraError);
    EXPECT_EQ(heard.guard.num_held_back(), static_cast<uint64_t>(num_held));
  }
  Heard heard(Recorded(), true);
  EXPECT_FALSE(heard.Check(info));
  EXPECT_TRUE(heard.Check(AsCalibrated()));
  EXPECT_THROW(heard.Check(info), CameraError);
}

TEST(CaptureGuard, TablesOfMirroredModesWantMirroredFrames) {
  Heard heard(Recorded(RG_CAPTURE_HAS_ORIENTATION));
  rg_mode mode = {};
  mode.flip_x = mode.flip_y = 1;
  FrameInfo info = AsCalibrated();
  info.orientation = 3;
  EXPECT_TRUE(heard.Check(info, true, kNoTime, &mode));
  EXPECT_EQ(heard.guard.num_not_as_calibrated(), 0u);
  info.orientation = 1;
  EXPECT_TRUE(heard.Check(info, true, kNoTime, &mode));
  EXPECT_EQ(heard.guard.num_not_as_calibrated(), 1u);
  ASSERT_EQ(heard.lines.size(), 1u);
  EXPECT_TRUE(
      Has(heard.lines[0], "the table's sensor mode had rotated by 180"));
}

TEST(Orientation, MirrorsMoveTheCorners) {
  // Corners as bits: x, and y times 2.
  const auto place = [](int orientation, int x, int y) {
    switch (orientation) {
      case 1:
        return x + 2 * y;
      case 2:
        return 1 - x + 2 * y;
      case 3:
        return 1 - x + 2 * (1 - y);
      case 4:
        return x + 2 * (1 - y);
      case 5:
        return y + 2 * x;
      case 6:
        return y + 2 * (1 - x);
      case 7:
        return 1 - y + 2 * (1 - x);
      default:
        return 1 - y + 2 * x;
    }
  };
  for (int orientation = 1; orientation <= 8; ++orientation) {
    for (int bits = 0; bits < 4; ++bits) {
      const int mirrored = Mirrored(orientation, bits & 1, bits & 2);
      for (int corner = 0; corner < 4; ++corner)
        EXPECT_EQ(place(mirrored, corner & 1, corner >> 1),
                  place(orientation, corner & 1, corner >> 1) ^ bits);
      const auto flips = FlipsBetween(orientation, mirrored);
      ASSERT_TRUE(flips);
      EXPECT_EQ(flips->x, (bits & 1) != 0);
      EXPECT_EQ(flips->y, (bits & 2) != 0);
    }
  }
  EXPECT_FALSE(FlipsBetween(1, 6));
  EXPECT_FALSE(FlipsBetween(1, 0));
  EXPECT_EQ(Mirrored(9, true, false), 0);
  EXPECT_EQ(FormatOrientation(0), "");
}

// ---- With the guard of streams ----------------------------------------------

StreamFormat GreyFormat(uint32_t width, uint32_t height) {
  return MakeStreamFormat(*FindPixelFormat("R8"), width, height, 0);
}

FrameInfo FocusedOn(const SensorCrop& crop) {
  FrameInfo info = AsCalibrated();
  info.crop = crop;
  return info;
}

TEST(RecordedCrop, OtherPartsAreSaidAndCounted) {
  const rg_camera camera = OpenLens();
  Heard heard(Recorded(RG_CAPTURE_HAS_CROP));
  StreamGuard guard(camera, GreyFormat(160, 120), StreamGuard::Use::kFrames, "",
                    std::nullopt, &heard.guard);
  guard.CheckFormat();
  EXPECT_TRUE(guard.Check(FocusedOn(kShown)));
  EXPECT_TRUE(guard.Check(FocusedOn({160, 120, 320, 240})));
  EXPECT_TRUE(guard.Check(FocusedOn({160, 120, 320, 240})));
  EXPECT_TRUE(guard.Check(FocusedOn({0, 0, 640, 481})));
  EXPECT_TRUE(guard.Check(FocusedOn({0, 0, 0, 0})));
  EXPECT_TRUE(guard.Check(FocusedOn(kShown)));
  EXPECT_EQ(heard.guard.num_not_as_calibrated(), 4u);
  EXPECT_EQ(heard.lines.size(), 1u);
}

TEST(RecordedCrop, APartThatIsToldByHandIsBinding) {
  const rg_camera camera = OpenLens();
  Heard heard(Recorded(RG_CAPTURE_HAS_CROP));
  StreamGuard guard(camera, GreyFormat(160, 120), StreamGuard::Use::kFrames, "",
                    SensorCrop{0, 0, 320, 240}, &heard.guard);
  EXPECT_THROW(guard.Check(FocusedOn(kShown)), CameraError);
}

TEST(RecordedCrop, FramesOfAnotherSizeAreRefused) {
  const rg_camera camera = OpenLens();
  Heard heard(Recorded(RG_CAPTURE_HAS_CROP));
  StreamGuard guard(camera, GreyFormat(80, 60), StreamGuard::Use::kFrames, "",
                    std::nullopt, &heard.guard);
  EXPECT_THROW(guard.CheckFormat(), CameraError);
  EXPECT_THROW(guard.Check(FocusedOn(kShown)), CameraError);
}

TEST(RecordedCrop, FramesOfATablesModeAreAsCalibrated) {
  rg_camera camera;
  ASSERT_EQ(rg_camera_open(&camera, kModesBlob, sizeof(kModesBlob)), RG_OK);
  ASSERT_EQ(rg_select_remap(&camera, 0), RG_OK);
  Heard heard(Recorded(RG_CAPTURE_HAS_CROP));
  StreamGuard guard(camera, GreyFormat(120, 100), StreamGuard::Use::kFrames, "",
                    std::nullopt, &heard.guard);
  EXPECT_TRUE(guard.Check(FocusedOn({180, 120, 240, 200})));
  EXPECT_EQ(heard.guard.num_not_as_calibrated(), 0u);
  EXPECT_TRUE(guard.Check(FocusedOn({182, 120, 240, 200})));
  EXPECT_EQ(heard.guard.num_not_as_calibrated(), 1u);
  // The second table's mode is mirrored: by the orientation it is known.
  const rg_capture_section recorded =
      Recorded(RG_CAPTURE_HAS_CROP | RG_CAPTURE_HAS_ORIENTATION);
  Heard mirrored(recorded);
  FrameInfo info = FocusedOn(kShown);
  EXPECT_EQ(FindTable(camera, GreyFormat(160, 120), kShown, info.crop,
                      mirrored.guard.GetFlips(info)),
            RG_NO_TABLE);
  info.orientation = 2;
  EXPECT_EQ(FindTable(camera, GreyFormat(160, 120), kShown, info.crop,
                      mirrored.guard.GetFlips(info)),
            1u);
  ASSERT_EQ(rg_select_remap(&camera, 1), RG_OK);
  StreamGuard of_mirrored(camera, GreyFormat(160, 120),
                          StreamGuard::Use::kFrames, "", std::nullopt,
                          &mirrored.guard);
  EXPECT_TRUE(of_mirrored.Check(info));
  EXPECT_EQ(mirrored.guard.num_not_as_calibrated(), 0u);
  info.orientation = 1;
  EXPECT_TRUE(of_mirrored.Check(info));
  EXPECT_EQ(mirrored.guard.num_not_as_calibrated(), 1u);
}

// All that the format takes, and what it does not, does no harm.
TEST(RecordedCrop, NonsenseIsHarmless) {
  const rg_camera camera = OpenLens();
  for (const auto& crop :
       {SensorCrop{0, 0, 1, 1}, SensorCrop{-65536, 65536, 65536, 65536},
        SensorCrop{0, 0, 0, 0}, SensorCrop{INT32_MIN, INT32_MAX, 1, 1},
        SensorCrop{0, 0, UINT32_MAX, UINT32_MAX}}) {
    rg_capture_section recorded = Recorded(RG_CAPTURE_HAS_CROP);
    recorded.crop_x = crop.x;
    recorded.crop_y = crop.y;
    recorded.crop_width = crop.width;
    recorded.crop_height = crop.height;
    Heard heard(recorded);
    StreamGuard guard(camera, GreyFormat(160, 120), StreamGuard::Use::kFrames,
                      "", std::nullopt, &heard.guard);
    EXPECT_TRUE(guard.Check(FocusedOn(kShown)));
    EXPECT_EQ(heard.guard.num_not_as_calibrated(), 1u);
    StreamGuard positions(camera, GreyFormat(160, 120),
                          StreamGuard::Use::kPositions, "", std::nullopt,
                          &heard.guard);
    try {
      positions.Check(FocusedOn(kShown));
    } catch (const CameraError& error) {
      EXPECT_EQ(error.code(), CameraExit::kBlob);
    }
  }
}

// ---- Sections ---------------------------------------------------------------

TEST(ReadCapture, TakesWhatTheBlobRecords) {
  EXPECT_FALSE(ReadCapture("lens", kLensBlob, sizeof(kLensBlob)));
  const auto recorded =
      ReadCapture("capture", kCaptureBlob, sizeof(kCaptureBlob));
  ASSERT_TRUE(recorded);
  EXPECT_EQ(recorded->lens_position_q16, 2 << 16);
  EXPECT_EQ(*RecordedCrop(recorded), (SensorCrop{4, 4, 256, 192}));
  EXPECT_EQ(recorded->orientation, 3);
}

TEST(ReadCapture, RefusesNonsenseOfAForgedBlob) {
  alignas(4) uint8_t blob[sizeof(kCaptureBlob)];
  std::memcpy(blob, kCaptureBlob, sizeof(blob));
  uint8_t* entry = blob + RG_HEADER_SIZE;
  while (rg_load_u16(entry) != RG_SECTION_CAPTURE)
    entry += RG_SECTION_ENTRY_SIZE;
  uint8_t* const section = blob + rg_load_u32(entry + RG_ENTRY_OFFSET);
  rg_store_u32(section + RG_CAPTURE_CROP_WIDTH, 0);
  rg_store_u32(entry + RG_ENTRY_CRC, rg_crc32(0, section, RG_CAPTURE_SIZE));
  const uint32_t table_size =
      RG_SECTION_ENTRY_SIZE * rg_load_u16(blob + RG_HEADER_SECTION_COUNT);
  rg_store_u32(blob + RG_HEADER_HEADER_CRC,
               rg_crc32(rg_crc32(0, blob, RG_HEADER_HEADER_CRC),
                        blob + RG_HEADER_SIZE, table_size));
  rg_camera camera;
  ASSERT_EQ(rg_camera_open(&camera, blob, sizeof(blob)), RG_OK);
  try {
    ReadCapture("front.raygrid", blob, sizeof(blob));
    FAIL();
  } catch (const CameraError& error) {
    EXPECT_EQ(error.code(), CameraExit::kBlob);
    EXPECT_TRUE(Has(error.what(), "front.raygrid: recorded capture settings"));
  }
}

}  // namespace
}  // namespace raygrid
