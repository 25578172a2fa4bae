#include "exchange/depthai_format.h"

#include "support.h"

namespace raygrid {
namespace {

// A calibration as CalibrationHandler writes it, shortened: a chain from the
// left camera over the right one to the middle one.
constexpr char kDevice[] =
    "{\"batchName\": \"\", \"boardName\": \"OAK\", \"cameraData\": [\n"
    "  [2, {\"cameraType\": 0, \"distortionCoeff\": [0.1, 0.2, 0.001, 0.002, "
    "0.3, 0.4, 0.5, 0.6, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],\n"
    "    \"extrinsics\": {\"rotationMatrix\": [[0.28, -0.96, 0], [0.96, 0.28, "
    "0], [0, 0, 1]], \"specTranslation\": {\"x\": 3.75, \"y\": 0, \"z\": 0}, "
    "\"toCameraSocket\": 0, \"translation\": {\"x\": 3, \"y\": 4, \"z\": 5}},\n"
    "    \"height\": 800, \"intrinsicMatrix\": [[799.5, 0.0, 640.25], [0.0, "
    "798.5, 400.75], [0.0, 0.0, 1.0]], \"lensPosition\": 0, \"specHfovDeg\": "
    "71.8, \"width\": 1280}],\n"
    "  [1, {\"cameraType\": 1, \"distortionCoeff\": [0.1, 0.2, 0.3, 0.4, 0.0, "
    "0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],\n"
    "    \"extrinsics\": {\"lengthUnit\": 1, \"rotationMatrix\": [[1, 0, 0], "
    "[0, 1, 0], [0, 0, 1]], \"toCameraSocket\": 2, \"translation\": {\"x\": "
    "-7.5, \"y\": 0, \"z\": 0}},\n"
    "    \"height\": 800, \"intrinsicMatrix\": [[801, 0, 641], [0, 802, 401], "
    "[0, 0, 1]], \"width\": 1280}],\n"
    "  [0, {\"cameraType\": 0, \"distortionCoeff\": [0.0], \"extrinsics\": "
    "{\"rotationMatrix\": [], \"toCameraSocket\": -1, \"translation\": {\"x\": "
    "0, \"y\": 0, \"z\": 0}}, \"height\": 1080, \"intrinsicMatrix\": [[1500, "
    "0, 960], [0, 1500, 540], [0, 0, 1]], \"width\": 1920}]\n"
    "], \"version\": 7}\n";

ExchangeContents ParseDevice(const std::string& text) {
  return ReadExchangeFile(RecognizeFormat(text), {"f", text, "", {}});
}

std::string Replaced(std::string text, const std::string& from,
                     const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(MakeDepthAiFormat, ReadsARigWhoseCamerasAreAChain) {
  const ExchangeContents contents = ParseDevice(kDevice);
  ASSERT_EQ(contents.cameras.size(), 3u);
  ASSERT_TRUE(contents.IsRig());
  EXPECT_TRUE(contents.warnings.empty());
  const InputCamera &right = contents.cameras[0], &left = contents.cameras[1],
                    &middle = contents.cameras[2];
  EXPECT_EQ(right.name, "CAM_C");
  EXPECT_EQ(right.lens.external_model->name, "perspective8");
  EXPECT_EQ(right.lens.Value("k6"), 0.6);
  EXPECT_EQ(right.lens.Value("fy"), 798.5);
  EXPECT_EQ(left.name, "CAM_B");
  EXPECT_EQ(left.lens.external_model->name, "fisheye");
  EXPECT_EQ(left.lens.Value("k4"), 0.4);
  EXPECT_EQ(middle.lens.external_model->name, "perspective");
  EXPECT_EQ(middle.lens.size, (ImageSize{1920, 1080}));
  // The rig's frame is that of the first camera, lengths are in metres.
  EXPECT_TRUE(right.camera_from_rig->translation.isZero(0));
  EXPECT_LT(
      (left.camera_from_rig->translation - Eigen::Vector3d(0.075, 0, 0)).norm(),
      1e-12);
  EXPECT_LT(
      (middle.camera_from_rig->translation - Eigen::Vector3d(0.03, 0.04, 0.05))
          .norm(),
      1e-12);
  EXPECT_LT((*middle.camera_from_rig * Eigen::Vector3d(1, 0, 0) -
             Eigen::Vector3d(0.31, 1.0, 0.05))
                .norm(),
            1e-12);
}

TEST(MakeDepthAiFormat, WritesTheRotationsOfAPair) {
  WriteRequest request = {"f.json", {}};
  for (const InputCamera& read : ParseDevice(kDevice).cameras) {
    if (request.cameras.size() == 2) break;
    OutputCamera camera;
    camera.name = read.name;
    camera.lens = read.lens;
    camera.camera_from_rig = read.camera_from_rig;
    camera.rectified.emplace();
    camera.rectified->p(0, 3) = request.cameras.empty() ? -60 : 0;
    request.cameras.push_back(camera);
  }
  const std::string text = MakeDepthAiFormat().write(request);
  for (const char* words :
       {"\"leftCameraSocket\": 1", "\"rightCameraSocket\": 2",
        "\"rectifiedRotationLeft\": [", "\"version\": 7"})
    EXPECT_NE(text.find(words), std::string::npos) << words;
}

TEST(MakeDepthAiFormat, SaysWhatItDoesNotTake) {
  const auto refused = [](const std::vector<std::string>& words,
                          const std::string& from, const std::string& to) {
    ExpectError(ExitCode::kInvalidInput, words,
                [&] { ParseDevice(Replaced(kDevice, from, to)); });
  };
  refused({"cameraData[0]", "cameraType 3"}, "\"cameraType\": 0",
          "\"cameraType\": 3");
  refused({"intrinsicMatrix"}, "[0.0, 0.0, 1.0]]", "[0.0, 0.1, 1.0]]");
  refused({"intrinsicMatrix", "3 rows"}, "[[1500, 0, 960], ", "[");
  refused({"lengthUnit 3"}, "\"lengthUnit\": 1", "\"lengthUnit\": 3");
  refused({"socket 2", "duplicate"}, "[1, {\"cameraType\"",
          "[2, {\"cameraType\"");
  refused({"socket 12"}, "[1, {\"cameraType\"", "[12, {\"cameraType\"");
  refused({"cameraData[1]", "distortionCoeff"}, "0.4, 0.0, 0.0",
          "0.4, 0.5, 0.6");
  refused({"extrinsics", "rotation"}, "[0.28, -0.96, 0]", "[0.28, -0.9, 0]");
  refused({"width"}, "\"width\": 1280", "\"width\": 0");
}

TEST(MakeDepthAiFormat, CamerasWithoutLinksAreNoRig) {
  const ExchangeContents contents = ParseDevice(
      Replaced(kDevice, "\"toCameraSocket\": 0", "\"toCameraSocket\": -1"));
  EXPECT_FALSE(contents.IsRig());
  ASSERT_EQ(contents.warnings.size(), 1u);
  EXPECT_NE(contents.warnings[0].find("socket 0"), std::string::npos);
}

}  // namespace
}  // namespace raygrid
