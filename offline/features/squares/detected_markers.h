/// Square markers detected in an image, including false detections: code shared
/// by ChArUco boards and AprilGrids.
#ifndef RAYGRID_FEATURES_SQUARES_DETECTED_MARKERS_H
#define RAYGRID_FEATURES_SQUARES_DETECTED_MARKERS_H

#include <Eigen/Core>
#include <array>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "appearance/board_appearance.h"
#include "features/board_view/detection.h"
#include "features/board_view/local_mapping.h"

namespace raygrid {

struct DetectedMarker {
  int index = 0;  ///< index among the board's markers
  /// Corners of the outermost cells, clockwise from the top left in upright
  /// orientation.
  std::array<Eigen::Vector2d, 4> corners_px;

  Eigen::Vector2d center_px() const;
};

/// Converts an image to 8 bits for marker detectors; amplifies low contrast.
cv::Mat ReadableImage(const GreyImage& image);

/// Detected markers and their nominal positions on the board.
class MarkerConstellation {
 public:
  /// pitch_m: distance between adjacent markers. Omits markers that were
  /// detected more than once.
  MarkerConstellation(const std::vector<PlacedMarker>& placed, double pitch_m,
                      const std::vector<DetectedMarker>& seen);

  /// Returns only the markers that are consistent with most of their
  /// neighbours.
  MarkerConstellation SelectConsistent() const;
  /// Returns the number of consistent pairs of neighbours minus that of
  /// inconsistent ones.
  int CountConsistent() const;

  const std::vector<DetectedMarker>& seen() const { return seen_; }
  int size() const { return static_cast<int>(seen_.size()); }
  /// Returns the distance from a board point to a marker's centre, in metres.
  double Distance(const DetectedMarker& marker,
                  const Eigen::Vector2d& point_m) const;
  /// Returns at most `count` markers within a distance, nearest first.
  std::vector<DetectedMarker> FindNearest(const Eigen::Vector2d& point_m,
                                          double distance_m, int count) const;
  /// Returns the local mapping around a board point, from a homography fitted
  /// to the corners of the given markers. square_m: unit of offsets.
  LocalMapping MappingAt(const Eigen::Vector2d& point_m, double square_m,
                         const std::vector<DetectedMarker>& markers) const;

 private:
  std::array<Eigen::Vector2d, 4> CornersOnBoard(
      const DetectedMarker& marker) const;
  Eigen::Matrix3d EstimateImageFromBoard(
      const std::vector<DetectedMarker>& markers) const;
  Eigen::Vector2d GetCenterOnBoard(const DetectedMarker& marker) const;
  int CountConfirming(const DetectedMarker& marker) const;
  bool Confirms(const DetectedMarker& witness,
                const DetectedMarker& marker) const;

  const std::vector<PlacedMarker>* placed_;
  double pitch_m_;
  std::vector<DetectedMarker> seen_;
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_SQUARES_DETECTED_MARKERS_H
