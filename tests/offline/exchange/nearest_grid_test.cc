/// Lenses that no model of raygrid has, against formulas.
#include <fmt/format.h>

#include <cmath>
#include <sstream>

#include "camera/model_registry.h"
#include "exchange/damaged_files.h"
#include "exchange/format.h"
#include "exchange/lenses_by_formula.h"
#include "support.h"

namespace raygrid {
namespace {

// OCamCalib: rows are x, columns y, and the polynomial of the radius is z.
TEST(MakeOcamCalibFormat, IsReadAsItsGrid) {
  const std::string text =
      "#polynomial coefficients for the DIRECT mapping function (ocam_model.ss "
      "in MATLAB). These are used by cam2world\n\n4 -180.0 0.0 0.0016 1e-06 "
      "\n\n#polynomial coefficients for the inverse mapping function\n\n3 250 "
      "140 10 \n\n#center: \"row\" and \"column\", starting from 0 (C "
      "convention)\n\n238.5 322.25\n\n#affine parameters \"c\", \"d\", \"e\""
      "\n\n0.9998 0.0004 -0.0003\n\n#image size: \"height\" and \"width\"\n\n"
      "480 640\n\n";
  const auto read = Read(text);
  EXPECT_EQ(read.cameras.at(0).lens.size, kImage);
  EXPECT_NE(read.warnings.at(0).find("RMS 0.00"), std::string::npos);
  const auto grid = MakeCameraModel(read.cameras[0].lens);
  for (const double x : {-150.0, 30.0, 140.0})
    for (const double y : {-120.0, 20.0, 190.0}) {
      const double r2 = x * x + y * y, r = std::sqrt(r2);
      const Eigen::Vector3d ray(y, x, 180 - 0.0016 * r2 - 1e-6 * r2 * r);
      const Eigen::Vector2d pixel(-0.0003 * x + y + 322.25,
                                  0.9998 * x + 0.0004 * y + 238.5);
      EXPECT_LT((grid->Project(ray).value() - pixel).norm(), 0.01);
    }
  ExpectError(ExitCode::kInvalidInput, {"f: ", "affine"},
              [&] { Read(text.substr(0, text.find("0.9998"))); });
}

// The file's numbers by the formulas of OCamCalib's cam2world() and world2cam()
// against the camera that was exported.
TEST(MakeOcamCalibFormat, WritesTheNearestPolynomial) {
  const Lens lens = {{290, 291.5, 322.5, 238}, {0.03, -0.01, 0.004, -0.001}};
  const auto camera = FindModelInfo("thin-prism-fisheye")
                          ->make(kImage, WholeImage(kImage),
                                 (Eigen::VectorXd(12) << 290, 291.5, 322.5, 238,
                                  0.03, -0.01, 0.004, -0.001, 0, 0, 0, 0)
                                     .finished());
  const Format& format = FindFormat("--to", "ocamcalib");
  const SelectedModel chosen =
      SelectExternalModel(format.FindModels(""), *camera, nullptr);
  ASSERT_TRUE(chosen.fit);
  EXPECT_LT(chosen.fit->max_px, 0.05);
  EXPECT_EQ(chosen.fit->num_unrepresentable, 0u);
  OutputCamera written;
  written.lens = chosen.lens;
  written.fit = chosen.fit;
  const std::string text = format.write({"calib_results.txt", {written}});
  EXPECT_NE(text.find("#fitted polynomial: RMS "), std::string::npos);
  std::string numbers;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (line[0] != '#') numbers += line + "\n";
  std::istringstream words(numbers);
  const auto list = [&] {
    size_t count = 0;
    words >> count;
    std::vector<double> values(count);
    for (double& value : values) words >> value;
    return values;
  };
  const std::vector<double> direct = list(), inverse = list();
  double row = 0, column = 0, c = 0, d = 0, e = 0, height = 0, width = 0;
  words >> row >> column >> c >> d >> e >> height >> width;
  EXPECT_EQ(Eigen::Vector2d(width, height), Eigen::Vector2d(640, 480));
  const auto at = [](const std::vector<double>& polynomial, double x) {
    double sum = 0;
    for (size_t k = 0; k < polynomial.size(); ++k)
      sum += polynomial[k] * std::pow(x, k);
    return sum;
  };
  const Eigen::Quaterniond turn = chosen.fit->fitted_from_camera;
  for (double x = 5; x < 640; x += 45)
    for (double y = 5; y < 480; y += 45) {
      const Eigen::Vector3d ray = turn * camera->Unproject({x, y}).value();
      const double theta = std::atan2(-ray.z(), ray.head<2>().norm());
      const Eigen::Vector2d radial =
          ray.head<2>().normalized() * at(inverse, theta);
      const Eigen::Vector2d pixel(e * radial.y() + radial.x() + column,
                                  c * radial.y() + d * radial.x() + row);
      EXPECT_LT((pixel - Eigen::Vector2d(x, y)).norm(), 0.06);
      const double across = radial.norm();
      const Eigen::Vector3d back(radial.x(), radial.y(), -at(direct, across));
      EXPECT_LT((back.normalized() - ray).norm(), 0.06 / 290);
    }
  ExpectLens(Read(text).cameras.at(0), lens, &Lens::Fisheye, 0.1);
}

TEST(MakeDsoFormat, WritesItsModels) {
  const Format& format = FindFormat("--to", "dso");
  const auto written = [&](const std::string& line) {
    const auto read = Read(line + "\n640 480\ncrop\n640 480\n");
    OutputCamera camera;
    camera.lens = read.cameras.at(0).lens;
    return format.write({"camera.txt", {camera}});
  };
  EXPECT_EQ(written("RadTan 410 411.5 322.5 238 -0.21 0.06 0.001 -0.002"),
            "RadTan 410.0 411.5 322.5 238.0 -0.21 0.06 0.001 -0.002\n640 480\n"
            "crop\n640 480\n");
  // The five numbers of a pinhole are those of FOV without its angle.
  EXPECT_EQ(written("Pinhole 400 360 319.5 239.5 0"),
            "Pinhole 400.0 360.0 319.5 239.5 0.0\n640 480\nnone\n640 480\n");
}

TEST(MakeDsoFormat, ReadsItsModels) {
  const auto lens = [](const std::string& line) {
    return Read(line + "\n640 480\ncrop\n640 480\n").cameras.at(0);
  };
  ExpectLens(lens("RadTan 410 411.5 322.5 238 -0.21 0.06 0.001 -0.002"),
             kPinholeLens, &Lens::Pinhole);
  ExpectLens(lens("EquiDistant 290 291.5 322.5 238 0.03 -0.01 0.004 -0.001"),
             kFisheyeLens, &Lens::Fisheye);
  // Parts of the image, whose first pixel begins at 0.
  ExpectLens(lens("Pinhole 0.625 0.75 0.5 0.5 0"),
             {{400, 360, 319.5, 239.5}, {}}, &Lens::Pinhole);
  const double omega = 0.92;
  const auto fov = MakeCameraModel(lens("0.625 0.75 0.5 0.5 0.92").lens);
  for (const double x : {-0.6, 0.1, 0.7}) {
    const Eigen::Vector2d xy(x, 0.3);
    const double bent =
        std::atan(2 * xy.norm() * std::tan(omega / 2)) / omega / xy.norm();
    const Eigen::Vector2d pixel(400 * x * bent + 319.5,
                                360 * 0.3 * bent + 239.5);
    EXPECT_LT((fov->Project({x, 0.3, 1}).value() - pixel).norm(), 0.01);
  }
}

// No lens of raygrid has a skew; the grid's error is stated.
TEST(FitNearestGrid, StandsForALensWithASkew) {
  const auto check = [](const std::string& text, const Lens& lens,
                        Formula formula) {
    const auto read = Read(text, kImage);
    EXPECT_EQ(read.cameras.at(0).lens.external_model->model, "central-generic");
    ASSERT_FALSE(read.warnings.empty());
    EXPECT_NE(read.warnings.back().find("fit error RMS 0.00"),
              std::string::npos)
        << read.warnings.back();
    ExpectLens(read.cameras[0], lens, formula, 0.01);
  };
  Lens pinhole = kPinholeLens, fisheye = kFisheyeLens;
  pinhole.k.push_back(2.5);
  fisheye.k.push_back(-1.5);
  check(
      "{\"K\": [[410, 2.5, 322.5], [0, 411.5, 238], [0, 0, 1]], \"dist\": "
      "[-0.21, 0.06, 0.001, -0.002, 0]}",
      pinhole, &Lens::Pinhole);
  check(
      "{\"K\": [[290, -1.5, 322.5], [0, 291.5, 238], [0, 0, 1]], \"D\": "
      "[[0.03], [-0.01], [0.004], [-0.001]]}",
      fisheye, &Lens::Fisheye);
  check(
      "camera_matrix:\n  rows: 3\n  cols: 3\n  data: [410, 2.5, 322.5, 0, "
      "411.5, 238, 0, 0, 1]\ndistortion_model: plumb_bob\n"
      "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [-0.21, 0.06, "
      "0.001, -0.002, 0]\n",
      pinhole, &Lens::Pinhole);
}

}  // namespace
}  // namespace raygrid
