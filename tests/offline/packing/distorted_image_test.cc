#include "packing/distorted_image.h"

#include <Eigen/LU>
#include <cstdio>
#include <cstring>

#include "packed_cameras.h"

namespace raygrid {
namespace {

constexpr double kWavePx = 40;

double WaveAt(double x, double y) {
  return 32768 + 12000 * std::sin(2 * M_PI * x / kWavePx) +
         12000 * std::cos(2 * M_PI * y / kWavePx);
}

Image WavyPicture(const ImageSize& size) {
  Image image;
  image.size = size;
  image.sample_bytes = 2;
  image.pixels.resize(image.stride() * size.height);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const auto sample = static_cast<uint16_t>(std::lround(WaveAt(x, y)));
      std::memcpy(&image.pixels[y * image.stride() + 2 * x], &sample, 2);
    }
  return image;
}

double SampleOf(const Image& image, int x, int y) {
  uint16_t sample;
  std::memcpy(&sample, &image.pixels[y * image.stride() + 2 * x], 2);
  return sample;
}

// By how far a window of a picture is shifted against the waves, by least
// squares.
Eigen::Vector2d ShiftOfWindow(const Image& image, int x0, int y0, int size) {
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (int y = y0; y < y0 + size; ++y)
    for (int x = x0; x < x0 + size; ++x) {
      const Eigen::Vector2d slope((WaveAt(x + 0.5, y) - WaveAt(x - 0.5, y)),
                                  (WaveAt(x, y + 0.5) - WaveAt(x, y - 0.5)));
      normal += slope * slope.transpose();
      right += slope * (WaveAt(x, y) - SampleOf(image, x, y));
    }
  return normal.inverse() * right;
}

TEST(DistortImage, UndoesWhatTheRuntimeUndistorted) {
  const CameraModel& camera = *GenericFile().camera;
  const Image before = WavyPicture(camera.image_size());
  const SourceMap map = MakeDistortionMap(camera, Virtual(), 0);
  const Image after = DistortImage(map, Opened().Undistort(before, 0), 0);
  ASSERT_EQ(after.size, before.size);
  constexpr int kWindow = 20;
  double worst = 0;
  int num_windows = 0;
  const auto is_inside = [&](int x, int y) {
    return map.IsKnown(x, y) && Area{2, 2, 637, 477}.Contains(map.At(x, y));
  };
  for (int y = 0; y + kWindow < before.size.height; y += kWindow)
    for (int x = 0; x + kWindow < before.size.width; x += kWindow) {
      if (!is_inside(x, y) || !is_inside(x + kWindow, y) ||
          !is_inside(x, y + kWindow) || !is_inside(x + kWindow, y + kWindow))
        continue;
      worst = std::max(worst, ShiftOfWindow(after, x, y, kWindow).norm());
      ++num_windows;
    }
  std::printf("there and back: %.4f px in %d windows\n", worst, num_windows);
  EXPECT_GT(num_windows, 300);
  EXPECT_LT(worst, 0.1);
}

TEST(DistortImage, IsBlackBeyondTheImageCircle) {
  const std::unique_ptr<CameraModel> camera = GenericFile().camera->Clone();
  const SourceMap whole = MakeDistortionMap(*camera, Virtual(), 0);
  camera->SetImageCircle(ImageCircle{{300, 250}, {200, 200}});
  const SourceMap lit = MakeDistortionMap(*camera, Virtual(), 0);
  for (int y = 0; y < lit.height; ++y)
    for (int x = 0; x < lit.width; ++x)
      ASSERT_EQ(lit.IsKnown(x, y),
                whole.IsKnown(x, y) && std::hypot(x - 300, y - 250) <= 200);
}

TEST(DistortImage, IsBlackWhereTheViewShowsNothing) {
  const CameraModel& camera = *GenericFile().camera;
  const VirtualView view = ViewOf(camera, {300, 200}, 30);
  Image picture;
  picture.size = view.size;
  picture.channels = 4;
  picture.pixels.assign(picture.stride() * 200, 200);
  const SourceMap map = MakeDistortionMap(camera, view, 1);
  const Image image = DistortImage(map, picture, 1);
  EXPECT_EQ(image.size, camera.image_size());
  EXPECT_EQ(image.channels, 4);
  for (int y = 0; y < image.size.height; ++y)
    for (int x = 0; x < image.size.width; ++x) {
      const auto pixel = view.Pixel(*camera.Unproject({x, y}));
      const Area area = {0, 0, 299, 199};
      const int alpha = image.pixels[y * image.stride() + 4 * x + 3];
      const bool is_seen = area.Contains(*pixel, -0.01);
      if (is_seen != area.Contains(*pixel, 0.01)) continue;
      ASSERT_EQ(alpha, is_seen ? 200 : 0) << x << ", " << y;
    }
  EXPECT_EQ(DistortImage(map, picture, 3).pixels, image.pixels);
}

}  // namespace
}  // namespace raygrid
