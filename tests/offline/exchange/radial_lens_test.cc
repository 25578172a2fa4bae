/// Polynomials of the radius, as Lensfun and Gyroflow have them, against their
/// formulas.
#include <fmt/format.h>

#include <cmath>

#include "exchange/damaged_files.h"
#include "exchange/format.h"
#include "exchange/lenses_by_formula.h"
#include "support.h"

namespace raygrid {
namespace {

// A rectilinear lens whose radius r becomes r times a factor.
template <typename Factor>
void ExpectRadial(const InputCamera& read, const Numbers& k,
                  const Factor& factor, double tolerance_px) {
  const auto model = MakeCameraModel(read.lens);
  for (const double x : {-0.25, 0.02, 0.2})
    for (const double y : {-0.18, 0.01, 0.12}) {
      const auto seen = model->Project({x, y, 1});
      ASSERT_TRUE(seen) << x << " " << y;
      const Eigen::Vector2d pixel =
          AtPixel(Eigen::Vector2d(x, y) * factor(std::hypot(x, y)), k);
      EXPECT_LT((*seen - pixel).norm(), tolerance_px) << x << " " << y;
    }
}

std::string GyroflowProfile(const std::string& model,
                            const std::string& coefficients) {
  return fmt::format(
      "{{\"calib_dimension\": {{\"w\": 640, \"h\": 480}}, "
      "\"distortion_model\": \"{}\", \"fisheye_params\": "
      "{{\"camera_matrix\": [[500, 0, 322.5], [0, 501, 238], [0, 0, 1]], "
      "\"distortion_coeffs\": [{}]}}}}\n",
      model, coefficients);
}

TEST(RadialModel, ReadsGyroflow) {
  const Numbers k = {500, 501, 322.5, 238};
  const auto exact = Read(GyroflowProfile("poly3", "-0.08"));
  EXPECT_TRUE(exact.warnings.empty());
  ExpectRadial(
      exact.cameras.at(0), k, [](double r) { return 1 - 0.08 * r * r; }, 1e-9);
  ExpectRadial(
      Read(GyroflowProfile("poly5", "-0.08, 0.02, 0, 0")).cameras.at(0), k,
      [](double r) { return 1 - 0.08 * r * r + 0.02 * std::pow(r, 4); }, 1e-9);
  const auto grid = Read(GyroflowProfile("ptlens", "0.02, -0.09, 0.03"));
  ASSERT_EQ(grid.warnings.size(), 1u);
  EXPECT_NE(grid.warnings[0].find("RMS 0.00"), std::string::npos);
  ExpectRadial(
      grid.cameras.at(0), k,
      [](double r) {
        return 1 + 0.03 * r - 0.09 * r * r + 0.02 * std::pow(r, 3);
      },
      0.01);
  ExpectError(ExitCode::kInvalidInput, {"f: ", "skew"}, [] {
    Read(TextWith(GyroflowProfile("ptlens", "0.02, -0.09, 0.03"), "[[500, 0,",
                  "[[500, 1,"));
  });
}

// f: mm at a sensor of crop factor 1.5; the polynomial's unit is half the
// smaller side of the calibration's 3:2 images.
TEST(RadialModel, ReadsLensfun) {
  const std::string text =
      "<lensdatabase version=\"1\"><lens><maker>a</maker><model>b c</model>"
      "<mount>d</mount><cropfactor>1.5</cropfactor><calibration><distortion "
      "model=\"poly3\" focal=\"20\" k1=\"-0.05\"/></calibration></lens>"
      "</lensdatabase>\n";
  const auto read = Read(text, kImage);
  EXPECT_EQ(read.cameras.at(0).name, "b c");
  EXPECT_TRUE(read.warnings.empty());
  const double mm = std::hypot(36, 24) / 1.5,
               f = 20 * std::hypot(639, 479) / mm,
               unit = mm / 2 / std::hypot(1, 1.5) / 20;
  ExpectRadial(
      read.cameras[0], {f, f, 319.5, 239.5},
      [&](double r) { return 1.05 - 0.05 * std::pow(r / unit, 2); }, 1e-9);
  // A camera of another crop factor sees another part of the lens.
  const auto cut = Read(TextWith(text, "<lens>",
                                 "<camera><maker>a</maker><model>e</model>"
                                 "<cropfactor>3</cropfactor></camera><lens>"),
                        kImage);
  ExpectRadial(
      cut.cameras.at(0), {2 * f, 2 * f, 319.5, 239.5},
      [&](double r) { return 1.05 - 0.05 * std::pow(r / unit, 2); }, 1e-9);
  const auto zoom =
      Read(TextWith(text, "<distortion",
                    "<distortion model=\"none\" focal=\"35\"/><distortion"),
           kImage);
  ASSERT_EQ(zoom.cameras.size(), 2u);
  EXPECT_EQ(zoom.cameras[0].name, "b-c-35mm");
  for (const auto& [old, by, word] : std::vector<std::array<const char*, 3>>{
           {"poly3", "acm", "'acm'"},
           {"<mount>d</mount>", "<type>panoramic</type>", "'panoramic'"},
           {"1.5", "0", "cropfactor"},
           {"focal=\"20\"", "", "focal length"},
           {"-0.05", "1.5", "image centre"},
           {"-0.05", "nan", "k1"},
           {"<calibration>", "<aspect-ratio>2:3</aspect-ratio><calibration>",
            "aspect-ratio"}})
    ExpectError(ExitCode::kInvalidInput, {"f: ", word},
                [&, &o = old, &b = by] { Read(TextWith(text, o, b), kImage); });
  ExpectError(ExitCode::kInvalidInput, {"f: ", "--image-size"},
              [&] { Read(text); });
}

}  // namespace
}  // namespace raygrid
