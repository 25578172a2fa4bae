#include "exchange/mrcal_format.h"

#include "support.h"

namespace raygrid {
namespace {

// A file that mrcal 2.2 wrote, with what its solver adds.
constexpr char kMrcal[] =
    "# generated on 2026-11-25 by bob's machine: {'a': (1,\n"
    "{\n    'lensmodel':  'LENSMODEL_OPENCV5',\n\n"
    "    # intrinsics are fx,fy,cx,cy,distortion0,distortion1,....\n"
    "    'intrinsics': [ 500, 501, 320, 240, 0.1, 0.01, 0.001, 0.002, "
    "0.003,],\n\n"
    "    'valid_intrinsics_region': [\n    [ 0, 0 ],\n    [ 600, 0 ],\n"
    "    [ 600, 400 ],\n    [ 0, 0 ],\n],\n\n"
    "    # extrinsics are rt_fromref\n"
    "    'extrinsics': [ 0.1, 0.2, 0.3, 1, 2, 3,],\n\n"
    "    'imagersize': [ 640, 480,],\n\n"
    "    'icam_intrinsics': 0,\n\n"
    "    # The optimization_inputs contain all the data\n"
    "    'optimization_inputs': b'P)h>@6aWYS{}`2mn[],:#\"*&|8<M?',\n\n}\n";

ExchangeContents ParseMrcal(const std::string& text) {
  return ReadExchangeFile(nullptr, {"a.cameramodel", text, "", {}});
}

std::string MrcalWith(const std::string& old, const std::string& by) {
  return TextWith(kMrcal, old, by);
}

TEST(MakeMrcalFormat, ReadsWhatMrcalWrites) {
  const ExchangeContents contents = ParseMrcal(kMrcal);
  ASSERT_EQ(contents.cameras.size(), 1u);
  const InputCamera& camera = contents.cameras[0];
  EXPECT_EQ(camera.lens.external_model->name, "LENSMODEL_OPENCV5");
  EXPECT_EQ(camera.lens.values,
            (std::vector<double>{500, 501, 320, 240, 0.1, 0.01, 0.001, 0.002,
                                 0.003}));
  ASSERT_TRUE(camera.camera_from_rig);
  EXPECT_EQ(camera.camera_from_rig->translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_LT(camera.camera_from_rig->rotation.angularDistance(
                RotationFromVector({0.1, 0.2, 0.3})),
            1e-12);
  EXPECT_TRUE(contents.warnings.empty());
  ASSERT_TRUE(camera.valid_region);
  EXPECT_TRUE(camera.valid_region->IsValidAt({500, 200}));
  EXPECT_FALSE(camera.valid_region->IsValidAt({200, 300}));
  EXPECT_FALSE(camera.valid_region->IsValidAt({630, 200}));
  const CameraFile file = MakeCameraFile(camera);
  EXPECT_EQ(file.uncertainty->mask.is_valid, camera.valid_region->is_valid);
  EXPECT_FALSE(file.uncertainty->HasStdDevs());
}

TEST(MakeMrcalFormat, ReadsTheNamesOfOldVersions) {
  const std::string old = MrcalWith("'lensmodel':  'LENSMODEL_",
                                    "'distortion_model':  'DISTORTION_");
  EXPECT_EQ(ParseMrcal(old).cameras.at(0).lens.values,
            ParseMrcal(kMrcal).cameras[0].lens.values);
  EXPECT_TRUE(ParseMrcal(old).warnings.empty());
  const std::string none = TextWith(TextWith(old, "OPENCV5", "NONE"),
                                    "0.1, 0.01, 0.001, 0.002, 0.003,", "");
  EXPECT_EQ(ParseMrcal(none).cameras.at(0).lens.external_model->name,
            "LENSMODEL_PINHOLE");
  ExpectError(ExitCode::kInvalidInput, {"CAHVOR"},
              [&] { ParseMrcal(TextWith(old, "OPENCV5", "CAHVOR")); });
}

TEST(MakeMrcalFormat, TellsWhatCanBeTrusted) {
  const std::string key = "'valid_intrinsics_region'";
  EXPECT_FALSE(ParseMrcal(MrcalWith(key, "'other'")).cameras[0].valid_region);
  OutputCamera camera;
  camera.lens = ParseMrcal(kMrcal).cameras[0].lens;
  const auto written = [&] {
    return FindFormat("--to", "mrcal").write({"a.cameramodel", {camera}});
  };
  EXPECT_EQ(written().find(key), std::string::npos);
  ValidityMask mask = ValidityMask::Over({640, 480});
  for (const size_t num_trusted : {size_t{0}, mask.is_valid.size() / 2}) {
    std::fill_n(mask.is_valid.begin(), num_trusted, true);
    camera.valid_region = mask;
    const InputCamera read = ParseMrcal(written()).cameras[0];
    ASSERT_TRUE(read.valid_region);
    EXPECT_EQ(read.valid_region->is_valid, mask.is_valid);
  }
}

TEST(MakeMrcalFormat, PrefersThePoseThatLaterVersionsAdd) {
  const ExchangeContents contents = ParseMrcal(
      MrcalWith("    'imagersize'",
                "    'rt_cam_ref': (0, 0, 0, 4, 5, 6),\n    'imagersize'"));
  EXPECT_EQ(contents.cameras[0].camera_from_rig->translation,
            Eigen::Vector3d(4, 5, 6));
}

// mrcal has the lens before the control points, raygrid behind them.
TEST(MakeMrcalFormat, ReadsSplines) {
  std::string numbers = "300, 301, 320, 240";
  for (int k = 0; k < 32; ++k) numbers += ", 0.0" + std::to_string(10 + k);
  const std::string text =
      "{'lensmodel': "
      "'LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=4_Ny=4_fov_x_deg=150',\n"
      "'intrinsics': [" +
      numbers + "], 'imagersize': [640, 480]}\n";
  const ConvertedCamera lens = ParseMrcal(text).cameras[0].lens;
  ASSERT_TRUE(lens.spline);
  EXPECT_EQ(lens.spline->grid().fov_x_deg, 150);
  EXPECT_EQ(lens.spline->surface().points()[1], Eigen::Vector2d(0.012, 0.013));
  EXPECT_EQ(lens.spline->Parameters().tail<4>(),
            Eigen::Vector4d(300, 301, 320, 240));
  const auto refused = [&](const std::string& old, const std::string& by,
                           const std::vector<std::string>& words) {
    ExpectError(ExitCode::kInvalidInput, words,
                [&] { ParseMrcal(TextWith(text, old, by)); });
  };
  refused("order=3", "order=2", {"only splines of order 3"});
  refused("Nx=4", "Nx=5", {"expected 44 numbers, found 36"});
  refused("Nx=4", "Nx=99999", {"Nx=99999", "expected the form LENSMODEL"});
  refused("Nx=4", "Nx=3", {"4 to 1027"});
  refused("=150", "=360", {"fov_x_deg"});
  refused("0.010", ".nan", {"intrinsics", "expected a finite number"});
  refused("300", "-300", {"focal length"});
}

TEST(MakeMrcalFormat, RefusesInOneLine) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> cases = {
      {MrcalWith("OPENCV5", "CAHVOR"),
       {"a.cameramodel", "LENSMODEL_CAHVOR", "LENSMODEL_OPENCV8"}},
      {MrcalWith("OPENCV5", "OPENCV8"),
       {"OPENCV8", "expected 12 numbers, found 9"}},
      {MrcalWith("0.003", "nan"), {"intrinsics", "expected a finite number"}},
      {MrcalWith(", 480", ""), {"imagersize", "width and height"}},
      {MrcalWith("'imagersize'", "'size'"), {"imagersize"}},
      {MrcalWith("1, 2, 3", "1, 2"), {"extrinsics", "6 numbers"}},
      {MrcalWith("1, 2, 3", "1, 2, inf"), {"extrinsics"}},
      {MrcalWith("[ 600, 0 ]", "[ 600 ]"), {"valid_intrinsics_region"}},
      {MrcalWith("[ 600, 0 ]", "[ 600, nan ]"), {"valid_intrinsics_region"}},
      {MrcalWith("    [ 600, 0 ],\n    [ 600, 400 ],\n", ""),
       {"valid_intrinsics_region", "3 points"}}};
  for (const auto& [text, words] : cases)
    ExpectError(ExitCode::kInvalidInput, words,
                [&, &text = text] { ParseMrcal(text); });
  const std::string whole = kMrcal;
  for (size_t size = 160; size + 2 < whole.size(); size += 7)
    EXPECT_THROW(ParseMrcal(whole.substr(0, size)), InputError) << size;
}

}  // namespace
}  // namespace raygrid
