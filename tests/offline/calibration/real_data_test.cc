// Held-out error on photographs, if they lie beside the project.

#include <cstdio>
#include <filesystem>
#include <opencv2/calib3d.hpp>

#include "calibration/calibration.h"
#include "calibration/camera_evaluation.h"
#include "dataset/csv.h"
#include "dataset/files.h"
#include "support.h"

namespace raygrid {
namespace {

struct RealData {
  Dataset training, test;
  Pattern pattern;
};

std::string Folder() {
  return std::string(RAYGRID_REAL_DATA) + "/stereo_left/";
}

bool HasReachedView() {
  for (const char* name : {"features.csv", "split.csv", "pattern.yaml"})
    if (!std::filesystem::exists(Folder() + name)) return false;
  return true;
}

RealData ReadRealData() {
  RealData data;
  data.pattern = ReadPattern(Folder() + "pattern.yaml");
  const std::string split_path = Folder() + "split.csv";
  const std::string split_text = ReadFile(split_path);
  CsvReader split(split_path, split_text, {"image", "part"});
  std::map<std::string, std::string> part;
  while (split.Next()) part[split.Text("image")] = split.Text("part");
  data.training.image_size = data.test.image_size = {640, 480};
  const auto datasets = ReadFeatures(Folder() + "features.csv");
  for (const ImageFeatures& image : datasets.at("").images)
    (part.at(image.image) == "test" ? data.test : data.training)
        .images.push_back(image);
  return data;
}

// By OpenCV alone, with a flat board.
OpenCvModel CalibrateByOpenCv(const RealData& data, int flags) {
  std::vector<std::vector<cv::Point3f>> points;
  std::vector<std::vector<cv::Point2f>> pixels;
  for (const ImageFeatures& image : data.training.images) {
    points.emplace_back();
    pixels.emplace_back();
    const Board& board = data.pattern.boards[0];
    for (const Feature& f : image.features) {
      points.back().emplace_back(f.column * board.square_m,
                                 f.row * board.square_m, 0);
      pixels.back().emplace_back(f.pixel.x(), f.pixel.y());
    }
  }
  cv::Matx33d k;
  cv::Mat d;
  std::vector<cv::Mat> rotations, translations;
  cv::calibrateCamera(points, pixels, cv::Size(640, 480), k, d, rotations,
                      translations, flags);
  // k1 k2 p1 p2 k3 k4 k5 k6
  std::array<double, 8> c = {};
  for (size_t i = 0; i < c.size() && i < d.total(); ++i) c[i] = d.at<double>(i);
  const ImageSize size = {640, 480};
  return OpenCvModel(size, WholeImage(size),
                     {k(0, 0), k(1, 1), k(0, 2), k(1, 2), c[0], c[1], c[4],
                      c[5], c[6], c[7], c[2], c[3]});
}

ErrorMetrics HeldOutResiduals(const char* what, const CameraModel& camera,
                              const Pattern& pattern, const RealData& data) {
  const Evaluation evaluation = EvaluateCamera(camera, data.test, pattern, 0);
  const ErrorMetrics metrics = ComputeErrorMetrics(evaluation.residuals);
  std::printf(
      "held out, %-26s median %.4f px, RMS %.4f, max %.3f, %d features, %d "
      "outside the area\n",
      what, metrics.median_px, metrics.rms_px, metrics.max_px, metrics.count,
      evaluation.outside_area);
  return metrics;
}

ErrorMetrics HeldOutOfModel(const std::string& model, const RealData& data) {
  CalibrationOptions options;
  options.model = model;
  const CalibrationResult result =
      Calibrate(data.training, data.pattern, options);
  return HeldOutResiduals(model.c_str(), *result.camera.camera, result.pattern,
                          data);
}

TEST(RealData, GenericCameraHasTheLeastHeldOutError) {
  if (!HasReachedView())
    GTEST_SKIP() << "no real data in " << Folder()
                 << "; name their folder with -DRAYGRID_REAL_DATA";
  const RealData data = ReadRealData();
  ASSERT_GE(data.test.images.size(), 3u);
  const ErrorMetrics central = HeldOutOfModel("central-generic", data);
  const ErrorMetrics opencv = HeldOutOfModel("opencv", data);
  const ErrorMetrics plain = HeldOutResiduals(
      "cv::calibrateCamera", CalibrateByOpenCv(data, 0), data.pattern, data);
  const ErrorMetrics rational = HeldOutResiduals(
      "cv::calibrateCamera rational",
      CalibrateByOpenCv(data, cv::CALIB_RATIONAL_MODEL), data.pattern, data);
  EXPECT_LE(central.median_px, 1.02 * opencv.median_px);
  EXPECT_LE(central.median_px,
            0.8 * std::min(plain.median_px, rational.median_px));
  // Nor by leaving out what is hard to explain.
  EXPECT_GE(central.count, 0.9 * plain.count);
}

}  // namespace
}  // namespace raygrid
