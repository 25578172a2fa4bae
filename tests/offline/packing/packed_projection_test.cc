// Projection by blobs: inverse grids, and what is said where they lose pixels.
#include "camera/central_generic.h"
#include "camera/noncentral_generic.h"
#include "packed_cameras.h"
#include "packing/projection_error.h"

namespace raygrid {
namespace {

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

// The fisheye, its entrance pupil moving backwards and sideways by millimetres:
// from the centre, what its edge sees looks as if it were outside.
CameraFile FisheyeWithPupil() {
  const CentralGeneric lens = ExampleFisheye();
  const BSplineSurface& directions = lens.surface();
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector2d& chart : directions.points())
    points.emplace_back(0.002 * chart.x(), 0.001 - 0.001 * chart.x(),
                        -0.002 * chart.squaredNorm());
  CameraFile file;
  file.camera = std::make_shared<NonCentralGeneric>(lens.image_size(),
                                                    directions, points);
  return file;
}

// All over the area, its edge among them, also where the pupil moves by a sixth
// of the point's distance a radian.
TEST(BlobCamera, ProjectsThePointsOnLines) {
  const CameraFile file = FisheyeWithPupil();
  const BlobCamera blob("lines", PackCamera(file, PackOptions()).blob);
  ASSERT_TRUE(blob.CanProject());
  const Area& area = file.camera->area();
  for (const double metres : {0.1, 0.5, 20.0, 1e5}) {
    double worst_px = 0;
    for (int j = 0; j <= 45; ++j) {
      for (int i = 0; i <= 60; ++i) {
        const Eigen::Vector2d pixel(
            std::round((area.x0 + area.width() * i / 60) * 65536) / 65536,
            std::round((area.y0 + area.height() * j / 45) * 65536) / 65536);
        const auto line = blob.Line(pixel);
        if (!line) continue;
        const auto seen = blob.Project(line->origin + metres * line->direction);
        ASSERT_TRUE(seen) << pixel.transpose() << " from " << metres << " m";
        worst_px = std::max(worst_px, (*seen - pixel).norm());
      }
    }
    EXPECT_LT(worst_px, 0.002) << metres << " m";
  }
}

TEST(BlobCamera, ProjectsPointsAsTheCameraOfLines) {
  const CameraFile file = FisheyeWithPupil();
  const BlobCamera blob("lines", PackCamera(file, PackOptions()).blob);
  TestRandom random(6);
  int num_seen = 0, num_hidden = 0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector2d xy = random.PixelIn({-1.2, -1.2, 1.2, 1.2});
    const Eigen::Vector3d point(xy.x(), xy.y(), random.Uniform(-0.3, 0.5));
    if (point.norm() < 0.1) continue;
    const auto exact = file.camera->Project(point);
    const auto pixel = blob.Project(point);
    if (exact && !file.camera->area().Contains(*exact, -0.01)) continue;
    ASSERT_EQ(!exact, !pixel) << point.transpose();
    ++(exact ? num_seen : num_hidden);
    if (!exact) continue;
    EXPECT_LT((*exact - *pixel).norm(), 0.002) << point.transpose();
  }
  EXPECT_GT(num_seen, 500);
  EXPECT_GT(num_hidden, 100);
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
  known.mask = ValidityMask::Over(lens.image_size());
  const Eigen::Vector2d center(320, 240);
  for (size_t k = 0; k < known.mask.is_valid.size(); ++k)
    known.mask.is_valid[k] =
        (known.mask.CellCenter(static_cast<int>(k)) - center).norm() < 230;
  return file;
}

void ExpectTrustedRoundTrips(const CameraFile& file) {
  const BlobCamera blob("corner", PackCamera(file, PackOptions()).blob);
  TestRandom random(15);
  int num_trusted = 0;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn(file.camera->area());
    if (!file.uncertainty->mask.IsValidAt(pixel)) continue;
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

TEST(BlobCamera, LeavesOutTheCornerOfAFisheyeThatLooksTooFarBack) {
  CameraFile file = FisheyeWithCorner(10);
  ExpectTrustedRoundTrips(file);
  EXPECT_EQ(PackCamera(file, PackOptions()).excluded_fraction, 0);
  file.uncertainty->mask.is_valid[0] = true;
  const PackedCamera valid_region = PackCamera(file, PackOptions());
  EXPECT_GT(valid_region.excluded_fraction, 0);
  EXPECT_LT(valid_region.excluded_fraction, 0.002);
  EXPECT_FALSE(
      BlobCamera("corner", valid_region.blob).GetValidityMask()->is_valid[0]);
  file.uncertainty.reset();
  const PackedCamera whole = PackCamera(file, PackOptions());
  EXPECT_GT(whole.excluded_fraction, 0);
  EXPECT_LT(whole.excluded_fraction, 0.5);
  const ValidityMask valid =
      BlobCamera("corner", whole.blob).GetValidityMask().value();
  EXPECT_FALSE(valid.IsValidAt({0, 0}));
  EXPECT_TRUE(valid.IsValidAt({320, 240}));
  EXPECT_TRUE(valid.IsValidAt({639, 479}));
}

// Every pixel of the area, there and back, of those that count.
void ExpectAllFound(const ProjectedPixels& pixels) {
  EXPECT_GT(pixels.num_pixels, 1000);
  EXPECT_EQ(pixels.num_not_invertible, 0);
  EXPECT_EQ(pixels.num_not_converged, 0);
  EXPECT_EQ(pixels.num_inaccurate, 0);
  EXPECT_LE(pixels.worst_px, 0.002);
}

// Trusted in a few cells near the middle, as a camera that was calibrated with
// few pictures of a small board.
CameraFile HardlyTrusted(std::shared_ptr<const CameraModel> camera) {
  CameraFile file;
  file.camera = std::move(camera);
  CameraUncertainty& known = file.uncertainty.emplace();
  known.lattice = {2, 2, {0.01, 0.01, 0.01, 0.01}};
  known.mask = ValidityMask::Over(file.camera->image_size());
  for (size_t k = 0; k < known.mask.is_valid.size(); ++k)
    known.mask.is_valid[k] =
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
    EXPECT_TRUE(packed.warnings.empty());
    ASSERT_TRUE(packed.projection);
    ExpectAllFound(packed.projection->valid_region);
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
  ExpectAllFound(smooth.projection->valid_region);
  ExpectAllFound(rough.projection->valid_region);
  EXPECT_TRUE(rough.warnings.empty());
  EXPECT_GT(rough.blob.size(), smooth.blob.size());
}

TEST(PackCamera, SaysWhatProjectionMisses) {
  const CameraFile file = RoughFile(0.2);
  const PackedCamera packed = PackCamera(file, PackOptions());
  ASSERT_TRUE(packed.projection);
  EXPECT_GT(packed.projection->valid_region.FailedFraction(), 0);
  EXPECT_GT(packed.projection->valid_region.num_not_invertible, 0);
  ASSERT_EQ(packed.warnings.size(), 1u);
  EXPECT_NE(packed.warnings[0].find("do not converge"), std::string::npos);
  // The figures are the runtime's.
  const BlobCamera blob("rough", packed.blob);
  const ProjectionError again = MeasureProjection(blob, nullptr, 1e6, 1);
  EXPECT_EQ(again.valid_region.num_not_converged,
            packed.projection->valid_region.num_not_converged);
  EXPECT_EQ(again.valid_region.worst_px,
            packed.projection->valid_region.worst_px);
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
  ASSERT_EQ(packed.warnings.size(), 1u);
  const BlobCamera blob("wide", packed.blob);
  EXPECT_FALSE(blob.CanProject());
  EXPECT_TRUE(blob.Unproject({16000, 8}));
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

}  // namespace
}  // namespace raygrid
