#include "exchange/kalibr_format.h"

#include "support.h"

namespace raygrid {
namespace {

// A file that kalibr_calibrate_cameras wrote, shortened.
constexpr char kCamchain[] =
    "cam0:\n  cam_overlaps: [1]\n  camera_model: pinhole\n"
    "  distortion_coeffs: [-0.28, 0.07, 0.0002, 1.7e-05]\n"
    "  distortion_model: radtan\n"
    "  intrinsics: [458.5, 457.5, 367.25, 248.5]\n  resolution: [752, 480]\n"
    "  rostopic: /cam0/image_raw\n"
    "cam1:\n  T_cn_cnm1:\n"
    "  - [1.0, 0.0, 0.0, -0.11]\n  - [0.0, 0.0, -1.0, 0.02]\n"
    "  - [0.0, 1.0, 0.0, 0.03]\n  - [0.0, 0.0, 0.0, 1.0]\n"
    "  cam_overlaps: [0]\n  camera_model: ds\n  distortion_coeffs: []\n"
    "  distortion_model: none\n"
    "  intrinsics: [-0.2, 0.6, 300.5, 301.5, 379.0, 255.0]\n"
    "  resolution: [752, 480]\n  rostopic: /cam1/image_raw\n";

ExchangeContents ParseKalibr(const std::string& text) {
  return ReadExchangeFile(RecognizeFormat(text), {"f", text, "", {}});
}

TEST(MakeKalibrFormat, ReadsAChain) {
  const ExchangeContents contents = ParseKalibr(kCamchain);
  ASSERT_TRUE(contents.IsRig());
  const InputCamera &first = contents.cameras[0], &second = contents.cameras[1];
  EXPECT_EQ(first.name, "cam0");
  EXPECT_EQ(first.lens.external_model->name, "pinhole-radtan");
  EXPECT_EQ(first.lens.Value("p2"), 1.7e-05);
  EXPECT_EQ(second.lens.external_model->name, "ds-none");
  EXPECT_EQ(second.lens.Value("xi"), -0.2);
  EXPECT_EQ(second.lens.Value("fy"), 301.5);
  EXPECT_EQ(second.lens.size, (ImageSize{752, 480}));
  EXPECT_LT((*second.camera_from_rig * Eigen::Vector3d(1, 2, 3) -
             Eigen::Vector3d(1 - 0.11, -3 + 0.02, 2 + 0.03))
                .norm(),
            1e-12);
}

// DSEC has the chain in a map, with rectified cameras beside.
TEST(MakeKalibrFormat, ReadsTheChainOfDsec) {
  std::string chain = "\n" + std::string(kCamchain);
  while (chain.find("  intrinsics:") != std::string::npos)
    chain = TextWith(chain, "  intrinsics:", "  camera_matrix:");
  std::string indented;
  for (const char c : chain) indented += c == '\n' ? "\n  " : std::string(1, c);
  const ExchangeContents contents = ParseKalibr(
      "intrinsics:" + indented +
      "camRect0:\n    camera_model: pinhole\n    is_rectified: true\n"
      "    camera_matrix: [1.0, 1.0, 1.0, 1.0]\n"
      "extrinsics:\n  R_rect0: []\n");
  ASSERT_TRUE(contents.IsRig());
  ASSERT_EQ(contents.cameras.size(), 2u);
  EXPECT_EQ(contents.cameras[0].lens.Value("fx"), 458.5);
  EXPECT_EQ(contents.cameras[1].lens.Value("fy"), 301.5);
}

TEST(MakeKalibrFormat, ChainsPoses) {
  const std::string third = TextWith(
      std::string(kCamchain).substr(std::string(kCamchain).find("cam1:")),
      "cam1:", "cam2:");
  const ExchangeContents contents = ParseKalibr(kCamchain + third);
  ASSERT_EQ(contents.cameras.size(), 3u);
  const Pose step = *contents.cameras[1].camera_from_rig;
  const Eigen::Vector3d point(0.1, 0.2, 0.3);
  EXPECT_LT(
      (*contents.cameras[2].camera_from_rig * point - step * (step * point))
          .norm(),
      1e-12);
  // Two cameras have the topic of cam1: the keys name them.
  EXPECT_EQ(contents.cameras[2].name, "cam2");
}

TEST(MakeKalibrFormat, WritesWhatItReads) {
  const ExchangeContents contents = ParseKalibr(kCamchain);
  WriteRequest request = {"f.yaml", {}};
  for (const InputCamera& camera : contents.cameras)
    request.cameras.push_back({camera.name,
                               "",
                               camera.lens,
                               std::nullopt,
                               camera.camera_from_rig,
                               std::nullopt,
                               {}});
  request.cameras[0].name = "left";
  request.cameras[1].name = "right";
  const ExchangeContents again = ParseKalibr(MakeKalibrFormat().write(request));
  ASSERT_TRUE(again.IsRig());
  EXPECT_EQ(again.cameras[0].name, "left");
  EXPECT_EQ(again.cameras[1].name, "right");
  for (int c = 0; c < 2; ++c) {
    EXPECT_EQ(again.cameras[c].lens.values, contents.cameras[c].lens.values);
    EXPECT_LT((again.cameras[c].camera_from_rig->translation -
               contents.cameras[c].camera_from_rig->translation)
                  .norm(),
              1e-15);
  }
}

// The chain, or poses in the IMU, whichever way around; all say one rig.
TEST(MakeKalibrFormat, FindsTheRigInPosesOfTheImu) {
  const std::string chain = kCamchain;
  const std::string pose = chain.substr(
      chain.find("  T_cn_cnm1:"),
      chain.find("  cam_overlaps: [0]") - chain.find("  T_cn_cnm1:"));
  const std::string one =
      "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n";
  // The inverse of the second camera's pose.
  const std::string back =
      "[[1, 0, 0, 0.11], [0, 0, 1, -0.03], [0, -1, 0, 0.02], [0, 0, 0, 1]]\n";
  const Pose expected = *ParseKalibr(chain).cameras[1].camera_from_rig;
  const auto check = [&](const std::string& text) {
    const ExchangeContents contents = ParseKalibr(text);
    ASSERT_TRUE(contents.IsRig());
    const Pose& found = *contents.cameras[1].camera_from_rig;
    EXPECT_LT((found.translation - expected.translation).norm(), 1e-12);
    EXPECT_LT(found.rotation.angularDistance(expected.rotation), 1e-7);
  };
  check(TextWith(chain, "T_cn_cnm1", "baseline_last_to_this_cam"));
  check("cam0:\n  T_cam_imu: " + one +
        TextWith(TextWith(chain, "T_cn_cnm1", "T_cam_imu"), "cam0:\n", ""));
  check("cam0:\n  T_imu_cam: " + one +
        TextWith(TextWith(chain, pose, "  T_imu_cam: " + back), "cam0:\n", ""));
}

// Programs leave the end of the last line out. Only a number there may be cut.
TEST(MakeKalibrFormat, ReadsALastLineWithoutItsEnd) {
  std::string text = kCamchain;
  text.pop_back();
  EXPECT_TRUE(ParseKalibr(text).IsRig());
  EXPECT_TRUE(ParseKalibr(text).warnings.empty());
  const auto cut = ParseKalibr(text + "\n  timeshift_cam_imu: 0.25");
  ASSERT_EQ(cut.warnings.size(), 1u);
  EXPECT_NE(cut.warnings[0].find("truncated"), std::string::npos);
}

TEST(MakeKalibrFormat, SaysWhatIsMissingOrWrong) {
  const auto expect = [](const std::string& old, const std::string& by,
                         const std::vector<std::string>& words) {
    ExpectError(ExitCode::kInvalidInput, words,
                [&] { ParseKalibr(TextWith(kCamchain, old, by)); });
  };
  expect("radtan", "fov", {"f: cam0", "'fov'", "pinhole-radtan"});
  expect("model: ds", "model: bsplines", {"cam1", "'bsplines'"});
  expect("cam1:", "cam2:", {"without gaps"});
  expect("457.5", ".inf", {"cam0: intrinsics", "finite"});
  expect("-0.28,", "", {"distortion_coeffs", "4 numbers"});
  expect("-0.2, 0.6", "0.6", {"cam1: intrinsics", "5 numbers", "6"});
  expect("resolution: [752, 480]", "resolution: [752]", {"resolution"});
  expect("- [1.0, 0.0, 0.0, -0.11]", "- [1.5, 0.0, 0.0, -0.11]",
         {"T_cn_cnm1", "not a rotation matrix"});
  expect("  - [0.0, 0.0, 0.0, 1.0]\n", "", {"T_cn_cnm1", "4 x 4"});
  const ExchangeContents apart =
      ParseKalibr(TextWith(kCamchain, "T_cn_cnm1", "other"));
  EXPECT_FALSE(apart.IsRig());
  EXPECT_EQ(apart.warnings.size(), 2u);
}

}  // namespace
}  // namespace raygrid
