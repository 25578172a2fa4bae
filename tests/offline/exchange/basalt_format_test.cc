#include "exchange/basalt_format.h"

#include "support.h"

namespace raygrid {
namespace {

// A calibration as cereal writes it, shortened.
constexpr char kBasalt[] =
    "{\n    \"value0\": {\n        \"T_imu_cam\": [\n            {\n"
    "                \"px\": 0.5,\n                \"py\": 0.0,\n"
    "                \"pz\": -0.25,\n                \"qx\": 0.0,\n"
    "                \"qy\": 0.0,\n                \"qz\": 0.6,\n"
    "                \"qw\": 0.8\n            },\n"
    "            {\"px\": 0.5, \"py\": 0.1, \"pz\": -0.25, \"qx\": 0.0, "
    "\"qy\": 0.0, \"qz\": 0.6, \"qw\": 0.8}\n        ],\n"
    "        \"intrinsics\": [\n            {\n"
    "                \"camera_type\": \"ds\",\n"
    "                \"intrinsics\": {\n                    \"fx\": 349.75,\n"
    "                    \"fy\": 348.75,\n                    \"cx\": 365.5,\n"
    "                    \"cy\": 249.25,\n                    \"xi\": -0.25,\n"
    "                    \"alpha\": 0.5625\n                }\n"
    "            },\n            {\"camera_type\": \"pinhole-radtan8\", "
    "\"intrinsics\": {\"fx\": 269.75, \"fy\": 269.5, \"cx\": 322.5, \"cy\": "
    "228.75, \"k1\": 0.3, \"k2\": -0.02, \"p1\": -0.00025, \"p2\": 6.1e-05, "
    "\"k3\": 0.016, \"k4\": 0.57, \"k5\": -0.06, \"k6\": 0.03, \"rpmax\": "
    "2.7}}\n        ],\n"
    "        \"resolution\": [\n            [\n                752,\n"
    "                480\n            ],\n            [640, 480]\n        ],\n"
    "        \"vignette\": [\n            {\n"
    "                \"value0\": 0,\n                \"value1\": 50000000000,\n"
    "                \"value2\": [[0.99]]\n            }\n        ],\n"
    "        \"calib_accel_bias\": [-0.003, 0.026, 0.136, 0.0, 0.0, 0.0, 0.0, "
    "0.0, 0.0],\n        \"imu_update_rate\": 200.0,\n"
    "        \"cam_time_offset_ns\": 0\n    }\n}\n";

ExchangeContents ParseBasalt(const std::string& text,
                             std::optional<ImageSize> size = {}) {
  return ReadExchangeFile(RecognizeFormat(text), {"f", text, "", size});
}

WriteRequest RequestOf(const ExchangeContents& contents) {
  WriteRequest request = {"f.json", {}};
  for (const InputCamera& read : contents.cameras) {
    OutputCamera camera;
    camera.name = read.name;
    camera.serial = read.serial;
    camera.lens = read.lens;
    camera.camera_from_rig = read.camera_from_rig;
    request.cameras.push_back(std::move(camera));
  }
  return request;
}

TEST(MakeBasaltFormat, ReadsARigInTheFrameOfItsFirstCamera) {
  const ExchangeContents contents = ParseBasalt(kBasalt);
  ASSERT_TRUE(contents.IsRig());
  const InputCamera &first = contents.cameras[0], &second = contents.cameras[1];
  EXPECT_EQ(first.name, "cam0");
  EXPECT_EQ(first.lens.external_model->name, "ds");
  EXPECT_EQ(first.lens.Value("xi"), -0.25);
  EXPECT_EQ(first.lens.size, (ImageSize{752, 480}));
  EXPECT_EQ(second.lens.external_model->name, "pinhole-radtan8");
  EXPECT_EQ(second.lens.Value("p2"), 6.1e-05);
  EXPECT_EQ(second.lens.Value("k6"), 0.03);
  EXPECT_TRUE(first.camera_from_rig->translation.isZero(0));
  // The second camera stands 0.1 m along y of the IMU, which the cameras are
  // turned against about z: cos 0.28, sin 0.96.
  EXPECT_LT(
      (second.camera_from_rig->translation - Eigen::Vector3d(-0.096, -0.028, 0))
          .norm(),
      1e-12);
}

TEST(MakeBasaltFormat, SaysWhatItDoesNotTake) {
  const ExchangeContents contents = ParseBasalt(kBasalt);
  ASSERT_EQ(contents.warnings.size(), 3u);
  EXPECT_EQ(contents.warnings[0], "ignored: vignette, calib_accel_bias");
  EXPECT_NE(contents.warnings[1].find("rpmax"), std::string::npos);
  EXPECT_NE(contents.warnings[2].find("IMU"), std::string::npos);
}

TEST(MakeBasaltFormat, WritesWhatItReads) {
  ExchangeContents contents = ParseBasalt(kBasalt);
  contents.cameras[0].name = "le\"ft";
  contents.cameras[1].serial = "12";
  const std::string text = MakeBasaltFormat().write(RequestOf(contents));
  const ExchangeContents again = ParseBasalt(text);
  ASSERT_TRUE(again.IsRig());
  EXPECT_TRUE(again.warnings.empty());
  EXPECT_EQ(again.cameras[0].name, "le\"ft");
  EXPECT_EQ(again.cameras[1].name, "cam1");
  EXPECT_EQ(again.cameras[1].serial, "12");
  for (int c = 0; c < 2; ++c) {
    EXPECT_EQ(again.cameras[c].lens.values, contents.cameras[c].lens.values);
    const Pose step = *again.cameras[c].camera_from_rig *
                      contents.cameras[c].camera_from_rig->Inverse();
    EXPECT_LT(step.translation.norm() + step.rotation.vec().norm(), 1e-15);
  }
  EXPECT_EQ(MakeBasaltFormat().write(RequestOf(again)), text);
  // A calibration begins with cereal's name, and has all of its keys.
  EXPECT_EQ(text.rfind("{\n    \"value0\": {\n        \"T_imu_cam\"", 0), 0u);
  for (const char* key :
       {"accel_bias_std", "accel_noise_std", "calib_accel_bias",
        "calib_gyro_bias", "cam_time_offset_ns", "gyro_bias_std",
        "gyro_noise_std", "imu_update_rate", "vignette"})
    EXPECT_NE(text.find("\"" + std::string(key) + "\": "), std::string::npos);
}

TEST(MakeBasaltFormat, ReadsUnifiedCamerasAndFisheyes) {
  const std::string ucm =
      TextWith(TextWith(kBasalt, "\"ds\"", "\"ucm\""), "\"xi\": -0.25,", "");
  const ConvertedCamera lens = ParseBasalt(ucm).cameras[0].lens;
  const auto model = MakeCameraModel(lens);
  EXPECT_EQ(model->Name(), "double-sphere");
  // x / (alpha d + (1 - alpha) z), d = 3
  const auto pixel = model->Project(Eigen::Vector3d(2, 1, 2));
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x(), 365.5 + 2 * 349.75 / (0.5625 * 3 + 0.4375 * 2), 1e-9);
  const std::string fisheye =
      TextWith(TextWith(kBasalt, "\"ds\"", "\"kb4\""), "\"xi\": -0.25,",
               "\"k1\": 0.01, \"k2\": 0.02, \"k3\": 0.03, \"k4\": 0.04,");
  // alpha is a number of another model.
  ExpectError(ExitCode::kInvalidInput, {"intrinsics[0]", "'alpha'", "kb4"},
              [&] { ParseBasalt(fisheye); });
  EXPECT_EQ(ParseBasalt(TextWith(fisheye, "\"alpha\": 0.5625", "\"alpha\": 0"))
                .cameras[0]
                .lens.Value("k4"),
            0.04);
}

TEST(MakeBasaltFormat, SaysWhatIsMissingOrWrong) {
  const auto expect = [](const std::string& old, const std::string& by,
                         const std::vector<std::string>& words) {
    ExpectError(ExitCode::kInvalidInput, words,
                [&] { ParseBasalt(TextWith(kBasalt, old, by)); });
  };
  expect("\"ds\"", "\"fov\"", {"f: intrinsics[0]", "'fov'", "pinhole-radtan8"});
  expect("\"ds\"", "\"kb4\"", {"intrinsics[0]: k1", "finite"});
  expect("349.75", "\"?\"", {"intrinsics[0]: fx"});
  expect("349.75", "-349.75", {"focal length"});
  expect("\"qw\": 0.8", "\"qw\": 8", {"T_imu_cam[0]", "not a unit quaternion"});
  expect("\"px\": 0.5", "\"p\": 0.5", {"T_imu_cam[0]: px"});
  expect("\"resolution\"", "\"other\"", {"--image-size"});
  expect("            [640, 480]\n", "            640\n", {"resolution"});
  expect("{\n    \"value0\"", "{\n    \"value1\"", {"value0", "intrinsics"});
  const std::string apart = TextWith(kBasalt, "T_imu_cam", "other");
  EXPECT_FALSE(ParseBasalt(apart).IsRig());
  EXPECT_EQ(ParseBasalt(apart).warnings.size(), 3u);
  EXPECT_EQ(
      ParseBasalt(TextWith(kBasalt, "\"resolution\"", "\"other\""), {{64, 48}})
          .cameras[1]
          .lens.size,
      (ImageSize{64, 48}));
}

}  // namespace
}  // namespace raygrid
