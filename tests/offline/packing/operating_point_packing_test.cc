#include <algorithm>
#include <cstdio>
#include <vector>

#include "bytes.h"
#include "camera/opencv.h"
#include "packed_cameras.h"
#include "packing/remap_fitting.h"

namespace raygrid {
namespace {

// A lens whose focal length grows by 4 % from 0 to 10 dioptres, while its
// centre and its distortion move.
OpenCvModel LensAt(double dioptres) {
  const ImageSize size = {640, 480};
  const double t = dioptres / 10;
  const double scale = 1 + 0.04 * t + 0.004 * t * (1 - t);
  const OpenCvModel::ParameterArray parameters = {530 * scale,
                                                  532 * scale,
                                                  322.3 + 1.8 * t,
                                                  237.1 - 1.1 * t * t,
                                                  -0.28 + 0.02 * t,
                                                  0.09 - 0.01 * t,
                                                  0,
                                                  0,
                                                  0,
                                                  0,
                                                  7e-4,
                                                  -4e-4};
  return OpenCvModel(size, WholeImage(size), parameters);
}

CentralGeneric CameraAt(double dioptres) {
  return FittedGrid(LensAt(dioptres), 40);
}

struct PackedStack {
  OperatingPointSamples samples;
  VirtualView view;
  PackedCamera packed;
};

// Packed once for all tests: the reference is at 4 dioptres.
const PackedStack& GetOperatingPointModel() {
  static const PackedStack* const made = [] {
    auto* stack = new PackedStack;
    stack->samples = SelectSamples(RG_OPERATING_PARAMETER_LENS_POSITION, 0, 10,
                                   CameraAt, 0.01);
    CameraFile file = GenericFile();
    file.camera = std::make_shared<CentralGeneric>(CameraAt(4));
    stack->view = ViewOf(*file.camera, {640, 480}, 50);
    PackOptions options;
    options.remaps = {stack->view, ViewOf(*file.camera, {320, 240}, 0)};
    options.max_error_px = 0.03;
    options.stack = stack->samples;
    stack->packed = PackCamera(file, options);
    return stack;
  }();
  return *made;
}

rg_camera OpenAt(const BlobCamera& blob, double dioptres) {
  rg_camera camera = blob.camera();
  EXPECT_EQ(rg_set_operating_point(
                &camera, static_cast<int32_t>(std::lround(dioptres * 65536))),
            RG_OK);
  return camera;
}

// Conditions that are no knots.
const double kConditions[] = {0.31, 2.2, 3.99, 5.05, 6.6, 8.1, 9.9};

TEST(SelectSamples, TakesAsFewAsDo) {
  const OperatingPointSamples& samples = GetOperatingPointModel().samples;
  EXPECT_GE(samples.values.size(), 3u);
  EXPECT_LE(samples.values.size(), 12u);
  EXPECT_EQ(samples.values.front(), 0);
  EXPECT_EQ(samples.values.back(), 10);
  const OperatingPointSamples looser =
      SelectSamples(RG_OPERATING_PARAMETER_LENS_POSITION, 0, 10, CameraAt, 0.1);
  EXPECT_LT(looser.values.size(), samples.values.size());
  std::printf(
      "%zu knots, blob %zu bytes, %zu knots at 0.1 px\n", samples.values.size(),
      GetOperatingPointModel().packed.blob.size(), looser.values.size());
}

TEST(StackPacking, RaysAreTheLensesAtUnseenConditions) {
  const BlobCamera blob("stack", GetOperatingPointModel().packed.blob);
  double worst_px = 0, worst_back_px = 0;
  for (const double dioptres : kConditions) {
    const rg_camera camera = OpenAt(blob, dioptres);
    const OpenCvModel lens = LensAt(dioptres);
    for (int y = 0; y < 480; y += 13) {
      for (int x = 0; x < 640; x += 13) {
        const rg_pixel pixel = {RG_PIXEL(x), RG_PIXEL(y)};
        rg_ray ray;
        rg_pixel back;
        ASSERT_EQ(rg_unproject(&camera, pixel, &ray), RG_OK);
        const Eigen::Vector3d direction(ray.x_q30, ray.y_q30, ray.z_q30);
        const auto seen = lens.Project(direction, nullptr, 1);
        ASSERT_TRUE(seen);
        worst_px = std::max(worst_px, (*seen - Eigen::Vector2d(x, y)).norm());
        ASSERT_EQ(rg_project(&camera, &ray, &back), RG_OK) << x << ' ' << y;
        worst_back_px = std::max(
            worst_back_px,
            Eigen::Vector2d(back.x_q16 - pixel.x_q16, back.y_q16 - pixel.y_q16)
                    .norm() /
                65536);
      }
    }
  }
  std::printf("rays: %.4f px, and back %.5f px\n", worst_px, worst_back_px);
  EXPECT_LE(worst_px, 0.05);
  EXPECT_LE(worst_back_px, 0.002);
}

// Ramps show where a pixel comes from: 16 bits have 1/90 px a step.
TEST(StackPacking, FramesAreTheLensesAtUnseenConditions) {
  constexpr int kScale = 90;
  const BlobCamera blob("stack", GetOperatingPointModel().packed.blob);
  const VirtualView& view = GetOperatingPointModel().view;
  double worst_px = 0;
  for (const double dioptres : kConditions) {
    rg_camera camera = OpenAt(blob, dioptres);
    ASSERT_EQ(rg_select_remap(&camera, 0), RG_OK);
    const OpenCvModel lens = LensAt(dioptres);
    std::vector<uint16_t> ramps[2], found[2];
    for (int axis = 0; axis < 2; ++axis) {
      for (int y = 0; y < 480; ++y)
        for (int x = 0; x < 640; ++x)
          ramps[axis].push_back(
              static_cast<uint16_t>(kScale * (axis == 0 ? x : y)));
      found[axis].assign(640 * 480, 0);
      rg_image image = {};
      image.format = RG_FORMAT_GREY16;
      image.width = 640;
      image.height = 480;
      image.planes[0].data =
          reinterpret_cast<const uint8_t*>(ramps[axis].data());
      image.planes[0].stride = 1280;
      rg_target target = {};
      target.num_rows = 480;
      target.border_values[0] = 65535;
      target.planes[0].data = reinterpret_cast<uint8_t*>(found[axis].data());
      target.planes[0].stride = 1280;
      ASSERT_EQ(rg_remap(&camera, &image, &target), RG_OK);
    }
    for (int y = 0; y < 480; y += 7) {
      for (int x = 0; x < 640; x += 7) {
        const auto direction = view.Direction({x, y});
        const auto source = direction ? lens.Project(*direction) : std::nullopt;
        if (!source || found[0][640 * y + x] == 65535) continue;
        const Eigen::Vector2d at(found[0][640 * y + x], found[1][640 * y + x]);
        worst_px = std::max(worst_px, (at / kScale - *source).norm());
      }
    }
  }
  std::printf("frames: %.4f px, with %.4f px of the ramps' own\n", worst_px,
              1.0 / kScale);
  EXPECT_LE(worst_px, 0.05);
}

// Vertices and bends at a condition lie between those of its knots: the tables
// are alike, and the blob's own are, too.
TEST(StackPacking, TablesAreAlike) {
  const PackedStack& stack = GetOperatingPointModel();
  const BlobCamera blob("stack", stack.packed.blob);
  ASSERT_NE(blob.blob().stack, 0u);
  rg_stack_section section;
  rg_blob_stack(&blob.blob(), &section);
  ASSERT_EQ(section.num_samples, stack.samples.values.size());
  for (size_t k = 0; k < stack.samples.values.size(); ++k)
    EXPECT_NEAR(rg_stack_sample_value(&section, k) / 65536.0,
                stack.samples.values[k], 1e-5);
  EXPECT_EQ(blob.NumRemaps(), 2u);
  for (const PackedRemap& remap : stack.packed.remaps)
    EXPECT_LE(remap.error_px, 0.03);
  EXPECT_TRUE(stack.packed.warnings.empty());
}

// A view that reaches beyond the area in parts: blocks that one knot shows and
// another does not.
TEST(StackPacking, ViewsMayReachBeyondTheArea) {
  CameraFile file = GenericFile();
  file.camera = std::make_shared<CentralGeneric>(CameraAt(4));
  PackOptions options;
  options.remaps = {ViewOf(*file.camera, {320, 240}, 75)};
  options.stack = GetOperatingPointModel().samples;
  const PackedCamera packed = PackCamera(file, options);
  EXPECT_LE(packed.remaps[0].error_px, 0.05);
  const BlobCamera blob("stack", packed.blob);
  rg_camera camera = OpenAt(blob, 7.3);
  EXPECT_EQ(rg_select_remap(&camera, 0), RG_OK);
}

TEST(StackPacking, KnotsThatDoNotFitEachOtherAreRefused) {
  CameraFile file = GenericFile();
  file.camera = std::make_shared<CentralGeneric>(CameraAt(0));
  PackOptions options;
  options.stack = OperatingPointSamples{
      RG_OPERATING_PARAMETER_TEMPERATURE, {20, 30}, {CameraAt(0), CameraAt(1)}};
  EXPECT_NO_THROW(PackCamera(file, options));
  options.stack->values = {30, 20};
  ExpectError(ExitCode::kQualityTooLow, {"ascend"},
              [&] { PackCamera(file, options); });
  options.stack->values = {20};
  ExpectError(ExitCode::kQualityTooLow, {"2 to 64"},
              [&] { PackCamera(file, options); });
  options.stack->values = {20, 30};
  options.stack->cameras[1] = FittedGrid(LensAt(1), 60);
  ExpectError(ExitCode::kQualityTooLow, {"equal size"},
              [&] { PackCamera(file, options); });
}

TEST(SelectSamples, RefusesRangesThatNeedTooMany) {
  // A coarse grid is fitted faster, and needs as many samples.
  const auto coarse_at = [](double dioptres) {
    return FittedGrid(LensAt(dioptres), 160);
  };
  ExpectError(ExitCode::kQualityTooLow, {"64 samples"}, [&] {
    SelectSamples(RG_OPERATING_PARAMETER_LENS_POSITION, 0, 10, coarse_at, 1e-7);
  });
}

}  // namespace
}  // namespace raygrid
