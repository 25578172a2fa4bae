#include "packing/remap_fitting.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <vector>

#include "camera/central_generic.h"
#include "camera/opencv.h"
#include "camera/thin_prism_fisheye.h"
#include "cortex_m/tile_corners.h"
#include "packed_cameras.h"
#include "packing/source_map.h"
#include "packing/view.h"
#include "support.h"

namespace raygrid {
namespace {

constexpr ImageSize kFullHd = {1920, 1080};

struct TestCase {
  const char* name;
  std::shared_ptr<CameraModel> camera;
  double hfov_deg;

  VirtualView PinholeView(const ImageSize& size = kFullHd) const {
    return ViewOf(*camera, size, hfov_deg);
  }
};

// A camera as a grid of cells, with bumps.
std::shared_ptr<CameraModel> AsRoughGrid(const CameraModel& camera,
                                         double knot_spacing_px,
                                         double deviation) {
  const Area& area = camera.area();
  BSplineSurface surface =
      FitCentralGeneric(camera, area,
                        NumControlPoints(area.width(), knot_spacing_px),
                        NumControlPoints(area.height(), knot_spacing_px), 3)
          .surface();
  TestRandom random(7);
  for (Eigen::Vector2d& point : surface.points())
    point += deviation * random.NormalVector<2>();
  return std::make_shared<CentralGeneric>(camera.image_size(), surface);
}

std::vector<TestCase> TestCases() {
  const double w = kFullHd.width;
  const OpenCvModel::ParameterArray mild = {
      0.7 * w, 0.7 * w, 967, 536, -0.3, 0.1, 0, 0, 0, 0, 7e-4, -4e-4};
  const ThinPrismFisheye::ParameterArray wide = {
      0.36 * w, 0.36 * w, 967, 536, -0.012, 0.008, -0.006, 0.001, 0, 0, 0, 0};
  const Area area = WholeImage(kFullHd);
  const auto fisheye = std::make_shared<ThinPrismFisheye>(kFullHd, area, wide);
  return {{"mild", std::make_shared<OpenCvModel>(kFullHd, area, mild), 71},
          {"fisheye to 108", fisheye, 108},
          {"fisheye to 132", fisheye, 132}};
}

// formats/SPEC.md, "Bends" and "Remap arithmetic", in double precision.
class PlainTable {
 public:
  explicit PlainTable(const RemapTable& table)
      : table_(table), section_(table.section) {}

  Eigen::Vector2d At(double x, double y) const {
    const int block = 1 << section_.block_log2;
    const int part = section_.part_log2 != 0 ? 1 << section_.part_log2 : block;
    const int i = static_cast<int>(x) / part * part;
    const int j = static_cast<int>(y) / part * part;
    const double u = (x - i) / part, v = (y - j) / part;
    return (Corner(i, j) * (1 - u) + Corner(i + part, j) * u) * (1 - v) +
           (Corner(i, j + part) * (1 - u) + Corner(i + part, j + part) * u) * v;
  }

 private:
  // The source position of the corner of parts at an output pixel.
  Eigen::Vector2d Corner(int x, int y) const {
    const int block = 1 << section_.block_log2;
    const int i = x / block, j = y / block;
    const double u = static_cast<double>(x % block) / block;
    const double v = static_cast<double>(y % block) / block;
    const auto curve = [](double t) { return 4 * t * (1 - t); };
    if (u == 0 && v == 0) return Vertex(i, j);
    if (u == 0)
      return (1 - v) * Vertex(i, j) + v * Vertex(i, j + 1) +
             curve(v) * Bend(i, j + 1, 2);
    const Eigen::Vector2d top = (1 - u) * Vertex(i, j) + u * Vertex(i + 1, j) +
                                curve(u) * Bend(i + 1, j, 0);
    if (v == 0) return top;
    const Eigen::Vector2d bottom = (1 - u) * Vertex(i, j + 1) +
                                   u * Vertex(i + 1, j + 1) +
                                   curve(u) * Bend(i + 1, j + 1, 0);
    return (1 - v) * top + v * bottom +
           curve(v) * ((1 - u) * Bend(i, j + 1, 2) + u * Bend(i + 1, j + 1, 2));
  }

  Eigen::Vector2d Vertex(int i, int j) const {
    const int k = 2 * (j * section_.columns + i);
    const int unit = 1 << section_.residual_shift;
    return Eigen::Vector2d(
               section_.origin_x_q12 + i * section_.column_step_x_q12 +
                   j * section_.row_step_x_q12 + table_.residuals[k] * unit,
               section_.origin_y_q12 + i * section_.column_step_y_q12 +
                   j * section_.row_step_y_q12 +
                   table_.residuals[k + 1] * unit) /
           4096;
  }

  // How far the middle of the edge that leads to a vertex from the left (0) or
  // from above (2) lies off.
  Eigen::Vector2d Bend(int i, int j, int first) const {
    const int8_t* const bend =
        &table_.bends[4 * (j * section_.columns + i) + first];
    const int log2 =
        section_.bend_shift + section_.block_log2 - section_.part_log2 - 2 - 12;
    return {std::ldexp(bend[0], log2), std::ldexp(bend[1], log2)};
  }

  const RemapTable& table_;
  const rg_remap_section& section_;
};

// The worst error of a table, with the camera asked for every pixel.
double WorstError(const CameraModel& camera, const OutputImage& target,
                  const RemapTable& table) {
  rg_remap_section section = table.section;
  section.empty_blocks = table.empty_blocks.data();
  section.bends = table.bends.data();
  std::vector<uint32_t> words(rg_remap_section_size(&section) / 4);
  auto* const bytes = reinterpret_cast<uint8_t*>(words.data());
  rg_write_remap(&section, table.residuals.data(), bytes);
  const int log2 =
      section.part_log2 != 0 ? section.part_log2 : section.block_log2;
  const int part = 1 << log2;
  const Area &area = camera.area(), whole = WholeImage(camera.image_size());
  const Area image = {std::max(area.x0, whole.x0), std::max(area.y0, whole.y0),
                      std::min(area.x1, whole.x1), std::min(area.y1, whole.y1)};
  double worst = 0;
  for (int y = 0; y < target.size.height; ++y) {
    rg_tile_row parts;
    rg_init_tile_row(bytes, log2, log2, y >> log2, &parts);
    rg_block block;
    std::optional<Eigen::Vector2d> exact;
    for (int x = 0; x < target.size.width; ++x) {
      if (x % part == 0) rg_next_block(&parts, &block);
      rg_block_row row;
      rg_compute_block_row(&block, y % part, &row);
      const rg_position p = rg_row_position(&row, x % part);
      const Eigen::Vector2d position(p.q12[0] / 4096.0, p.q12[1] / 4096.0);
      const bool is_taken = !parts.is_block_empty && image.Contains(position);
      const auto direction = target.direction(Eigen::Vector2d(x, y));
      exact = direction
                  ? camera.Project(*direction, exact ? &*exact : nullptr, 1.5)
                  : std::nullopt;
      if (!is_taken && !(exact && image.Contains(*exact))) continue;
      worst = std::max(worst, exact && !parts.is_block_empty
                                  ? (position - *exact).norm()
                                  : INFINITY);
    }
  }
  return worst;
}

size_t BytesOf(const RemapTable& table) {
  return rg_remap_section_size(&table.section);
}

TEST(FitRemapTable, KeepsThreeHundredthsOfAPixelInTwoHundredthsOfAByte) {
  for (const TestCase& test_case : TestCases()) {
    const VirtualView target = test_case.PinholeView();
    const RemapTable table = FitRemapTable(*test_case.camera, target, 0.03, 0);
    EXPECT_LE(table.max_error_px, 0.03) << test_case.name;
    EXPECT_LE(BytesOf(table), 0.02 * kFullHd.width * kFullHd.height)
        << test_case.name;
    std::printf(
        "%s: blocks of %d, parts of %d, %.4f px, %.4f bytes/px\n",
        test_case.name, 1 << table.section.block_log2,
        1 << table.section.part_log2, table.max_error_px,
        static_cast<double>(BytesOf(table)) / kFullHd.width / kFullHd.height);
    // The error that was measured is true of pixels anywhere.
    const PlainTable plain(table);
    TestRandom random(3);
    double worst = 0;
    for (int k = 0; k < 20000; ++k) {
      const Eigen::Vector2d at = random.PixelIn({0, 0, 1919, 1079});
      const int x = static_cast<int>(at.x()), y = static_cast<int>(at.y());
      const auto exact =
          test_case.camera->Project(*target.Direction({x, y}), nullptr, 0);
      if (exact) worst = std::max(worst, (plain.At(x, y) - *exact).norm());
    }
    constexpr double kRounding = 0.002;
    EXPECT_LT(worst, table.max_error_px + kRounding) << test_case.name;
    EXPECT_GT(worst, table.max_error_px / 2) << test_case.name;
  }
}

// Views that look around and are turned. A grid has no bumps within 100 degrees
// of a lens's axis.
TEST(FitRemapTable, KeepsTheBoundForEveryProjection) {
  const CentralGeneric camera =
      FitCentralGeneric(*MakeSimulatedCamera("fisheye190", {640, 480}),
                        {50, 40, 590, 440}, 27, 21);
  for (const auto& [projection, hfov_deg] :
       {std::pair(ViewProjection::kPinhole, 90.0),
        std::pair(ViewProjection::kCylindrical, 180.0),
        std::pair(ViewProjection::kEquirectangular, 360.0),
        std::pair(ViewProjection::kStereographic, 200.0),
        std::pair(ViewProjection::kEquidistant, 210.0)}) {
    ViewRequest request;
    request.size = hfov_deg == 360 ? ImageSize{1600, 800} : ImageSize{800, 600};
    request.projection = projection;
    request.hfov_deg = hfov_deg;
    request.rotate_deg = Eigen::Vector3d(35, 20, -15);
    const VirtualView view = MakeView(camera, request);
    const RemapTable table = FitRemapTable(camera, view, 0.05, 0);
    const double worst = WorstError(camera, MakeViewOutput(view), table);
    std::printf("%s: %.4f px, parts of %d\n", ProjectionName(projection), worst,
                1 << table.section.part_log2);
    EXPECT_LE(table.max_error_px, 0.05);
    EXPECT_LE(worst, 0.05 + 1e-3) << ProjectionName(projection);
    EXPECT_GT(worst, 0.01);
    EXPECT_EQ(table.section.projection, static_cast<int>(projection));
  }
}

TEST(FitRemapTable, WorstErrorIsThatOfAllPixels) {
  std::vector<TestCase> cases = TestCases();
  cases.push_back({"grid", AsRoughGrid(*cases[1].camera, 60, 1e-5), 108});
  cases.push_back({"rough grid", AsRoughGrid(*cases[2].camera, 60, 1e-4), 132});
  for (const TestCase& test_case : cases) {
    for (const ImageSize size : {ImageSize{645, 363}, ImageSize{301, 203}}) {
      const VirtualView target = test_case.PinholeView(size);
      const RemapTable table = FitRemapTable(*test_case.camera, target, 1, 0);
      EXPECT_NEAR(table.max_error_px,
                  WorstError(*test_case.camera, MakeViewOutput(target), table),
                  1e-6)
          << test_case.name << ", " << size.width;
    }
  }
}

TEST(FitRemapTable, TighterBoundsTakeSmallerPartsAndAreKept) {
  const TestCase test_case = TestCases()[1];
  int last = 64;
  for (const double bound : {0.2, 0.05, 0.02, 0.01}) {
    const RemapTable table =
        FitRemapTable(*test_case.camera, test_case.PinholeView(), bound, 0);
    const rg_remap_section& section = table.section;
    const int log2 =
        section.part_log2 != 0 ? section.part_log2 : section.block_log2;
    EXPECT_LE(table.max_error_px, bound);
    EXPECT_LE(1 << log2, last);
    last = 1 << log2;
  }
  EXPECT_EQ(last, 8);
}

TEST(FitRemapTable, GivesTheSameWithAnyNumberOfThreads) {
  const TestCase test_case = TestCases()[2];
  const RemapTable one =
      FitRemapTable(*test_case.camera, test_case.PinholeView(), 0.03, 1);
  const RemapTable three =
      FitRemapTable(*test_case.camera, test_case.PinholeView(), 0.03, 3);
  EXPECT_EQ(one.residuals, three.residuals);
  EXPECT_EQ(one.bends, three.bends);
  EXPECT_EQ(one.max_error_px, three.max_error_px);
}

// The ways to the view and back are each other's inverse. The bound is one of
// pixels of the view, which far off the axis are smaller than the camera's.
TEST(FitDistortionTable, UndoesTheOtherDirection) {
  for (const TestCase& test_case : TestCases()) {
    const VirtualView view = test_case.PinholeView();
    const RemapTable there = FitRemapTable(*test_case.camera, view, 0.05, 0);
    const double bound = test_case.hfov_deg < 90    ? 0.05
                         : test_case.hfov_deg < 120 ? 0.1
                                                    : 0.2;
    const RemapTable back =
        FitDistortionTable(*test_case.camera, view, bound, 0);
    EXPECT_LE(back.max_error_px, bound) << test_case.name;
    EXPECT_EQ(back.section.width, kFullHd.width);
    const PlainTable to_camera(there), to_view(back);
    const auto as_camera = MakeViewCamera(view);
    TestRandom random(5);
    double worst = 0, worst_back = 0;
    int num_inside = 0;
    for (int k = 0; k < 40000; ++k) {
      const Eigen::Vector2d at = random.PixelIn({1, 1, 1918, 1078});
      const Eigen::Vector2d pixel(std::floor(at.x()), std::floor(at.y()));
      const auto exact =
          as_camera->Project(*test_case.camera->Unproject(pixel));
      if (!exact || !Area{2, 2, 1917, 1077}.Contains(*exact)) continue;
      const Eigen::Vector2d seen = to_view.At(pixel.x(), pixel.y());
      worst_back = std::max(worst_back, (seen - *exact).norm());
      const Eigen::Vector2d home = to_camera.At(seen.x(), seen.y());
      worst = std::max(worst, (home - pixel).norm());
      ++num_inside;
    }
    std::printf("%s: back %.4f px, there and back %.4f px, %d pixels\n",
                test_case.name, worst_back, worst, num_inside);
    EXPECT_GT(num_inside, 10000);
    EXPECT_LT(worst_back, back.max_error_px + 0.002);
    EXPECT_LT(worst, 0.1);
  }
}

TEST(FitDistortionTable, KeepsTheBoundForEveryProjection) {
  constexpr double kBound = 0.5;
  const CentralGeneric camera =
      FitCentralGeneric(*MakeSimulatedCamera("fisheye190", {640, 480}),
                        {50, 40, 590, 440}, 27, 21);
  for (const auto& [projection, hfov_deg] :
       {std::pair(ViewProjection::kPinhole, 90.0),
        std::pair(ViewProjection::kCylindrical, 180.0),
        std::pair(ViewProjection::kEquirectangular, 180.0),
        std::pair(ViewProjection::kStereographic, 200.0),
        std::pair(ViewProjection::kEquidistant, 210.0)}) {
    ViewRequest request;
    request.size = {800, 600};
    request.projection = projection;
    request.hfov_deg = hfov_deg;
    request.rotate_deg = Eigen::Vector3d(35, 20, -15);
    const VirtualView view = MakeView(camera, request);
    const RemapTable table = FitDistortionTable(camera, view, kBound, 0);
    EXPECT_LE(table.max_error_px, kBound) << ProjectionName(projection);
    EXPECT_EQ(table.section.width, 640);
    // Whatever the table shows of calibrated pixels is where the view has it.
    const PlainTable plain(table);
    double worst = 0;
    int num_seen = 0;
    for (int y = 40; y <= 440; y += 3) {
      for (int x = 50; x <= 590; x += 3) {
        const auto exact = view.Pixel(*camera.Unproject({x, y}));
        if (!exact || !WholeImage(view.size).Contains(*exact)) continue;
        worst = std::max(worst, (plain.At(x, y) - *exact).norm());
        ++num_seen;
      }
    }
    std::printf("%s: %.4f px of %d, parts of %d\n", ProjectionName(projection),
                worst, num_seen, 1 << table.section.part_log2);
    EXPECT_GT(num_seen, 1000);
    EXPECT_LE(worst, kBound + 0.002) << ProjectionName(projection);
  }
}

int NumEmptyBlocks(const RemapTable& table) {
  int count = 0;
  for (const uint8_t bits : table.empty_blocks)
    for (int k = 0; k < 8; ++k) count += bits >> k & 1;
  return count;
}

// A corner of the last block lies at the limit of what a table can hold, or
// beyond it.
TEST(FitRemapTable, ReachesTheEdgeOfTheWidestImages) {
  for (const double k1 : {0.0, -0.02, 0.02}) {
    for (const ImageSize& size :
         {ImageSize{8192, 40}, ImageSize{8188, 40}, ImageSize{40, 8192}}) {
      SCOPED_TRACE(testing::Message() << k1 << " " << size.width);
      const OpenCvModel lens(
          size, WholeImage(size),
          {8216, 8216, (size.width - 1) / 2.0, (size.height - 1) / 2.0, k1, 0,
           0, 0, 0, 0, 0, 0});
      ViewRequest request;
      request.alpha = 0;
      const RemapTable table =
          FitRemapTable(lens, MakeView(lens, request), 0.05, 2);
      EXPECT_LE(table.max_error_px, 0.05);
      EXPECT_EQ(NumEmptyBlocks(table), 0);
      // A picture of a sixteenth of the size shows the edges within a block.
      request.size = {std::max(size.width / 16, 8),
                      std::max(size.height / 16, 8)};
      request.alpha = 1;
      const RemapTable small =
          FitRemapTable(lens, MakeView(lens, request), 0.05, 2);
      EXPECT_LE(small.max_error_px, 0.05);
      EXPECT_EQ(small.num_out_of_range > 0, NumEmptyBlocks(small) > 0);
      EXPECT_LE(NumEmptyBlocks(small), 2);
    }
  }
}

}  // namespace
}  // namespace raygrid
