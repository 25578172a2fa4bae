#include "initialization/parametric_initialization.h"

#include <cmath>
#include <opencv2/calib3d.hpp>

#include "initialization/planar_views.h"

namespace raygrid {
namespace {

constexpr size_t kMaxParametricViews = 16;
// Maximum RMS error of a successful fit.
constexpr double kMaxRelativeRms = 0.02;  // relative to the image width

// Discards the last digits for reproducible results: LAPACK, which OpenCV
// calls, rounds differently depending on the memory alignment of its data.
constexpr int kPixelBits = 6, kRatioBits = 20;
double Rounded(double value, int bits) {
  return std::ldexp(std::round(std::ldexp(value, bits)), -bits);
}

}  // namespace

std::optional<OpenCvModel> InitializeFromPlanarBoards(const Dataset& dataset,
                                                      const Pattern& pattern) {
  std::vector<std::vector<cv::Point3f>> points;
  std::vector<std::vector<cv::Point2f>> pixels;
  for (const PlanarView& view :
       SamplePlanarViews(dataset, pattern, kMaxParametricViews)) {
    points.emplace_back();
    pixels.emplace_back();
    for (const Eigen::Vector2d& point : view.points)
      points.back().emplace_back(point.x(), point.y(), 0);
    for (const Eigen::Vector2d& pixel : view.pixels)
      pixels.back().emplace_back(pixel.x(), pixel.y());
  }
  if (points.empty()) return std::nullopt;

  const ImageSize& size = dataset.image_size;
  cv::Mat matrix, distortion;
  std::vector<cv::Mat> rotations, translations;
  double rms;
  try {
    rms = cv::calibrateCamera(points, pixels, cv::Size(size.width, size.height),
                              matrix, distortion, rotations, translations);
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
  const double* k = distortion.ptr<double>();
  OpenCvModel::ParameterArray parameters = {matrix.at<double>(0, 0),
                                            matrix.at<double>(1, 1),
                                            matrix.at<double>(0, 2),
                                            matrix.at<double>(1, 2),
                                            k[0],
                                            k[1],
                                            k[4],
                                            0,
                                            0,
                                            0,
                                            k[2],
                                            k[3]};
  for (const double value : parameters)
    if (!std::isfinite(value)) return std::nullopt;
  if (!(rms < kMaxRelativeRms * size.width) || parameters[0] <= 0 ||
      parameters[1] <= 0)
    return std::nullopt;
  for (size_t i = 0; i < parameters.size(); ++i)
    parameters[i] = Rounded(parameters[i], i < 4 ? kPixelBits : kRatioBits);
  return OpenCvModel(size, WholeImage(size), parameters);
}

}  // namespace raygrid
