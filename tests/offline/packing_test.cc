#include <cstdio>
#include <functional>
#include <limits>

#include "camera/central_generic.h"
#include "camera/noncentral_generic.h"
#include "packing/blob_camera.h"
#include "packing/narrow_grid.h"
#include "packing/pack.h"
#include "packing/virtual_camera.h"
#include "simulation/simulated_camera.h"
#include "support.h"

namespace raygrid {
namespace {

// Fitted once for all tests.
const CameraFile& GenericFile() {
  static const CameraFile* const file = [] {
    auto* made = new CameraFile;
    made->camera = std::make_shared<CentralGeneric>(
        FittedGrid(ExampleSimulatedCamera(), 40));
    made->name = "front";
    made->serial = "0042";
    made->training = {0.1, 0.12, 0.9, 3000};
    return made;
  }();
  return *file;
}

VirtualCamera Virtual() {
  return MakeVirtualCamera(*GenericFile().camera, {640, 480}, 0);
}

PackOptions WithRemap(double max_error_px = 0.05) {
  PackOptions options;
  options.remaps = {Virtual()};
  options.max_error_px = max_error_px;
  return options;
}

const PackedCamera& Packed() {
  static const PackedCamera* const packed =
      new PackedCamera(PackCamera(GenericFile(), WithRemap()));
  return *packed;
}

const BlobCamera& Opened() {
  static const BlobCamera* const camera =
      new BlobCamera("packed", Packed().blob);
  return *camera;
}

TEST(PackCamera, IsSmallAndExact) {
  EXPECT_LE(Packed().blob.size(), 10000u);
  EXPECT_LE(Packed().unproject_error_px, 0.002);
  EXPECT_LE(Packed().unproject_error_rad, 1e-6);
  EXPECT_GT(Packed().unproject_error_rad, 0);
  ASSERT_EQ(Packed().remaps.size(), 1u);
  EXPECT_LE(Packed().remaps[0].error_px, 0.05);
  std::printf(
      "blob %zu bytes, blocks of %d, %.2g px, %.2g rad, remap %.3f px\n",
      Packed().blob.size(), Packed().remaps[0].block_size,
      Packed().unproject_error_px, Packed().unproject_error_rad,
      Packed().remaps[0].error_px);
}

TEST(PackCamera, GivesTheSameBytesEachTime) {
  PackOptions options = WithRemap();
  options.num_threads = 1;
  EXPECT_EQ(PackCamera(GenericFile(), options).blob, Packed().blob);
}

TEST(PackCamera, WithoutRemapIsSmaller) {
  const PackedCamera packed = PackCamera(GenericFile(), PackOptions());
  EXPECT_TRUE(packed.remaps.empty());
  EXPECT_LT(packed.blob.size(), Packed().blob.size());
  EXPECT_FALSE(BlobCamera("packed", packed.blob).has_remap());
}

TEST(PackCamera, TighterBoundTakesSmallerBlocksAndIsKept) {
  const PackedCamera packed = PackCamera(GenericFile(), WithRemap(0.012));
  EXPECT_LE(packed.remaps[0].error_px, 0.012);
  EXPECT_LT(packed.remaps[0].block_size, Packed().remaps[0].block_size);
  EXPECT_GT(packed.blob.size(), Packed().blob.size());
}

TEST(PackCamera, BoundThatCannotBeKeptIsAnError) {
  ExpectError(ExitCode::kQuality, {"--max-error-px"},
              [] { PackCamera(GenericFile(), WithRemap(1e-4)); });
}

TEST(PackCamera, TooLongNamesAreRefused) {
  CameraFile file = GenericFile();
  file.name = std::string(31, 'x');
  EXPECT_NO_THROW(PackCamera(file, PackOptions()));
  file.name += 'x';
  ExpectError(ExitCode::kUsage, {"name"},
              [&] { PackCamera(file, PackOptions()); });
}

TEST(PackCamera, ParametricCamerasPackToo) {
  CameraFile file;
  const OpenCvModel lens = ExampleLens();
  file.camera = std::make_shared<OpenCvModel>(lens);
  PackOptions options = WithRemap();
  const PackedCamera packed = PackCamera(file, options);
  EXPECT_LE(packed.unproject_error_px, kMaxPackingErrorPx);
  const BlobCamera blob("packed", packed.blob);
  TestRandom random(2);
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn({1, 1, 638, 478});
    EXPECT_LT(blob.Unproject(pixel)->cross(*lens.Unproject(pixel)).norm(),
              1e-5);
  }
}

TEST(PackCamera, CamerasWithoutRaysInTheirAreaAreRefused) {
  // Most of the area lies beyond this lens's fold.
  const ImageSize size = {640, 480};
  CameraFile file;
  file.camera = std::make_shared<OpenCvModel>(
      size, WholeImage(size),
      OpenCvModel::ParameterArray{300, 300, 320, 240, -0.5, 0, 0, 0, 0, 0, 0,
                                  0});
  EXPECT_THROW(PackCamera(file, PackOptions()), Error);
}

TEST(PackCamera, PacksAFisheye) {
  CameraFile file;
  file.camera = std::make_shared<CentralGeneric>(ExampleFisheye());
  PackOptions options;
  options.remaps = {MakeVirtualCamera(*file.camera, {640, 480}, 120)};
  const PackedCamera packed = PackCamera(file, options);
  EXPECT_LE(packed.unproject_error_px, kMaxPackingErrorPx);
  EXPECT_LE(packed.remaps[0].error_px, options.max_error_px);
}

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

// Pixels all over the area, its edge among them, there and back.
void ExpectRoundTrips(const BlobCamera& camera, const CameraModel& model) {
  const Area& area = model.area();
  for (int j = 0; j <= 90; ++j) {
    for (int i = 0; i <= 120; ++i) {
      const Eigen::Vector2d exact(area.x0 + area.width() * i / 120,
                                  area.y0 + area.height() * j / 90);
      const Eigen::Vector2d pixel =
          (exact * 65536).array().round().matrix() / 65536;
      const auto ray = camera.Unproject(pixel);
      if (!ray) continue;
      const auto back = camera.Project(*ray * 3.7);
      ASSERT_TRUE(back) << pixel.transpose();
      EXPECT_LT((*back - pixel).norm(), 0.002) << pixel.transpose();
    }
  }
}

TEST(BlobCamera, ProjectsWhatItUnprojects) {
  ExpectRoundTrips(Opened(), *GenericFile().camera);
  CameraFile file;
  file.camera = std::make_shared<CentralGeneric>(ExampleFisheye());
  const PackedCamera packed = PackCamera(file, PackOptions());
  ExpectRoundTrips(BlobCamera("fisheye", packed.blob), *file.camera);
}

// A fisheye that is trusted around its middle, the control points of a corner
// so many times as far from its axis.
CameraFile FisheyeWithCorner(double times) {
  CentralGeneric lens = ExampleFisheye();
  Eigen::VectorXd parameters = lens.Parameters();
  for (const int node : {0, 1, lens.surface().columns()})
    parameters.segment<2>(2 * node) *= times;
  lens.SetParameters(parameters);
  CameraFile file;
  file.camera = std::make_shared<CentralGeneric>(lens);
  CameraUncertainty& known = file.uncertainty.emplace();
  known.lattice = {2, 2, {0.01, 0.01, 0.01, 0.01}};
  known.mask = TrustMask::Over(lens.image_size());
  const Eigen::Vector2d middle(320, 240);
  for (size_t k = 0; k < known.mask.is_trusted.size(); ++k)
    known.mask.is_trusted[k] =
        (known.mask.CellCenter(static_cast<int>(k)) - middle).norm() < 230;
  return file;
}

void ExpectTrustedRoundTrips(const CameraFile& file) {
  const BlobCamera blob("corner", PackCamera(file, PackOptions()).blob);
  TestRandom random(15);
  int num_trusted = 0;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn(file.camera->area());
    if (!file.uncertainty->mask.Trusts(pixel)) continue;
    ++num_trusted;
    const auto back = blob.Project(*file.camera->Unproject(pixel));
    ASSERT_TRUE(back) << pixel.transpose();
    EXPECT_LT((*back - pixel).norm(), 0.002);
  }
  EXPECT_GT(num_trusted, 100);
}

TEST(BlobCamera, ProjectsWhereAFisheyeIsTrustedThoughItsCornerFolds) {
  ExpectTrustedRoundTrips(FisheyeWithCorner(-1));
}

TEST(BlobCamera, HoldsAFisheyeWhoseCornerLooksTooFarBackIfItIsNotTrusted) {
  CameraFile file = FisheyeWithCorner(10);
  ExpectTrustedRoundTrips(file);
  file.uncertainty->mask.is_trusted[0] = true;
  EXPECT_THROW(PackCamera(file, PackOptions()), Error);
  file.uncertainty.reset();
  EXPECT_THROW(PackCamera(file, PackOptions()), Error);
}

// Every pixel of the area, there and back, of those that count.
void ExpectAllFound(const FoundPixels& pixels) {
  EXPECT_GT(pixels.num_pixels, 1000);
  EXPECT_EQ(pixels.num_unfindable, 0);
  EXPECT_EQ(pixels.num_lost, 0);
  EXPECT_EQ(pixels.num_off, 0);
  EXPECT_LE(pixels.worst_px, 0.002);
}

// Trusted in a few cells near the middle, as a camera that was calibrated with
// few pictures of a small board.
CameraFile HardlyTrusted(std::shared_ptr<const CameraModel> camera) {
  CameraFile file;
  file.camera = std::move(camera);
  CameraUncertainty& known = file.uncertainty.emplace();
  known.lattice = {2, 2, {0.01, 0.01, 0.01, 0.01}};
  known.mask = TrustMask::Over(file.camera->image_size());
  for (size_t k = 0; k < known.mask.is_trusted.size(); ++k)
    known.mask.is_trusted[k] =
        (known.mask.CellCenter(static_cast<int>(k)) - Eigen::Vector2d(350, 210))
            .norm() < 50;
  return file;
}

TEST(PackCamera, FindsTheWholeAreaAgainThoughHardlyAnyOfItIsTrusted) {
  const std::shared_ptr<const CameraModel> fisheye =
      std::make_shared<CentralGeneric>(ExampleFisheye());
  for (const auto& camera : {GenericFile().camera, fisheye}) {
    const CameraFile file = HardlyTrusted(camera);
    const PackedCamera packed = PackCamera(file, PackOptions());
    EXPECT_TRUE(packed.remarks.empty());
    ASSERT_TRUE(packed.projection);
    ExpectAllFound(packed.projection->trusted);
    ExpectAllFound(packed.projection->others);
    ExpectRoundTrips(BlobCamera("hardly trusted", packed.blob), *camera);
  }
}

// The fisheye, with control points thrown about: no two cells are alike.
CameraFile RoughFile(double throw_chart) {
  CentralGeneric lens = ExampleFisheye();
  Eigen::VectorXd parameters = lens.Parameters();
  TestRandom random(4);
  for (int k = 0; k < parameters.size() / 2; ++k)
    parameters.segment<2>(2 * k) +=
        random.PixelIn({-throw_chart, -throw_chart, throw_chart, throw_chart});
  lens.SetParameters(parameters);
  CameraFile file;
  file.camera = std::make_shared<CentralGeneric>(lens);
  return file;
}

TEST(PackCamera, RoughCamerasGetFinerInverseGrids) {
  const PackedCamera smooth = PackCamera(RoughFile(0), PackOptions());
  const PackedCamera rough = PackCamera(RoughFile(0.01), PackOptions());
  ASSERT_TRUE(smooth.projection && rough.projection);
  ExpectAllFound(smooth.projection->trusted);
  ExpectAllFound(rough.projection->trusted);
  EXPECT_TRUE(rough.remarks.empty());
  EXPECT_GT(rough.blob.size(), smooth.blob.size());
}

TEST(PackCamera, SaysWhatProjectionMisses) {
  const CameraFile file = RoughFile(0.2);
  const PackedCamera packed = PackCamera(file, PackOptions());
  ASSERT_TRUE(packed.projection);
  EXPECT_GT(packed.projection->trusted.MissedPart(), 0);
  EXPECT_GT(packed.projection->trusted.num_unfindable, 0);
  ASSERT_EQ(packed.remarks.size(), 1u);
  EXPECT_NE(packed.remarks[0].find("not found"), std::string::npos);
  // The figures are the runtime's.
  const BlobCamera blob("rough", packed.blob);
  const ProjectionError again = MeasureProjection(blob, nullptr, 1e6, 1);
  EXPECT_EQ(again.trusted.num_lost, packed.projection->trusted.num_lost);
  EXPECT_EQ(again.trusted.worst_px, packed.projection->trusted.worst_px);
}

TEST(PackCamera, TakesControlPointsOf32BitsIfAskedTo) {
  PackOptions options;
  options.is_narrow_allowed = false;
  const PackedCamera narrow = PackCamera(GenericFile(), PackOptions());
  const PackedCamera wide = PackCamera(GenericFile(), options);
  EXPECT_GT(wide.blob.size(), narrow.blob.size() + 500);
  EXPECT_LT(wide.unproject_error_rad, narrow.unproject_error_rad);
}

TEST(Narrow, RefusesPointsFarFromTheirPlane) {
  constexpr int32_t kLargest = std::numeric_limits<int32_t>::max();
  ControlPoints points = {4, 5, {}};
  for (int k = 0; k < 20; ++k)
    points.values.insert(points.values.end(),
                         {k % 2 ? kLargest : -kLargest, k / 4 % 2 ? 5 : 7});
  EXPECT_FALSE(Narrow(points));
  // The plane, drawn out to the first point, lies beyond 32 bits.
  for (int k = 0; k < 20; ++k)
    points.values[2 * k] = k == 0 || k >= 12 ? kLargest : -kLargest;
  EXPECT_FALSE(Narrow(points));
}

TEST(PackCamera, HoldsCamerasThatNoInverseGridLeadsBackTo) {
  // Pixels beyond 16256 px do not fit one.
  CameraFile file;
  file.camera = std::make_shared<OpenCvModel>(
      ImageSize{16384, 16}, WholeImage({16384, 16}),
      OpenCvModel::ParameterArray{16000, 16000, 8192, 8, 0, 0, 0, 0, 0, 0, 0,
                                  0});
  const PackedCamera packed = PackCamera(file, PackOptions());
  EXPECT_FALSE(packed.projection);
  ASSERT_EQ(packed.remarks.size(), 1u);
  const BlobCamera blob("wide", packed.blob);
  EXPECT_FALSE(blob.CanProject());
  EXPECT_TRUE(blob.Unproject({16000, 8}));
}

TEST(PackCamera, HoldsSeveralRemapTables) {
  PackOptions options = WithRemap();
  options.remaps.push_back(
      MakeVirtualCamera(*GenericFile().camera, {320, 200}, 40));
  const PackedCamera packed = PackCamera(GenericFile(), options);
  ASSERT_EQ(packed.remaps.size(), 2u);
  const BlobCamera blob("two", packed.blob);
  for (uint32_t k = 0; k < 2; ++k) {
    rg_camera camera = blob.camera();
    uint16_t width, height;
    ASSERT_EQ(rg_select_remap(&camera, k), RG_OK);
    ASSERT_EQ(rg_remap_size(&camera, &width, &height), RG_OK);
    EXPECT_EQ((ImageSize{width, height}), options.remaps[k].size);
    EXPECT_EQ(packed.remaps[k].size, options.remaps[k].size);
  }
}

TEST(PackCamera, MeasuresChroma) {
  const PackedRemap coarse = Packed().remaps[0];
  const PackedRemap fine =
      PackCamera(GenericFile(), WithRemap(0.012)).remaps[0];
  EXPECT_GT(coarse.chroma_error_px, 0);
  EXPECT_LE(fine.chroma_error_px, 3.5 * fine.error_px);
  if (coarse.part_size > 8) {
    EXPECT_LE(coarse.chroma_error_px, coarse.error_px);
  }
}

TEST(BlobCamera, ProjectsAsTheCamera) {
  TestRandom random(5);
  int num_seen = 0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector2d direction = random.PixelIn({-1.5, -1.5, 1.5, 1.5});
    const Eigen::Vector3d point(direction.x(), direction.y(), 1);
    const auto exact = GenericFile().camera->Project(point);
    const auto pixel = Opened().Project(point);
    if (exact && !GenericFile().camera->area().Contains(*exact, 0.01) &&
        GenericFile().camera->area().Contains(*exact, -0.01))
      continue;
    ASSERT_EQ(exact.has_value(), pixel.has_value()) << point.transpose();
    if (!exact) continue;
    ++num_seen;
    EXPECT_LT((*exact - *pixel).norm(), 0.002);
  }
  EXPECT_GT(num_seen, 100);
}

TEST(BlobCamera, ToModelIsTheCamera) {
  const std::unique_ptr<CameraModel> model = Opened().ToModel();
  EXPECT_EQ(model->image_size(), GenericFile().camera->image_size());
  EXPECT_LT((model->Parameters() - GenericFile().camera->Parameters())
                .cwiseAbs()
                .maxCoeff(),
            kMaxNarrowErrorRad);
}

// Lines that leave the example camera through points up to 1 cm off its centre.
NonCentralGeneric CameraOfLines(const BSplineSurface& directions) {
  std::vector<Eigen::Vector3d> points;
  TestRandom random(8);
  for (int k = 0; k < directions.num_points(); ++k) {
    const Eigen::Vector2d xy = random.PixelIn({-0.01, -0.01, 0.01, 0.01});
    points.emplace_back(xy.x(), xy.y(), 0.005 * (k % 3));
  }
  return NonCentralGeneric({640, 480}, directions, points);
}

TEST(PackCamera, PacksTheLinesOfANonCentralCamera) {
  const auto& central =
      dynamic_cast<const CentralGeneric&>(*GenericFile().camera);
  CameraFile file = GenericFile();
  file.camera =
      std::make_shared<NonCentralGeneric>(CameraOfLines(central.surface()));
  const PackedCamera packed = PackCamera(file, WithRemap());
  const BlobCamera blob("lines", packed.blob);
  const std::unique_ptr<CameraModel> model = blob.ToModel();
  EXPECT_FALSE(model->IsCentral());
  TestRandom random(3);
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector2d pixel =
        (random.PixelIn({1, 1, 638, 478}) * 65536).array().round() / 65536;
    const auto exact = file.camera->Line(pixel);
    const auto line = blob.Line(pixel);
    ASSERT_TRUE(exact && line);
    EXPECT_LT((line->origin - exact->origin).norm(), 5e-8);
    EXPECT_LT(line->direction.cross(exact->direction).norm(), 1e-6);
    EXPECT_LT((model->Line(pixel)->origin - exact->origin).norm(), 1e-8);
  }
  EXPECT_FALSE(blob.Project({0, 0, 1}));
  EXPECT_TRUE(blob.has_remap());
}

TEST(BlobCamera, RefusesDamagedBlobsByName) {
  for (size_t i = 0; i < Packed().blob.size(); i += 997) {
    std::string damaged = Packed().blob;
    damaged[i] ^= 0x10;
    ExpectError(ExitCode::kBlob, {"d.raygrid"},
                [&] { BlobCamera("d.raygrid", damaged); });
  }
  for (const size_t size : {size_t{0}, size_t{3}, Packed().blob.size() - 1})
    ExpectError(ExitCode::kBlob, {"d.raygrid"}, [&] {
      BlobCamera("d.raygrid", Packed().blob.substr(0, size));
    });
}

TEST(IsBlob, KnowsNamesAndContents) {
  EXPECT_TRUE(IsBlob("x", Packed().blob));
  EXPECT_TRUE(IsBlob("x.raygrid", ""));
  EXPECT_FALSE(IsBlob("camera.yaml", "raygrid_camera: 1"));
  EXPECT_FALSE(IsBlob("x", ""));
}

// Where an undistorted pixel comes from; nothing near the area's edge.
std::optional<Eigen::Vector2d> Source(const VirtualCamera& virtual_camera,
                                      int x, int y) {
  const auto source = GenericFile().camera->Project(
      virtual_camera.Direction(Eigen::Vector2d(x, y)));
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
  ExpectError(ExitCode::kBlob, {}, [&] { Opened().Undistort(image, 0); });
}

TEST(BlobCamera, UndistortNeedsARemap) {
  const BlobCamera blob("p", PackCamera(GenericFile(), PackOptions()).blob);
  ExpectError(ExitCode::kBlob, {}, [&] {
    blob.Undistort(Made(1, [](int, int, int) { return 0; }), 0);
  });
}

TEST(VirtualCamera, HasTheFieldOfViewAskedFor) {
  for (const double hfov : {1.0, 60.0, 90.0, 120.0, 170.0}) {
    const VirtualCamera camera =
        MakeVirtualCamera(*GenericFile().camera, {800, 600}, hfov);
    EXPECT_NEAR(camera.HorizontalFieldOfViewDeg(), hfov, 1e-9);
    EXPECT_EQ(camera.size, (ImageSize{800, 600}));
  }
}

TEST(VirtualCamera, IsByDefaultAsSharpAsTheImagesMiddle) {
  const auto focal_px = [](ImageSize size) {
    return MakeVirtualCamera(*GenericFile().camera, size, 0).focal_px;
  };
  EXPECT_NEAR(focal_px({0, 0}), 531, 10);
  EXPECT_NEAR(focal_px({320, 240}), focal_px({640, 480}) / 2, 1e-9);
}

TEST(VirtualCamera, RefusesFieldsOfViewThatNoPinholeHas) {
  for (const double hfov : {-10.0, 171.0, 180.0, 360.0, double{NAN}})
    ExpectError(ExitCode::kUsage, {"field of view"}, [&] {
      MakeVirtualCamera(*GenericFile().camera, {640, 480}, hfov);
    });
}

TEST(VirtualCamera, RefusesFocalLengthsThatBlobsDoNotHold) {
  const CameraModel& camera = *GenericFile().camera;
  EXPECT_LT(MakeVirtualCamera(camera, {640, 480}, 0.56).focal_px, 65536);
  ExpectError(ExitCode::kUsage, {"focal length", "0.561"}, [&] {
    MakeVirtualCamera(camera, {640, 480}, 0.55);
  });
}

TEST(PackCamera, RuntimeTellsUncertaintyAndTrustAsTheFileDoes) {
  CameraFile file = GenericFile();
  TestRandom random(8);
  CameraUncertainty& known = file.uncertainty.emplace();
  known.lattice = {5, 4, {}};
  for (int i = 0; i < 20; ++i)
    known.lattice.deviation_px.push_back(random.Uniform(0.001, 0.1));
  known.mask = TrustMask::Over({640, 480});
  for (size_t k = 0; k < known.mask.is_trusted.size(); ++k)
    known.mask.is_trusted[k] = random.Uniform(0, 1) < 0.5;
  const BlobCamera opened("blob", PackCamera(file, PackOptions()).blob);

  const Area& area = file.camera->area();
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn(area);
    const rg_pixel q16 = {static_cast<int32_t>(pixel.x() * 65536),
                          static_cast<int32_t>(pixel.y() * 65536)};
    EXPECT_EQ(rg_is_valid(&opened.camera(), q16) != 0,
              known.mask.Trusts(pixel));
    uint16_t deviation_q12;
    ASSERT_EQ(rg_uncertainty(&opened.camera(), q16, &deviation_q12), RG_OK);
    EXPECT_NEAR(deviation_q12 / 4096.0, known.lattice.At(area, pixel), 1e-3);
  }
}

}  // namespace
}  // namespace raygrid
