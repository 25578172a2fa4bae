// Blobs and their views, as the host sees them through the runtime.
#include "packing/blob_camera.h"

#include <functional>

#include "packed_cameras.h"

namespace raygrid {
namespace {

TEST(BlobCamera, UnprojectsAsTheCamera) {
  TestRandom random(1);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector2d pixel =
        (random.PixelIn({0.5, 0.5, 638.5, 478.5}) * 65536).array().round() /
        65536;
    const auto ray = Opened().Unproject(pixel);
    ASSERT_TRUE(ray);
    EXPECT_LT(ray->cross(*GenericFile().camera->Unproject(pixel)).norm(), 1e-6);
    EXPECT_NEAR(ray->norm(), 1, 1e-6);
  }
}

TEST(BlobCamera, SeesNothingOutsideTheArea) {
  EXPECT_EQ(Opened().image_size(), (ImageSize{640, 480}));
  for (const Eigen::Vector2d& pixel :
       {Eigen::Vector2d(-1, 5), Eigen::Vector2d(5, -1), Eigen::Vector2d(640, 5),
        Eigen::Vector2d(5, 480), Eigen::Vector2d(1e6, 5),
        Eigen::Vector2d(NAN, 5)})
    EXPECT_FALSE(Opened().Unproject(pixel)) << pixel.transpose();
}

TEST(BlobCamera, ToModelIsTheCamera) {
  const std::unique_ptr<CameraModel> model = Opened().ToModel();
  EXPECT_EQ(model->image_size(), GenericFile().camera->image_size());
  EXPECT_LT((model->Parameters() - GenericFile().camera->Parameters())
                .cwiseAbs()
                .maxCoeff(),
            kMaxInt16ErrorRad);
}

TEST(BlobCamera, RefusesDamagedBlobsByName) {
  for (size_t i = 0; i < Packed().blob.size(); i += 997) {
    std::string damaged = Packed().blob;
    damaged[i] ^= 0x10;
    ExpectError(ExitCode::kInvalidBlob, {"d.raygrid"},
                [&] { BlobCamera("d.raygrid", damaged); });
  }
  for (const size_t size : {size_t{0}, size_t{3}, Packed().blob.size() - 1})
    ExpectError(ExitCode::kInvalidBlob, {"d.raygrid"}, [&] {
      BlobCamera("d.raygrid", Packed().blob.substr(0, size));
    });
}

TEST(IsBlob, KnowsNamesAndContents) {
  EXPECT_TRUE(IsBlob("x", Packed().blob));
  EXPECT_TRUE(IsBlob("x.raygrid", ""));
  EXPECT_FALSE(IsBlob("camera.yaml", "raygrid_camera: 1"));
  EXPECT_FALSE(IsBlob("x", ""));
}

// The place that an undistorted pixel comes from; nothing near the area's edge.
std::optional<Eigen::Vector2d> Source(const VirtualView& view, int x, int y) {
  const auto source =
      GenericFile().camera->Project(*view.Direction(Eigen::Vector2d(x, y)));
  if (!source || !GenericFile().camera->area().Contains(*source, -0.5))
    return std::nullopt;
  return source;
}

Image Made(int channels, const std::function<double(int, int, int)>& value) {
  Image image;
  image.size = {640, 480};
  image.channels = channels;
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x)
      for (int c = 0; c < channels; ++c)
        image.pixels.push_back(
            static_cast<uint8_t>(std::lround(value(x, y, c))));
  return image;
}

TEST(BlobCamera, ConstantImageStaysConstantInside) {
  const Image undistorted =
      Opened().Undistort(Made(1, [](int, int, int) { return 201; }), 7);
  ASSERT_EQ(undistorted.pixels.size(), 640u * 480u);
  int num_inside = 0;
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      const int value = undistorted.pixels[640 * y + x];
      EXPECT_TRUE(value == 201 || value == 7) << value;
      if (!Source(Virtual(), x, y)) continue;
      ++num_inside;
      EXPECT_EQ(value, 201) << x << ' ' << y;
    }
  }
  EXPECT_GT(num_inside, 200000);
}

double Waves(int x, int y, int c) {
  return 128 + 60 * std::sin(x / (9.0 + c)) +
         60 * std::cos(y / 11.0 + x / 30.0);
}

double Bilinear(const Image& image, const Eigen::Vector2d& at, int channel) {
  const int x = static_cast<int>(at.x()), y = static_cast<int>(at.y());
  const double u = at.x() - x, v = at.y() - y;
  const auto pixel = [&](int i, int j) {
    return image.pixels[(j * image.size.width + i) * image.channels + channel];
  };
  return (1 - v) * ((1 - u) * pixel(x, y) + u * pixel(x + 1, y)) +
         v * ((1 - u) * pixel(x, y + 1) + u * pixel(x + 1, y + 1));
}

TEST(BlobCamera, UndistortsSmoothImagesToTwoGreyLevels) {
  const Image image = Made(3, Waves);
  const Image undistorted = Opened().Undistort(image, 0);
  ASSERT_EQ(undistorted.channels, 3);
  double worst = 0;
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      const auto source = Source(Virtual(), x, y);
      if (!source) continue;
      for (int c = 0; c < 3; ++c)
        worst =
            std::max(worst, std::abs(undistorted.pixels[3 * (640 * y + x) + c] -
                                     Bilinear(image, *source, c)));
    }
  }
  EXPECT_LE(worst, 2);
  EXPECT_GT(worst, 0.1);  // the board computes in integers
}

TEST(BlobCamera, UndistortRefusesImagesOfAnotherSize) {
  Image image;
  image.size = {320, 240};
  image.pixels.resize(320 * 240);
  ExpectError(ExitCode::kInvalidBlob, {},
              [&] { Opened().Undistort(image, 0); });
}

TEST(BlobCamera, UndistortNeedsARemap) {
  const BlobCamera blob("p", PackCamera(GenericFile(), PackOptions()).blob);
  ExpectError(ExitCode::kInvalidBlob, {}, [&] {
    blob.Undistort(Made(1, [](int, int, int) { return 0; }), 0);
  });
}

TEST(BlobCamera, TellsTheViewOfItsTable) {
  const VirtualView view = Opened().GetRemapView(0);
  EXPECT_EQ(view.size, Virtual().size);
  EXPECT_LT((view.focal_px - Virtual().focal_px).norm(), 1e-4);
  EXPECT_LT((view.center_px - Virtual().center_px).norm(), 1e-4);
  ExpectError(ExitCode::kInvalidBlob, {}, [] { Opened().GetRemapView(1); });
}

}  // namespace
}  // namespace raygrid
