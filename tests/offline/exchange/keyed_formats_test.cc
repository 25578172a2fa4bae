/// Files of keys and numbers that programs publish, against formulas.
#include <fmt/format.h>

#include <cmath>

#include "dataset/text_encoding.h"
#include "exchange/damaged_files.h"
#include "exchange/format.h"
#include "exchange/lenses_by_formula.h"
#include "exchange/table_format.h"
#include "support.h"

namespace raygrid {
namespace {

TEST(MakeKeyedFormats, ReadCamodocal) {
  const std::string head =
      "%YAML:1.0\n---\nmodel_type: MODEL\ncamera_name: front\n"
      "image_width: 640\nimage_height: 480\n";
  const std::string distortion =
      "distortion_parameters:\n   k1: K1\n   k2: K2\n   p1: 0.001\n   p2: "
      "-0.002\n";
  const auto with = [&](const char* model, const char* k1, const char* k2) {
    return TextWith(head, "MODEL", model) +
           TextWith(TextWith(distortion, "K1", k1), "K2", k2);
  };
  const auto pinhole = Read(with("PINHOLE", "-0.21", "0.06") +
                            "projection_parameters:\n   fx: 410.\n   fy: "
                            "411.5\n   cx: 322.5\n   cy: 238.\n");
  EXPECT_EQ(pinhole.cameras.at(0).name, "front");
  EXPECT_TRUE(pinhole.warnings.empty());
  ExpectLens(pinhole.cameras[0], kPinholeLens, &Lens::Pinhole);
  const std::string mei = with("MEI", "-0.11", "0.05") +
                          "mirror_parameters:\n   xi: 1.25\n"
                          "projection_parameters:\n   gamma1: 910.\n   gamma2: "
                          "911.5\n   u0: 322.5\n   v0: 238.\n";
  ExpectLens(Read(mei).cameras.at(0), kOmniLens, &Lens::Omni);
  // VINS has the camera in its settings, where "fisheye" asks for a mask.
  ExpectLens(Read(mei + "fisheye: 1\nmax_cnt: 150\n").cameras.at(0), kOmniLens,
             &Lens::Omni);
  const std::string fisheye =
      TextWith(head, "MODEL", "KANNALA_BRANDT") +
      "projection_parameters:\n   k2: 0.03\n   k3: -0.01\n   k4: 0.004\n"
      "   k5: -0.001\n   mu: 290.\n   mv: 291.5\n   u0: 322.5\n   v0: 238.\n";
  ExpectLens(Read(fisheye).cameras.at(0), kFisheyeLens, &Lens::Fisheye);
  // Converters from Kalibr write its coefficients elsewhere.
  const std::string converted = TextWith(
      TextWith(fisheye, "projection_parameters:", "distortion_parameters:"),
      "   mu:", "projection_parameters:\n   mu:");
  ExpectLens(Read(converted).cameras.at(0), kFisheyeLens, &Lens::Fisheye);
  ExpectError(ExitCode::kInvalidInput, {"f: ", "'SCARAMUZZA'", "MEI"},
              [&] { Read(TextWith(fisheye, "KANNALA_BRANDT", "SCARAMUZZA")); });
  ExpectError(ExitCode::kInvalidInput, {"f: ", "mirror_parameters/xi"},
              [&] { Read(TextWith(mei, "xi:", "other:")); });
}

TEST(MakeKeyedFormats, ReadOrbSlam) {
  const std::string old =
      "%YAML:1.0\n\nCamera.fx: 410.\nCamera.fy: 411.5\nCamera.cx: 322.5\n"
      "Camera.cy: 238.\nCamera.k1: -0.21\nCamera.k2: 0.06\nCamera.p1: 0.001\n"
      "Camera.p2: -0.002\nCamera.fps: 30.0\nORBextractor.nFeatures: 1000\n"
      "Viewer.PointSize:2\n";
  const auto one = Read(old, kImage);
  ExpectLens(one.cameras.at(0), kPinholeLens, &Lens::Pinhole);
  EXPECT_TRUE(one.warnings.empty());
  ExpectError(ExitCode::kInvalidInput, {"f: ", "--image-size"},
              [&] { Read(old); });
  // OpenVSLAM's name of the model; another value is another lens.
  const std::string fisheye =
      TextWith(TextWith(old, "Camera.p1: 0.001", "Camera.k3: 0.004"),
               "Camera.p2: -0.002",
               "Camera.k4: -0.001\nCamera.model: \"fisheye\"\n"
               "Camera.cols: 640\nCamera.rows: 480");
  EXPECT_EQ(Read(fisheye).cameras.at(0).lens.external_model->model,
            "thin-prism-fisheye");
  ExpectError(ExitCode::kInvalidInput, {"f: ", "equirectangular"}, [&] {
    Read(TextWith(fisheye, "\"fisheye\"", "equirectangular"));
  });
  const auto camera = [](const std::string& word, const char* cx) {
    return TextWith(
        "@.fx: 290.\n@.fy: 291.5\n@.cx: " + std::string(cx) +
            "\n@.cy: 238.\n@.k1: 0.03\n@.k2: -0.01\n@.k3: 0.004\n@.k4: "
            "-0.001\n",
        "@", word);
  };
  std::string first = camera("Camera1", "322.5"),
              second = camera("Camera2", "300.0");
  for (std::string* text : {&first, &second})
    while (text->find('@') != std::string::npos)
      *text = TextWith(*text, "@", text == &first ? "Camera1" : "Camera2");
  const auto pair = Read(
      "%YAML:1.0\nFile.version: \"1.0\"\nCamera.type: \"KannalaBrandt8\"\n" +
      first + second +
      "Camera.width: 640\nCamera.height: 480\nStereo.ThDepth: 40.0\n"
      "Stereo.T_c1_c2: !!opencv-matrix\n  rows: 4\n  cols: 4\n  dt: f\n"
      "  data: [1, 0, 0, 0.1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n");
  ASSERT_EQ(pair.cameras.size(), 2u);
  ASSERT_TRUE(pair.IsRig());
  ExpectLens(pair.cameras[0], kFisheyeLens, &Lens::Fisheye);
  EXPECT_EQ(pair.cameras[1].lens.Value("cx"), 300);
  // A point of the second camera's origin lies at 0.1 m in the first one.
  EXPECT_LT(
      (*pair.cameras[1].camera_from_rig * Eigen::Vector3d(0.1, 0, 0)).norm(),
      1e-12);
}

TEST(MakeKeyedFormats, ReadEurocAndOkvis) {
  const std::string pose =
      "[0, -1, 0, 0.1, 1, 0, 0, 0.2, 0, 0, 1, 0.3, 0, 0, 0, 1]";
  const std::string euroc =
      "sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: " + pose +
      "\nrate_hz: 20\nresolution: [640, 480]\ncamera_model: pinhole\n"
      "intrinsics: [410, 411.5, 322.5, 238]\n"
      "distortion_model: radial-tangential\n"
      "distortion_coefficients: [-0.21, 0.06, 0.001, -0.002]\n";
  const auto read = Read(euroc);
  ExpectLens(read.cameras.at(0), kPinholeLens, &Lens::Pinhole);
  const Eigen::Vector3d in_body(0.1, 0.2, 0.3);
  EXPECT_LT((*read.cameras[0].camera_from_rig * in_body).norm(), 1e-12);
  const std::string fisheye =
      TextWith(TextWith(TextWith(euroc, "radial-tangential", "equidistant"),
                        "410, 411", "290, 291"),
               "-0.21, 0.06, 0.001, -0.002", "0.03, -0.01, 0.004, -0.001");
  ExpectLens(Read(fisheye).cameras.at(0), kFisheyeLens, &Lens::Fisheye);
  ExpectError(ExitCode::kInvalidInput, {"f: ", "'omni'"},
              [&] { Read(TextWith(euroc, "pinhole", "omni")); });
  const std::string okvis =
      "%YAML:1.0\ncameras:\n     - {T_SC:\n        " + pose +
      ",\n        image_dimension: [640, 480],\n"
      "        distortion_coefficients: [-0.21, 0.06, 0.001, -0.002],\n"
      "        distortion_type: radialtangential,\n"
      "        focal_length: [410, 411.5],\n"
      "        principal_point: [322.5, 238]}\n"
      "     - {T_SC:\n        " +
      pose +
      ",\n        image_dimension: [640, 480],\n"
      "        distortion_coefficients: [0.03, -0.01, 0.004, -0.001],\n"
      "        distortion_type: equidistant,\n"
      "        focal_length: [290, 291.5],\n"
      "        principal_point: [322.5, 238]}\ncamera_params:\n  rate: 20\n";
  const auto rig = Read(okvis);
  ASSERT_EQ(rig.cameras.size(), 2u);
  EXPECT_TRUE(rig.IsRig());
  ExpectLens(rig.cameras[0], kPinholeLens, &Lens::Pinhole);
  ExpectLens(rig.cameras[1], kFisheyeLens, &Lens::Fisheye);
}

TEST(MakeKeyedFormats, ReadGyroflow) {
  const std::string text =
      "{\"name\": \"a\", \"camera_model\": \"HERO fisheye\", "
      "\"calib_dimension\": {\"w\": 640, \"h\": 480}, "
      "\"input_horizontal_stretch\": 1.0, \"fisheye_params\": {\"RMS_error\": "
      "0.5, \"camera_matrix\": [[290, 0, 322.5], [0, 291.5, 238], [0, 0, 1]], "
      "\"distortion_coeffs\": [0.03, -0.01, 0.004, -0.001]}, "
      "\"distortion_model\": null, \"digital_lens\": null}\n";
  const auto read = Read(text);
  ExpectLens(read.cameras.at(0), kFisheyeLens, &Lens::Fisheye);
  EXPECT_TRUE(read.warnings.empty());
  for (const auto& [old, by, word] : std::vector<std::array<const char*, 3>>{
           {"\"distortion_model\": null", "\"distortion_model\": \"sony\"",
            "'sony'"},
           {"\"digital_lens\": null", "\"digital_lens\": \"gopro_superview\"",
            "digital_lens"},
           {"_stretch\": 1.0", "_stretch\": 1.33", "1.33"}})
    ExpectError(ExitCode::kInvalidInput, {"f: ", word},
                [&, &o = old, &b = by] { Read(TextWith(text, o, b)); });
}

TEST(MakeKeyedFormats, ReadAnipose) {
  const std::string text =
      "[cam_0] # left\nname = \"A\"\nsize = [ 640, 480,]\n"
      "matrix = [ [ 410, 0.0, 322.5,],\n  [ 0.0, 411.5, 238.0,],\n"
      "  [ 0.0, 0.0, 1.0,],]\n"
      "distortions = [ -0.21, 0.06, 0.001, -0.002, 0.0,]\n"
      "rotation = [ 0.0, 0.0, 1.5707963267948966,]\n"
      "translation = [ 1.0, 2.0, 3.0,]\n\n[cam_1]\nname = \"B\"\n"
      "size = [ 640, 480,]\nmatrix = [ [ 290, 0.0, 322.5,], [ 0.0, 291.5, "
      "238.0,], [ 0.0, 0.0, 1.0,],]\n"
      "distortions = [ 0.03, -0.01, 0.004, -0.001,]\nfisheye = true\n"
      "rotation = [ 0.0, 0.0, 0.0,]\ntranslation = [ 0.0, 0.0, 0.0,]\n\n"
      "[metadata]\nadjusted = false\n";
  const auto rig = Read(text);
  ASSERT_EQ(rig.cameras.size(), 2u);
  EXPECT_TRUE(rig.IsRig());
  EXPECT_EQ(rig.cameras[0].name, "A");
  ExpectLens(rig.cameras[0], kPinholeLens, &Lens::Pinhole);
  ExpectLens(rig.cameras[1], kFisheyeLens, &Lens::Fisheye);
  EXPECT_LT((*rig.cameras[0].camera_from_rig * Eigen::Vector3d(1, 0, 0) -
             Eigen::Vector3d(1, 3, 3))
                .norm(),
            1e-12);
  ExpectError(ExitCode::kInvalidInput, {"f: ", "line"},
              [&] { Read(TextWith(text, "[ 640, 480,]", "[ 640")); });
}

TEST(MakeKeyedFormats, ReadOpenSfm) {
  // Lengths are parts of the longer side, from the image's middle.
  const auto part = [](double px) { return px / 640; };
  const std::string text = fmt::format(
      "{{\"v2 a b 640 480\": {{\"projection_type\": \"brown\", \"width\": 640, "
      "\"height\": 480, \"focal_x\": {}, \"focal_y\": {}, \"c_x\": {}, "
      "\"c_y\": {}, \"k1\": -0.21, \"k2\": 0.06, \"k3\": 0.0, \"p1\": 0.001, "
      "\"p2\": -0.002}}}}\n",
      part(410), part(411.5), part(322.5 - 319.5), part(238 - 239.5));
  ExpectLens(Read(text).cameras.at(0), kPinholeLens, &Lens::Pinhole);
  const std::string scene =
      "[{\"cameras\": " + text + ", \"shots\": {\"a\": {\"rotation\": []}}}]";
  ExpectLens(Read(scene).cameras.at(0), kPinholeLens, &Lens::Pinhole);
  // A scene may have more points than a list of cameras may have values.
  std::string points;
  for (size_t k = 0; k < kMaxStructureCharacters / 4; ++k)
    points += fmt::format("{}\"{}\": {{\"color\": [1, 2]}}", k ? ", " : "", k);
  ExpectLens(Read(TextWith(scene, "\"shots\"",
                           "\"points\": {" + points + "}, \"shots\""))
                 .cameras.at(0),
             kPinholeLens, &Lens::Pinhole);
  ExpectError(ExitCode::kInvalidInput, {"f: ", "'spherical'"},
              [&] { Read(TextWith(text, "brown", "spherical")); });
  const auto simple = Read(
      "{\"a\": {\"projection_type\": \"perspective\", \"width\": 640, "
      "\"height\": 480, \"focal\": 0.75, \"k1\": -0.1, \"k2\": 0.02}}\n");
  ExpectLens(simple.cameras.at(0), {{480, 480, 319.5, 239.5}, {-0.1, 0.02}},
             &Lens::Pinhole);
}

TEST(MakeKeyedFormats, ReadCalibTexts) {
  const auto raw = Read(
      "calib_time: 09-Jan-2012 13:57:47\nS_00: 6.4e+02 4.8e+02\n"
      "K_00: 410 0 322.5 0 411.5 238 0 0 1\nD_00: -0.21 0.06 0.001 -0.002 0\n"
      "R_00: 1 0 0 0 1 0 0 0 1\nT_00: 0 0 0\nS_rect_00: 600 400\n"
      "S_01: 640 480\nK_01: 410 0 322.5 0 411.5 238 0 0 1\n"
      "D_01: -0.21 0.06 0.001 -0.002 0\nR_01: 1 0 0 0 1 0 0 0 1\n"
      "T_01: -0.5 0 0\n");
  ASSERT_EQ(raw.cameras.size(), 2u);
  EXPECT_TRUE(raw.IsRig());
  EXPECT_TRUE(raw.warnings.empty());
  ExpectLens(raw.cameras[0], kPinholeLens, &Lens::Pinhole);
  EXPECT_EQ(raw.cameras[1].camera_from_rig->translation.x(), -0.5);
  const auto rectified = Read(
      "P0: 700 0 300 0 0 700 200 0 0 0 1 0\n"
      "P1: 700 0 300 -350 0 700 200 0 0 0 1 0\nTr: 1 0 0 0 0 1 0 0 0 0 1 0\n",
      kImage);
  ASSERT_EQ(rectified.cameras.size(), 2u);
  EXPECT_EQ(rectified.cameras[1].camera_from_rig->translation.x(), -0.5);
  const auto line =
      Read("410 411.5 322.5 238 -0.21 0.06 0.001 -0.002\n", kImage);
  ExpectLens(line.cameras.at(0), kPinholeLens, &Lens::Pinhole);
  const auto commented = Read(
      "# fx fy cx cy k1 k2 p1 p2\n\n410 411.5 322.5 238 -0.21 0.06 0.001 "
      "-0.002\n",
      kImage);
  ExpectLens(commented.cameras.at(0), kPinholeLens, &Lens::Pinhole);
  ExpectError(ExitCode::kInvalidInput, {"f: ", "supported format"},
              [] { Read("410 411.5 322.5 238\n410 411.5 322.5 238\n"); });
  const auto ini = Read(
      "# intrinsics\n\n[image]\n\nwidth\n640\n\nheight\n480\n\n[front]\n\n"
      "camera matrix\n410 0 322.5\n0 411.5 238\n0 0 1\n\ndistortion\n"
      "-0.21 0.06 0.001 -0.002 0\n\nrectification\n1 0 0\n0 1 0\n0 0 1\n\n"
      "projection\n410 0 322.5 0\n0 411.5 238 0\n0 0 1 0\n");
  EXPECT_TRUE(ini.warnings.empty());
  EXPECT_EQ(ini.cameras.at(0).name, "front");
  ExpectLens(ini.cameras[0], kPinholeLens, &Lens::Pinhole);
  // The calibrator writes four coefficients of fisheyes, five of others.
  const auto fisheye = Read(
      "[image]\n\nwidth\n640\n\nheight\n480\n\n[front]\n\ncamera matrix\n"
      "290 0 322.5\n0 291.5 238\n0 0 1\n\ndistortion\n0.03 -0.01 0.004 "
      "-0.001\n");
  ExpectLens(fisheye.cameras.at(0), kFisheyeLens, &Lens::Fisheye);
  EXPECT_EQ(fisheye.warnings.size(), 1u);
  // ost.txt of a pair: what the program printed, and a camera behind the other.
  const auto side = [](const std::string& name, const char* t) {
    return "# oST version 5.0 parameters\n\n[image]\n\nwidth\n640\n\nheight\n"
           "480\n\n[narrow_stereo/" +
           name +
           "]\n\ncamera matrix\n410 0 322.5\n0 411.5 238\n0 0 1\n\n"
           "distortion\n-0.21 0.06 0.001 -0.002 0\n\nrectification\n1 0 0\n"
           "0 1 0\n0 0 1\n\nprojection\n400 0 320 " +
           t + "\n0 400 240 0\n0 0 1 0\n\n";
  };
  const auto pair = Read("Left:\n('D = ', [-0.21, 0.06])\nNone\n" +
                         side("left", "0") + side("right", "-40"));
  ASSERT_EQ(pair.cameras.size(), 2u);
  EXPECT_TRUE(pair.warnings.empty());
  EXPECT_EQ(pair.cameras[1].name, "right");
  ExpectLens(pair.cameras[1], kPinholeLens, &Lens::Pinhole);
  ASSERT_TRUE(pair.IsRig());
  EXPECT_NEAR(pair.cameras[1].camera_from_rig->translation.x(), -0.1, 1e-12);
}

// One camera a map, and its pose beside it.
TEST(MakeKeyedFormats, ReadCamerasOfSvo) {
  const auto camera = [](const std::string& label, const std::string& lens,
                         const std::string& type, const std::string& numbers,
                         const std::string& x) {
    return "- camera:\n    label: " + label +
           "\n    id: 54\n    line-delay-nanoseconds: 0\n    image_height: "
           "480\n    image_width: 640\n    type: " +
           (lens.size() > 22 ? "unified-projection" : "pinhole") +
           "\n    intrinsics:\n      cols: 1\n      rows: 4\n      data: [" +
           lens + "]\n    distortion:\n      type: " + type +
           "\n      parameters:\n        cols: 1\n        rows: 4\n        "
           "data: [" +
           numbers +
           "]\n  T_B_C:\n    cols: 4\n    rows: 4\n    data: [0, -1, 0, " + x +
           ", 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n";
  };
  const std::string text =
      "label: \"rig\"\ncameras:\n" +
      camera("left", "410, 411.5, 322.5, 238", "radial-tangential",
             "-0.21, 0.06, 0.001, -0.002", "0.0") +
      camera("right", "290, 291.5, 322.5, 238", "equidistant",
             "0.03, -0.01, 0.004, -0.001", "0.5") +
      camera("top", "1.25, 910, 911.5, 322.5, 238", "radial-tangential",
             "-0.11, 0.05, 0.001, -0.002", "1.0") +
      "imu_params:\n  imu_rate: 800\n";
  const auto rig = Read(text);
  ASSERT_EQ(rig.cameras.size(), 3u);
  ASSERT_TRUE(rig.IsRig());
  EXPECT_TRUE(rig.warnings.empty());
  EXPECT_EQ(rig.cameras[1].name, "right");
  ExpectLens(rig.cameras[0], kPinholeLens, &Lens::Pinhole);
  ExpectLens(rig.cameras[1], kFisheyeLens, &Lens::Fisheye);
  ExpectLens(rig.cameras[2], kOmniLens, &Lens::Omni);
  EXPECT_LT(
      (*rig.cameras[1].camera_from_rig * Eigen::Vector3d(0.5, 0, 0)).norm(),
      1e-12);
  ExpectError(ExitCode::kInvalidInput, {"f: ", "cam0: ", "'omni'"},
              [&] { Read(TextWith(text, "type: pinhole", "type: omni")); });
}

// Parameters of ROS 2 are in maps of maps, and have shorter names.
TEST(MakeKeyedFormats, ReadVikit) {
  const std::string text =
      "cam_model: Pinhole\ncam_width: 640\ncam_height: 480\nscale: 0.5\n"
      "cam_fx: 410\ncam_fy: 411.5\ncam_cx: 322.5\ncam_cy: 238\n"
      "cam_d0: -0.21\ncam_d1: 0.06\ncam_d2: 0.001\ncam_d3: -0.002\n";
  const auto read = Read(text);
  ExpectLens(read.cameras.at(0), kPinholeLens, &Lens::Pinhole);
  EXPECT_EQ(read.cameras[0].lens.size, kImage);
  EXPECT_TRUE(read.warnings.empty());
  ExpectLens(
      Read("/**:\n  ros__parameters:\n    camera:\n      model: Pinhole\n"
           "      width: 640\n      height: 480\n      scale: 0.5\n"
           "      fx: 410\n      fy: 411.5\n      cx: 322.5\n      cy: 238\n"
           "      d0: -0.21\n      d1: 0.06\n      d2: 0.001\n"
           "      d3: -0.002\n")
          .cameras.at(0),
      kPinholeLens, &Lens::Pinhole);
  const std::string fisheye =
      "cam_model: EquidistantCamera\ncam_width: 640\ncam_height: 480\n"
      "cam_fx: 290\ncam_fy: 291.5\ncam_cx: 322.5\ncam_cy: 238\n"
      "k1: 0.03\nk2: -0.01\nk3: 0.004\nk4: -0.001\n";
  ExpectLens(Read(fisheye).cameras.at(0), kFisheyeLens, &Lens::Fisheye);
  ExpectError(ExitCode::kInvalidInput, {"f: ", "'PinholeAtan'", "supported"},
              [&] { Read(TextWith(text, "Pinhole", "PinholeAtan")); });
  ExpectError(ExitCode::kInvalidInput, {"f: ", "k1"},
              [&] { Read(text + "k1: 0.3\n"); });
}

TEST(MakeKeyedFormats, ReadAssignments) {
  const std::string text =
      "% Intrinsic and Extrinsic Camera Parameters\n\n%-- Focal length:\n"
      "fc = [ 410.0 ; 411.5 ];\ncc = [ 322.5 ; 238.0 ];\nalpha_c = 0.000;\n"
      "kc = [ -0.21 ; 0.06 ; 0.001 ; -0.002 ; 0.0 ];\n"
      "fc_error = [ 1.0 ; NaN ];\nnx = 640;\nny = 480;\n"
      "n_ima = 4;\t\t% Number of images\nomc_1 = [ NaN ; NaN ; NaN ];\n";
  const auto read = Read(text);
  ExpectLens(read.cameras.at(0), kPinholeLens, &Lens::Pinhole);
  EXPECT_EQ(read.cameras[0].lens.size, kImage);
  EXPECT_TRUE(read.warnings.empty());
  ExpectError(ExitCode::kInvalidInput, {"f: ", "'alpha_c'", "0.001"}, [&] {
    Read(TextWith(text, "alpha_c = 0.000", "alpha_c = 0.001"));
  });
  const auto of_side = [](const std::string& side) {
    return "fc" + side + " = [ 410 ; 411.5 ];\ncc" + side +
           " = [ 322.5 ; 238 ];\nalpha_c" + side + " = [ 0.0 ];\nkc" + side +
           " = [ -0.21 ; 0.06 ; 0.001 ; -0.002 ; 0 ];\n";
  };
  const auto pair = Read(of_side("_left") + of_side("_right") +
                             "om = [ 0.0 ; 0.0 ; 1.5707963267948966 ];\n"
                             "T = [ -100.0 ; 0.0 ; 0.0 ];\n",
                         kImage);
  ASSERT_EQ(pair.cameras.size(), 2u);
  ASSERT_TRUE(pair.IsRig());
  EXPECT_EQ(pair.cameras[1].name, "right");
  ExpectLens(pair.cameras[1], kPinholeLens, &Lens::Pinhole);
  EXPECT_LT((*pair.cameras[1].camera_from_rig * Eigen::Vector3d(1, 0, 0) -
             Eigen::Vector3d(-100, 1, 0))
                .norm(),
            1e-12);
  const auto rectified = Read(
      "cam0=[410 0 322.5; 0 410 238; 0 0 1]\n"
      "cam1=[410 0 350; 0 410 238; 0 0 1]\ndoffs=27.5\nbaseline=193.001\n"
      "width=640\nheight=480\nndisp=270\n");
  ASSERT_TRUE(rectified.IsRig());
  EXPECT_TRUE(rectified.warnings.empty());
  EXPECT_EQ(rectified.cameras[1].lens.Value("cx"), 350);
  EXPECT_NEAR(rectified.cameras[1].camera_from_rig->translation.x(), -0.193001,
              1e-12);
}

// Settings of a pair that the program rectifies have another model beside.
TEST(MakeKeyedFormats, ReadRectifiedCamerasOfStella) {
  const auto read = Read(
      "Camera.setup: \"stereo\"\nCamera.model: \"perspective\"\n"
      "Camera.fx: 410\nCamera.fy: 411.5\nCamera.cx: 322.5\nCamera.cy: 238\n"
      "Camera.k1: -0.21\nCamera.k2: 0.06\nCamera.p1: 0.001\n"
      "Camera.p2: -0.002\nCamera.k3: 0\nCamera.cols: 640\nCamera.rows: 480\n"
      "StereoRectifier.model: \"fisheye\"\n"
      "StereoRectifier.K_left: [190, 0, 254, 0, 190, 256, 0, 0, 1]\n"
      "Feature.scale_factor: 1.2\n");
  ExpectLens(read.cameras.at(0), kPinholeLens, &Lens::Pinhole);
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_NE(read.warnings[0].find("StereoRectifier.K_left"), std::string::npos);
}

TEST(Tum, KeepsTheFractionOfStamps) {
  const auto write = [](const std::string& image) {
    PoseTable table;
    table.poses.emplace_back().image = image;
    return FindTableFormat("tum")->write_poses(table).files[0].second;
  };
  for (const char* image : {"1700000000.123456789", "1700000000.123456789.png"})
    EXPECT_NE(write(image).find("\n1700000000.123456789 "), std::string::npos);
  EXPECT_NE(write("1700000000.png").find("\n1700000000 "), std::string::npos);
}

// Poses of TUM have eight numbers a line, too, of which four are a rotation.
TEST(MakeKeyedFormats, TellLinesOfNumbersFromPoses) {
  const auto is_tum = [](const std::string& text) {
    const TableFormat* table = RecognizeTable(text);
    return table && table->name == "tum";
  };
  const std::string line = "410 411.5 322.5 238 -0.21 0.06 0.001 -0.002\n";
  EXPECT_FALSE(is_tum(line));
  EXPECT_FALSE(is_tum(line + "640 480\ncrop\n640 480\n"));
  EXPECT_TRUE(is_tum("1.5 0.1 0.2 0.3 0 0 0.71 0.71\n"));
  const auto dso = Read(line + "640 480\ncrop\n640 480\n");
  ExpectLens(dso.cameras.at(0), kPinholeLens, &Lens::Pinhole);
  EXPECT_EQ(dso.cameras[0].lens.size, kImage);
}

// Both would be cameras of another image.
TEST(MakeKeyedFormats, JudgeLengthsByTheImage) {
  ExpectError(ExitCode::kInvalidInput, {"f: ", "fx 0.64", "fractions"},
              [] { Read("0.64 0.86 0.5 0.5\n", kImage); });
  const std::string line = "410 411.5 322.5 238\n";
  EXPECT_TRUE(Read(line, kImage).warnings.empty());
  for (const ImageSize& size : {ImageSize{480, 640}, ImageSize{1920, 1080}}) {
    const auto read = Read(line, size);
    ASSERT_EQ(read.warnings.size(), 1u) << size.width;
    EXPECT_NE(read.warnings[0].find("far from the centre"), std::string::npos);
  }
}

// Each is refused with one line, or is a camera of numbers.
TEST(MakeKeyedFormats, TakeDamagedFilesForNothingElse) {
  const std::vector<std::string> texts = {
      "%YAML:1.0\n---\nmodel_type: MEI\nimage_width: 640\nimage_height: 480\n"
      "mirror_parameters:\n   xi: 1.25\ndistortion_parameters:\n   k1: -0.1\n"
      "   k2: 0.05\n   p1: 0.001\n   p2: -0.002\nprojection_parameters:\n"
      "   gamma1: 910.\n   gamma2: 911.5\n   u0: 322.5\n   v0: 238.\n",
      "%YAML:1.0\nCamera.type: \"PinHole\"\nCamera1.fx: 410.\n"
      "Camera1.fy: 411.5\nCamera1.cx: 322.5\nCamera1.cy: 238.\n"
      "Camera2.fx: 410.\nCamera2.fy: 411.5\nCamera2.cx: 322.5\n"
      "Camera2.cy: 238.\nCamera.width: 640\nCamera.height:480\nTlr: "
      "!!opencv-matrix\n  rows: 3\n  cols: 4\n  dt: f\n  data:[1, 0, 0, 0.1, "
      "0, 1, 0, 0, 0, 0, 1, 0]\n",
      "T_BS:\n  data: [1, 0, 0, 0.1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n"
      "resolution: [640, 480]\ncamera_model: pinhole\nintrinsics: [410, 411, "
      "322, 238]\ndistortion_model: radtan\ndistortion_coefficients: [-0.2, "
      "0.06, 0.001, -0.002]\n",
      "{\"calib_dimension\": {\"w\": 640, \"h\": 480}, \"fisheye_params\": "
      "{\"camera_matrix\": [[290, 0, 322], [0, 291, 238], [0, 0, 1]], "
      "\"distortion_coeffs\": [0.03, -0.01, 0.004, -0.001]}}\n",
      "[cam_0]\nname = \"A\"\nsize = [ 640, 480,]\nmatrix = [ [ 410, 0.0, "
      "322,],\n  [ 0.0, 411, 238,],\n [ 0.0, 0.0, 1.0,],]\ndistortions = [ "
      "-0.2, 0.06,]\nrotation = [ 0.0, 0.0, 1.57,]\ntranslation = [ 1.0, 2.0, "
      "3.0,]\n",
      "S_00: 640 480\nK_00: 410 0 322 0 411 238 0 0 1\nD_00: -0.2 0.06 0 0 0\n"
      "R_00: 1 0 0 0 1 0 0 0 1\nT_00: 0 0 0\n",
      "410 411.5 322.5 238 -0.21 0.06 0.001 -0.002\n",
      "RadTan 410 411.5 322.5 238 -0.21 0.06 0.001 -0.002\n640 480\nnone\n",
      "[image]\n\nwidth\n640\n\nheight\n480\n\n[front]\n\ncamera matrix\n"
      "410 0 322\n0 411 238\n0 0 1\n\ndistortion\n-0.2 0.06 0 0 0\n",
      "fc = [ 410 ; 411 ];\ncc = [ 322 ; 238 ];\nkc = [ -0.2 ; 0.06 ];\n"
      "nx = 640;\nny = 480;\n",
      "{\"front\": {\"mtx\": [[410, 0, 322], [0, 411, 238], [0, 0, 1]], "
      "\"dist\": [[-0.2, 0.06, 0, 0, 0]], \"image_size\": [640, 480]}}\n"};
  TestRandom random(7);
  int num_refused = 0, num_read = 0;
  for (const std::string& text : texts) {
    const Format* format = RecognizeFormat(text);
    ASSERT_NE(format, nullptr) << text;
    for (int k = NumMutants(150); k-- > 0; ++num_read) {
      const std::string mutant = Mutated(text, &random);
      num_refused += IsRefused([&] {
        ExpectFinite(ReadExchangeFile(format, {"f", mutant, "", kImage}));
      });
    }
  }
  EXPECT_GT(num_refused, num_read / 4);
  EXPECT_LT(num_refused, num_read);
}

// A line of the camera matrix, and of coefficients if there are any.
TEST(MakeKeyedFormats, WriteLinesOfNumbers) {
  const auto written = [](const std::string& line) {
    OutputCamera camera;
    camera.lens = Read(line, kImage).cameras.at(0).lens;
    return FindFormat("--to", "calib-line").write({"calib.txt", {camera}});
  };
  for (const char* line :
       {"410.0 411.5 322.5 238.0\n",
        "410.0 411.5 322.5 238.0 -0.21 0.06 0.001 -0.002\n",
        "410.0 411.5 322.5 238.0 -0.21 0.0 0.0 0.0\n",
        "410.0 411.5 322.5 238.0 -0.21 0.06 0.001 -0.002 0.01\n"})
    EXPECT_EQ(written(line), line);
}

// P = K [I t]: cameras beside each other, which are not turned.
TEST(MakeKeyedFormats, WriteProjectionsOfKitti) {
  const Format& format = FindFormat("--to", "kitti-rectified");
  EXPECT_TRUE(format.supports_rigs);
  WriteRequest request = {"calib.txt", {{}, {}}};
  const auto read = Read("410 410 322.5 238", kImage);
  for (OutputCamera& camera : request.cameras) {
    camera.lens = read.cameras.at(0).lens;
    camera.lens.external_model = &format.external_models.front();
    camera.lens.values.resize(4);
    camera.camera_from_rig = Pose{};
  }
  request.cameras[1].camera_from_rig->translation = {-0.5, 0, 0};
  const std::string text = format.write(request);
  EXPECT_EQ(text,
            "P0: 410.0 0.0 322.5 0.0 0.0 410.0 238.0 0.0 0.0 0.0 1.0 0.0\n"
            "P1: 410.0 0.0 322.5 -205.0 0.0 410.0 238.0 0.0 0.0 0.0 1.0 0.0\n");
  const auto again = Read(text, kImage);
  EXPECT_LT((again.cameras.at(1).camera_from_rig->translation -
             Eigen::Vector3d(-0.5, 0, 0))
                .norm(),
            1e-15);
  request.cameras[1].camera_from_rig->rotation =
      Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitY());
  ExpectError(ExitCode::kInvalidInput, {"rotated", "rectified.yaml"},
              [&] { format.write(request); });
}

}  // namespace
}  // namespace raygrid
