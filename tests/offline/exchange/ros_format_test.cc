#include "exchange/ros_format.h"

#include "support.h"

namespace raygrid {
namespace {

// A file that camera_calibration_parsers wrote.
constexpr char kCameraInfo[] =
    "image_width: 640\nimage_height: 480\ncamera_name: narrow_stereo/left\n"
    "camera_matrix:\n  rows: 3\n  cols: 3\n"
    "  data: [500.5, 0, 320.25, 0, 501, 240, 0, 0, 1]\n"
    "distortion_model: plumb_bob\ndistortion_coefficients:\n  rows: 1\n"
    "  cols: 5\n  data: [-0.3, 0.1, 0.001, -0.002, 0]\n"
    "rectification_matrix:\n  rows: 3\n  cols: 3\n"
    "  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\nprojection_matrix:\n  rows: 3\n"
    "  cols: 4\n  data: [500.5, 0, 320.25, 0, 0, 501, 240, 0, 0, 0, 1, 0]\n";

// A message as 'ros2 topic echo' prints it.
constexpr char kMessage[] =
    "header:\n  stamp:\n    sec: 1\n  frame_id: camera\nheight: 480\n"
    "width: 640\ndistortion_model: rational_polynomial\nd:\n- 0.1\n- 0.2\n"
    "- 0.001\n- 0.002\n- 0.3\n- 0.4\n- 0.5\n- 0.6\nk:\n- 500.5\n- 0.0\n"
    "- 320.25\n- 0.0\n- 501.0\n- 240.0\n- 0.0\n- 0.0\n- 1.0\n"
    "r: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"
    "p: [400.0, 0, 300.0, 0, 0, 400.0, 240, 0, 0, 0, 1, 0]\n"
    "binning_x: 0\nbinning_y: 0\nroi:\n  x_offset: 0\n  y_offset: 0\n"
    "  height: 0\n  width: 0\n  do_rectify: false\n---\n";

ExchangeContents ParseRos(const std::string& text) {
  return ReadExchangeFile(RecognizeFormat(text), {"f", text, "", {}});
}

TEST(MakeRosFormat, ReadsFiles) {
  const InputCamera camera = ParseRos(kCameraInfo).cameras.at(0);
  EXPECT_EQ(camera.name, "narrow_stereo/left");
  EXPECT_EQ(camera.lens.external_model->name, "plumb_bob");
  EXPECT_EQ(camera.lens.size, (ImageSize{640, 480}));
  EXPECT_EQ(camera.lens.values,
            (std::vector<double>{500.5, 501, 320.25, 240, -0.3, 0.1, 0.001,
                                 -0.002, 0}));
  EXPECT_FALSE(camera.rectified->HasBaseline());
}

TEST(MakeRosFormat, ReadsMessages) {
  const ExchangeContents contents = ParseRos(kMessage);
  const ConvertedCamera& lens = contents.cameras.at(0).lens;
  EXPECT_EQ(lens.external_model->name, "rational_polynomial");
  EXPECT_EQ(lens.values,
            (std::vector<double>{500.5, 501, 320.25, 240, 0.1, 0.2, 0.001,
                                 0.002, 0.3, 0.4, 0.5, 0.6}));
  EXPECT_EQ(contents.cameras[0].rectified->p(0, 2), 300);
  EXPECT_TRUE(contents.warnings.empty());
  const std::string binned = TextWith(kMessage, "binning_x: 0", "binning_x: 2");
  EXPECT_EQ(ParseRos(binned).warnings.size(), 1u);
}

TEST(MakeRosFormat, KnowsWhatDriversWrite) {
  const auto form_with = [](const std::string& model, const std::string& d) {
    const std::string text = TextWith(TextWith(kCameraInfo, "plumb_bob", model),
                                      "-0.3, 0.1, 0.001, -0.002, 0]", d + "]");
    return *ParseRos(text).cameras.at(0).lens.external_model;
  };
  EXPECT_EQ(form_with("plumb_bob", "").parameters.size(), 4u);
  EXPECT_EQ(form_with("plumb_bob", "0,0,0,0").parameters.size(), 8u);
  EXPECT_EQ(form_with("equidistant", "0,0,0,0").model, "thin-prism-fisheye");
  EXPECT_EQ(form_with("rational_polynomial", "0,0,0,0,0,0,0,0,0,0,0,.1").model,
            "opencv-14");
}

// Single cameras, and files of drivers that fill what they do not use.
TEST(MakeRosFormat, ReadsWhatNeedNotBeThere) {
  const auto read = [](const std::string& text) {
    return ParseRos(text).cameras.at(0);
  };
  const std::string text = kCameraInfo;
  const InputCamera single = read(text.substr(0, text.find("rectification")));
  EXPECT_FALSE(single.rectified);
  EXPECT_EQ(single.lens.values, read(text).lens.values);
  for (const char* none : {"none", "''", "\"\""}) {
    const std::string plain = TextWith(TextWith(text, "plumb_bob", none),
                                       "-0.3, 0.1, 0.001, -0.002, 0]", "]");
    EXPECT_EQ(read(plain).lens.external_model->parameters.size(), 4u) << none;
  }
  for (const char* zeros : {", 0, 0, 0]", ", 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]"})
    EXPECT_EQ(read(TextWith(text, ", 0]\nrect", std::string(zeros) + "\nrect"))
                  .lens.values,
              single.lens.values);
  const std::string rational =
      TextWith(TextWith(text, "plumb_bob", "rational_polynomial"), "-0.002, 0]",
               "-0.002, 0, 1, 2, 3, 0, 0, 0, 0, 0, 0]");
  EXPECT_EQ(read(rational).lens.external_model->model, "opencv");
  // No size: the option says it.
  const std::string unsized = TextWith(TextWith(text, "image_width: 640\n", ""),
                                       "image_height: 480\n", "");
  ExpectError(ExitCode::kInvalidInput, {"f: ", "--image-size"},
              [&] { ParseRos(unsized); });
  EXPECT_EQ(ReadExchangeFile(nullptr, {"f", unsized, "", ImageSize{64, 48}})
                .cameras.at(0)
                .lens.size,
            (ImageSize{64, 48}));
}

// Early files say the model as camera_model; some drivers say fisheye.
TEST(MakeRosFormat, KnowsFisheyesByTheirOlderNames) {
  const std::string fisheye =
      TextWith(kCameraInfo, ", -0.002, 0]", ", -0.002]");
  const auto model_of = [&](const std::string& line) {
    return ParseRos(TextWith(fisheye, "distortion_model: plumb_bob", line))
        .cameras.at(0)
        .lens.external_model->name;
  };
  EXPECT_EQ(model_of("distortion_model: fisheye"), "equidistant");
  EXPECT_EQ(model_of("camera_model: fisheye"), "equidistant");
  EXPECT_EQ(model_of("camera_model: pinhole"), "plumb_bob");
  EXPECT_EQ(model_of("camera_model: pinhole\ndistortion_model: equidistant"),
            "equidistant");
  for (const char* against :
       {"distortion_model: plumb_bob\ncamera_model: fisheye",
        "is_fisheye: true", "xi: 1.5", "camera_model: omni"})
    ExpectError(ExitCode::kInvalidInput, {"f: "}, [&] { model_of(against); });
}

TEST(MakeRosFormat, SaysWhatIsMissingOrWrong) {
  const auto expect = [](const std::string& old, const std::string& by,
                         const std::vector<std::string>& words) {
    ExpectError(ExitCode::kInvalidInput, words,
                [&] { ParseRos(TextWith(kCameraInfo, old, by)); });
  };
  expect("plumb_bob", "Brown Conrady", {"f: ", "'Brown Conrady'", "plumb_bob"});
  expect("501,", ".nan,", {"camera_matrix", "finite"});
  expect("image_width", "other", {"width"});
  expect(", -0.002, 0]", ", -0.002, 0, 1]", {"expected 9 numbers, found 10"});
  expect("plumb_bob", "none", {"'none'", "non-zero"});
  expect("0, 0, 1]\nproj", "0, 0, 5]\nproj", {"rectification_matrix"});
  expect("data: [1,", "data: [", {"rectification_matrix", "9 numbers"});
}

// Two views with one K, 0.1 m apart, of cameras that are turned.
TEST(MakeRosFormat, FindsThePosesOfAPair) {
  std::vector<InputCamera> pair(2);
  const Eigen::AngleAxisd first(0.1, Eigen::Vector3d::UnitY()),
      second(-0.2, Eigen::Vector3d::UnitX());
  pair[0].rectified.emplace();
  pair[0].rectified->r = first.toRotationMatrix();
  pair[0].rectified->p.leftCols<3>() =
      Eigen::Vector3d(400, 410, 1).asDiagonal();
  pair[1].rectified = pair[0].rectified;
  pair[1].rectified->r = second.toRotationMatrix();
  pair[1].rectified->p(0, 3) = -40;
  ComputeStereoPoses(&pair);
  const Eigen::Vector3d point(0.3, -0.2, 2);
  const auto in_view = [&](const InputCamera& camera) {
    return Eigen::Vector3d(camera.rectified->r *
                           (*camera.camera_from_rig * point));
  };
  EXPECT_LT((in_view(pair[1]) - in_view(pair[0]) - Eigen::Vector3d(-0.1, 0, 0))
                .norm(),
            1e-12);
  EXPECT_LT((*pair[0].camera_from_rig * point - point).norm(), 1e-12);
  // A camera alone says nothing.
  pair[1].rectified.reset();
  pair[0].camera_from_rig.reset();
  ComputeStereoPoses(&pair);
  EXPECT_FALSE(pair[0].camera_from_rig);
}

TEST(MakeRosFormat, WritesNumbersThatPythonTakesForSuch) {
  OutputCamera camera;
  camera.lens = ParseRos(kCameraInfo).cameras[0].lens;
  camera.lens.values[4] = 1e-7;
  camera.lens.values[0] = 500;
  const std::string text = MakeRosFormat().write({"f.yaml", {camera}});
  EXPECT_NE(text.find("[500.0, 0.0,"), std::string::npos) << text;
  EXPECT_NE(text.find("[1.0e-07,"), std::string::npos) << text;
}

}  // namespace
}  // namespace raygrid
