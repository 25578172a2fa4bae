#include <cstdio>
#include <limits>

#include "camera/central_generic.h"
#include "camera/noncentral_generic.h"
#include "packed_cameras.h"
#include "packing/int16_grid.h"

namespace raygrid {
namespace {

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
  ExpectError(ExitCode::kQualityTooLow, {"--max-error-px"},
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

// Most of the area lies beyond this lens's fold, a circle of 163 px.
TEST(PackCamera, CamerasWithoutRaysInTheirAreaLeaveThemOut) {
  const ImageSize size = {640, 480};
  CameraFile file;
  file.camera = std::make_shared<OpenCvModel>(
      size, WholeImage(size),
      OpenCvModel::ParameterArray{300, 300, 320, 240, -0.5, 0, 0, 0, 0, 0, 0,
                                  0});
  const PackedCamera packed = PackCamera(file, PackOptions());
  EXPECT_GT(packed.excluded_fraction, 0.72);
  EXPECT_LT(packed.excluded_fraction, 0.85);
  ASSERT_FALSE(packed.warnings.empty());
  EXPECT_NE(packed.warnings[0].find("folds"), std::string::npos);
  const ValidityMask valid =
      BlobCamera("packed", packed.blob).GetValidityMask().value();
  EXPECT_TRUE(valid.IsValidAt({320, 240}));
  EXPECT_FALSE(valid.IsValidAt({0, 0}));
}

TEST(PackCamera, PacksAFisheye) {
  CameraFile file;
  file.camera = std::make_shared<CentralGeneric>(ExampleFisheye());
  PackOptions options;
  options.remaps = {ViewOf(*file.camera, {640, 480}, 120)};
  const PackedCamera packed = PackCamera(file, options);
  EXPECT_LE(packed.unproject_error_px, kMaxPackingErrorPx);
  EXPECT_LE(packed.remaps[0].error_px, options.max_error_px);
}

TEST(PackCamera, TakesControlPointsOf32BitsIfAskedTo) {
  PackOptions options;
  options.is_int16_allowed = false;
  const PackedCamera narrow = PackCamera(GenericFile(), PackOptions());
  const PackedCamera wide = PackCamera(GenericFile(), options);
  EXPECT_GT(wide.blob.size(), narrow.blob.size() + 500);
  EXPECT_LT(wide.unproject_error_rad, narrow.unproject_error_rad);
}

TEST(QuantizeToInt16, RefusesPointsFarFromTheirPlane) {
  constexpr int32_t kLargest = std::numeric_limits<int32_t>::max();
  ControlPoints points = {4, 5, {}};
  for (int k = 0; k < 20; ++k)
    points.values.insert(points.values.end(),
                         {k % 2 ? kLargest : -kLargest, k / 4 % 2 ? 5 : 7});
  EXPECT_FALSE(QuantizeToInt16(points));
  // The plane, drawn out to the first point, lies beyond 32 bits.
  for (int k = 0; k < 20; ++k)
    points.values[2 * k] = k == 0 || k >= 12 ? kLargest : -kLargest;
  EXPECT_FALSE(QuantizeToInt16(points));
}

TEST(PackCamera, HoldsSeveralRemapTables) {
  PackOptions options = WithRemap();
  options.remaps.push_back(ViewOf(*GenericFile().camera, {320, 200}, 40));
  const PackedCamera packed = PackCamera(GenericFile(), options);
  ASSERT_EQ(packed.remaps.size(), 2u);
  const BlobCamera blob("two", packed.blob);
  for (uint32_t k = 0; k < 2; ++k) {
    rg_camera camera = blob.camera();
    uint16_t width, height;
    ASSERT_EQ(rg_select_remap(&camera, k), RG_OK);
    ASSERT_EQ(rg_remap_size(&camera, &width, &height), RG_OK);
    EXPECT_EQ((ImageSize{width, height}), options.remaps[k].view.size);
    EXPECT_EQ(packed.remaps[k].view.size, options.remaps[k].view.size);
  }
}

TEST(PackCamera, MeasuresChroma) {
  const PackedRemap coarse = Packed().remaps[0];
  const PackedRemap fine =
      PackCamera(GenericFile(), WithRemap(0.012)).remaps[0];
  EXPECT_GT(coarse.chroma_error_px, 0);
  EXPECT_LE(fine.chroma_error_px, 3.5 * fine.error_px);
  if (coarse.tile_size > 8) {
    EXPECT_LE(coarse.chroma_error_px, coarse.error_px);
  }
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
  EXPECT_TRUE(blob.Project({0, 0, 1}));
  EXPECT_TRUE(blob.has_remap());
}

TEST(PackCamera, RuntimeTellsUncertaintyAndTrustAsTheFileDoes) {
  CameraFile file = GenericFile();
  TestRandom random(8);
  CameraUncertainty& known = file.uncertainty.emplace();
  known.lattice = {5, 4, {}};
  for (int i = 0; i < 20; ++i)
    known.lattice.stddev_px.push_back(random.Uniform(0.001, 0.1));
  known.mask = ValidityMask::Over({640, 480});
  for (size_t k = 0; k < known.mask.is_valid.size(); ++k)
    known.mask.is_valid[k] = random.Uniform(0, 1) < 0.5;
  const BlobCamera opened("blob", PackCamera(file, PackOptions()).blob);

  const Area& area = file.camera->area();
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector2d pixel = random.PixelIn(area);
    const rg_pixel q16 = {static_cast<int32_t>(pixel.x() * 65536),
                          static_cast<int32_t>(pixel.y() * 65536)};
    EXPECT_EQ(rg_is_valid(&opened.camera(), q16) != 0,
              known.mask.IsValidAt(pixel));
    uint16_t deviation_q12;
    ASSERT_EQ(rg_uncertainty(&opened.camera(), q16, &deviation_q12), RG_OK);
    EXPECT_NEAR(deviation_q12 / 4096.0, known.lattice.At(area, pixel), 1e-3);
  }
}

TEST(PackCamera, MaskMayStandAlone) {
  CameraFile file = GenericFile();
  ValidityMask mask = ValidityMask::Over({640, 480});
  mask.is_valid[mask.CellIndex({320, 240})] = true;
  file.uncertainty = CameraUncertainty::FromMask(mask);
  const BlobCamera opened("blob", PackCamera(file, PackOptions()).blob);
  EXPECT_EQ(opened.blob().uncertainty, 0u);
  ASSERT_TRUE(opened.GetValidityMask());
  EXPECT_EQ(opened.GetValidityMask()->is_valid, mask.is_valid);
}

TEST(PackCamera, RowTimeComesOutOfTheBlob) {
  CameraFile file = GenericFile();
  EXPECT_FALSE(BlobCamera("blob", PackCamera(file, {}).blob).GetRowTime());
  file.line_delay = {-20.1e-6, 0.03e-6};
  const auto read = BlobCamera("blob", PackCamera(file, {}).blob).GetRowTime();
  ASSERT_TRUE(read);
  EXPECT_NEAR(read->seconds, -20.1e-6, 1e-12);
  EXPECT_NEAR(read->stddev_s, 0.03e-6, 1e-12);
}

TEST(PackCamera, RecordsHowTheCameraStood) {
  const std::string without = PackCamera(GenericFile(), PackOptions()).blob;
  EXPECT_FALSE(BlobCamera("blob", without).GetCalibrationCapture());
  CameraFile file = GenericFile();
  Capture& capture = file.capture.emplace();
  capture.lens_position = -1.0 / 3;
  capture.crop = {-65536, 65536, 40960, 8};
  capture.zoom = 1024;
  capture.sensor_temperature_c = -40.5;
  capture.exposure_us = 8333;
  capture.analogue_gain = 1.5;
  const std::string blob = PackCamera(file, PackOptions()).blob;
  EXPECT_EQ(blob.size(), without.size() + 16 + 44);
  const auto read = BlobCamera("blob", blob).GetCalibrationCapture();
  ASSERT_TRUE(read);
  EXPECT_NEAR(*read->lens_position, -1.0 / 3, 1.0 / 131072);
  EXPECT_NEAR(read->lens_tolerance, 0.1, 1.0 / 131072);
  EXPECT_EQ(read->crop, capture.crop);
  EXPECT_EQ(read->zoom, 1024);
  EXPECT_FALSE(read->orientation);
  EXPECT_EQ(read->sensor_temperature_c, -40.5);
  EXPECT_EQ(read->exposure_us, 8333);
  EXPECT_EQ(read->analogue_gain, 1.5);
  // Packed again, it has the same bytes.
  file.capture = read;
  EXPECT_EQ(PackCamera(file, PackOptions()).blob, blob);
}

}  // namespace
}  // namespace raygrid
