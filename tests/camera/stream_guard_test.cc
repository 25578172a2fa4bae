#include "stream_guard.h"

#include <gtest/gtest.h>

#include "camera_error.h"
#include "camera_support.h"

namespace raygrid {
namespace {

using Use = StreamGuard::Use;

constexpr SensorCrop kComplete = {0, 0, 320, 240};

StreamFormat Format(uint32_t width, uint32_t height) {
  return MakeStreamFormat(*FindPixelFormat("R8"), width, height, 0);
}

FrameInfo Showing(const std::optional<SensorCrop>& crop) {
  FrameInfo info = {};
  info.crop = crop;
  return info;
}

void ExpectRefused(StreamGuard* guard, const FrameInfo& info,
                   const std::string& word) {
  try {
    guard->Check(info);
    FAIL() << word;
  } catch (const CameraError& error) {
    EXPECT_EQ(error.code(), CameraExit::kBlob);
    EXPECT_NE(std::string(error.what()).find(word), std::string::npos)
        << error.what();
  }
}

TEST(StreamGuard, FramesOfTheBlobsSizeAreTaken) {
  const rg_camera camera = OpenLens();
  StreamGuard guard(camera, Format(160, 120), Use::kFrames, "", std::nullopt);
  guard.Check({});
  EXPECT_FALSE(guard.mode());
}

TEST(StreamGuard, OtherSizesAreRefusedWithWhatTheBlobServes) {
  const rg_camera camera = OpenLens();
  StreamGuard guard(camera, Format(80, 60), Use::kFrames, "", std::nullopt);
  ExpectRefused(&guard, {}, "160x120");
  ExpectRefused(&guard, {}, "80x60");
}

TEST(StreamGuard, AnotherSerialNumberIsRefused) {
  const rg_camera camera = OpenLens();
  StreamGuard same(camera, Format(160, 120), Use::kFrames, "L-150/7",
                   std::nullopt);
  same.Check({});
  StreamGuard other(camera, Format(160, 120), Use::kFrames, "L-150/8",
                    std::nullopt);
  ExpectRefused(&other, {}, "serial");
}

TEST(StreamGuard, AZoomWhileItRunsIsRefused) {
  const rg_camera camera = OpenLens();
  StreamGuard guard(camera, Format(160, 120), Use::kFrames, "", std::nullopt);
  guard.Check({});
  guard.Check(Showing(kComplete));
  guard.Check(Showing(kComplete));
  ExpectRefused(&guard, Showing(SensorCrop{80, 60, 160, 120}), "80,60,160x120");
}

TEST(StreamGuard, ACropThatWasNotCalibratedIsRefusedFromTheFirstFrame) {
  const rg_camera camera = OpenLens();
  StreamGuard guard(camera, Format(160, 120), Use::kFrames, "", kComplete);
  ExpectRefused(&guard, Showing(SensorCrop{80, 60, 160, 120}), "0,0,320x240");
}

TEST(StreamGuard, PositionsOfACropAreBroughtToCalibratedOnes) {
  const rg_camera camera = OpenLens();
  // The right half of the lower half, in pixels twice as fine.
  StreamGuard guard(camera, Format(160, 120), Use::kPositions, "", kComplete);
  guard.Check(Showing(SensorCrop{160, 120, 160, 120}));
  ASSERT_TRUE(guard.mode());
  rg_pixel calibrated;
  ASSERT_EQ(rg_mode_to_calibrated(&*guard.mode(), {RG_PIXEL(0), RG_PIXEL(0)},
                                  &calibrated),
            RG_OK);
  EXPECT_NEAR(calibrated.x_q16 / 65536.0, 80 - 0.25, 1e-3);
  EXPECT_NEAR(calibrated.y_q16 / 65536.0, 60 - 0.25, 1e-3);
}

// The golden camera of 320 x 240 pixels with tables for a crop of 120 x 100,
// for binning to 160 x 120 that is mirrored, and for a scaled crop.
rg_camera OpenModes() {
  rg_camera camera;
  if (rg_camera_open(&camera, kModesBlob, sizeof(kModesBlob)) != RG_OK ||
      rg_select_remap(&camera, 0) != RG_OK)
    abort();
  return camera;
}

// The sensor's pixels are half as wide as calibrated ones.
constexpr SensorCrop kSensor = {8, 4, 640, 480};
constexpr SensorCrop kCropOfTable = {8 + 180, 4 + 120, 240, 200};

TEST(StreamGuard, FramesOfATablesModeAreTaken) {
  const rg_camera camera = OpenModes();
  StreamGuard guard(camera, Format(120, 100), Use::kFrames, "", kSensor);
  guard.Check({});
  guard.Check(Showing(kCropOfTable));
  // Frames of that size that show another part.
  ExpectRefused(&guard, Showing(SensorCrop{8, 4, 240, 200}), "pack --mode");
}

TEST(StreamGuard, OfAModeWhoseCropIsNotKnownAllFramesShowWhatTheFirstDoes) {
  const rg_camera camera = OpenModes();
  StreamGuard guard(camera, Format(120, 100), Use::kFrames, "", std::nullopt);
  guard.Check({});
  guard.Check(Showing(kCropOfTable));
  guard.Check({});
  guard.Check(Showing(kCropOfTable));
  ExpectRefused(&guard, Showing(SensorCrop{0, 0, 240, 200}), "188,124,240x200");
}

TEST(StreamGuard, CalibratedFramesAreRefusedByATableOfAMode) {
  const rg_camera camera = OpenModes();
  StreamGuard guard(camera, Format(320, 240), Use::kFrames, "", kSensor);
  ExpectRefused(&guard, Showing(kSensor), "120x100");
}

TEST(FindTable, IsTheOneOfTheFramesMode) {
  const rg_camera camera = OpenModes();
  EXPECT_EQ(FindTable(camera, Format(120, 100), kSensor, kCropOfTable), 0u);
  // Not known to be mirrored.
  EXPECT_EQ(FindTable(camera, Format(160, 120), kSensor, kSensor), RG_NO_TABLE);
  EXPECT_EQ(FindTable(camera, Format(120, 100), kSensor, std::nullopt),
            RG_NO_TABLE);
  // The table that distorts takes no frames.
  EXPECT_EQ(FindTable(camera, Format(320, 240), kSensor, kSensor), RG_NO_TABLE);
  EXPECT_EQ(FindTable(OpenLens(), Format(160, 120), std::nullopt, kSensor), 0u);
}

TEST(FindTable, KnowsBlobsWithTablesOfModes) {
  EXPECT_TRUE(HasTablesOfModes(OpenModes()));
  EXPECT_FALSE(HasTablesOfModes(OpenLens()));
}

TEST(StreamGuard, ImpossibleCropsAreRefused) {
  const rg_camera camera = OpenLens();
  for (const SensorCrop& crop :
       {SensorCrop{0, 0, 0, 0}, SensorCrop{-400, 0, 320, 240},
        SensorCrop{0, 0, 4000000000u, 1}, SensorCrop{INT32_MAX, 0, 320, 240}}) {
    StreamGuard guard(camera, Format(160, 120), Use::kFrames, "", kComplete);
    EXPECT_THROW(guard.Check(Showing(crop)), CameraError);
  }
}

}  // namespace
}  // namespace raygrid
