#include "initialization/parametric_start.h"

#include <cmath>
#include <opencv2/calib3d.hpp>

namespace raygrid {
namespace {

constexpr size_t kMaxViews = 16;
constexpr size_t kMinFeatures = 8, kMaxFeatures = 80;  // of a view
// Worse than this, the fit has found nothing of the lens.
constexpr double kMaxRmsPart = 0.02;  // of the image's width

struct PlanarViews {
  std::vector<std::vector<cv::Point3f>> points;
  std::vector<std::vector<cv::Point2f>> pixels;
};

// The features of one board in one image.
void AddView(const ImageFeatures& image, const Board& board,
             PlanarViews* views) {
  const std::vector<Eigen::Vector3d> nominal = board.NominalPoints();
  std::vector<cv::Point3f> points;
  std::vector<cv::Point2f> pixels;
  const size_t step = image.features.size() / kMaxFeatures + 1;
  for (size_t i = 0; i < image.features.size(); i += step) {
    const Feature& feature = image.features[i];
    if (feature.board != board.id) continue;
    const Eigen::Vector3d& point =
        nominal[board.PointIndex(feature.column, feature.row)];
    points.emplace_back(point.x(), point.y(), 0);
    pixels.emplace_back(feature.pixel.x(), feature.pixel.y());
  }
  if (points.size() < kMinFeatures) return;
  views->points.push_back(std::move(points));
  views->pixels.push_back(std::move(pixels));
}

// At most kMaxViews of them, evenly spread.
PlanarViews Sample(const PlanarViews& all) {
  PlanarViews sample;
  const size_t count = std::min(kMaxViews, all.points.size());
  for (size_t i = 0; i < count; ++i) {
    const size_t index = i * all.points.size() / count;
    sample.points.push_back(all.points[index]);
    sample.pixels.push_back(all.pixels[index]);
  }
  return sample;
}

}  // namespace

std::optional<OpenCvModel> StartFromPlanarBoards(const Dataset& dataset,
                                                 const Pattern& pattern) {
  PlanarViews all;
  for (const ImageFeatures& image : dataset.images)
    for (const Board& board : pattern.boards) AddView(image, board, &all);
  const PlanarViews views = Sample(all);
  if (views.points.empty()) return std::nullopt;

  const ImageSize& size = dataset.image_size;
  cv::Mat matrix, distortion;
  std::vector<cv::Mat> rotations, translations;
  double rms;
  try {
    rms = cv::calibrateCamera(views.points, views.pixels,
                              cv::Size(size.width, size.height), matrix,
                              distortion, rotations, translations);
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
  const double* k = distortion.ptr<double>();
  const OpenCvModel::ParameterArray parameters = {matrix.at<double>(0, 0),
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
  if (!(rms < kMaxRmsPart * size.width) || parameters[0] <= 0 ||
      parameters[1] <= 0)
    return std::nullopt;
  return OpenCvModel(size, WholeImage(size), parameters);
}

}  // namespace raygrid
