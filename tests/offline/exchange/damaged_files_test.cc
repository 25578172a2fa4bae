/// Damaged files of formats that are only read, and of tables.
#include "exchange/damaged_files.h"

#include <cstring>

#include "exchange/npz.h"
#include "exchange/puzzlepaint_files.h"
#include "exchange/puzzlepaint_state.h"
#include "exchange/table_format.h"

namespace raygrid {
namespace {

constexpr char kVnlog[] =
    "# filename x y level\nnone.png - -\n"
    "a.png 10.5 20.25 0\na.png 20 20 0\na.png 30 20 1\n"
    "a.png 10 30 0\na.png 20 30 -\na.png 30 30 0\n";
constexpr char kAprilGrid[] =
    "target_type: 'aprilgrid'\ntagCols: 6\ntagRows: 5\ntagSize: 0.088\n"
    "tagSpacing: 0.3\n";
constexpr char kCheckerboard[] =
    "target_type: 'checkerboard'\ntargetCols: 3\ntargetRows: 4\n"
    "rowSpacingMeters: 0.06\ncolSpacingMeters: 0.061\n";
constexpr char kStarPattern[] =
    "num_star_segments: 16\nsquares_x: 17\nsquares_y: 24\n"
    "square_length_in_meters: 0.011882352941176469\napriltags:\n"
    "  - tag_x: 6\n    tag_y: 10\n    width: 4\n    height: 4\n    index: 0\n";
constexpr char kCornersOfOpenCv[] =
    "%YAML:1.0\n---\nimage_width: 64\nimage_height: 48\nboard_width: 3\n"
    "board_height: 2\n"
    "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
    "   data: [ 50., 0., 32., 0., 50., 24., 0., 0., 1. ]\n"
    "distortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n"
    "   dt: d\n   data: [ 0.1, 0., 0., 0., 0. ]\n"
    "image_points: !!opencv-matrix\n   rows: 1\n   cols: 6\n   dt: \"2f\"\n"
    "   data: [ 1., 2., 3., 2., 5., 2., 1., 4., 3., 4., 5., 4. ]\n";

TEST(DamagedFiles, OfCornersAndTargetsAreNothingElse) {
  TestRandom random(6);
  const std::vector<std::pair<const char*, const char*>> files = {
      {"mrcal-corners", kVnlog},
      {"kalibr-target", kAprilGrid},
      {"kalibr-target", kCheckerboard},
      {"puzzlepaint-pattern", kStarPattern},
      {"opencv", kCornersOfOpenCv}};
  for (const auto& [name, text] : files) {
    const Format& format = FindFormat("", name);
    int num_refused = 0;
    const int count = NumMutants(300);
    for (int k = 0; k < count; ++k) {
      const std::string damaged = Mutated(text, &random);
      num_refused += IsRefused([&, name = name] {
        ReadRequest request = {"f", damaged, "", {}};
        if (name == std::string("mrcal-corners")) request.board = {3, 2};
        ExpectFinite(ReadExchangeFile(&format, request));
      });
    }
    EXPECT_GT(num_refused, count / 10) << name;
    EXPECT_LT(num_refused, count) << name;
  }
}

// Directions and origins of 6 x 8 pixels.
std::vector<NpyArray> RayArrays() {
  std::vector<double> directions, origins;
  for (int k = 0; k < 6 * 8; ++k) {
    directions.insert(directions.end(),
                      {(k % 8 - 3.5) / 8, (k / 8 - 2.5) / 8, 1.0});
    origins.insert(origins.end(), {k * 1e-4, 0, 0});
  }
  const std::vector<int32_t> size = {8, 6};
  return {MakeNpyArray("directions", {6, 8, 3}, directions.data()),
          MakeNpyArray("origins", {6, 8, 3}, origins.data()),
          MakeNpyArray("image_size", {2}, size.data())};
}

// Archives have sums of their bytes, so arrays are damaged before they are put
// in one.
std::string DamagedRays(TestRandom* random) {
  std::vector<NpyArray> arrays = RayArrays();
  NpyArray& array = arrays[random->Index(static_cast<int>(arrays.size()))];
  static const char* const types[] = {"<f4", "<f8", "<i2", "<i8", ">f8",
                                      "|O",  "<c8", "",    "<f9"};
  const int kind = random->Index(4);
  if (kind == 0)
    array.type = types[random->Index(9)];
  else if (kind == 1)
    array.shape[random->Index(static_cast<int>(array.shape.size()))] =
        size_t{1} << random->Index(64);
  else if (kind == 2)
    for (int k = 0; k < 20; ++k)
      array.bytes[random->Index(static_cast<int>(array.bytes.size()))] =
          static_cast<char>(random->Index(256));
  const std::string bytes = WriteNpz(arrays);
  return kind == 3 ? Mutated(bytes, random) : bytes;
}

void ExpectTable(const RayTable& rays) {
  ASSERT_EQ(rays.directions.size(), rays.x.size() * rays.y.size());
  for (const double place : rays.x) EXPECT_TRUE(std::isfinite(place));
  for (const double place : rays.y) EXPECT_TRUE(std::isfinite(place));
  EXPECT_GT(rays.image_size.width, rays.x.back());
  EXPECT_GT(rays.image_size.height, rays.y.back());
  for (size_t k = 0; k < rays.directions.size(); ++k) {
    if (rays.directions[k].hasNaN()) continue;  // a pixel without a ray
    EXPECT_NEAR(rays.directions[k].norm(), 1, 1e-12);
    if (!rays.origins.empty()) {
      EXPECT_TRUE(rays.origins[k].allFinite());
    }
  }
}

TEST(DamagedFiles, OfRaysAreNothingElse) {
  TestRandom random(8);
  const TableFormat& format = *FindTableFormat("rays");
  ExpectTable(format.read_rays("f", WriteNpz(RayArrays())));
  int num_refused = 0;
  const int count = NumMutants(600);
  for (int k = 0; k < count; ++k) {
    const std::string damaged = DamagedRays(&random);
    num_refused +=
        IsRefused([&] { ExpectTable(format.read_rays("f", damaged)); });
  }
  EXPECT_GT(num_refused, count / 3);
  EXPECT_LT(num_refused, count);
}

// Two cameras saw a board of 3 x 2 features and one of 2 x 2, in two images.
PuzzlepaintDataset TwoBoards() {
  PuzzlepaintDataset dataset;
  dataset.image_sizes = {{64, 48}, {32, 32}};
  for (const char* name : {"a.png", "b.png"})
    dataset.imagesets.push_back(
        {name,
         {{{{10.5F, 20.25F}, 0}, {{30, 20}, 1}, {{10, 30}, 3}, {{40, 40}, 7}},
          {{{1, 2}, 9}}}});
  dataset.geometries = {
      {0.02F,
       {{0, {0, 0}}, {1, {1, 0}}, {2, {2, 0}}, {3, {0, 1}}, {4, {1, 1}}}},
      {0.03F, {{6, {0, 0}}, {7, {1, 0}}, {8, {0, 1}}, {9, {1, 1}}}}};
  return dataset;
}

TEST(DamagedFiles, OfDatasetsAreNothingElse) {
  TestRandom random(9);
  const TableFormat& format = *FindTableFormat("puzzlepaint-dataset");
  const std::string whole = EncodePuzzlepaintDataset(TwoBoards());
  EXPECT_EQ(format.read_features("f", whole).boards.size(), 2u);
  int num_refused = 0;
  const int count = NumMutants(600);
  for (int k = 0; k < count; ++k) {
    const std::string damaged = Mutated(whole, &random);
    num_refused += IsRefused([&] {
      const FeatureTable table = format.read_features("f", damaged);
      for (const NamedDataset& camera : table.cameras) {
        ExpectFinite(camera.dataset.images);
        for (const ImageFeatures& image : camera.dataset.images)
          for (const Feature& feature : image.features)
            EXPECT_LT(feature.column, table.boards.at(feature.board).columns);
      }
      for (const Board& board : table.boards)
        EXPECT_EQ(static_cast<int>(board.points.size()), board.num_points());
    });
  }
  EXPECT_GT(num_refused, count / 3);
  EXPECT_LT(num_refused, count);
}

// Poses of cameras and of the rig, features, points.
std::vector<std::string> TextsOfState() {
  const PuzzlepaintDataset dataset = TwoBoards();
  std::map<int, Eigen::Vector3d> points;
  for (const PuzzlepaintGeometry& geometry : dataset.geometries)
    for (const auto& [id, place] : geometry.places)
      points[id] = geometry.PointAt(place) + Eigen::Vector3d(1, 2, 3);
  const PuzzlepaintPoses poses = {
      2,
      {{0, {}},
       {1, {Eigen::Quaterniond(0.6, 0, 0.8, 0), {0.125, -0.5, 1e-3}}}}};
  return {FormatPuzzlepaintPoses(poses, {}),
          FormatPuzzlepaintPoses(poses, {{0, "a.png"}}),
          EncodePuzzlepaintDataset(dataset), FormatPuzzlepaintPoints(points)};
}

TEST(DamagedFiles, OfStatesAreNothingElse) {
  TestRandom random(10);
  int num_refused = 0;
  const int count = NumMutants(300);
  for (int k = -1; k < count; ++k) {
    ReadRequest request = {"s/intrinsics0.yaml", "", "", {}};
    request.beside = TextsOfState();
    if (k >= 0) request.beside[k % 4] = Mutated(request.beside[k % 4], &random);
    InputCamera camera;
    std::vector<std::string> warnings;
    num_refused +=
        IsRefused([&] { ReadCameraState(request, &camera, &warnings); });
    for (const BoardPose& pose : camera.poses)
      EXPECT_TRUE(pose.camera_from_board.rotation.coeffs().allFinite() &&
                  pose.camera_from_board.translation.allFinite());
    ExpectFinite(camera.features);
    if (k < 0) {
      EXPECT_EQ(camera.poses.size(), 4u);
    }
  }
  EXPECT_GT(num_refused, count / 3);
  EXPECT_LT(num_refused, count);
}

// A view of 12 x 9 pixels, of which some see nothing.
std::string StMapBytes() {
  ViewTable view;
  view.path = "f.exr";
  view.size = view.source_size = {12, 9};
  for (int k = 0; k < 12 * 9; ++k)
    view.sources.emplace_back(k % 7 == 0 ? NAN : k % 12 * 0.9, k / 12 * 0.8);
  return FindTableFormat("stmap")->write_view(view).files.front().second;
}

void ExpectTable(const ViewTable& view) {
  ASSERT_EQ(view.sources.size(), view.num_pixels());
  for (const Eigen::Vector2d& source : view.sources) {
    EXPECT_EQ(source.hasNaN(), !source.allFinite());
    EXPECT_EQ(std::isnan(source.x()), std::isnan(source.y()));
  }
}

TEST(DamagedFiles, OfStMapsAreNothingElse) {
  TestRandom random(9);
  const TableFormat& format = *FindTableFormat("stmap");
  const std::string bytes = StMapBytes();
  ExpectTable(format.read_view("f", bytes, {}));
  int num_refused = 0;
  const int count = NumMutants(300);
  for (int k = 0; k < count; ++k) {
    const std::string damaged = Mutated(bytes, &random);
    num_refused += IsRefused([&] {
      ExpectTable(format.read_view("f", damaged, {{12, 9}}));
    });
  }
  EXPECT_GT(num_refused, count / 3);
  EXPECT_LT(num_refused, count);
}

}  // namespace
}  // namespace raygrid
