/// Files as programs publish them, of formats that are only read.
#include <fmt/format.h>

#include <string>

#include "exchange/damaged_files.h"
#include "exchange/format.h"
#include "exchange/lenses_by_formula.h"
#include "support.h"

namespace raygrid {
namespace {

const Lens kRadialLens = {{410, 410, 322.5, 238}, {-0.21, 0.06, 0, 0, 0.01}};
const Lens kSingleBrown = {{410, 410, 322.5, 238},
                           {-0.21, 0.06, 1e-3, -2e-3, 0.01}};
const Lens kSingleFisheye = {{290, 290, 322.5, 238},
                             {0.03, -0.01, 4e-3, -1e-3}};

// The pose of the second camera is that of a point in its frame.
Eigen::Vector3d SecondFromFirst(const ExchangeContents& rig,
                                const Eigen::Vector3d& point) {
  return *rig.cameras.at(1).camera_from_rig *
         (rig.cameras.at(0).camera_from_rig->Inverse() * point);
}

std::string BoofCvCamera(const std::string& model, const std::string& skew) {
  return "model: " + model +
         "\nversion: 0\npinhole:\n  fx: 410.0\n  fy: 411.5\n  cx: 322.5\n"
         "  cy: 238.0\n  width: 640\n  height: 480\n  skew: " +
         skew + "\n";
}

constexpr char kBoofCvDistortion[] =
    "radial_tangential:\n  radial:\n  - -0.21\n  - 0.06\n  t1: 0.001\n"
    "  t2: -0.002\n";

std::string Indented(const std::string& text) {
  std::string indented = "  ";
  for (const char c : text) indented += c == '\n' ? "\n  " : std::string(1, c);
  return indented.substr(0, indented.size() - 2);
}

TEST(PublishedCameras, ReadBoofCv) {
  const std::string text =
      BoofCvCamera("pinhole_radial_tangential", "0.0") + kBoofCvDistortion;
  const auto read = Read("# Pinhole camera model\n\n" + text);
  ExpectLens(read.cameras.at(0), kPinholeLens, &Lens::Pinhole);
  EXPECT_EQ(read.cameras[0].lens.size, kImage);
  EXPECT_TRUE(read.warnings.empty());
  ExpectLens(Read(BoofCvCamera("pinhole", "0.0")).cameras.at(0),
             {kPinholeLens.k, {}}, &Lens::Pinhole);
  const std::string omni = TextWith(
      TextWith(
          TextWith(TextWith(BoofCvCamera("omnidirectional_universal", "0.0") +
                                kBoofCvDistortion,
                            "410.0", "910.0"),
                   "411.5", "911.5"),
          "- -0.21", "- -0.11"),
      "- 0.06", "- 0.05");
  ExpectLens(Read(omni + "mirror_offset: 1.25\n").cameras.at(0), kOmniLens,
             &Lens::Omni);
  ExpectError(ExitCode::kInvalidInput, {"f: ", "mirror_offset"},
              [&] { Read(omni); });
  ExpectError(ExitCode::kInvalidInput, {"f: ", "'kannala_brandt'"}, [&] {
    Read(TextWith(text, "pinhole_radial_tangential", "kannala_brandt"));
  });
  ExpectError(
      ExitCode::kInvalidInput, {"f: ", "radial", "4 coefficients"}, [&] {
        Read(TextWith(text, "  - 0.06\n", "  - 0.06\n  - 0.1\n  - 0.2\n"));
      });
  // A skew is approximated, and said.
  const auto skewed = Read(BoofCvCamera("pinhole_radial_tangential", "1.5") +
                           kBoofCvDistortion);
  ASSERT_EQ(skewed.warnings.size(), 1u);
  EXPECT_NE(skewed.warnings[0].find("skew of 1.5 px"), std::string::npos);
  ExpectLens(skewed.cameras.at(0),
             {{410, 411.5, 322.5, 238, 1.5}, kPinholeLens.d}, &Lens::Pinhole,
             0.05);
}

// The pose is that of the left camera in the right one's frame.
TEST(PublishedCameras, ReadBoofCvPair) {
  const std::string camera = Indented(
      BoofCvCamera("pinhole_radial_tangential", "0.0") + kBoofCvDistortion);
  const auto pair = Read("model: stereo_camera\nversion: 0\nleft:\n" + camera +
                         "right:\n" + TextWith(camera, "322.5", "300.0") +
                         "rightToLeft:\n  rotation: [0, -1, 0, 1, 0, 0, 0, 0, "
                         "1]\n  x: 0.12\n  y: 0.02\n  z: 0.03\n");
  ASSERT_EQ(pair.cameras.size(), 2u);
  ASSERT_TRUE(pair.IsRig());
  EXPECT_TRUE(pair.warnings.empty());
  EXPECT_EQ(pair.cameras[0].name, "left");
  EXPECT_EQ(pair.cameras[1].name, "right");
  EXPECT_EQ(pair.cameras[1].lens.Value("cx"), 300);
  EXPECT_LT(SecondFromFirst(pair, {0.12, 0.02, 0.03}).norm(), 1e-12);
  EXPECT_LT(
      (SecondFromFirst(pair, {0.12, 1.02, 0.03}) - Eigen::Vector3d(1, 0, 0))
          .norm(),
      1e-12);
}

std::string OpenMvgScene(const std::string& intrinsics) {
  return "{\"sfm_data_version\": \"0.3\", \"root_path\": \"/images\", "
         "\"views\": [{\"key\": 0, \"value\": {\"ptr_wrapper\": {\"data\": "
         "{\"width\": 9, \"height\": 9}}}}], \"intrinsics\": [" +
         intrinsics +
         "], \"extrinsics\": [], \"structure\": [], \"control_points\": []}";
}

std::string OpenMvgCamera(const std::string& id, const std::string& data) {
  return "{\"key\": 0, \"value\": {" + id +
         ", \"ptr_wrapper\": {\"id\": 2147483721, \"data\": {" + data + "}}}}";
}

constexpr char kMvgBase[] =
    "\"width\": 640, \"height\": 480, \"focal_length\": 410.0, "
    "\"principal_point\": [322.5, 238.0]";

TEST(PublishedCameras, ReadOpenMvg) {
  const std::string id =
      "\"polymorphic_id\": 2147483649, \"polymorphic_name\": \"NAME\"";
  const std::string radial = OpenMvgCamera(
      id, std::string(kMvgBase) + ", \"disto_k3\": [-0.21, 0.06, 0.01]");
  const auto read = Read(OpenMvgScene(radial));
  ExpectLens(read.cameras.at(0), kRadialLens, &Lens::Pinhole);
  EXPECT_EQ(read.cameras[0].lens.size, kImage);
  EXPECT_TRUE(read.warnings.empty());
  // A base class of newer versions, and the second camera of a model.
  const std::string base = std::string("\"value0\": {") + kMvgBase + "}, ";
  const auto two = Read(
      OpenMvgScene(radial + ", " +
                   OpenMvgCamera("\"polymorphic_id\": 1",
                                 base + "\"disto_k3\": [-0.21, 0.06, 0.01]")));
  ASSERT_EQ(two.cameras.size(), 2u);
  ExpectLens(two.cameras[1], kRadialLens, &Lens::Pinhole);
  ExpectLens(Read(OpenMvgScene(OpenMvgCamera(
                      id, base + "\"disto_t2\": [-0.21, 0.06, 0.01, 0.001, "
                                 "-0.002]")))
                 .cameras.at(0),
             kSingleBrown, &Lens::Pinhole);
  const std::string fisheye = TextWith(base, "410.0", "290.0");
  ExpectLens(Read(OpenMvgScene(OpenMvgCamera(
                      id, fisheye + "\"fisheye\": [0.03, -0.01, 0.004, "
                                    "-0.001]")))
                 .cameras.at(0),
             kSingleFisheye, &Lens::Fisheye);
  ExpectError(ExitCode::kInvalidInput, {"f: ", "'NAME'", "supported"},
              [&] { Read(OpenMvgScene(OpenMvgCamera(id, kMvgBase))); });
  ExpectLens(Read(OpenMvgScene(
                      OpenMvgCamera(TextWith(id, "NAME", "pinhole"), kMvgBase)))
                 .cameras.at(0),
             {kRadialLens.k, {}}, &Lens::Pinhole);
}

// Versions before 1.2 have pixels, later ones millimetres and the offset from
// the image centre.
TEST(PublishedCameras, ReadAliceVision) {
  const auto scene = [](const std::string& camera) {
    return "{\"version\": [\"1\", \"2\", \"6\"], \"views\": [{\"width\": "
           "\"9\"}], \"intrinsics\": [{\"intrinsicId\": \"7\", \"width\": "
           "\"640\", \"height\": \"480\", \"locked\": \"0\", " +
           camera + "}]}";
  };
  const std::string old =
      "\"type\": \"radial3\", \"pxFocalLength\": \"410\", \"principalPoint\": "
      "[\"322.5\", \"238\"], \"distortionParams\": [\"-0.21\", \"0.06\", "
      "\"0.01\"]";
  const auto read = Read(scene(old));
  ExpectLens(read.cameras.at(0), kRadialLens, &Lens::Pinhole);
  EXPECT_TRUE(read.warnings.empty());
  // 410 px = 12.3 mm * 640 px / 19.2 mm. The image centre is at 319.5, 239.5.
  const std::string recent =
      "\"type\": \"radial3\", \"sensorWidth\": \"19.2\", \"focalLength\": "
      "\"12.3\", \"pixelRatio\": \"1\", \"principalPoint\": [\"3\", \"-1.5\"], "
      "\"distortionParams\": [\"-0.21\", \"0.06\", \"0.01\"], "
      "\"undistortionOffset\": [\"0\", \"0\"], \"undistortionParams\": \"\"";
  const auto later = Read(scene(recent));
  ExpectLens(later.cameras.at(0), kRadialLens, &Lens::Pinhole);
  EXPECT_TRUE(later.warnings.empty());
  const std::string pinhole = TextWith(recent, "radial3", "pinhole");
  ExpectLens(
      Read(scene(TextWith(pinhole, "[\"-0.21\", \"0.06\", \"0.01\"]", "\"\"")))
          .cameras.at(0),
      {kRadialLens.k, {}}, &Lens::Pinhole);
  ExpectLens(Read(scene(TextWith(pinhole, "\"pinhole\"",
                                 "\"pinhole\", \"distortionType\": "
                                 "\"radialk3\"")))
                 .cameras.at(0),
             kRadialLens, &Lens::Pinhole);
  ExpectError(ExitCode::kInvalidInput, {"f: ", "distortionParams"},
              [&] { Read(scene(pinhole)); });
  const auto refuse = [&](const std::string& from, const std::string& to,
                          const char* word) {
    ExpectError(ExitCode::kInvalidInput, {"f: ", word},
                [&] { Read(scene(TextWith(recent, from, to))); });
  };
  refuse("\"pixelRatio\": \"1\"", "\"pixelRatio\": \"1.5\"", "pixelRatio");
  refuse("radial3", "3deradial4", "'3deradial4'");
  refuse("19.2", "-1", "sensor width");
  refuse("\"undistortionParams\": \"\"", "\"undistortionParams\": [\"0.1\"]",
         "undistortionParams");
  refuse("\"radial3\"", "\"pinhole\", \"distortionType\": \"3declassicld\"",
         "3declassicld");
}

// p1 and p2 of a fisheye are its third and fourth coefficient.
TEST(PublishedCameras, ReadOv2Slam) {
  const auto camera = [](const std::string& side, const std::string& numbers) {
    std::string text = numbers;
    while (text.find('@') != std::string::npos)
      text = TextWith(text, "@", side);
    return text;
  };
  const std::string pinhole =
      "Camera.fx@: 410.\nCamera.fy@: 411.5\nCamera.cx@: 322.5\n"
      "Camera.cy@: 238.\nCamera.k1@: -0.21\nCamera.k2@: 0.06\n"
      "Camera.p1@: 0.001\nCamera.p2@: -0.002\n";
  const std::string fisheye =
      "Camera.fx@: 290.\nCamera.fy@: 291.5\nCamera.cx@: 322.5\n"
      "Camera.cy@: 238.\nCamera.k1@: 0.03\nCamera.k2@: -0.01\n"
      "Camera.p1@: 0.004\nCamera.p2@: -0.001\n";
  const std::string head =
      "%YAML 1.0\n---\nCamera.topic_left: /cam0/image_raw\n"
      "Camera.model_left: pinhole\nCamera.model_right: fisheye\n"
      "Camera.left_nwidth: 640\nCamera.left_nheight: 480\n"
      "Camera.right_nwidth: 640\nCamera.right_nheight: 480\n";
  const std::string poses =
      "body_T_cam0: !!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: d\n"
      "   data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n"
      "body_T_cam1: !!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: d\n"
      "   data: [1, 0, 0, 0.11, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n"
      "mono: 0\nalpha: 1.\nbdo_stereo_rect: 1\n";
  const auto pair =
      Read(head + camera("l", pinhole) + camera("r", fisheye) + poses);
  ASSERT_TRUE(pair.IsRig());
  EXPECT_TRUE(pair.warnings.empty());
  ExpectLens(pair.cameras.at(0), kPinholeLens, &Lens::Pinhole);
  ExpectLens(pair.cameras.at(1), kFisheyeLens, &Lens::Fisheye);
  EXPECT_EQ(pair.cameras[1].name, "right");
  EXPECT_LT(SecondFromFirst(pair, {0.11, 0, 0}).norm(), 1e-12);
  EXPECT_EQ(Read(head + camera("l", pinhole)).cameras.size(), 1u);
}

TEST(PublishedCameras, ReadStorageOfPrograms) {
  const auto matrix = [](const std::string& name, int rows, int columns,
                         const std::string& data) {
    return fmt::format(
        "<{0} type_id=\"opencv-matrix\"><rows>{1}</rows><cols>{2}</cols>"
        "<dt>d</dt><data>{3}</data></{0}>\n",
        name, rows, columns, data);
  };
  const std::string k = "410. 0. 322.5 0. 411.5 238. 0. 0. 1.",
                    d = "-0.21 0.06 0.001 -0.002 0.",
                    begin =
                        "<?xml "
                        "version=\"1.0\"?>\n<opencv_storage>\n",
                    end = "</opencv_storage>\n";
  // OpenPose's CameraMatrix is the pose.
  const auto openpose = Read(
      begin +
          matrix("CameraMatrix", 3, 4, "1. 0. 0. 0.5 0. 1. 0. 0. 0. 0. 1. 0.") +
          matrix("Intrinsics", 3, 3, k) + matrix("Distortion", 5, 1, d) + end,
      kImage);
  ExpectLens(openpose.cameras.at(0), kPinholeLens, &Lens::Pinhole);
  EXPECT_EQ(openpose.cameras[0].camera_from_rig->translation.x(), 0.5);
  // SLStudio's projector is not a camera.
  const auto slstudio = Read(
      begin + matrix("Kc", 3, 3, k) + matrix("kc", 5, 1, d) +
      matrix("Kp", 3, 3, k) + matrix("kp", 5, 1, d) +
      "<frameWidth>640</frameWidth><frameHeight>480</frameHeight>\n" + end);
  ASSERT_EQ(slstudio.cameras.size(), 1u);
  ExpectLens(slstudio.cameras[0], kPinholeLens, &Lens::Pinhole);
  ASSERT_EQ(slstudio.warnings.size(), 1u);
  EXPECT_NE(slstudio.warnings[0].find("Kp, kp"), std::string::npos);
}

TEST(PublishedCameras, ReadTextsOfDepthSensors) {
  const auto infinitam = Read(
      "640 480\n410 411.5\n322.5 238\n\n320 240\n205 206\n160 120\n\n"
      "1 0 0 0.02\n0 1 0 0\n0 0 1 0\n\n1135.09 0.08\n");
  ASSERT_TRUE(infinitam.IsRig());
  EXPECT_TRUE(infinitam.warnings.empty());
  ExpectLens(infinitam.cameras[0], {kPinholeLens.k, {}}, &Lens::Pinhole);
  EXPECT_EQ(infinitam.cameras[1].lens.size, (ImageSize{320, 240}));
  EXPECT_NEAR(SecondFromFirst(infinitam, {0, 0, 0}).x(), 0.02, 1e-12);
  const auto scannet = Read(
      "colorHeight = 480\ncolorWidth = 640\ndepthHeight = 240\n"
      "depthWidth = 320\nfx_color = 410\nfy_color = 411.5\nmx_color = 322.5\n"
      "my_color = 238\nfx_depth = 205\nfy_depth = 206\nmx_depth = 160\n"
      "my_depth = 120\nsceneType = Bedroom / Hotel\n");
  ASSERT_EQ(scannet.cameras.size(), 2u);
  ExpectLens(scannet.cameras[0], {kPinholeLens.k, {}}, &Lens::Pinhole);
  EXPECT_EQ(scannet.cameras[1].lens.size, (ImageSize{320, 240}));
  const std::string sens =
      "m_colorWidth = 640\nm_colorHeight = 480\n"
      "m_calibrationColorIntrinsic = 410 0 322.5 0 0 411.5 238 0 0 0 1 0 0 0 0 "
      "1\n";
  ExpectLens(Read(sens).cameras.at(0), {kPinholeLens.k, {}}, &Lens::Pinhole);
  ExpectError(ExitCode::kInvalidInput, {"f: ", "camera matrix"},
              [&] { Read(TextWith(sens, "322.5 0 0", "322.5 7 0")); });
  const auto anything = Read(
      "K: 410 0 322.5 0 411.5 238 0 0 1\nD: -0.21 0.06 0.001 -0.002\n"
      "T: 1 0 0 0 0 1 0 0 0 0 1 0\n",
      kImage);
  ExpectLens(anything.cameras.at(0), kPinholeLens, &Lens::Pinhole);
  // A matrix as a list of YAML is of another program.
  ExpectLens(Read("K:\n- - 410.0\n  - 0.0\n  - 322.5\n- - 0.0\n  - 411.5\n"
                  "  - 238.0\n- - 0.0\n  - 0.0\n  - 1.0\nD:\n- -0.21\n- 0.06\n"
                  "- 0.001\n- -0.002\n- 0.0\nwidth: 640\nheight: 480\n"
                  "R:\n- - 1\n  - 0\n  - 0\n- - 0\n  - 1\n  - 0\n- - 0\n  - 0\n"
                  "  - 1\nT:\n- 0.0\n- 0.0\n- 0.0\n")
                 .cameras.at(0),
             kPinholeLens, &Lens::Pinhole);
  EXPECT_EQ(Read("P2: 410 0 322.5 45 0 410 238 0 0 0 1 0.004\n"
                 "Tr: 1 0 0 0 0 1 0 0 0 0 1 0\n",
                 kImage)
                .cameras.size(),
            1u);
}

// The sections of the resolutions do not state them.
TEST(PublishedCameras, ReadSectionsOfDepthSensors) {
  const std::string camera =
      "fx=410\nfy=411.5\ncx=322.5\ncy=238\nk1=-0.21\nk2=0.06\np1=0.001\n"
      "p2=-0.002\nk3=0\n";
  const auto zed = Read("[LEFT_CAM_FHD]\n" + camera + "[LEFT_CAM_HD]\n" +
                        camera + "[STEREO]\nBaseline=119.9\n");
  ASSERT_EQ(zed.cameras.size(), 2u);
  EXPECT_EQ(zed.cameras[0].lens.size, (ImageSize{1920, 1080}));
  EXPECT_EQ(zed.cameras[1].lens.size, (ImageSize{1280, 720}));
  EXPECT_EQ(zed.cameras[1].name, "LEFT_CAM_HD");
  ExpectLens(zed.cameras[1], kPinholeLens, &Lens::Pinhole);
  ExpectError(ExitCode::kInvalidInput, {"f: ", "k4"}, [&] {
    Read("[LEFT_CAM_HD]\n" + camera + "k4=0.1\n[STEREO]\nBaseline=119.9\n");
  });
  const std::string intrinsic =
      "fx=410\nfy=411.5\ncx=322.5\ncy=238\nwidth=640\nheight=480\n";
  const std::string distortion =
      "k1=-0.21\nk2=0.06\nk3=0\nk4=0.01\nk5=0.002\nk6=0.003\np1=0.001\n"
      "p2=-0.002\n";
  const auto orbbec = Read(
      "[DepthIntrinsic]\n" + intrinsic + "[ColorIntrinsic]\n" + intrinsic +
      "[DepthDistortion]\n" + distortion + "[ColorDistortion]\n" + distortion);
  ASSERT_EQ(orbbec.cameras.size(), 2u);
  EXPECT_TRUE(orbbec.warnings.empty());
  EXPECT_EQ(orbbec.cameras[0].name, "Color");
  ExpectLens(
      orbbec.cameras[0],
      {kPinholeLens.k, {-0.21, 0.06, 1e-3, -2e-3, 0, 0.01, 0.002, 0.003}},
      &Lens::Pinhole);
}

// Lengths are fractions of the sensor from its corner: the first pixel's centre
// is at half a pixel.
TEST(PublishedCameras, ReadAzureKinect) {
  const std::string text =
      "{\"CalibrationInformation\": {\"Cameras\": [{\"Intrinsics\": "
      "{\"ModelParameterCount\": 14, \"ModelParameters\": [0.5046875, "
      "0.496875, "
      "0.640625, 0.85729166666666667, -0.21, 0.06, 0, 0.01, 0.002, 0.003, 0, "
      "0, "
      "-0.002, 0.001], \"ModelType\": "
      "\"CALIBRATION_LensDistortionModelBrownConrady\"}, \"Purpose\": "
      "\"Color\", \"Rt\": {\"Rotation\": [1, 0, 0, 0, 1, 0, 0, 0, 1], "
      "\"Translation\": [-0.03, 0, 0]}, \"SensorHeight\": 480, "
      "\"SensorWidth\": 640}], \"InertialSensors\": []}}";
  const auto read = Read(text);
  EXPECT_TRUE(read.warnings.empty());
  ExpectLens(
      read.cameras.at(0),
      {kPinholeLens.k, {-0.21, 0.06, 1e-3, -2e-3, 0, 0.01, 0.002, 0.003}},
      &Lens::Pinhole);
  EXPECT_EQ(read.cameras[0].camera_from_rig->translation.x(), -0.03);
  ExpectError(ExitCode::kInvalidInput, {"f: ", "number 11", "0.5"}, [&] {
    Read(TextWith(text, "0.003, 0, 0, ", "0.003, 0.5, 0, "));
  });
}

// The SDK of Orbbec numbers its models.
TEST(PublishedCameras, ReadIntrinsicAndDistortion) {
  const std::string camera =
      "{\"width\": 640, \"height\": 480, \"intrinsic\": {\"fx\": 410, \"fy\": "
      "411.5, \"cx\": 322.5, \"cy\": 238, \"width\": 640, \"height\": 480}, "
      "\"distortion\": {\"k1\": -0.21, \"k2\": 0.06, \"k3\": 0, \"k4\": 0, "
      "\"k5\": 0, \"k6\": 0, \"p1\": 0.001, \"p2\": -0.002, \"model\": 4}}";
  const auto read = Read("{\"01\": {\"sn\": \"C\", \"RGB\": " + camera +
                         "}, \"02\": {\"RGB\": " + camera + "}}");
  ASSERT_EQ(read.cameras.size(), 2u);
  ExpectLens(read.cameras[0], kPinholeLens, &Lens::Pinhole);
  EXPECT_EQ(read.cameras[0].name, "cam0");
  EXPECT_EQ(read.cameras[1].name, "cam1");
  ExpectLens(Read("{\"RGB\": " +
                  TextWith(camera, "\"model\": 4", "\"model\": 0") + "}")
                 .cameras.at(0),
             {kPinholeLens.k, {}}, &Lens::Pinhole);
  // Other keys of the camera are not skipped.
  ExpectError(
      ExitCode::kInvalidInput, {"f: ", "distortion_model", "spherical"}, [&] {
        Read("{\"RGB\": " +
             TextWith(camera, "{\"width\"",
                      "{\"distortion_model\": \"spherical\", \"width\"") +
             "}");
      });
  for (const char* model : {"2", "5"})
    ExpectError(ExitCode::kInvalidInput, {"f: ", "model: ", model}, [&] {
      Read(
          "{\"RGB\": " +
          TextWith(camera, "\"model\": 4", std::string("\"model\": ") + model) +
          "}");
    });
}

// Keys of Autoware, OpenCalib, Panoptic Studio and Record3D.
TEST(PublishedCameras, ReadOtherNamesOfMatrices) {
  const std::string autoware =
      "%YAML:1.0\n---\nCameraExtrinsicMat: !!opencv-matrix\n   rows: 4\n"
      "   cols: 4\n   dt: d\n   data: [ 1., 0., 0., 0., 0., 1., 0., 0., 0., "
      "0., "
      "1., 0., 0., 0., 0., 1. ]\nCameraMat: !!opencv-matrix\n   rows: 3\n"
      "   cols: 3\n   dt: d\n   data: [ 410., 0., 322.5, 0., 411.5, 238., 0., "
      "0., 1. ]\nDistCoeff: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n"
      "   data: [ -0.21, 0.06, 0.001, -0.002, 0. ]\nImageSize: [ 640, 480 ]\n"
      "ReprojectionError: 0.1\nDistModel: plumb_bob\n";
  ExpectLens(Read(autoware).cameras.at(0), kPinholeLens, &Lens::Pinhole);
  ExpectError(ExitCode::kInvalidInput, {"f: ", "DistModel", "scaramuzza"},
              [&] { Read(TextWith(autoware, "plumb_bob", "scaramuzza")); });
  const std::string opencalib =
      "{\"center_camera-intrinsic\": {\"device_type\": \"camera\", \"param\": "
      "{\"img_dist_w\": 640, \"img_dist_h\": 480, \"cam_K\": {\"rows\": 3, "
      "\"cols\": 3, \"type\": 6, \"data\": [[410, 0, 322.5], [0, 411.5, 238], "
      "[0, 0, 1]]}, \"cam_dist\": {\"cols\": 5, \"data\": [[-0.21, 0.06, "
      "0.001, -0.002, 0]]}}}}";
  ExpectLens(Read(opencalib).cameras.at(0), kPinholeLens, &Lens::Pinhole);
  ExpectError(
      ExitCode::kInvalidInput, {"f: ", "img_dist_type", "scaramuzza"}, [&] {
        Read(TextWith(opencalib, "\"img_dist_w\"",
                      "\"img_dist_type\": \"scaramuzza\", \"img_dist_w\""));
      });
  const auto panoptic = Read(
      "{\"cameras\": [{\"name\": \"00_00\", \"type\": \"hd\", \"resolution\": "
      "[640, 480], \"K\": [[410, 0, 322.5], [0, 411.5, 238], [0, 0, 1]], "
      "\"distCoef\": [-0.21, 0.06, 0.001, -0.002, 0], \"R\": [[1, 0, 0], [0, "
      "1, 0], [0, 0, 1]], \"t\": [[22.5], [0], [0]]}]}");
  ExpectLens(panoptic.cameras.at(0), kPinholeLens, &Lens::Pinhole);
  EXPECT_EQ(panoptic.cameras[0].camera_from_rig->translation.x(), 22.5);
  const auto record3d = Read(
      "// written by hand\n{\n  // columns first\n  \"w\": 640, \"h\": 480,\n"
      "  \"K\": [410, 0, 0, 0, 411.5, 0, 322.5, 238, 1]\n}\n");
  ExpectLens(record3d.cameras.at(0), {kPinholeLens.k, {}}, &Lens::Pinhole);
  ASSERT_EQ(record3d.warnings.size(), 1u);
  EXPECT_NE(record3d.warnings[0].find("without distortion"), std::string::npos);
}

// Kalibr's coefficients may end with zeros, matrices of ROS may be unknown.
TEST(PublishedCameras, ReadZerosForNothing) {
  const std::string kalibr =
      "cam0:\n  camera_model: pinhole\n  distortion_model: radtan\n"
      "  distortion_coeffs: [-0.21, 0.06, 0.001, -0.002, 0.0]\n"
      "  intrinsics: [410, 411.5, 322.5, 238]\n  resolution: [640, 480]\n"
      "  rostopic: /cam0\n";
  ExpectLens(Read(kalibr).cameras.at(0), kPinholeLens, &Lens::Pinhole);
  ExpectError(ExitCode::kInvalidInput, {"f: ", "list of 4 numbers"},
              [&] { Read(TextWith(kalibr, "-0.002, 0.0", "-0.002, 0.1")); });
  const auto ros = Read(
      "header:\n  frame_id: front\nheight: 480.0\nwidth: 640.0\n"
      "distortion_model: plumb_bob\nD: [-0.21, 0.06, 0.001, -0.002, 0]\n"
      "K: [410, 0, 322.5, 0, 411.5, 238, 0, 0, 1]\n"
      "R: [0, 0, 0, 0, 0, 0, 0, 0, 1]\nP: [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, "
      "0]\n");
  ExpectLens(ros.cameras.at(0), kPinholeLens, &Lens::Pinhole);
  EXPECT_FALSE(ros.cameras[0].rectified);
}

TEST(PublishedCameras, ReadDamagedFilesAsNothingElse) {
  const std::string fisheye = "\"fisheye\": [0.03, -0.01, 0.004, -0.001]";
  const std::vector<std::string> texts = {
      BoofCvCamera("pinhole_radial_tangential", "0.0") + kBoofCvDistortion,
      OpenMvgScene(OpenMvgCamera("\"polymorphic_id\": 1",
                                 std::string(kMvgBase) + ", " + fisheye)),
      "640 480\n410 411.5\n322.5 238\n\n320 240\n205 206\n160 120\n\n"
      "1 0 0 0.02\n0 1 0 0\n0 0 1 0\n\n1135.09 0.08\n",
      "[LEFT_CAM_HD]\nfx=410\nfy=411.5\ncx=322.5\ncy=238\nk1=-0.21\nk2=0.06\n"
      "[STEREO]\nBaseline=119.9\n"};
  TestRandom random(8);
  int num_refused = 0, num_read = 0;
  for (const std::string& text : texts) {
    const Format* format = RecognizeFormat(text);
    ASSERT_NE(format, nullptr) << text;
    for (int k = NumMutants(150); k-- > 0; ++num_read) {
      const std::string mutant = Mutated(text, &random);
      num_refused += IsRefused([&] {
        ExpectFinite(ReadExchangeFile(format, {"f", mutant, "", {}}));
      });
    }
  }
  EXPECT_GT(num_refused, num_read / 4);
  EXPECT_LT(num_refused, num_read);
}

}  // namespace
}  // namespace raygrid
