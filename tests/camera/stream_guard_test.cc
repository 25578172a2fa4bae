#include "stream_guard.h"

#include <gtest/gtest.h>

#include "camera_error.h"
#include "camera_support.h"

namespace raygrid {
namespace {

using Use = StreamGuard::Use;

constexpr SensorCrop kWhole = {0, 0, 320, 240};

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
  guard.Check(Showing(kWhole));
  guard.Check(Showing(kWhole));
  ExpectRefused(&guard, Showing(SensorCrop{80, 60, 160, 120}), "80,60,160x120");
}

TEST(StreamGuard, ACropThatWasNotCalibratedIsRefusedFromTheFirstFrame) {
  const rg_camera camera = OpenLens();
  StreamGuard guard(camera, Format(160, 120), Use::kFrames, "", kWhole);
  ExpectRefused(&guard, Showing(SensorCrop{80, 60, 160, 120}), "0,0,320x240");
}

TEST(StreamGuard, PositionsOfACropAreBroughtToCalibratedOnes) {
  const rg_camera camera = OpenLens();
  // The right half of the lower half, in pixels twice as fine.
  StreamGuard guard(camera, Format(160, 120), Use::kPositions, "", kWhole);
  guard.Check(Showing(SensorCrop{160, 120, 160, 120}));
  ASSERT_TRUE(guard.mode());
  rg_pixel calibrated;
  ASSERT_EQ(rg_mode_to_calibrated(&*guard.mode(), {RG_PIXEL(0), RG_PIXEL(0)},
                                  &calibrated),
            RG_OK);
  EXPECT_NEAR(calibrated.x_q16 / 65536.0, 80 - 0.25, 1e-3);
  EXPECT_NEAR(calibrated.y_q16 / 65536.0, 60 - 0.25, 1e-3);
}

TEST(StreamGuard, ImpossibleCropsAreRefused) {
  const rg_camera camera = OpenLens();
  for (const SensorCrop& crop :
       {SensorCrop{0, 0, 0, 0}, SensorCrop{-400, 0, 320, 240},
        SensorCrop{0, 0, 4000000000u, 1}, SensorCrop{INT32_MAX, 0, 320, 240}}) {
    StreamGuard guard(camera, Format(160, 120), Use::kFrames, "", kWhole);
    EXPECT_THROW(guard.Check(Showing(crop)), CameraError);
  }
}

}  // namespace
}  // namespace raygrid
