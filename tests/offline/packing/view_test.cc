// The pinhole views that images are undistorted to.
#include "packed_cameras.h"
#include "packing/remap_fitting.h"
#include "packing/view_request.h"

namespace raygrid {
namespace {

constexpr ImageSize kViewedSize = {320, 240};

const CameraModel& Example() { return *GenericFile().camera; }

ViewRequest RequestOf(const ImageSize& size) {
  ViewRequest request;
  request.size = size;
  return request;
}

VirtualView ViewOfAlpha(const CameraModel& camera, const ImageSize& size,
                        double alpha) {
  ViewRequest request = RequestOf(size);
  request.alpha = alpha;
  return MakeView(camera, request);
}

void ExpectRefused(const CameraModel& camera, const ViewRequest& request,
                   const std::vector<std::string>& words) {
  ExpectError(ExitCode::kUsage, words, [&] { MakeView(camera, request); });
}

// The output pixels of a view's table that come from nowhere.
int NumBorderPixels(const CameraModel& camera, const VirtualView& view) {
  CameraFile file;
  file.camera = std::shared_ptr<const CameraModel>(camera.Clone());
  PackOptions options;
  options.remaps = {view};
  options.max_error_px = 0.2;
  Image white;
  white.size = camera.image_size();
  white.pixels.assign(static_cast<size_t>(white.size.width) * white.size.height,
                      255);
  const Image seen =
      BlobCamera("blob", PackCamera(file, options).blob).Undistort(white, 0);
  return static_cast<int>(
      std::count(seen.pixels.begin(), seen.pixels.end(), 0));
}

TEST(VirtualView, HasTheFieldOfViewAskedFor) {
  for (const double field_deg : {1.0, 60.0, 90.0, 120.0, 170.0}) {
    const VirtualView view = ViewOf(Example(), {800, 600}, field_deg);
    EXPECT_NEAR(view.HorizontalFieldOfViewDeg(), field_deg, 1e-9);
    EXPECT_EQ(view.focal_px.x(), view.focal_px.y());
    EXPECT_EQ(view.size, (ImageSize{800, 600}));
    ViewRequest request = RequestOf({800, 600});
    request.vfov_deg = field_deg;
    EXPECT_NEAR(MakeView(Example(), request).VerticalFieldOfViewDeg(),
                field_deg, 1e-9);
    request.hfov_deg = 50;
    const VirtualView both = MakeView(Example(), request);
    EXPECT_NEAR(both.VerticalFieldOfViewDeg(), field_deg, 1e-9);
    EXPECT_NEAR(both.HorizontalFieldOfViewDeg(), 50, 1e-9);
  }
}

TEST(VirtualView, HasTheFieldOfViewAskedForAroundAnyCenter) {
  ViewRequest request = RequestOf({640, 480});
  request.hfov_deg = 80;
  request.center_px = Eigen::Vector2d(100, 20);
  const VirtualView view = MakeView(Example(), request);
  EXPECT_NEAR(view.HorizontalFieldOfViewDeg(), 80, 1e-9);
  EXPECT_EQ(view.center_px, Eigen::Vector2d(100, 20));
  const Eigen::Vector3d left = *view.Direction({-0.5, 20}),
                        right = *view.Direction({639.5, 20});
  EXPECT_NEAR(std::acos(left.normalized().dot(right.normalized())),
              80 * M_PI / 180, 1e-9);
}

TEST(VirtualView, IsByDefaultAsSharpAsTheImagesMiddle) {
  const auto focal_px = [](ImageSize size) {
    return ViewOf(Example(), size, 0).focal_px.x();
  };
  EXPECT_NEAR(focal_px({0, 0}), 531, 10);
  EXPECT_NEAR(focal_px({320, 240}), focal_px({640, 480}) / 2, 1e-9);
}

TEST(VirtualView, OfAlphaZeroHasNoBorderAndIsTheLargest) {
  for (const char* lens : {"pinhole", "wide", "fisheye"}) {
    for (const ImageSize size : {kViewedSize, ImageSize{200, 200}}) {
      const CentralGeneric camera =
          FitCentralGeneric(*MakeSimulatedCamera(lens, kViewedSize),
                            WholeImage(kViewedSize), 19, 15);
      VirtualView view = ViewOfAlpha(camera, size, 0);
      EXPECT_EQ(NumBorderPixels(camera, view), 0) << lens;
      if (view.HorizontalFieldOfViewDeg() > 130) continue;  // no larger one
      view.focal_px *= 0.98;
      view.center_px += 0.02 * (Eigen::Vector2d(size.width, size.height) / 2 -
                                view.center_px);
      EXPECT_GT(NumBorderPixels(camera, view), 0) << lens;
    }
  }
}

TEST(VirtualView, OfAlphaZeroIsNotWiderThanUsefulWhereALensSeesMore) {
  const auto camera = MakeSimulatedCamera("fisheye190", kViewedSize);
  const VirtualView view = ViewOfAlpha(*camera, kViewedSize, 0);
  EXPECT_NEAR(view.HorizontalFieldOfViewDeg(), 140, 1);
  for (int y = 0; y < kViewedSize.height; ++y)
    for (int x = 0; x < kViewedSize.width; ++x)
      ASSERT_TRUE(camera->Project(*view.Direction(Eigen::Vector2d(x, y))))
          << x << ", " << y;
}

TEST(VirtualView, OfAlphaOneShowsEveryPixelAndIsTheSmallest) {
  for (const char* lens : {"pinhole", "wide"}) {
    for (const ImageSize size : {kViewedSize, ImageSize{200, 300}}) {
      const auto camera = MakeSimulatedCamera(lens, kViewedSize);
      const VirtualView view = ViewOfAlpha(*camera, size, 1);
      Eigen::AlignedBox2d box;
      for (int y = 0; y < kViewedSize.height; ++y)
        for (int x = 0; x < kViewedSize.width; ++x)
          box.extend(*view.Pixel(*camera->Unproject(Eigen::Vector2d(x, y))));
      const Eigen::Vector2d last(size.width - 1, size.height - 1);
      EXPECT_GE(box.min().minCoeff(), 0) << lens;
      EXPECT_TRUE((box.max().array() <= last.array()).all()) << lens;
      EXPECT_GT((box.sizes().array() / last.array()).maxCoeff(), 0.97) << lens;
    }
  }
}

// A fisheye's image circle within its image: corners are dark.
std::unique_ptr<CameraModel> CameraWithCircle(const char* lens) {
  auto camera = MakeSimulatedCamera(lens, kViewedSize)->Clone();
  camera->SetImageCircle(ImageCircle{{165, 115}, {100, 100}});
  return camera;
}

TEST(VirtualView, OfAlphaZeroLiesInTheImageCircle) {
  for (const ViewProjection projection :
       {ViewProjection::kPinhole, ViewProjection::kEquidistant}) {
    const auto camera = CameraWithCircle("fisheye");
    ViewRequest request = RequestOf(kViewedSize);
    request.projection = projection;
    request.alpha = 0;
    const VirtualView view = MakeView(*camera, request);
    double farthest_px = 0;
    for (int y = 0; y < kViewedSize.height; ++y)
      for (int x = 0; x < kViewedSize.width; ++x) {
        const auto source =
            camera->Project(*view.Direction(Eigen::Vector2d(x, y)));
        ASSERT_TRUE(source && camera->IsInImageCircle(*source))
            << x << ", " << y;
        farthest_px = std::max(
            farthest_px, (*source - camera->image_circle()->center).norm());
      }
    EXPECT_GT(farthest_px, 98);
  }
}

TEST(VirtualView, OfAlphaOneShowsTheImageCircleAndNotMuchMore) {
  const auto camera = CameraWithCircle("fisheye");
  ViewRequest request = RequestOf(kViewedSize);
  request.projection = ViewProjection::kEquidistant;
  request.alpha = 1;
  const VirtualView view = MakeView(*camera, request);
  Eigen::AlignedBox2d box;
  for (int y = 0; y < kViewedSize.height; ++y)
    for (int x = 0; x < kViewedSize.width; ++x)
      if (const Eigen::Vector2d pixel(x, y); camera->IsInImageCircle(pixel))
        box.extend(*view.Pixel(*camera->Unproject(pixel)));
  const Eigen::Vector2d last(kViewedSize.width - 1, kViewedSize.height - 1);
  EXPECT_GE(box.min().minCoeff(), 0);
  EXPECT_TRUE((box.max().array() <= last.array()).all());
  EXPECT_GT((box.sizes().array() / last.array()).maxCoeff(), 0.97);
}

// Blocks of the table are up to 16 pixels wide.
TEST(VirtualView, IsBorderBeyondTheImageCircle) {
  const CentralGeneric unlimited =
      FitCentralGeneric(*MakeSimulatedCamera("wide", kViewedSize),
                        WholeImage(kViewedSize), 19, 15);
  const VirtualView wide = ViewOfAlpha(unlimited, kViewedSize, 1);
  CentralGeneric camera = unlimited;
  const ImageCircle circle = {{165, 115}, {100, 100}};
  camera.SetImageCircle(circle);
  CameraFile file;
  file.camera = std::make_shared<CentralGeneric>(camera);
  PackOptions options;
  options.remaps = {wide};
  options.max_error_px = 0.2;
  Image white;
  white.size = kViewedSize;
  white.pixels.assign(
      static_cast<size_t>(kViewedSize.width) * kViewedSize.height, 255);
  const Image seen =
      BlobCamera("blob", PackCamera(file, options).blob).Undistort(white, 0);
  int num_beyond = 0;
  for (int y = 0; y < kViewedSize.height; ++y)
    for (int x = 0; x < kViewedSize.width; ++x) {
      const auto source =
          unlimited.Project(*wide.Direction(Eigen::Vector2d(x, y)));
      if (!source) continue;
      const double beyond_px =
          (*source - circle.center).norm() - circle.radii_px.x();
      const int level = seen.pixels[y * kViewedSize.width + x];
      if (beyond_px <= -1) {
        ASSERT_EQ(level, 255) << x << ", " << y;
      }
      if (beyond_px <= 30) continue;
      ASSERT_EQ(level, 0) << x << ", " << y;
      ++num_beyond;
    }
  EXPECT_GT(num_beyond, 5000);
  EXPECT_LT(ViewOfAlpha(camera, kViewedSize, 1).HorizontalFieldOfViewDeg(),
            wide.HorizontalFieldOfViewDeg());
}

TEST(VirtualView, OfAlphaBetweenIsBetween) {
  const auto camera = MakeSimulatedCamera("wide", kViewedSize);
  const VirtualView none = ViewOfAlpha(*camera, kViewedSize, 0),
                    half = ViewOfAlpha(*camera, kViewedSize, 0.5),
                    all = ViewOfAlpha(*camera, kViewedSize, 1);
  EXPECT_NEAR(half.focal_px.x(), (none.focal_px + all.focal_px).x() / 2, 1e-9);
  EXPECT_LT((half.center_px - (none.center_px + all.center_px) / 2).norm(),
            1e-9);
}

TEST(VirtualView, OfAlphaOneIsRefusedForLensesThatNoPinholeShows) {
  const auto camera = MakeSimulatedCamera("fisheye190", kViewedSize);
  ViewRequest request = RequestOf(kViewedSize);
  request.alpha = 1;
  ExpectRefused(*camera, request, {"alpha", "degrees off its axis", "alpha=0"});
}

constexpr ViewProjection kProjections[] = {
    ViewProjection::kPinhole, ViewProjection::kCylindrical,
    ViewProjection::kEquirectangular, ViewProjection::kStereographic,
    ViewProjection::kEquidistant};

ViewRequest RequestOf(ViewProjection projection, double hfov_deg) {
  ViewRequest request = RequestOf(kViewedSize);
  request.projection = projection;
  request.hfov_deg = hfov_deg;
  return request;
}

TEST(VirtualView, OfAnyProjectionHasTheFieldOfViewAskedFor) {
  for (const ViewProjection projection : kProjections) {
    for (const double field_deg : {20.0, 100.0, 160.0}) {
      ViewRequest request = RequestOf(projection, field_deg);
      request.center_px = Eigen::Vector2d(200, 100);
      const VirtualView view = MakeView(Example(), request);
      const Eigen::Vector3d left = *view.Direction({-0.5, 100}),
                            right = *view.Direction({319.5, 100});
      EXPECT_NEAR(std::acos(left.normalized().dot(right.normalized())),
                  field_deg * M_PI / 180, 1e-9)
          << ProjectionName(projection);
      EXPECT_NEAR(view.HorizontalFieldOfViewDeg(), field_deg, 1e-9);
    }
  }
}

TEST(VirtualView, SeesNoMoreThanItsProjectionShows) {
  for (const auto& [projection, hfov_deg, vfov_deg] :
       {std::tuple(ViewProjection::kCylindrical, 360.0, 161.0),
        std::tuple(ViewProjection::kEquirectangular, 360.0, 180.0),
        std::tuple(ViewProjection::kEquidistant, 360.0, 360.0)}) {
    ViewRequest request = RequestOf(kViewedSize);
    request.projection = projection;
    request.focal_px = 20;
    const VirtualView view = MakeView(Example(), request);
    EXPECT_NEAR(view.HorizontalFieldOfViewDeg(), hfov_deg, 0.1);
    EXPECT_NEAR(view.VerticalFieldOfViewDeg(), vfov_deg, 0.1);
    // The whole way around is asked for by the angle, too.
    request.focal_px.reset();
    request.hfov_deg = 360;
    EXPECT_NEAR(MakeView(Example(), request).focal_px.x(),
                kViewedSize.width / (2 * M_PI), 1e-6);
  }
}

TEST(VirtualView, IsTurnedToTheRightThenUpThenClockwise) {
  ViewRequest request = RequestOf(ViewProjection::kPinhole, 60);
  const auto turned = [&](double yaw, double pitch, double roll) {
    request.rotate_deg = Eigen::Vector3d(yaw, pitch, roll);
    return MakeView(Example(), request);
  };
  const Eigen::Vector2d center(159.5, 119.5), right(259.5, 119.5);
  const double s = std::sqrt(0.5);
  EXPECT_LT(
      (*turned(45, 0, 0).Direction(center) - Eigen::Vector3d(s, 0, s)).norm(),
      1e-12);
  EXPECT_LT(
      (*turned(0, 45, 0).Direction(center) - Eigen::Vector3d(0, -s, s)).norm(),
      1e-12);
  // Its right is below, so what it shows is turned the other way.
  const Eigen::Vector3d rolled = *turned(0, 0, 90).Direction(right);
  EXPECT_NEAR(rolled.x(), 0, 1e-12);
  EXPECT_GT(rolled.y(), 0.3);
  // Yaw is around the camera's own vertical axis.
  EXPECT_LT((*turned(90, 30, 0).Direction(center) -
             Eigen::Vector3d(std::sqrt(0.75), -0.5, 0))
                .norm(),
            1e-12);
  for (const Eigen::Vector3d& angles :
       {Eigen::Vector3d(30, -20, 100), Eigen::Vector3d(-170, 80, -3),
        Eigen::Vector3d(0, 90, 35), Eigen::Vector3d(0, -90, -120)})
    EXPECT_LT((RotationToAngles(RotationFromAngles(angles)) - angles).norm(),
              1e-9);
}

TEST(VirtualView, OfAnyProjectionAndAlphaZeroHasNoBorder) {
  for (const char* lens : {"wide", "fisheye", "fisheye190"}) {
    const CentralGeneric camera =
        FitCentralGeneric(*MakeSimulatedCamera(lens, kViewedSize),
                          WholeImage(kViewedSize), 19, 15);
    for (const ViewProjection projection : kProjections) {
      ViewRequest request = RequestOf({480, 360});
      request.projection = projection;
      request.alpha = 0;
      EXPECT_EQ(NumBorderPixels(camera, MakeView(camera, request)), 0)
          << lens << ' ' << ProjectionName(projection);
      request.rotate_deg = Eigen::Vector3d(10, -5, 90);
      EXPECT_EQ(NumBorderPixels(camera, MakeView(camera, request)), 0)
          << lens << ' ' << ProjectionName(projection) << ", turned";
    }
  }
}

TEST(VirtualView, OfAnyProjectionAndAlphaOneShowsEveryPixel) {
  for (const char* lens : {"pinhole", "wide", "fisheye190"}) {
    const auto camera = MakeSimulatedCamera(lens, kViewedSize);
    for (const ViewProjection projection : kProjections) {
      if (projection == ViewProjection::kPinhole) continue;
      ViewRequest request = RequestOf({200, 150});
      request.projection = projection;
      request.alpha = 1;
      request.rotate_deg = Eigen::Vector3d(10, -5, 30);
      if (projection == ViewProjection::kCylindrical &&
          std::string(lens) == "fisheye190") {
        ExpectRefused(*camera, request, {"alpha", "horizon"});
        continue;
      }
      const VirtualView view = MakeView(*camera, request);
      Eigen::AlignedBox2d box;
      for (int y = 0; y < kViewedSize.height; ++y) {
        for (int x = 0; x < kViewedSize.width; ++x) {
          const auto ray = camera->Unproject(Eigen::Vector2d(x, y));
          if (ray) box.extend(*view.Pixel(*ray));
        }
      }
      EXPECT_GE(box.min().minCoeff(), 0)
          << lens << ' ' << ProjectionName(projection);
      EXPECT_LE(box.max().x(), 199);
      EXPECT_LE(box.max().y(), 149);
      EXPECT_GT((box.sizes().array() / Eigen::Array2d(199, 149)).maxCoeff(),
                0.97);
    }
  }
}

// Tables of cameras of lines show far scenes.
TEST(VirtualView, OfAlphaZeroAndOneIsSoForEveryOtherLens) {
  for (const char* lens : {"example", "noncentral", "glass"}) {
    const ImageSize size = {640, 480};
    const auto truth = MakeSimulatedCamera(lens, size);
    const std::unique_ptr<CameraModel> camera =
        truth->IsCentral()
            ? FitCentralGeneric(*truth, WholeImage(size), 27, 21).Clone()
            : FitNonCentralGeneric(*truth, WholeImage(size), 27, 21).Clone();
    ViewRequest request = RequestOf(kViewedSize);
    request.projection = ViewProjection::kEquidistant;
    request.alpha = 0;
    EXPECT_EQ(NumBorderPixels(*camera, MakeView(*camera, request)), 0) << lens;
    request.alpha = 1;
    const VirtualView all = MakeView(*camera, request);
    Eigen::AlignedBox2d box;
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x)
        box.extend(*all.Pixel(*camera->Unproject(Eigen::Vector2d(x, y))));
    const Eigen::Vector2d last(kViewedSize.width - 1, kViewedSize.height - 1);
    EXPECT_GE(box.min().minCoeff(), 0) << lens;
    EXPECT_TRUE((box.max().array() <= last.array()).all()) << lens;
    EXPECT_GT((box.sizes().array() / last.array()).maxCoeff(), 0.97) << lens;
  }
}

TEST(VirtualView, OfAnyProjectionIsACameraAndComesBackFromIt) {
  for (const ViewProjection projection : kProjections) {
    ViewRequest request = RequestOf(projection, 120);
    request.rotate_deg = Eigen::Vector3d(10, 20, 30);
    const VirtualView view = MakeView(Example(), request);
    const auto camera = MakeViewCamera(view);
    const Eigen::Vector2d pixel(30, 200);
    EXPECT_LT((view.camera_from_view * *camera->Unproject(pixel) -
               view.Direction(pixel)->normalized())
                  .norm(),
              1e-12);
    const auto back = MakeCameraView(*camera);
    ASSERT_TRUE(back);
    EXPECT_EQ(back->projection, projection);
    EXPECT_EQ(back->focal_px, view.focal_px);
    EXPECT_FALSE(back->IsTurned());
  }
}

TEST(VirtualView, IsACameraAndComesBackFromIt) {
  ViewRequest request = RequestOf({640, 480});
  request.hfov_deg = 80;
  request.vfov_deg = 30;
  request.center_px = Eigen::Vector2d(100, 20);
  const VirtualView view = MakeView(Example(), request);
  const auto camera = MakeViewCamera(view);
  for (const Eigen::Vector2d& pixel :
       {Eigen::Vector2d(0, 0), Eigen::Vector2d(639, 479)}) {
    EXPECT_LT(camera->Unproject(pixel)
                  ->cross(view.Direction(pixel)->normalized())
                  .norm(),
              1e-12);
    EXPECT_LT((*view.Pixel(*view.Direction(pixel)) - pixel).norm(), 1e-9);
  }
  const auto back = MakeCameraView(*camera);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->focal_px, view.focal_px);
  EXPECT_EQ(back->center_px, view.center_px);
  EXPECT_FALSE(MakeCameraView(Example()));
}

TEST(VirtualView, LikeAnotherIsScaledToTheSize) {
  ViewRequest request;
  request.like = ViewOf(Example(), {640, 480}, 70);
  EXPECT_EQ(MakeView(Example(), request).focal_px, request.like->focal_px);
  request.size = {320, 240};
  const VirtualView half = MakeView(Example(), request);
  EXPECT_NEAR(half.HorizontalFieldOfViewDeg(), 70, 1e-9);
  EXPECT_EQ(half.size, (ImageSize{320, 240}));
}

TEST(VirtualView, RefusesWhatNoPinholeHas) {
  for (const double field_deg : {-10.0, 171.0, 180.0, 360.0, double{NAN}}) {
    ViewRequest request = RequestOf({640, 480});
    request.hfov_deg = field_deg;
    ExpectRefused(Example(), request, {"field of view"});
  }
  for (const double alpha : {-0.1, 1.1, double{NAN}}) {
    ViewRequest request = RequestOf({640, 480});
    request.alpha = alpha;
    ExpectRefused(Example(), request, {"alpha", "must be 0"});
  }
  ViewRequest request = RequestOf({640, 480});
  request.focal_px = -3;
  ExpectRefused(Example(), request, {"focal length"});
  request.hfov_deg = 90;
  ExpectRefused(Example(), request, {"mutually exclusive"});
  request.focal_px.reset();
  request.center_px = Eigen::Vector2d(-5, 100);
  ExpectRefused(Example(), request, {"center outside", "focal length"});
}

TEST(VirtualView, RefusesAnglesThatItsProjectionDoesNotHave) {
  const auto refused = [](ViewProjection projection, double hfov_deg,
                          double vfov_deg) {
    ViewRequest request = RequestOf(projection, hfov_deg);
    request.vfov_deg = vfov_deg;
    ExpectRefused(Example(), request,
                  {"field of view", ProjectionName(projection)});
  };
  refused(ViewProjection::kCylindrical, 361, 90);
  refused(ViewProjection::kCylindrical, 180, 171);
  refused(ViewProjection::kEquirectangular, 180, 181);
  refused(ViewProjection::kStereographic, 341, 90);
  refused(ViewProjection::kEquidistant, 361, 90);
  ViewRequest request;
  request.like = ViewOf(Example(), {640, 480}, 70);
  request.rotate_deg = Eigen::Vector3d(0, 0, 0);
  ExpectRefused(Example(), request,
                {"view cannot be combined", "rotate", "projection"});
  // Nothing of the area's middle is seen there.
  request = RequestOf(kViewedSize);
  request.alpha = 0;
  request.rotate_deg = Eigen::Vector3d(180, 0, 0);
  ExpectRefused(Example(), request, {"centre", "rotate"});
}

TEST(VirtualView, RefusesWhatBlobsDoNotHold) {
  EXPECT_LT(ViewOf(Example(), {640, 480}, 0.56).focal_px.x(), 65536);
  ViewRequest request = RequestOf({640, 480});
  request.hfov_deg = 0.55;
  ExpectRefused(Example(), request, {"focal length", "0.561"});
  request = RequestOf({640, 480});
  request.center_px = Eigen::Vector2d(40000, 0);
  ExpectRefused(Example(), request, {"center", "32767"});
}

}  // namespace
}  // namespace raygrid
