/// Dictionaries of Python that hold cameras, against formulas.
#include <fmt/format.h>

#include <cmath>

#include "exchange/damaged_files.h"
#include "exchange/format.h"
#include "exchange/lenses_by_formula.h"
#include "support.h"

namespace raygrid {
namespace {

TEST(MakePythonFormat, ReadsListsUnderTheNamesThatPeopleGive) {
  const std::string k = "[[410, 0, 322.5], [0, 411.5, 238], [0, 0, 1]]";
  const std::string d = "[[-0.21, 0.06, 0.001, -0.002, 0.0]]";
  for (const auto& [matrix, distortion] :
       std::vector<std::array<std::string, 2>>{
           {"K", "D"},
           {"mtx", "dist"},
           {"camera_matrix", "dist_coeff"},
           {"camera_matrix", "dist_coeffs"},
           {"cameraMatrix", "distCoeffs"}}) {
    const std::string json =
        fmt::format("{{\"{}\": {}, \"{}\": {}, \"image_size\": [640, 480]}}\n",
                    matrix, k, distortion, d);
    SCOPED_TRACE(json);
    ExpectLens(Read(json).cameras.at(0), kPinholeLens, &Lens::Pinhole);
    const std::string yaml =
        fmt::format("{}: {}\n{}: {}\n", matrix, k, distortion, d);
    ExpectLens(Read(yaml, kImage).cameras.at(0), kPinholeLens, &Lens::Pinhole);
  }
  const auto named = Read(
      fmt::format("{{\"front\": {{\"K\": {0}, \"D\": {1}}}, \"back\": {{\"K\": "
                  "{0}, \"D\": {1}}}}}",
                  k, d),
      kImage);
  ASSERT_EQ(named.cameras.size(), 2u);
  EXPECT_EQ(named.cameras[1].name, "back");
  const auto scalars = Read(
      "{\"fx\": 410, \"fy\": 411.5, \"cx\": 322.5, \"cy\": 238, \"k1\": -0.21, "
      "\"k2\": 0.06, \"p1\": 0.001, \"p2\": -0.002, \"k3\": 0, \"width\": 640, "
      "\"height\": 480}");
  ExpectLens(scalars.cameras.at(0), kPinholeLens, &Lens::Pinhole);
}

TEST(MakePythonFormat, ReadsSizesOfAnyForm) {
  for (const char* size : {"\"DIM\": [640, 480]", "\"resolution\": \"640x480\"",
                           "\"imageSize\": {\"width\": 640, \"height\": 480}"})
    ExpectLens(
        Read(fmt::format("{{\"K\": [[410, 0, 322.5], [0, 411.5, 238], [0, 0, "
                         "1]], \"D\": [-0.21, 0.06, 0.001, -0.002, 0], {}}}",
                         size))
            .cameras.at(0),
        kPinholeLens, &Lens::Pinhole);
  EXPECT_THROW(Read("{\"K\": [410, 0, 322, 0, 411, 238, 0, 0, 1], \"D\": [0, "
                    "0, 0, 0], \"resolution\": \"640xtall\"}"),
               Error);
}

// The keys of a camera around its intrinsics are read, or named.
TEST(MakePythonFormat, ReadsKeysAroundTheIntrinsics) {
  const auto file = [](const std::string& keys) {
    return Read(fmt::format(
        "{{\"cameras\": [{{\"camera_id\": \"C7\", \"resolution\": [640, 480], "
        "\"intrinsics\": {{\"camera_matrix\": [410, 0, 322.5, 0, 411.5, 238, "
        "0, 0, 1], \"distortion_coefficients\": [0.02, -0.01, 0.004, 0]}}, "
        "{}}}]}}",
        keys));
  };
  const auto read = file("\"extrinsics\": {\"view_matrix\": [1, 0]}");
  ASSERT_EQ(read.cameras.size(), 1u);
  EXPECT_EQ(read.cameras[0].name, "C7");
  EXPECT_EQ(read.cameras[0].lens.external_model->model, "opencv");
  ASSERT_FALSE(read.warnings.empty());
  EXPECT_NE(read.warnings.back().find("extrinsics"), std::string::npos);
  EXPECT_EQ(file("\"camera_model\": \"fisheye\"")
                .cameras[0]
                .lens.external_model->model,
            "thin-prism-fisheye");
}

TEST(MakePythonFormat, ReadsToml) {
  const std::string lens =
      "camera_matrix = [[410, 0, 322.5], [0, 411.5, 238], [0, 0, 1]]\n"
      "distortion = [-0.21, 0.06, 0.001, -0.002, 0.0]\nsize = [640, 480]\n";
  ExpectLens(Read(lens).cameras.at(0), kPinholeLens, &Lens::Pinhole);
  const auto named = Read("# two\n[left]\n" + lens + "\n[right]\n" + lens);
  ASSERT_EQ(named.cameras.size(), 2u);
  EXPECT_EQ(named.cameras[1].name, "right");
  ExpectLens(named.cameras[1], kPinholeLens, &Lens::Pinhole);
}

// Cameras stand in maps of maps, in lists with names, and in pairs.
TEST(MakePythonFormat, FindsCameras) {
  const std::string lens =
      "\"K\": [[410, 0, 322.5], [0, 411.5, 238], [0, 0, 1]], \"dist\": "
      "[-0.21, 0.06, 0.001, -0.002, 0]";
  const auto listed = Read("{\"cameras\": [{\"name\": \"left\", " + lens +
                               "}, {\"name\": \"right\", " + lens + "}]}",
                           kImage);
  ASSERT_EQ(listed.cameras.size(), 2u);
  EXPECT_EQ(listed.cameras[1].name, "right");
  ExpectLens(listed.cameras[1], kPinholeLens, &Lens::Pinhole);
  const std::string matrix = "[[410, 0, 322.5], [0, 411.5, 238], [0, 0, 1]]";
  const auto pair = Read(
      "{\"left_camera_matrix\": " + matrix +
          ", \"right_camera_matrix\": " + matrix +
          ", \"left_dist_coeffs\": [[0, 0, 0, 0, 0.1]], "
          "\"right_dist_coeffs\": [[0, 0, 0, 0, 0.1]], \"R\": [[1, 0, 0], [0, "
          "1, 0], [0, 0, 1]], \"T\": [[-0.1], [0], [0]]}",
      kImage);
  ASSERT_EQ(pair.cameras.size(), 2u);
  ASSERT_TRUE(pair.IsRig());
  EXPECT_EQ(pair.cameras[1].camera_from_rig->translation.x(), -0.1);
  // RealSense: a model that its zeros do not need.
  const std::string real =
      "{\"intrinsics\": {\"fx\": 410, \"fy\": 411.5, \"ppx\": 322.5, "
      "\"ppy\": 238, \"width\": 640, \"height\": 480, \"model\": "
      "\"distortion.inverse_brown_conrady\", \"coeffs\": [0, 0, 0, 0, 0]}}";
  ExpectLens(Read(real).cameras.at(0), {{410, 411.5, 322.5, 238}, {}},
             &Lens::Pinhole);
  ExpectError(ExitCode::kInvalidInput, {"f: ", "inverse_brown_conrady"},
              [&] { Read(TextWith(real, "[0, 0,", "[0.1, 0,")); });
  ExpectError(ExitCode::kInvalidInput, {"f: ", "modified_brown_conrady"}, [&] {
    Read(TextWith(TextWith(real, "inverse", "modified"), "[0, 0,", "[0.1, 0,"));
  });
}

// Those that are missing are 0; k3 and k4 are no tangential ones.
TEST(MakePythonFormat, ReadsCoefficientsByTheirNames) {
  const auto with = [](const std::string& coefficients) {
    return Read("{\"fx\": 410, \"fy\": 411.5, \"cx\": 322.5, \"cy\": 238, " +
                coefficients + ", \"width\": 640, \"height\": 480}");
  };
  const Numbers k = {410, 411.5, 322.5, 238};
  for (const auto& [text, d] : std::vector<std::pair<const char*, Numbers>>{
           {"\"k1\": -0.1", {-0.1}},
           {"\"k1\": -0.21, \"k2\": 0.06", {-0.21, 0.06}},
           {"\"k1\": -0.21, \"k2\": 0.06, \"k3\": 0.01",
            {-0.21, 0.06, 0, 0, 0.01}},
           {"\"k1\": 0.1, \"p1\": 0.001, \"p2\": 0.002", {0.1, 0, 1e-3, 2e-3}},
           {"\"k1\": 0.1, \"k4\": 0.2, \"p1\": 0.001, \"p2\": 0.002",
            {0.1, 0, 1e-3, 2e-3, 0, 0.2}}}) {
    const auto read = with(text);
    SCOPED_TRACE(text);
    ExpectLens(read.cameras.at(0), {k, d}, &Lens::Pinhole);
    EXPECT_TRUE(read.warnings.empty());
  }
  const auto fisheye =
      with("\"k1\": 0.03, \"k2\": -0.01, \"k3\": 0.004, \"k4\": -0.001");
  ExpectLens(fisheye.cameras.at(0), {k, kFisheyeLens.d}, &Lens::Fisheye);
  EXPECT_EQ(fisheye.warnings.size(), 1u);
  ExpectError(ExitCode::kInvalidInput, {"f: ", "cv::fisheye", "'model'"}, [&] {
    with(
        "\"k1\": 0.03, \"k2\": -0.01, \"k3\": 0.004, \"k4\": -0.001, "
        "\"model\": \"pinhole\"");
  });
}

TEST(MakePythonFormat, ReadsIntrinsicsAsFourNumbers) {
  const auto read = Read(
      "intrinsics: [410, 411.5, 322.5, 238]\nresolution: [640, 480]\n"
      "distortion: [-0.21, 0.06, 0.001, -0.002, 0]\n");
  ExpectLens(read.cameras.at(0), kPinholeLens, &Lens::Pinhole);
}

// A sensor's or renderer's camera, row by row or column by column.
TEST(MakePythonFormat, TakesCamerasWithoutDistortion) {
  for (const char* text :
       {"{\"fx\": 410, \"fy\": 411.5, \"ppx\": 322.5, \"ppy\": 238, "
        "\"width\": 640, \"height\": 480}",
        "{\"intrinsic_matrix\": [410, 0, 0, 0, 411.5, 0, 322.5, 238, 1], "
        "\"width\": 640, \"height\": 480}"}) {
    const auto read = Read(text);
    ExpectLens(read.cameras.at(0), {{410, 411.5, 322.5, 238}, {}},
               &Lens::Pinhole);
    ASSERT_EQ(read.warnings.size(), 1u);
    EXPECT_NE(read.warnings[0].find("no distortion"), std::string::npos);
  }
  // It may have coefficients under a name that is not known.
  ExpectError(ExitCode::kInvalidInput,
              {"f: ", "'distortion_coefficients' is missing"}, [] {
                Read(
                    "{\"K\": [[410, 0, 322.5], [0, 411.5, 238], [0, 0, 1]], "
                    "\"width\": 640, \"height\": 480, \"distort_params\": "
                    "[0.1, 0.2, 0, 0, 0]}");
              });
}

// Names of makers are no models, and numbers may be repeated.
TEST(MakePythonFormat, KnowsWhatSaysNothingOfTheLens) {
  const std::string text =
      "{\"K\": [[410, 0, 322.5], [0, 411.5, 238], [0, 0, 1]], \"dist\": "
      "[-0.21, 0.06, 0.001, -0.002, 0], \"width\": 640, \"height\": 480, "
      "\"camera_model\": \"OmniVision OV5640\", \"model\": \"oCam-1CGN\", "
      "\"k1\": -0.21, \"alpha\": 1.0}";
  const auto read = Read(text);
  ExpectLens(read.cameras.at(0), kPinholeLens, &Lens::Pinhole);
  ASSERT_EQ(read.warnings.size(), 1u);
  for (const char* word : {"camera_model", "alpha"})
    EXPECT_NE(read.warnings[0].find(word), std::string::npos);
  ExpectError(ExitCode::kInvalidInput, {"f: ", "'k1'"},
              [&] { Read(TextWith(text, "\"k1\": -0.21", "\"k1\": -0.3")); });
  for (const char* other : {"inverse_brown_conrady", "Scaramuzza", "division"})
    ExpectError(ExitCode::kInvalidInput, {"f: ", other},
                [&] { Read(TextWith(text, "OmniVision OV5640", other)); });
}

// A column of 4, as cv2.fisheye alone returns it.
TEST(MakePythonFormat, TellsFisheyes) {
  const std::string text =
      "{\"K\": [[290, 0, 322.5], [0, 291.5, 238], [0, 0, 1]], \"D\": [[0.03], "
      "[-0.01], [0.004], [-0.001]], \"dim\": [640, 480]}";
  const auto read = Read(text, kImage);
  ExpectLens(read.cameras.at(0), kFisheyeLens, &Lens::Fisheye);
  EXPECT_EQ(read.warnings.size(), 1u);
  const std::string row = TextWith(text, "[[0.03], [-0.01], [0.004], [-0.001]]",
                                   "[0.03, -0.01, 0.004, -0.001]");
  EXPECT_EQ(Read(row, kImage).cameras.at(0).lens.external_model->name,
            "opencv4");
  EXPECT_EQ(
      Read(row, kImage, "fisheye").cameras.at(0).lens.external_model->name,
      "fisheye");
  for (const char* key : {"model", "type", "lens_type", "distortion_type"}) {
    const std::string said = TextWith(
        row, "\"dim\"", fmt::format("\"{}\": \"fisheye\", \"d\"", key));
    EXPECT_EQ(Read(said, kImage).cameras.at(0).lens.external_model->name,
              "fisheye");
  }
}

}  // namespace
}  // namespace raygrid
