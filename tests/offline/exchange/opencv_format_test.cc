#include "exchange/opencv_format.h"

#include <fmt/format.h>

#include "support.h"

namespace raygrid {
namespace {

// Files that OpenCV 4.6 wrote.
constexpr char kYaml[] =
    "%YAML:1.0\n---\ncalibration_time: \"Tue 1 Jan\"\nimage_width: 640\n"
    "image_height: 480\ncamera_matrix: !!opencv-matrix\n   rows: 3\n"
    "   cols: 3\n   dt: d\n   data: [ 5.0012345678899999e+02, 0., 320., 0.,\n"
    "       501., 240., 0., 0., 1. ]\n"
    "distortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: 5\n"
    "   dt: d\n   data: [ -2.9999999999999999e-01, 1.0000000000000001e-01,\n"
    "       1.0000000000000000e-03, -2.0000000000000000e-03, 0.25 ]\n";
constexpr char kXml[] =
    "<?xml version=\"1.0\"?>\n<opencv_storage>\n"
    "<calibration_time>\"Tue 1 Jan\"</calibration_time>\n"
    "<cameraResolution>\n  640 480</cameraResolution>\n"
    "<cameraMatrix type_id=\"opencv-matrix\">\n  <rows>3</rows>\n"
    "  <cols>3</cols>\n  <dt>d</dt>\n  <data>\n"
    "    5.0012345678899999e+02 0. 320. 0. 501. 240. 0. 0.\n    1.</data>"
    "</cameraMatrix>\n<distCoeffs type_id=\"opencv-matrix\">\n"
    "  <rows>5</rows>\n  <cols>1</cols>\n  <dt>d</dt>\n  <data>\n"
    "    -2.9999999999999999e-01 1.0000000000000001e-01\n"
    "    1.0000000000000000e-03 -2.0000000000000000e-03 0.25</data>"
    "</distCoeffs>\n</opencv_storage>\n";

ExchangeContents Parse(const std::string& text,
                       const std::string& external_model = "",
                       std::optional<ImageSize> size = {}) {
  return ReadExchangeFile(RecognizeFormat(text),
                          {"f", text, external_model, size});
}

TEST(OpenCvFormat, ReadsWhatOpenCvWrites) {
  for (const char* text : {kYaml, kXml}) {
    const ExchangeContents contents = Parse(text);
    ASSERT_EQ(contents.cameras.size(), 1u);
    const ConvertedCamera& lens = contents.cameras[0].lens;
    EXPECT_EQ(lens.external_model->name, "opencv5");
    EXPECT_EQ(lens.size, (ImageSize{640, 480}));
    EXPECT_EQ(lens.values,
              (std::vector<double>{500.12345678899999, 501, 320, 240, -0.3, 0.1,
                                   0.001, -0.002, 0.25}));
  }
}

TEST(OpenCvFormat, TellsModelsApart) {
  const std::string four =
      TextWith(TextWith(kYaml, ", 0.25", ""), "cols: 5", "cols: 4");
  EXPECT_EQ(Parse(four).cameras[0].lens.external_model->name, "opencv4");
  EXPECT_EQ(Parse(four).warnings.size(), 1u);
  EXPECT_EQ(Parse(four, "fisheye").cameras[0].lens.external_model->name,
            "fisheye");
  EXPECT_TRUE(Parse(four, "fisheye").warnings.empty());
  const ExchangeContents column = Parse(
      TextWith(TextWith(four, "rows: 1", "rows: 4"), "cols: 4", "cols: 1"));
  EXPECT_EQ(column.cameras[0].lens.external_model->name, "fisheye");
  EXPECT_EQ(column.warnings.size(), 1u);
  for (const char* key :
       {"fisheye_model: 1\n", "distortion_model: fisheye\n"}) {
    const ExchangeContents said = Parse(four + key);
    EXPECT_EQ(said.cameras[0].lens.external_model->model, "thin-prism-fisheye");
    EXPECT_TRUE(said.warnings.empty());
  }
}

// OpenCV writes 14 numbers when a prism or a tilt was asked for.
TEST(OpenCvFormat, TakesZerosForWhatIsNotThere) {
  const auto with = [](const std::string& more) {
    return TextWith(TextWith(kYaml, "0.25 ]", "0.25, 0.1, 0, 0, " + more + "]"),
                    "cols: 5", "cols: 14");
  };
  EXPECT_EQ(Parse(with("0,0,0,0,0,0")).cameras[0].lens.external_model->model,
            "opencv");
  EXPECT_EQ(Parse(with("0,0,0,0,0,1e-3")).cameras[0].lens.external_model->name,
            "opencv14");
  // Of programs that have omnidir, too; the size is a matrix there.
  const ExchangeContents generic =
      Parse(TextWith(TextWith(with("0,0,0,0,0,0"), "image_width", "other"),
                     "image_height", "another") +
            "xi: 0.\nresolution: !!opencv-matrix\n   rows: 2\n   cols: 1\n"
            "   dt: i\n   data: [ 640, 480 ]\n");
  EXPECT_EQ(generic.cameras.at(0).lens.external_model->model, "opencv");
  EXPECT_EQ(generic.cameras[0].lens.size, (ImageSize{640, 480}));
}

// xi makes another camera of the same matrix and coefficients.
TEST(OpenCvFormat, ReadsOmnidir) {
  const std::string four =
      TextWith(TextWith(kYaml, ", 0.25", ""), "cols: 5", "cols: 4");
  for (const char* xi :
       {"xi: 1.25\n",
        "xi: !!opencv-matrix\n   rows: 1\n   cols: 1\n   dt: d\n"
        "   data: [ 1.25 ]\n"}) {
    const ExchangeContents contents = Parse(four + xi);
    EXPECT_TRUE(contents.warnings.empty());
    const auto lens = MakeCameraModel(contents.cameras.at(0).lens);
    EXPECT_EQ(lens->Name(), "omni-radtan");
    const Eigen::Vector3d point(0.2, -0.1, 1);
    const double depth = 1 + 1.25 * point.norm(), x = 0.2 / depth,
                 y = -0.1 / depth, r2 = x * x + y * y,
                 g = 1 - 0.3 * r2 + 0.1 * r2 * r2;
    const Eigen::Vector2d expected(
        500.12345678899999 *
                (x * g + 2 * 1e-3 * x * y - 2e-3 * (r2 + 2 * x * x)) +
            320,
        501 * (y * g + 1e-3 * (r2 + 2 * y * y) - 2 * 2e-3 * x * y) + 240);
    EXPECT_LT((lens->Project(point).value() - expected).norm(), 1e-9);
  }
  ExpectError(ExitCode::kInvalidInput, {"f: ", "omnidir", "--model opencv4"},
              [&] { Parse(four + "xi: 1.25\n", "opencv4"); });
  ExpectError(ExitCode::kInvalidInput, {"f: ", "xi", "is_fisheye"},
              [&] { Parse(four + "xi: 1.25\nis_fisheye: 1\n"); });
  ExpectError(ExitCode::kInvalidInput, {"f: ", "'xi'"},
              [&] { Parse(four + "camera_model: omnidirectional\n"); });
}

TEST(OpenCvFormat, RefusesAnotherModelThanTheFileSays) {
  const std::string four =
      TextWith(TextWith(kYaml, ", 0.25", ""), "cols: 5", "cols: 4");
  for (const auto& [line, model] :
       {std::pair("fisheye_model: 1\n", "opencv4"),
        {"fisheye_model: 0\n", "fisheye"},
        {"distortion_model: plumb_bob\n", "fisheye"},
        {"", "opencv8"}})
    ExpectError(ExitCode::kInvalidInput,
                {"f: ", std::string("--model ") + model},
                [&, &l = line, &m = model] { Parse(four + l, m); });
}

// FileStorage needs no space behind a key.
TEST(OpenCvFormat, ReadsKeysWithoutSpace) {
  std::string dense = kYaml;
  for (const auto& [spaced, bare] : {std::pair("data: [", "data:["),
                                     {"rows: ", "rows:"},
                                     {"image_width: ", "image_width:"}})
    dense = TextWith(dense, spaced, bare);
  EXPECT_EQ(Parse(dense).cameras.at(0).lens.values,
            Parse(kYaml).cameras.at(0).lens.values);
}

std::string StoredText(const std::string& key, int rows, int cols,
                       const std::string& data) {
  return fmt::format(
      "{}: !!opencv-matrix\n   rows: {}\n   cols: {}\n   dt: d\n   data: [ {} "
      "]\n",
      key, rows, cols, data);
}

// stereo_calib writes the cameras into one file, their pose into another.
TEST(OpenCvFormat, ReadsPairs) {
  const std::string pose = StoredText("R", 3, 3, "0, -1, 0, 1, 0, 0, 0, 0, 1") +
                           StoredText("T", 3, 1, "-0.1, 0.2, 0.3") +
                           StoredText("Q", 1, 4, "1, 2, 3, 4");
  for (const auto& [m1, d1, m2, d2] : std::vector<std::array<const char*, 4>>{
           {"M1", "D1", "M2", "D2"},
           {"cameraMatrix1", "distCoeffs1", "cameraMatrix2", "distCoeffs2"},
           {"K_left", "D_left", "K_right", "D_right"}}) {
    const std::string cameras =
        StoredText(m1, 3, 3, "500, 0, 320, 0, 501, 240, 0, 0, 1") +
        StoredText(d1, 14, 1, "-0.1,0.02,0,0,0.1,0,0,0.2,0,0,0,0,0,0") +
        StoredText(m2, 3, 3, "510, 0, 320, 0, 511, 240, 0, 0, 1") +
        StoredText(d2, 1, 5, "-0.1,0.02,0,0,0.1");
    const ImageSize size = {640, 480};
    ExchangeContents apart = Parse("%YAML:1.0\n---\n" + cameras, "", size);
    ASSERT_EQ(apart.cameras.size(), 2u) << m1;
    EXPECT_FALSE(apart.IsRig());
    EXPECT_EQ(apart.cameras[0].lens.external_model->name, "opencv8");
    EXPECT_EQ(apart.cameras[1].lens.Value("fy"), 511);
    const ExchangeContents alone = Parse("%YAML:1.0\n---\n" + pose);
    AssignPairPose(alone.second_from_first, "f", &apart.cameras);
    const ExchangeContents both =
        Parse("%YAML:1.0\n---\n" + cameras + pose, "", size);
    EXPECT_TRUE(both.warnings.empty());
    for (const ExchangeContents* contents : {&std::as_const(apart), &both}) {
      ASSERT_TRUE(contents->IsRig());
      EXPECT_LT(
          (*contents->cameras[1].camera_from_rig * Eigen::Vector3d(1, 0, 0) -
           Eigen::Vector3d(-0.1, 1.2, 0.3))
              .norm(),
          1e-12);
    }
  }
  std::vector<InputCamera> one(1);
  ExpectError(ExitCode::kInvalidInput, {"f: ", "R and T", "import"},
              [&] { AssignPairPose(Pose{}, "f", &one); });
}

// As many as are numbered, or named in a list.
TEST(OpenCvFormat, ReadsSeveralCameras) {
  const auto camera = [](const std::string& m, const std::string& d,
                         const char* fx) {
    return StoredText(m, 3, 3,
                      std::string(fx) + ", 0, 320, 0, 501, 240, 0, 0, 1") +
           StoredText(d, 1, 5, "-0.1,0.02,0,0,0.1");
  };
  const std::string head = "%YAML:1.0\n---\n";
  const ExchangeContents numbered =
      Parse(head + camera("camera_matrix_0", "camera_distortion_0", "500") +
                camera("camera_matrix_1", "camera_distortion_1", "510") +
                camera("camera_matrix_2", "camera_distortion_2", "520"),
            "", ImageSize{640, 480});
  ASSERT_EQ(numbered.cameras.size(), 3u);
  EXPECT_EQ(numbered.cameras[2].name, "camera2");
  EXPECT_EQ(numbered.cameras[2].lens.Value("fx"), 520);
  EXPECT_TRUE(numbered.warnings.empty());
  const ExchangeContents named = Parse(
      head + "names:\n  - \"01\"\n  - \"B2\"\n" +
          camera("K_01", "dist_01", "500") + camera("K_B2", "dist_B2", "510"),
      "", ImageSize{640, 480});
  ASSERT_EQ(named.cameras.size(), 2u);
  EXPECT_EQ(named.cameras[1].name, "B2");
  EXPECT_EQ(named.cameras[1].lens.Value("fx"), 510);
}

TEST(OpenCvFormat, SaysWhatIsMissingOrWrong) {
  const auto expect = [](const std::string& text,
                         const std::vector<std::string>& words) {
    ExpectError(ExitCode::kInvalidInput, words, [&] { Parse(text); });
  };
  expect(TextWith(kYaml, "image_width", "other"), {"f: ", "--image-size"});
  expect(TextWith(kYaml, "camera_matrix", "other"), {"camera_matrix"});
  expect(TextWith(kYaml, "distortion_coe", "x"), {"distortion_coefficients"});
  expect(TextWith(kYaml, "501.", ".nan"), {"camera_matrix", "finite"});
  expect(TextWith(kYaml, "501.", "1e999"), {"camera_matrix", "finite"});
  expect(TextWith(kYaml, "5.00", "x5.00"), {"camera_matrix"});
  expect(TextWith(kYaml, "0., 1. ]", "0., 2. ]"), {"camera_matrix"});
  expect(TextWith(kYaml, "cols: 5", "cols: 6"),
         {"5 numbers do not match the size 1 x 6"});
  expect(TextWith(TextWith(kYaml, ", 0.25", ", 0, 1"), "cols: 5", "cols: 6"),
         {"6 distortion coefficients"});
  expect(kYaml + std::string("distortion_model: brown\n"), {"'brown'"});
  expect(TextWith(kYaml, "dt: d", "dt: 2d"), {"expected 1 channel"});
  expect(TextWith(kXml, "opencv_storage", "other"), {"line"});
  expect(TextWith(kYaml, "image_width: 640", "image_width: 640.5"), {"size"});
}

TEST(OpenCvFormat, TakesTheSizeThatIsGiven) {
  const std::string without = TextWith(kYaml, "image_width", "other");
  EXPECT_EQ(Parse(without, "", ImageSize{640, 480}).cameras[0].lens.size,
            (ImageSize{640, 480}));
}

constexpr char kCorners[] =
    "board_width: 2\nboard_height: 2\nimage_points: !!opencv-matrix\n"
    "   rows: 2\n   cols: 4\n   dt: \"2f\"\n   data: [ 10.5, 20., 30., 20.,\n"
    "       10., 40., 30., 40., 1., 2., 3., 4., 5., 6., 7., 8.25 ]\n"
    "extrinsic_parameters: !!opencv-matrix\n   rows: 2\n   cols: 6\n"
    "   dt: d\n   data: [ 0., 0., 1.5707963267948966, 0.1, 0.2, 1., 0., 0., "
    "0.,\n"
    "       0., 0., 2. ]\n";

TEST(OpenCvFormat, ReadsWhatASampleCalibratedWith) {
  const InputCamera camera = Parse(kYaml + std::string(kCorners)).cameras.at(0);
  ASSERT_EQ(camera.features.size(), 2u);
  EXPECT_EQ(camera.features[1].image, "view0001");
  const Feature& last = camera.features[1].features.back();
  EXPECT_EQ(last.column, 1);
  EXPECT_EQ(last.row, 1);
  EXPECT_EQ(last.pixel, Eigen::Vector2d(7, 8.25));
  ASSERT_EQ(camera.poses.size(), 2u);
  EXPECT_LT((camera.poses[0].camera_from_board * Eigen::Vector3d(1, 0, 0) -
             Eigen::Vector3d(0.1, 1.2, 1))
                .norm(),
            1e-12);
  for (const auto& [old, by] :
       std::vector<std::array<const char*, 2>>{{"2f", "3f"},
                                               {"8.25", ".nan"},
                                               {"cols: 6", "cols: 4"},
                                               {"1.57", "x1.57"}})
    ExpectError(ExitCode::kInvalidInput, {"f: "}, [&, &o = old, &b = by] {
      Parse(TextWith(kYaml + std::string(kCorners), o, b));
    });
}

// A board that is not told is no fault of the camera.
TEST(OpenCvFormat, TakesCornersOnlyWithTheirBoard) {
  for (const auto& [old, by, word] :
       {std::array{"board_width", "other", "--board-size"},
        std::array{"board_height: 2", "board_height: 3", "2 x 3"}}) {
    const std::string text = TextWith(kCorners, old, by);
    const InputCamera camera = Parse(kYaml + text).cameras.at(0);
    EXPECT_TRUE(camera.features.empty());
    EXPECT_NE(camera.missing_features_reason.find(word), std::string::npos);
    ExpectError(ExitCode::kInvalidInput, {"f: ", "image_points", word},
                [&] { Parse(text); });
  }
  const ExchangeContents alone = Parse(kCorners);
  EXPECT_TRUE(alone.cameras.empty());
  ASSERT_EQ(alone.corners.size(), 2u);
  EXPECT_EQ(alone.corners[0].features[2].pixel, Eigen::Vector2d(10, 40));
}

TEST(OpenCvFormat, HoldsPoses) {
  OutputCamera camera;
  camera.lens = Parse(kYaml).cameras[0].lens;
  camera.poses = {
      {"a b.png", 0, {Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5), {1, 2, 3}}},
      {"\"c\".png", 7, {}}};
  for (const char* path : {"a.yaml", "a.xml", "a.json"}) {
    const std::string text = OpenCvFormat().write({path, {camera}});
    const std::vector<BoardPose> poses = Parse(text).cameras[0].poses;
    ASSERT_EQ(poses.size(), 2u) << path;
    EXPECT_EQ(poses[0].image, "a b.png");
    EXPECT_EQ(poses[1].image, "\"c\".png");
    EXPECT_EQ(poses[1].board, 7);
    EXPECT_LT(poses[0].camera_from_board.rotation.angularDistance(
                  camera.poses[0].camera_from_board.rotation),
              1e-7);
    EXPECT_EQ(poses[0].camera_from_board.translation, Eigen::Vector3d(1, 2, 3));
  }
}

// A distortion that folds within the image, and lengths that may be
// millimetres.
TEST(OpenCvFormat, SaysWhatMayNotBeExpected) {
  const auto warnings = [](const std::string& text) {
    return ReadExchangeFile(RecognizeFormat(text), {"f", text, "", {}})
        .warnings;
  };
  EXPECT_TRUE(warnings(kYaml).empty());
  const auto folds =
      warnings(TextWith(TextWith(kYaml, "-2.99", "-6.99"), "0.25", "0.0"));
  ASSERT_EQ(folds.size(), 1u);
  EXPECT_NE(folds[0].find("% of the image, where the distortion"),
            std::string::npos);
  const std::string pose =
      "R: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
      "   data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\nT: !!opencv-matrix\n   rows: 3\n"
      "   cols: 1\n   dt: d\n   data: [-120.0, 0, 0]\n";
  const auto far = warnings(kYaml + pose);
  ASSERT_EQ(far.size(), 1u);
  EXPECT_NE(far[0].find("120 m"), std::string::npos);
}

TEST(OpenCvFormat, StoresWhatAFitLeaves) {
  const Format format = OpenCvFormat();
  OutputCamera camera;
  camera.lens = Parse(kYaml).cameras[0].lens;
  camera.fit = ModelFit{0.125, 0.25, 0.5, 1000, 7};
  for (const char* path : {"a.yaml", "a.xml", "a.json"}) {
    const std::string text = format.write({path, {camera}});
    for (const char* word : {"raygrid_fit", "rms_px", "0.125", "max_px", "0.5",
                             "pixels_beyond", "lens_from_camera_wxyz"})
      EXPECT_NE(text.find(word), std::string::npos) << path << word;
    EXPECT_EQ(Parse(text).cameras[0].lens.values, camera.lens.values) << path;
  }
}

}  // namespace
}  // namespace raygrid
