#include "exchange/puzzlepaint_format.h"

#include "camera/noncentral_generic.h"
#include "camera/thin_prism_fisheye.h"
#include "exchange/external_model_selection.h"
#include "exchange/puzzlepaint_files.h"
#include "exchange/puzzlepaint_state.h"
#include "exchange/unit_grid.h"
#include "support.h"

namespace raygrid {
namespace {

constexpr ImageSize kGridImage = {320, 240};

ExchangeContents ParsePuzzlepaint(const std::string& text) {
  return ReadExchangeFile(RecognizeFormat(text), {"f", text, "", {}});
}

ThinPrismFisheye GridLens() {
  return {
      kGridImage, WholeImage(kGridImage), {150, 151, 162, 118, 0.02, -0.01}};
}

// The camera in the form that it takes, as a file and a lens.
std::pair<std::string, SelectedModel> WrittenGrid(const CameraModel& camera) {
  std::vector<const ExternalModel*> external_models;
  static const Format format = MakePuzzlepaintFormat();
  for (const ExternalModel& external_model : format.external_models)
    external_models.push_back(&external_model);
  SelectedModel chosen = SelectExternalModel(external_models, camera, nullptr);
  OutputCamera written;
  written.name = "front";
  written.lens = chosen.lens;
  written.fit = chosen.fit;
  return {format.write({"f.yaml", {written}}), std::move(chosen)};
}

// Lines that miss the origin by some 10 mm.
NonCentralGeneric LinesOf(const CameraModel& lens) {
  const CentralGeneric grid = FittedGrid(lens, 30);
  std::vector<Eigen::Vector3d> points;
  for (int k = 0; k < grid.surface().num_points(); ++k) {
    const Eigen::Vector2d pixel = grid.surface().GetPixel(k);
    points.emplace_back(1e-5 * pixel.x(), -3e-5 * pixel.y(),
                        1e-7 * pixel.x() * pixel.y());
  }
  return {kGridImage, grid.surface(), points};
}

TEST(MakePuzzlepaintFormat, HasTheFormulaOfTheProgram) {
  // 5 x 4 control points: 2 cells, of 10 pixels each, beside one another.
  std::vector<Eigen::Vector3d> directions;
  for (int k = 0; k < 20; ++k)
    directions.push_back(
        Eigen::Vector3d(0.1 * (k % 5), 0.1 * (k / 5), 1).normalized());
  const UnitGrid grid({40, 30}, {10, 5, 29, 14}, 5, 4, directions, {});
  EXPECT_EQ(grid.area(), (Area{9.5, 4.5, 29.5, 14.5}));
  // The corner of pixel (10, 5) is control point (1, 1), where its neighbours
  // have 1/6 as often as it has 4/6.
  Eigen::Vector3d expected = Eigen::Vector3d::Zero();
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i)
      expected +=
          (i == 1 ? 4 : 1) * (j == 1 ? 4 : 1) / 36.0 * directions[5 * j + i];
  EXPECT_LT((grid.Unproject({9.5, 4.5}).value() - expected.normalized()).norm(),
            1e-15);
  EXPECT_FALSE(grid.Unproject({9.4, 5}));
  ExpectRoundTrip(grid, 1e-6);
}

TEST(MakePuzzlepaintFormat, WritesTheNearestGrid) {
  const ThinPrismFisheye lens = GridLens();
  const auto [text, chosen] = WrittenGrid(lens);
  EXPECT_EQ(chosen.lens.external_model->name, "CentralGenericModel");
  EXPECT_GT(chosen.fit->max_px, 0);
  EXPECT_LT(chosen.fit->max_px, 0.01);
  EXPECT_NE(text.find("type : CentralGenericModel\nwidth : 320\nheight : 240\n"
                      "calibration_min_x : 0\ncalibration_min_y : 0\n"
                      "calibration_max_x : 319\ncalibration_max_y : 239\n"
                      "grid_width : 19\ngrid_height : 15\n# "),
            std::string::npos);
  const ExchangeContents read = ParsePuzzlepaint(text);
  ASSERT_EQ(read.warnings.size(), 1u);
  const size_t rms = read.warnings[0].find("RMS ");
  ASSERT_NE(rms, std::string::npos) << read.warnings[0];
  EXPECT_LT(std::stod(read.warnings[0].substr(rms + 4)), 0.01);
  const auto camera = MakeCameraModel(read.cameras[0].lens);
  EXPECT_EQ(camera->Name(), "central-generic");
  const std::string inner =
      TextWith(TextWith(text, "min_x : 0", "min_x : 12"), "y : 239", "y : 230");
  const auto part = MakeCameraModel(ParsePuzzlepaint(inner).cameras[0].lens);
  EXPECT_EQ(part->area(), (Area{11.5, 0, 319, 230.5}));
  EXPECT_NE(
      WrittenGrid(*part).first.find(inner.substr(
          inner.find("width"), inner.find("grid :") - inner.find("width"))),
      std::string::npos);
  for (const Eigen::Vector2d& pixel :
       {Eigen::Vector2d(3, 4), Eigen::Vector2d(160, 120),
        Eigen::Vector2d(300.5, 230)})
    EXPECT_LT(
        (camera->Project(lens.Unproject(pixel).value()).value() - pixel).norm(),
        0.01);
}

TEST(MakePuzzlepaintFormat, HoldsLines) {
  const NonCentralGeneric lines = LinesOf(GridLens());
  const auto [text, chosen] = WrittenGrid(lines);
  EXPECT_EQ(chosen.lens.external_model->name, "NoncentralGenericModel");
  EXPECT_LT(chosen.fit->max_px, 0.02);
  EXPECT_LT(text.find("point_grid : ["), text.find("direction_grid : ["));
  ExpectRoundTrip(*chosen.lens.grid, 1e-5);
  const auto read = MakeCameraModel(ParsePuzzlepaint(text).cameras[0].lens);
  EXPECT_EQ(read->Name(), "noncentral-generic");
  for (const Eigen::Vector2d& pixel :
       {Eigen::Vector2d(3, 4), Eigen::Vector2d(160, 120),
        Eigen::Vector2d(300.5, 230)})
    for (const double distance_m : {0.2, 5.0})
      EXPECT_LT(
          (read->Project(PointAlong(lines.Line(pixel).value(), distance_m))
               .value() -
           pixel)
              .norm(),
          0.02);
}

TEST(MakePuzzlepaintFormat, SaysWhatIsMissingOrWrong) {
  const std::string text = WrittenGrid(GridLens()).first;
  const auto expect = [&](const std::string& old, const std::string& by,
                          const std::vector<std::string>& words) {
    ExpectError(ExitCode::kInvalidInput, words,
                [&] { ParsePuzzlepaint(TextWith(text, old, by)); });
  };
  expect("type : Central", "type : Radial",
         {"f: unsupported type", "CentralGenericModel"});
  expect("type : ", "kind : ", {"'type' is missing"});
  expect("max_x : 319", "max_x : 320", {"calibration_max_x", "not a pixel"});
  expect("max_x : 319", "max_x : 0", {"empty area"});
  expect("grid_width : 19", "grid_width : 3", {"grid_width: must be 4 to"});
  expect("grid_width : 19", "grid_width : 20",
         {"grid: expected a list of 900 numbers"});
  expect("grid : [", "grid : [0, 0, 0, ", {"855 numbers"});
  expect("grid : [", "grid : [.nan, ", {"855 numbers"});
  expect("\ngrid : [", "\ngrid2 : [", {"grid: expected a list"});
  EXPECT_EQ(ParsePuzzlepaint(TextWith(text, "GenericModel\nwidth",
                                      "GenericBSplineModel\nwidth"))
                .cameras[0]
                .lens.external_model->name,
            "CentralGenericModel");
}

// ---- States ----------------------------------------------------------------

constexpr char kOnePose[] =
    "# Each pose gives the B_tr_A transformation.\npose_count: 3\nposes:\n"
    "  - index: 1\n    tx: 0.5\n    ty: -0.25\n    tz: 2\n"
    "    qx: 0\n    qy: 0.8\n    qz: 0\n    qw: 0.6\n";

TEST(MakePuzzlepaintFormat, ReadsPosesOfImagesThatWereUsed) {
  const PuzzlepaintPoses poses = ParsePuzzlepaintPoses("f", kOnePose);
  EXPECT_EQ(poses.count, 3);
  ASSERT_EQ(poses.poses.size(), 1u);
  // The x axis turns towards -z by the angle whose half has the cosine 0.6.
  EXPECT_LT((poses.poses.at(1) * Eigen::Vector3d(1, 0, 0) -
             Eigen::Vector3d(0.5 - 0.28, -0.25, 2 - 0.96))
                .norm(),
            1e-15);
  const std::string text = FormatPuzzlepaintPoses(poses, {{1, "a\nb.png"}});
  EXPECT_NE(text.find("- index: 1  # a\\nb.png\n"), std::string::npos);
  EXPECT_EQ(ParsePuzzlepaintPoses("f", text).poses.at(1).rotation.coeffs(),
            poses.poses.at(1).rotation.coeffs());
}

TEST(MakePuzzlepaintFormat, SaysWhatIsWrongWithPosesAndPoints) {
  const auto expect = [](const std::string& old, const std::string& by,
                         const std::vector<std::string>& words) {
    ExpectError(ExitCode::kInvalidInput, words, [&] {
      ParsePuzzlepaintPoses("f", TextWith(kOnePose, old, by));
    });
  };
  expect("index: 1", "index: 3", {"poses[0]: index 3", "pose_count 3"});
  expect("index: 1", "index: -1", {"poses[0]: index", "0 to 1000000"});
  expect("pose_count: 3", "pose_count: 1e9", {"pose_count"});
  expect("pose_count: 3", "count: 3", {"pose_count"});
  expect("tx: 0.5", "tx: .nan", {"poses[0]: tx: expected a finite number"});
  expect("qw: 0.6", "qw: 60", {"poses[0]", "not a unit quaternion"});
  expect("poses:", "list:", {"poses: expected a list"});
  const std::string points = FormatPuzzlepaintPoints({{5, {1, 2, 3}}});
  EXPECT_EQ(ParsePuzzlepaintPoints("f", points).at(5),
            Eigen::Vector3d(1, 2, 3));
  for (const auto& [old, by, word] :
       {std::tuple("[1.0, ", "[", "three coordinates"),
        {"index: 0", "index: 1", "point_index 1: out of range, 1 points"},
        {"id: 5", "id: -5", "feature_id"}})
    ExpectError(ExitCode::kInvalidInput, {word},
                [&, text = TextWith(points, old, by)] {
                  ParsePuzzlepaintPoints("f", text);
                });
}

// Cameras without lenses, whose files are written beside them.
std::vector<OutputCamera> PosedCameras(const std::vector<std::string>& images) {
  std::vector<OutputCamera> cameras(1);
  for (const std::string& image : images)
    cameras[0].poses.push_back(
        {image, 0, {Eigen::Quaterniond::Identity(), {0, 0, 1}}});
  return cameras;
}

std::map<int, Pose> WrittenPoses(const std::vector<std::string>& images,
                                 const std::string& dataset) {
  const auto files = WriteState("s/intrinsics0.yaml", PosedCameras(images),
                                {"", "", dataset, ""});
  EXPECT_EQ(files[1].path, "s/rig_tr_global.yaml");
  return ParsePuzzlepaintPoses("f", files[1].text).poses;
}

TEST(MakePuzzlepaintFormat, PlacesTheRigByACameraThatIsNotItsOrigin) {
  std::vector<OutputCamera> cameras = PosedCameras({"a.png"});
  cameras[0].camera_from_rig =
      Pose{Eigen::Quaterniond(0.6, 0, 0.8, 0), {0.5, -0.25, 0.125}};
  const auto files = WriteState("s/intrinsics0.yaml", cameras, {});
  ASSERT_EQ(files.size(), 2u);
  const auto only = [&](const CompanionFile& file) {
    return ParsePuzzlepaintPoses("f", file.text).poses.at(0);
  };
  EXPECT_EQ(files[0].path, "s/camera_tr_rig.yaml");
  const Eigen::Vector3d point(1, 2, 3);
  EXPECT_LT((only(files[0]) * (only(files[1]) * point) -
             cameras[0].poses[0].camera_from_board * point)
                .norm(),
            1e-14);
}

TEST(MakePuzzlepaintFormat, NumbersImagesAsTheDatasetOrTheirNamesDo) {
  PuzzlepaintDataset dataset;
  dataset.image_sizes = {{64, 48}};
  for (const char* name : {"c.png", "a.png", "b.png"})
    dataset.imagesets.push_back({name, {{}}});
  const std::string bytes = EncodePuzzlepaintDataset(dataset);
  const auto numbers = [](const std::map<int, Pose>& poses) {
    std::vector<int> all;
    for (const auto& pose : poses) all.push_back(pose.first);
    return all;
  };
  EXPECT_EQ(numbers(WrittenPoses({"a.png", "c.png"}, bytes)),
            (std::vector<int>{0, 1}));
  EXPECT_EQ(numbers(WrittenPoses({"b.png"}, bytes)), std::vector<int>{2});
  EXPECT_EQ(numbers(WrittenPoses({"7", "2"}, "")), (std::vector<int>{2, 7}));
  EXPECT_EQ(numbers(WrittenPoses({"7", "x"}, "")), (std::vector<int>{0, 1}));
  ExpectError(ExitCode::kInvalidInput, {"'d.png' is not in s/dataset.bin"},
              [&] { WrittenPoses({"d.png"}, bytes); });
}

TEST(MakePuzzlepaintFormat, WritesPointsThatReplaceNone) {
  PuzzlepaintDataset dataset;
  dataset.image_sizes = {{64, 48}};
  dataset.imagesets = {{"a.png", {{}}}};
  dataset.geometries = {{0.03F, {{0, {0, 0}}, {4, {2, 1}}}}};
  const auto files =
      WriteState("s/intrinsics0.yaml", PosedCameras({"a.png"}),
                 {"", "", EncodePuzzlepaintDataset(dataset), ""});
  ASSERT_EQ(files.size(), 3u);
  EXPECT_EQ(files[2].path, "s/points.yaml");
  EXPECT_TRUE(files[2].is_never_replaced);
  EXPECT_EQ(ParsePuzzlepaintPoints("f", files[2].text).at(4),
            Eigen::Vector3d(0.06, 0.03, 0));
}

TEST(MakePuzzlepaintFormat, RefusesStatesThatTheProgramWouldNotFind) {
  std::vector<OutputCamera> cameras = PosedCameras({"a.png", "b.png"});
  ExpectError(ExitCode::kUsage, {"front.yaml", "intrinsics0.yaml"}, [&] {
    MakePuzzlepaintFormat().write_beside({"s/front.yaml", cameras});
  });
  cameras[0].poses[1].board = 3;
  ExpectError(ExitCode::kInvalidInput, {"boards 0 and 3", "puzzlepaint"}, [&] {
    MakePuzzlepaintFormat().write_beside({"s/intrinsics0.yaml", cameras});
  });
}

}  // namespace
}  // namespace raygrid
