#include "camera/sensor_mode.h"

#include "simulation/simulated_camera.h"
#include "simulation/simulated_camera_models.h"
#include "support.h"

namespace raygrid {
namespace {

// The right half of the lower part, halved, and mirrored.
SensorMode HalvedCrop() {
  SensorMode mode;
  mode.size = {160, 100};
  mode.offset_px = {320, 280};
  mode.scale = {2, 2};
  mode.flip_x = true;
  return mode;
}

TEST(SensorMode, PixelsCoverWholeCalibratedOnes) {
  const SensorMode mode = HalvedCrop();
  // The first pixel is the last one of the row: calibrated pixels 638 and 639,
  // in rows 280 and 281.
  EXPECT_EQ(mode.ToCalibrated({0, 0}), Eigen::Vector2d(638.5, 280.5));
  EXPECT_EQ(mode.ToCalibrated({159, 99}), Eigen::Vector2d(320.5, 478.5));
  EXPECT_EQ(mode.FromCalibrated({638.5, 280.5}), Eigen::Vector2d(0, 0));
  EXPECT_EQ(mode.FromCalibrated({320, 280}), Eigen::Vector2d(159.25, -0.25));
}

TEST(ModeCamera, LooksAsTheCameraDoesThere) {
  const SimulatedCamera camera = ExampleSimulatedCamera();
  const SensorMode mode = HalvedCrop();
  const ModeCamera seen(camera, mode);
  EXPECT_EQ(seen.image_size(), mode.size);
  for (const Eigen::Vector2d& pixel :
       {Eigen::Vector2d(3, 5), {150.5, 20.25}, {80, 99}}) {
    const auto ray = seen.Unproject(pixel);
    ASSERT_TRUE(ray);
    EXPECT_EQ(*ray, *camera.Unproject(mode.ToCalibrated(pixel)));
    EXPECT_LT((*seen.Project(*ray) - pixel).norm(), 1e-6);
  }
  EXPECT_FALSE(seen.Unproject({-1, 50}));
  EXPECT_FALSE(seen.Project(*camera.Unproject({100, 100})));
}

TEST(ModeCamera, LightsWhatTheCameraLights) {
  SimulatedCamera camera = ExampleSimulatedCamera();
  camera.SetImageCircle(ImageCircle{{400, 350}, {90, 90}});
  SensorMode mode = HalvedCrop();
  mode.scale.y() = 1;
  const ModeCamera seen(camera, mode);
  int num_lit = 0;
  for (int y = 0; y < mode.size.height; ++y)
    for (int x = 0; x < mode.size.width; ++x) {
      const Eigen::Vector2d pixel(x, y);
      EXPECT_EQ(seen.IsInImageCircle(pixel),
                camera.IsInImageCircle(mode.ToCalibrated(pixel)));
      num_lit += seen.IsInImageCircle(pixel);
    }
  EXPECT_GT(num_lit, 1000);
  EXPECT_LT(num_lit, mode.size.width * mode.size.height);
}

TEST(ModeCamera, DerivativesAreThoseOfProjection) {
  ExpectDerivativeByPoint(
      ModeCamera(*MakeSimulatedCamera("wide", {640, 480}), HalvedCrop()), 1e-5);
}

}  // namespace
}  // namespace raygrid
