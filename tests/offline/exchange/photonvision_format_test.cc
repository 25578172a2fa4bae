#include "exchange/photonvision_format.h"

#include "exchange/damaged_files.h"
#include "support.h"

namespace raygrid {
namespace {

// A calibration with one corner of two, as PhotonVision writes it.
constexpr char kPhotonVision[] = R"({
"resolution":{"width":640.0,"height":480.0},
"cameraIntrinsics":{"rows":3,"cols":3,"type":6,
"data":[400.5,0.0,319.25,0.0,401.5,239.75,0.0,0.0,1.0]},
"distCoeffs":{"rows":1,"cols":8,"type":6,
"data":[-0.125,0.0625,0.001,-0.002,-0.01,0.02,0.03,0.004]},
"calobjectWarp":[0.0,0.0],
"observations":[{
"locationInObjectSpace":[{"x":0.0,"y":0.0,"z":0.0},{"x":0.05,"y":0.025,"z":0}],
"locationInImageSpace":[{"x":-1.0,"y":-1.0},{"x":100.5,"y":50.25}],
"reprojectionErrors":[{"x":0.0,"y":0.0},{"x":0.1,"y":0.1}],
"optimisedCameraToObject":{"translation":{"x":0.1,"y":0.2,"z":0.5},
"rotation":{"quaternion":{"W":0.8,"X":0.0,"Y":0.6,"Z":0.0}}},
"cornersUsed":[false,true],"snapshotName":"img0.png","snapshotDataLocation":null
}],
"calobjectSize":{"width":8.0,"height":8.0},"calobjectSpacing":0.025,
"lensmodel":"LENSMODEL_OPENCV"})";

ExchangeContents ParsePhotonVision(const std::string& text) {
  return ReadExchangeFile(RecognizeFormat(text), {"f", text, "", {}});
}

TEST(MakePhotonVisionFormat, ReadsCameraCornersAndPoses) {
  const ExchangeContents contents = ParsePhotonVision(kPhotonVision);
  EXPECT_TRUE(contents.warnings.empty());
  ASSERT_EQ(contents.cameras.size(), 1u);
  const InputCamera& camera = contents.cameras[0];
  const auto model = MakeCameraModel(camera.lens);
  EXPECT_EQ(model->Name(), "opencv");
  Eigen::VectorXd expected(12);
  // fx, fy, cx, cy, k1 to k6, p1, p2
  expected << 400.5, 401.5, 319.25, 239.75, -0.125, 0.0625, -0.01, 0.02, 0.03,
      0.004, 0.001, -0.002;
  EXPECT_EQ(model->Parameters(), expected);
  ASSERT_EQ(camera.features.size(), 1u);
  ASSERT_EQ(camera.features[0].features.size(), 1u);
  const Feature& corner = camera.features[0].features[0];
  EXPECT_EQ(std::pair(corner.column, corner.row), std::pair(2, 1));
  EXPECT_EQ(corner.pixel, Eigen::Vector2d(100.5, 50.25));
  ASSERT_EQ(camera.poses.size(), 1u);
  EXPECT_EQ(camera.poses[0].image, "img0.png");
  // The board's x axis, in the camera's axes.
  const Eigen::Vector3d seen =
      camera.poses[0].camera_from_board * Eigen::Vector3d(1, 0, 0);
  EXPECT_LT((seen - Eigen::Vector3d(0.1 + 0.28, 0.2, 0.5 - 0.96)).norm(),
            1e-12);
}

// Settings of a camera have a calibration for each size of its images.
TEST(MakePhotonVisionFormat, ReadsSettings) {
  const std::string other =
      TextWith(TextWith(kPhotonVision, "640.0", "1280.0"), "480.0", "960.0");
  const ExchangeContents contents =
      ParsePhotonVision(std::string("{\"nickname\": \"front\", \"FOV\": 70.0, "
                                    "\"calibrations\": [") +
                        kPhotonVision + ", " + other + "]}");
  ASSERT_EQ(contents.cameras.size(), 2u);
  EXPECT_EQ(contents.cameras[0].name, "640x480");
  EXPECT_EQ(contents.cameras[1].name, "1280x960");
  EXPECT_EQ(contents.cameras[1].lens.size, (ImageSize{1280, 960}));
  EXPECT_EQ(contents.cameras[1].features.size(), 1u);
}

TEST(MakePhotonVisionFormat, WritesWhatItReads) {
  OutputCamera camera;
  camera.lens = ParsePhotonVision(kPhotonVision).cameras[0].lens;
  const std::string text =
      MakePhotonVisionFormat().write({"front.json", {camera}});
  EXPECT_EQ(ParsePhotonVision(text).cameras[0].lens.values, camera.lens.values);
}

TEST(MakePhotonVisionFormat, TakesDamagedFilesForNothingElse) {
  TestRandom random(7);
  int num_refused = 0;
  const int count = NumMutants(400);
  for (int k = 0; k < count; ++k) {
    const std::string text = Mutated(kPhotonVision, &random);
    num_refused += IsRefused([&] {
      ExpectFinite(ReadExchangeFile(&FindFormat("", "photonvision"),
                                    {"f", text, "", {}}));
    });
  }
  EXPECT_GT(num_refused, count / 4);
}

}  // namespace
}  // namespace raygrid
