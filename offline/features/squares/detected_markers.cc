#include "features/squares/detected_markers.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <map>
#include <opencv2/calib3d.hpp>

namespace raygrid {
namespace {

constexpr int kNumWitnesses = 6;
// Maximum distance of a marker's neighbours, and tolerances for predicting its
// centre from one of them, in distances between markers. Predictions degrade
// with distance, due to lens distortion and errors of a small marker's corners.
constexpr double kWitnessDistance = 3.3;
constexpr double kMarkerTolerance = 0.15;
constexpr double kTolerancePerDistance = 0.12;

}  // namespace

cv::Mat ReadableImage(const GreyImage& image) {
  std::vector<float> levels = image.levels;
  const auto quantile = [&](double part) {
    const auto at =
        levels.begin() +
        static_cast<ptrdiff_t>(part * static_cast<double>(levels.size() - 1));
    std::nth_element(levels.begin(), at, levels.end());
    return static_cast<double>(*at);
  };
  constexpr double kOutliers = 0.01, kReadableRange = 120;
  const double dark = quantile(kOutliers), bright = quantile(1 - kOutliers);
  const double gain = kReadableRange / std::max(1.0, bright - dark);
  if (gain <= 1)
    return cv::Mat(image.size.height, image.size.width, CV_8U,
                   const_cast<uint8_t*>(image.bytes.data()));
  cv::Mat readable;
  cv::Mat(image.size.height, image.size.width, CV_32F,
          const_cast<float*>(image.levels.data()))
      .convertTo(readable, CV_8U, gain, 60 - gain * dark);
  return readable;
}

Eigen::Vector2d DetectedMarker::center_px() const {
  return (corners_px[0] + corners_px[1] + corners_px[2] + corners_px[3]) / 4;
}

MarkerConstellation::MarkerConstellation(
    const std::vector<PlacedMarker>& placed, double pitch_m,
    const std::vector<DetectedMarker>& seen)
    : placed_(&placed), pitch_m_(pitch_m) {
  std::map<int, int> times;
  for (const DetectedMarker& marker : seen) ++times[marker.index];
  for (const DetectedMarker& marker : seen)
    if (times[marker.index] == 1) seen_.push_back(marker);
}

MarkerConstellation MarkerConstellation::SelectConsistent() const {
  MarkerConstellation consistent = *this;
  consistent.seen_.clear();
  for (const DetectedMarker& marker : seen_)
    if (CountConfirming(marker) > 0) consistent.seen_.push_back(marker);
  return consistent;
}

int MarkerConstellation::CountConsistent() const {
  int agreement = 0;
  for (const DetectedMarker& marker : seen_)
    agreement += CountConfirming(marker);
  return agreement;
}

double MarkerConstellation::Distance(const DetectedMarker& marker,
                                     const Eigen::Vector2d& point_m) const {
  return (GetCenterOnBoard(marker) - point_m).norm();
}

std::vector<DetectedMarker> MarkerConstellation::FindNearest(
    const Eigen::Vector2d& point_m, double distance_m, int count) const {
  std::vector<DetectedMarker> nearest;
  for (const DetectedMarker& marker : seen_)
    if (Distance(marker, point_m) <= distance_m) nearest.push_back(marker);
  std::stable_sort(nearest.begin(), nearest.end(),
                   [&](const DetectedMarker& a, const DetectedMarker& b) {
                     return Distance(a, point_m) < Distance(b, point_m);
                   });
  if (static_cast<int>(nearest.size()) > count) nearest.resize(count);
  return nearest;
}

LocalMapping MarkerConstellation::MappingAt(
    const Eigen::Vector2d& point_m, double square_m,
    const std::vector<DetectedMarker>& markers) const {
  const Eigen::Matrix3d homography = EstimateImageFromBoard(markers);
  const Eigen::Vector3d origin = homography * point_m.homogeneous();
  const double unit = square_m / origin.z();
  LocalMapping mapping;
  mapping.center = origin.hnormalized();
  mapping.perspective = unit * homography.block<1, 2>(2, 0).transpose();
  mapping.linear = unit * homography.topLeftCorner<2, 2>() -
                   mapping.center * mapping.perspective.transpose();
  return mapping;
}

// Estimates the homography from the board's plane to the image.
Eigen::Matrix3d MarkerConstellation::EstimateImageFromBoard(
    const std::vector<DetectedMarker>& markers) const {
  std::vector<cv::Point2d> board, image;
  for (const DetectedMarker& marker : markers) {
    for (const Eigen::Vector2d& p : CornersOnBoard(marker))
      board.emplace_back(p.x(), p.y());
    for (const Eigen::Vector2d& p : marker.corners_px)
      image.emplace_back(p.x(), p.y());
  }
  const cv::Mat found = cv::findHomography(board, image);
  if (found.empty()) return Eigen::Matrix3d::Zero();
  Eigen::Matrix3d image_from_board;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      image_from_board(row, column) = found.at<double>(row, column);
  return image_from_board;
}

std::array<Eigen::Vector2d, 4> MarkerConstellation::CornersOnBoard(
    const DetectedMarker& marker) const {
  const PlacedMarker& placed = (*placed_)[marker.index];
  const Eigen::Vector2d right(placed.side_m(), 0), down(0, placed.side_m());
  return {placed.corner, placed.corner + right, placed.corner + right + down,
          placed.corner + down};
}

Eigen::Vector2d MarkerConstellation::GetCenterOnBoard(
    const DetectedMarker& marker) const {
  const PlacedMarker& placed = (*placed_)[marker.index];
  return placed.corner.array() + placed.side_m() / 2;
}

int MarkerConstellation::CountConfirming(const DetectedMarker& marker) const {
  int confirmations = 0;
  for (const DetectedMarker& witness :
       FindNearest(GetCenterOnBoard(marker), kWitnessDistance * pitch_m_,
                   kNumWitnesses + 1))
    if (witness.index != marker.index)
      confirmations += Confirms(witness, marker) ? 1 : -1;
  return confirmations;
}

// Compares the marker's centre, mapped to the board by the homography of the
// neighbour, with its nominal position.
bool MarkerConstellation::Confirms(const DetectedMarker& witness,
                                   const DetectedMarker& marker) const {
  const Eigen::Matrix3d board_from_image =
      EstimateImageFromBoard({witness}).inverse();
  const Eigen::Vector2d found =
      (board_from_image * marker.center_px().homogeneous()).hnormalized();
  const Eigen::Vector2d expected = GetCenterOnBoard(marker);
  const double distance = (expected - GetCenterOnBoard(witness)).norm();
  // The comparison is false also if a degenerate homography yields NaN.
  return (found - expected).norm() <
         kMarkerTolerance * pitch_m_ + kTolerancePerDistance * distance;
}

}  // namespace raygrid
