#include "exchange/nerfstudio_format.h"

#include "support.h"

namespace raygrid {
namespace {

// A file that ns-process-data wrote, shortened.
constexpr char kTransforms[] =
    "{\n    \"w\": 640,\n    \"h\": 480,\n    \"fl_x\": 500.25,\n"
    "    \"fl_y\": 501.5,\n    \"cx\": 320.0,\n    \"cy\": 240.5,\n"
    "    \"k1\": 0.0125,\n    \"k2\": -0.025,\n    \"p1\": 0.001,\n"
    "    \"p2\": -0.002,\n    \"camera_model\": \"OPENCV\",\n"
    "    \"frames\": [\n        {\n"
    "            \"file_path\": \"images/frame_00001.png\",\n"
    "            \"transform_matrix\": [\n"
    "                [1.0, 0.0, 0.0, 0.5],\n                [0.0, 1.0, 0.0, "
    "0.0],\n                [0.0, 0.0, 1.0, 5.0],\n                [0.0, 0.0, "
    "0.0, 1.0]\n            ],\n            \"colmap_im_id\": 1\n        },\n"
    "        {\"file_path\": \"b.png\", \"transform_matrix\": [[0, 0, 1, 1], "
    "[0, 1, 0, 2], [-1, 0, 0, 3], [0, 0, 0, 1]]}\n    ],\n"
    "    \"applied_transform\": [[1.0, 0.0, 0.0, 0.0]],\n"
    "    \"ply_file_path\": \"sparse_pc.ply\"\n}\n";

ExchangeContents ParseNerfstudio(const std::string& text) {
  return ReadExchangeFile(RecognizeFormat(text), {"f", text, "", {}});
}

// The file with the fisheye's name and k3 and k4 instead of p1 and p2.
std::string FisheyeTransforms() {
  return TextWith(TextWith(TextWith(kTransforms, "p1", "k3"), "p2", "k4"),
                  "OPENCV", "OPENCV_FISHEYE");
}

TEST(MakeNerfstudioFormat, ReadsACameraWhosePixelsBeginAtTheCorner) {
  const ExchangeContents contents = ParseNerfstudio(kTransforms);
  ASSERT_EQ(contents.cameras.size(), 1u);
  EXPECT_TRUE(contents.warnings.empty());
  const ConvertedCamera& lens = contents.cameras[0].lens;
  EXPECT_EQ(lens.external_model->name, "OPENCV");
  EXPECT_EQ(lens.size, (ImageSize{640, 480}));
  EXPECT_EQ(lens.Value("p2"), -0.002);
  EXPECT_EQ(lens.Value("k3"), 0);
  EXPECT_EQ(Eigen::Vector4d(MakeCameraModel(lens)->Parameters().head<4>()),
            Eigen::Vector4d(500.25, 501.5, 319.5, 240));
  const ConvertedCamera fisheye =
      ParseNerfstudio(FisheyeTransforms()).cameras[0].lens;
  EXPECT_EQ(fisheye.external_model->name, "OPENCV_FISHEYE");
  EXPECT_EQ(fisheye.Value("k4"), -0.002);
}

// instant-ngp says a fisheye by a flag.
TEST(MakeNerfstudioFormat, ReadsTheFlagOfFisheyes) {
  const std::string fisheye = FisheyeTransforms();
  const std::string without =
      TextWith(fisheye, "    \"camera_model\": \"OPENCV_FISHEYE\",\n", "");
  const auto with = [&](const std::string& flag) {
    return TextWith(without, "\"frames\"", flag + ", \"frames\"");
  };
  const auto said = ParseNerfstudio(with("\"is_fisheye\": true"));
  EXPECT_TRUE(said.warnings.empty());
  EXPECT_EQ(
      MakeCameraModel(said.cameras.at(0).lens)->Parameters(),
      MakeCameraModel(ParseNerfstudio(fisheye).cameras[0].lens)->Parameters());
  EXPECT_EQ(ParseNerfstudio(TextWith(kTransforms, "\"frames\"",
                                     "\"is_fisheye\": false, \"frames\""))
                .cameras.at(0)
                .lens.external_model->name,
            "OPENCV");
  ExpectError(ExitCode::kInvalidInput, {"f: ", "is_fisheye", "OPENCV"}, [&] {
    ParseNerfstudio(with("\"is_fisheye\": true, \"camera_model\": \"OPENCV\""));
  });
}

TEST(MakeNerfstudioFormat, ReadsWhatFramesSayOfOneCamera) {
  const std::string frame =
      "{\"fl_x\": 50, \"fl_y\": 51, \"cx\": 32, \"cy\": "
      "24, \"w\": 64, \"h\": 48, \"file_path\": \"a\"}";
  const std::string text =
      "{\"camera_model\": \"SIMPLE_PINHOLE\", \"frames\": "
      "[" +
      frame + ", " + frame + "]}";
  const ExchangeContents contents = ParseNerfstudio(text);
  EXPECT_EQ(contents.cameras[0].lens.external_model->name, "PINHOLE");
  EXPECT_EQ(contents.cameras[0].lens.Value("fy"), 51);
  ASSERT_EQ(contents.warnings.size(), 1u);
  EXPECT_NE(contents.warnings[0].find("frames[0]: transform_matrix"),
            std::string::npos);
  ExpectError(
      ExitCode::kInvalidInput, {"frames[1]: fl_x differs", "a single camera"},
      [&] {
        ParseNerfstudio(TextWith(text, frame + ", " + frame,
                                 frame + ", " + TextWith(frame, "50", "60")));
      });
}

// The camera looks along -z of its own axes there, with y up.
TEST(MakeNerfstudioFormat, ReadsPlacesOfFrames) {
  const std::vector<BoardPose> poses =
      ParseNerfstudio(kTransforms).cameras[0].poses;
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_EQ(poses[0].image, "images/frame_00001.png");
  const Pose& first = poses[0].camera_from_board;
  EXPECT_LT(
      (first * Eigen::Vector3d(0.5, 0, 0) - Eigen::Vector3d(0, 0, 5)).norm(),
      1e-12);
  EXPECT_LT(
      (first * Eigen::Vector3d(1.5, 1, 0) - Eigen::Vector3d(1, -1, 5)).norm(),
      1e-12);
  // The second one stands at (1, 2, 3), and looks along -x of the world.
  EXPECT_LT((poses[1].camera_from_board * Eigen::Vector3d(0, 2, 3) -
             Eigen::Vector3d(0, 0, 1))
                .norm(),
            1e-12);
}

TEST(MakeNerfstudioFormat, WritesWhatItReads) {
  const ExchangeContents contents = ParseNerfstudio(kTransforms);
  OutputCamera camera;
  camera.name = "front";
  camera.lens = contents.cameras[0].lens;
  camera.poses = contents.cameras[0].poses;
  const std::string text = MakeNerfstudioFormat().write({"f.json", {camera}});
  const InputCamera again = ParseNerfstudio(text).cameras[0];
  EXPECT_EQ(again.name, "front");
  EXPECT_EQ(again.lens.values, camera.lens.values);
  ASSERT_EQ(again.poses.size(), 2u);
  for (int k = 0; k < 2; ++k) {
    EXPECT_EQ(again.poses[k].image, camera.poses[k].image);
    const Pose step = again.poses[k].camera_from_board *
                      camera.poses[k].camera_from_board.Inverse();
    EXPECT_LT(step.translation.norm() + step.rotation.vec().norm(), 1e-14);
  }
  EXPECT_NE(text.find("\"k4\": 0.0,"), std::string::npos);
  camera.poses[1].board = 3;
  ExpectError(ExitCode::kInvalidInput, {"--poses", "boards 0 and 3"}, [&] {
    MakeNerfstudioFormat().write({"f.json", {camera}});
  });
  camera.poses.clear();
  EXPECT_NE(
      MakeNerfstudioFormat().write({"f.json", {camera}}).find("\"frames\": []"),
      std::string::npos);
}

TEST(MakeNerfstudioFormat, SaysWhatIsMissingOrWrong) {
  const auto expect = [](const std::string& text, const std::string& old,
                         const std::string& by,
                         const std::vector<std::string>& words) {
    ExpectError(ExitCode::kInvalidInput, words,
                [&] { ParseNerfstudio(TextWith(text, old, by)); });
  };
  expect(kTransforms, "OPENCV", "FISHEYE624",
         {"f: unsupported camera_model", "PINHOLE"});
  expect(kTransforms, "p1", "k4", {"k4 of OPENCV must be 0"});
  expect(FisheyeTransforms(), "k4", "p2", {"p2 of OPENCV_FISHEYE must be 0"});
  expect(kTransforms, "501.5", "[]", {"fl_y", "expected a finite number"});
  expect(kTransforms, "\"h\"", "\"x\"", {"h: expected a finite number"});
  expect(kTransforms, "\"k1\"", "\"distortion_params\"",
         {"distortion_params", "6 numbers"});
  const ExchangeContents scaled =
      ParseNerfstudio(TextWith(kTransforms, "[1.0,", "[2.0,"));
  ASSERT_EQ(scaled.warnings.size(), 1u);
  EXPECT_NE(scaled.warnings[0].find(
                "frames[0]: transform_matrix: not a rotation matrix"),
            std::string::npos);
  EXPECT_TRUE(scaled.cameras[0].poses.empty());
}

}  // namespace
}  // namespace raygrid
