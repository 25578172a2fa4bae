// Tables for frames of other sensor modes than the calibrated one.
#include "packed_cameras.h"
#include "ramp_images.h"

namespace raygrid {
namespace {

// The pixels from (x0, y0) on, as a sensor reads them: in squares of bin
// pixels, which it averages.
Image ReadOut(const Image& image, int x0, int y0, const ImageSize& size,
              int bin) {
  Image frame;
  frame.size = size;
  frame.sample_bytes = 2;
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      double sum = 0;
      for (int k = 0; k < bin * bin; ++k)
        sum += LevelAt(image, x0 + bin * x + k % bin, y0 + bin * y + k / bin);
      AddLevel(sum / (bin * bin), &frame);
    }
  }
  return frame;
}

struct ReadOutMode {
  SensorMode mode;
  int bin;
};

// Two crops and a binning of 640 x 480 pixels.
std::vector<ReadOutMode> ModesOfExample() {
  return {{{"left", {320, 480}, {0, 0}, {1, 1}}, 1},
          {{"low", {400, 200}, {211, 280}, {1, 1}}, 1},
          {{"half", {320, 240}, {0, 0}, {2, 2}}, 2}};
}

TEST(SensorModes, FramesOfThreeAreUndistortedThroughOneBlob) {
  const SimulatedCamera truth = ExampleSimulatedCamera();
  PackOptions options = WithRemap();
  for (const ReadOutMode& read : ModesOfExample())
    options.remaps.emplace_back(
        MakeModeView(*GenericFile().camera, read.mode, {}), read.mode);
  const PackedCamera packed = PackCamera(GenericFile(), options);
  const BlobCamera blob("packed", packed.blob);
  const Image ramps[2] = {RampImage({640, 480}, 0), RampImage({640, 480}, 1)};
  for (size_t k = 0; k < ModesOfExample().size(); ++k) {
    const ReadOutMode read = ModesOfExample()[k];
    const SensorMode& mode = read.mode;
    const uint32_t table = blob.FindModeTable(mode.name).value();
    EXPECT_EQ(table, k + 1);
    ASSERT_EQ(blob.FrameSize(table), mode.size);
    Image seen[2];
    for (int axis = 0; axis < 2; ++axis)
      seen[axis] = blob.Undistort(
          ReadOut(ramps[axis], static_cast<int>(mode.offset_px.x()),
                  static_cast<int>(mode.offset_px.y()), mode.size, read.bin),
          0, table);
    const VirtualView& view = packed.remaps[table].view;
    double worst_px = 0;
    int num_pixels = 0;
    for (int y = 0; y < view.size.height; ++y) {
      for (int x = 0; x < view.size.width; ++x) {
        const auto at = SourceInRamps(seen, x, y);
        if (!at) continue;
        const auto source = truth.Project(*view.Direction({x, y}));
        ASSERT_TRUE(source);
        worst_px = std::max(worst_px, (*at - *source).norm());
        ++num_pixels;
      }
    }
    std::printf("%s: %d pixels within %.3f px of truth\n", mode.name.c_str(),
                num_pixels, worst_px);
    EXPECT_GT(num_pixels, 0.9 * view.size.width * view.size.height);
    // The bound is in pixels of the mode, which are bin calibrated ones wide.
    EXPECT_LT(worst_px / read.bin, 0.05);
  }
}

TEST(SensorModes, ViewsShowTheMiddleOfCropsInTheMiddle) {
  const CameraModel& camera = *GenericFile().camera;
  const VirtualView whole = MakeView(camera, {});
  const SensorMode half = {"half", {320, 240}, {0, 0}, {2, 2}};
  EXPECT_LT(
      (MakeModeView(camera, half, {}).center_px - Eigen::Vector2d(159.5, 119.5))
          .norm(),
      1e-9);
  const SensorMode low = {"low", {400, 200}, {211, 280}, {1, 1}};
  for (const double hfov_deg : {0.0, 40.0}) {
    ViewRequest request;
    if (hfov_deg > 0) request.hfov_deg = hfov_deg;
    const VirtualView view = MakeModeView(camera, low, request);
    const auto of_crop =
        view.Pixel(*camera.Unproject(low.ToCalibrated({199.5, 99.5})));
    const auto of_whole = whole.Pixel(*camera.Unproject({319.5, 239.5}));
    EXPECT_LT((*of_crop - Eigen::Vector2d(199.5, 99.5) -
               (*of_whole - Eigen::Vector2d(319.5, 239.5)) *
                   (view.focal_px.x() / whole.focal_px.x()))
                  .norm(),
              0.01);
    if (hfov_deg > 0) {
      EXPECT_NEAR(view.HorizontalFieldOfViewDeg(), hfov_deg, 1e-6);
    }
  }
}

TEST(SensorModes, AreToldByTheBlob) {
  PackOptions options;
  SensorMode mode = {"turned", {160, 100}, {12.5, 20}, {2.5, 2.5}, true, true};
  const VirtualView view = MakeModeView(*GenericFile().camera, mode, {});
  options.remaps = {RemapRequest(view, mode), RemapRequest(view, mode)};
  options.max_error_px = 0.2;
  const PackedCamera packed = PackCamera(GenericFile(), options);
  const BlobCamera blob("packed", packed.blob);
  ASSERT_EQ(blob.Modes().size(), 1u);
  const SensorMode told = blob.Modes()[0];
  EXPECT_EQ(told.name, mode.name);
  EXPECT_EQ(told.size, mode.size);
  EXPECT_EQ(told.offset_px, mode.offset_px);
  EXPECT_EQ(told.scale, mode.scale);
  EXPECT_TRUE(told.flip_x && told.flip_y);
  EXPECT_EQ(packed.remaps[1].mode, "turned");
  EXPECT_FALSE(blob.FindModeTable("other"));
}

TEST(SensorModes, TablesWithoutThemAreAsBefore) {
  const BlobCamera& blob = Opened();
  EXPECT_TRUE(blob.Modes().empty());
  EXPECT_EQ(blob.FrameSize(0), (ImageSize{640, 480}));
  EXPECT_LT(rg_load_u16(blob.blob().bytes + RG_HEADER_MINOR), 5);
}

}  // namespace
}  // namespace raygrid
