#include "exchange/colmap_format.h"

#include "exchange/colmap_files.h"
#include "exchange/damaged_files.h"
#include "support.h"

namespace raygrid {
namespace {

// Files that COLMAP 4.2 wrote.
constexpr char kColmapCameras[] =
    "# Camera list with one line of data per camera:\n"
    "#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n"
    "# Number of cameras: 2\n"
    "1 OPENCV 640 480 500 501 320.5 240.5 0.10000000000000001 0.01 0.001 "
    "0.002\n"
    "2 SIMPLE_RADIAL 640 480 500 320.5 240.5 0.01\n";
constexpr char kColmapRigs[] =
    "# Rig calib list with one line of data per calib:\n"
    "#   RIG_ID, NUM_SENSORS, REF_SENSOR_TYPE, REF_SENSOR_ID, SENSORS[] as "
    "(SENSOR_TYPE, SENSOR_ID, HAS_POSE, [QW, QX, QY, QZ, TX, TY, TZ])\n"
    "# Number of rigs: 1\n"
    "1 2 CAMERA 1 CAMERA 2 1 0.80000000000000004 0 0 0.59999999999999998 1 2 "
    "3\n";
// A line of points follows each image, as COLMAP writes it.
constexpr char kColmapImages[] =
    "# Image list with two lines of data per image:\n"
    "#   IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n"
    "#   POINTS2D[] as (X, Y, POINT3D_ID)\n"
    "# Number of images: 2, mean observations per image: 1\n"
    "4 0.80000000000000004 0 0.59999999999999998 0 1 2 3 2 camera2/a.png\n"
    "10.5 20.5 -1 11.5 21.5 7\n"
    "7 1 0 0 0 0.10000000000000001 0 0.5 1 b c.png\n"
    "\n";
const std::string kBinaryRig = {
    1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 3, 0, 0, 0,  // one rig of 3 sensors
    0, 0, 0, 0, 1, 0, 0, 0,                          // camera 1
    1, 0, 0, 0, 9, 0, 0, 0, 0,                       // an IMU
    0, 0, 0, 0, 2, 0, 0, 0, 0};                      // camera 2, no pose

ExchangeContents ParseColmap(const std::string& cameras,
                             const std::string& rigs = "",
                             const std::string& images = "") {
  return ReadExchangeFile(nullptr,
                          {"m/cameras.txt", cameras, "", {}, {rigs, images}});
}

std::string ColmapBinary(const std::string& cameras = kColmapCameras) {
  return EncodeColmapCameras(ParseColmapCameras("", cameras));
}

TEST(MakeColmapFormat, ReadsWhatColmapWrites) {
  for (const std::string& file :
       {std::string(kColmapCameras), ColmapBinary()}) {
    const ExchangeContents contents = ParseColmap(file);
    ASSERT_EQ(contents.cameras.size(), 2u);
    const ConvertedCamera& lens = contents.cameras[0].lens;
    EXPECT_EQ(lens.external_model->name, "OPENCV");
    EXPECT_EQ(lens.size, (ImageSize{640, 480}));
    EXPECT_EQ(contents.cameras[1].name, "camera2");
    EXPECT_FALSE(contents.IsRig());
    Eigen::VectorXd parameters(12);
    // COLMAP's first pixel is at (0.5, 0.5).
    parameters << 500, 500, 320, 240, 0.01, 0, 0, 0, 0, 0, 0, 0;
    EXPECT_EQ(MakeCameraModel(contents.cameras[1].lens)->Parameters(),
              parameters);
  }
}

// A model that no lens of raygrid has is read as the nearest grid.
TEST(MakeColmapFormat, ReadsThePrismFisheyeOfAria) {
  const auto contents = ParseColmap(
      "1 RAD_TAN_THIN_PRISM_FISHEYE 640 480 300 301 322 241 0.05 -0.02 0.005 "
      "-0.003 0.001 -0.0005 0.001 -0.002 0.0005 -0.0004 0.0002 -0.0003\n");
  ASSERT_EQ(contents.cameras.size(), 1u);
  EXPECT_NE(contents.warnings.at(0).find("RMS 0.00"), std::string::npos);
  const auto grid = MakeCameraModel(contents.cameras[0].lens);
  const double k[] = {0.05, -0.02, 0.005, -0.003, 0.001, -0.0005};
  for (const double x : {-0.9, 0.1, 0.8})
    for (const double y : {-0.6, 0.05, 0.7}) {
      const double r = std::hypot(x, y), theta = std::atan(r);
      double bent = theta;
      for (int i = 0; i < 6; ++i) bent += k[i] * std::pow(theta, 2 * i + 3);
      const double u = x / r * bent, v = y / r * bent, r2 = bent * bent;
      const Eigen::Vector2d pixel(
          300 * (u + 0.001 * (2 * u * u + r2) - 0.002 * 2 * u * v +
                 0.0005 * r2 - 0.0004 * r2 * r2) +
              322 - 0.5,
          301 * (v - 0.002 * (2 * v * v + r2) + 0.001 * 2 * u * v +
                 0.0002 * r2 - 0.0003 * r2 * r2) +
              241 - 0.5);
      EXPECT_LT((grid->Project({x, y, 1}).value() - pixel).norm(), 0.01);
    }
}

TEST(MakeColmapFormat, TakesLinesThatEndAsOnWindows) {
  const std::string text =
      "\r\n# Name of camera 3: front\r\n3 PINHOLE 640 480 500 500 320 240\r\n";
  EXPECT_EQ(ParseColmap(text).cameras[0].name, "front");
}

TEST(MakeColmapFormat, TakesACommentThatEndsBeforeTheNumber) {
  const std::string text =
      "# Name of camera \n3 PINHOLE 640 480 500 500 320 240\n";
  EXPECT_EQ(ParseColmap(text).cameras.size(), 1u);
}

TEST(MakeColmapFormat, NumbersModelsAsColmapDoes) {
  const std::string bytes = ColmapBinary();
  ASSERT_EQ(bytes.size(), 8u + 24 + 8 * 8 + 24 + 4 * 8);
  EXPECT_EQ(bytes.substr(0, 32), std::string("\2\0\0\0\0\0\0\0"
                                             "\1\0\0\0\4\0\0\0"
                                             "\x80\2\0\0\0\0\0\0"
                                             "\xe0\1\0\0\0\0\0\0",
                                             32));
  EXPECT_EQ(ColmapModelNames()[10], "THIN_PRISM_FISHEYE");
  for (const ExternalModel& external_model : MakeColmapFormat().external_models)
    EXPECT_EQ(NumColmapParameters(external_model.name),
              static_cast<int>(external_model.parameters.size()))
        << external_model.name;
}

TEST(MakeColmapFormat, HasRigsInTheFrameOfTheirFirstCamera) {
  const ExchangeContents rig = ParseColmap(kColmapCameras, kColmapRigs);
  ASSERT_TRUE(rig.IsRig());
  EXPECT_EQ(rig.cameras[1].camera_from_rig->translation,
            Eigen::Vector3d(1, 2, 3));
  EXPECT_NEAR(rig.cameras[1].camera_from_rig->rotation.z(), 0.6, 1e-15);
  std::vector<OutputCamera> lenses(2);
  const Pose rig_from_other = {RotationFromVector({0.3, 0.2, 0.1}), {4, 5, 6}};
  for (int c = 0; c < 2; ++c) {
    lenses[c].lens = rig.cameras[c].lens;
    lenses[c].camera_from_rig =
        *rig.cameras[c].camera_from_rig * rig_from_other;
  }
  const Format format = MakeColmapFormat();
  for (const char* path : {"m/cameras.txt", "m/cameras.bin"}) {
    const std::vector<CompanionFile> beside =
        format.write_beside({path, lenses});
    ASSERT_EQ(beside.size(), 1u);
    EXPECT_EQ(beside[0].path, std::string("m/rigs") + (path + 9));
    EXPECT_EQ(beside[0].path, format.beside(path)[0]);
    const ExchangeContents again =
        ParseColmap(format.write({path, lenses}), beside[0].text);
    ASSERT_TRUE(again.IsRig());
    const Pose& pose = *again.cameras[1].camera_from_rig;
    EXPECT_LT((pose.translation - Eigen::Vector3d(1, 2, 3)).norm(), 1e-12);
    EXPECT_NEAR(std::abs(pose.rotation.w()), 0.8, 1e-12);
  }
}

TEST(MakeColmapFormat, HasPosesOfOneWorld) {
  for (const std::string& images :
       {std::string(kColmapImages),
        EncodeColmapImages(ParseColmapImages("", kColmapImages))}) {
    const ExchangeContents contents =
        images == kColmapImages ? ParseColmap(kColmapCameras, "", images)
                                : ParseColmap(ColmapBinary(), "", images);
    ASSERT_EQ(contents.cameras[1].poses.size(), 1u);
    const BoardPose& pose = contents.cameras[1].poses[0];
    EXPECT_EQ(pose.image, "a.png");
    EXPECT_EQ(contents.cameras[0].poses[0].image, "b c.png");
    EXPECT_LT((pose.camera_from_board * Eigen::Vector3d(1, 0, 0) -
               Eigen::Vector3d(1.28, 2, 2.04))
                  .norm(),
              1e-12);
  }
}

TEST(MakeColmapFormat, WritesImagesAndNoPoints) {
  OutputCamera camera;
  camera.lens = ParseColmap(kColmapCameras).cameras[0].lens;
  camera.poses = {{"a.png", 3, {RotationFromVector({1, 2, 0.5}), {1, 2, 3}}}};
  const Format format = MakeColmapFormat();
  for (const char* path : {"m/cameras.txt", "m/cameras.bin"}) {
    const std::vector<CompanionFile> beside =
        format.write_beside({path, {camera}});
    ASSERT_EQ(beside.size(), 2u);
    EXPECT_EQ(beside[0].path, std::string("m/images") + (path + 9));
    EXPECT_EQ(beside[1].path, std::string("m/points3D") + (path + 9));
    EXPECT_TRUE(beside[1].is_never_replaced);
    const std::vector<BoardPose> poses =
        ParseColmap(format.write({path, {camera}}), "", beside[0].text)
            .cameras[0]
            .poses;
    ASSERT_EQ(poses.size(), 1u);
    const Pose &back = poses[0].camera_from_board,
               &pose = camera.poses[0].camera_from_board;
    EXPECT_EQ(back.rotation.coeffs(), pose.rotation.coeffs());
    EXPECT_EQ(back.translation, pose.translation);
  }
  camera.poses.push_back({"a.png", 4, {}});
  ExpectError(ExitCode::kInvalidInput, {"boards 3 and 4", "COLMAP"}, [&] {
    format.write_beside({"m/cameras.txt", {camera}});
  });
  camera.poses = {{"a b.png", 3, {}}};
  ExpectError(ExitCode::kInvalidInput, {"a b.png", "space", "cameras.bin"},
              [&] {
                format.write_beside({"m/cameras.txt", {camera}});
              });
  EXPECT_EQ(format.write_beside({"m/cameras.bin", {camera}}).size(), 2u);
}

TEST(MakeColmapFormat, SaysWhichPosesItLeavesOut) {
  EXPECT_EQ(ParseColmap(ColmapBinary(), kBinaryRig).warnings.size(), 1u);
  EXPECT_FALSE(ParseColmap(ColmapBinary(), kBinaryRig).IsRig());
  // A model without rigs has one for each camera.
  EXPECT_TRUE(ParseColmap(kColmapCameras, "1 1 CAMERA 1\n2 1 CAMERA 2\n")
                  .warnings.empty());
  ExpectError(ExitCode::kInvalidInput, {"camera 7", "does not exist"}, [] {
    ParseColmap(kColmapCameras, TextWith(kColmapRigs, "CAMERA 2", "CAMERA 7"));
  });
  ExpectError(ExitCode::kInvalidInput,
              {"m/rigs.txt, line 4", "not a unit quaternion"}, [] {
                ParseColmap(
                    kColmapCameras,
                    TextWith(TextWith(kColmapRigs, "0.80000000000000004", "0"),
                             "0.59999999999999998", "0"));
              });
  ExpectError(ExitCode::kInvalidInput, {"m/images.txt", "camera 9", "b c.png"},
              [] {
                ParseColmap(kColmapCameras, "",
                            TextWith(kColmapImages, "0.5 1 b", "0.5 9 b"));
              });
  ExpectError(
      ExitCode::kInvalidInput, {"m/images.txt, line 6", "three fields"}, [] {
        ParseColmap(kColmapCameras, "", TextWith(kColmapImages, " 7\n", "\n"));
      });
  ExpectError(
      ExitCode::kInvalidInput, {"m/rigs.txt, line 4", "too few fields"},
      [] { ParseColmap(kColmapCameras, TextWith(kColmapRigs, " 1 2 3", "")); });
}

TEST(MakeColmapFormat, RefusesInOneLine) {
  const std::string text = kColmapCameras;
  const std::vector<std::pair<std::string, std::vector<std::string>>> cases = {
      {TextWith(text, "OPENCV", "CRAZY"),
       {"m/cameras.txt", "camera 1", "CRAZY is not a COLMAP model", "OPENCV"}},
      {TextWith(text, "OPENCV", "FOV"),
       {"FOV is a COLMAP model that is not supported"}},
      {TextWith(text, "0.01", "nan"), {"line 4", "'nan' is not a number"}},
      {TextWith(text, "640", "640.5"), {"line 4", "'640.5'"}},
      {TextWith(text, " 0.002", ""), {"OPENCV", "expected 8 numbers, found 7"}},
      {TextWith(text, "2 SIMPLE", "1 SIMPLE"), {"duplicate camera 1"}},
      {TextWith(text, "640", "0"), {"image size"}},
      {text.substr(0, text.find("1 OPENCV")), {"contains no camera"}},
      {TextWith(ColmapBinary(), std::string("\4\0\0\0", 4),
                "\x63" + std::string(3, 0)),
       {"camera 1", "unknown model 99"}},
      {ColmapBinary() + "x", {"1 byte after its end"}},
  };
  for (const auto& [file, words] : cases)
    ExpectError(ExitCode::kInvalidInput, words, [&, &file = file] {
      for (const InputCamera& camera : ParseColmap(file).cameras)
        MakeCameraModel(camera.lens);
    });
}

TEST(MakeColmapFormat, RefusesEveryTruncation) {
  const std::string cameras = ColmapBinary(),
                    rigs = EncodeColmapRig(ParseColmapRigs("", kColmapRigs)[0]);
  const Format format = MakeColmapFormat();
  for (size_t size = 0; size < cameras.size(); ++size)
    ExpectError(
        ExitCode::kInvalidInput, {"cameras.txt", "truncated after"}, [&] {
          ReadExchangeFile(&format,
                           {"cameras.txt", cameras.substr(0, size), "", {}});
        });
  for (size_t size = 1; size < rigs.size(); ++size)
    ExpectError(ExitCode::kInvalidInput, {"truncated after"},
                [&] { ParseColmap(cameras, rigs.substr(0, size)); });
}

TEST(MakeColmapFormat, TakesDamagedBytesForNothingElse) {
  TestRandom random(4);
  const Format format = MakeColmapFormat();
  const std::string rigs = EncodeColmapRig(ParseColmapRigs("", kColmapRigs)[0]);
  for (int k = NumMutants(500); k-- > 0;) {
    std::string cameras = ColmapBinary(), beside = rigs,
                images =
                    EncodeColmapImages(ParseColmapImages("", kColmapImages));
    for (std::string* bytes : {&cameras, &beside, &images})
      (*bytes)[random.Index(static_cast<int>(bytes->size()))] =
          static_cast<char>(random.Index(256));
    try {
      const ExchangeContents contents = ReadExchangeFile(
          &format, {"c.bin", cameras, "", {}, {beside, images}});
      ExpectFinite(contents);
      for (const InputCamera& camera : contents.cameras) {
        EXPECT_TRUE(
            camera.camera_from_rig.value_or(Pose{}).translation.allFinite());
      }
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::kInvalidInput) << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace raygrid
