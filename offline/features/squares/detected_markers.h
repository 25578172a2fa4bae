/// Square markers seen in an image, some of them wrongly: the common part of
/// ChArUco boards and AprilGrids.
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
  int index = 0;  ///< among the board's markers
  /// The corners of the marker's outermost cells: from the top left, clockwise
  /// as printed.
  std::array<Eigen::Vector2d, 4> corners_px;

  Eigen::Vector2d center_px() const;
};

/// The image as libraries that read markers want it: dark ones made as bright
/// as others.
cv::Mat ReadableImage(const GreyImage& image);

/// Markers in an image together with where they are on the board.
class MarkerConstellation {
 public:
  /// pitch_m is the distance between markers that are next to each other. A
  /// marker that was seen twice is left out.
  MarkerConstellation(const std::vector<PlacedMarker>& placed, double pitch_m,
                      const std::vector<DetectedMarker>& seen);

  /// The constellation without the markers that most of their neighbours
  /// contradict, or that have no neighbour to confirm them.
  MarkerConstellation Consistent() const;
  /// How many pairs of neighbours confirm each other, less those that do not.
  int Agreement() const;

  const std::vector<DetectedMarker>& seen() const { return seen_; }
  int size() const { return static_cast<int>(seen_.size()); }
  /// The distance from a point to a marker's centre on the board, metres.
  double Distance(const DetectedMarker& marker,
                  const Eigen::Vector2d& point_m) const;
  /// The markers within a distance from a point, nearest first, count at most.
  std::vector<DetectedMarker> Nearest(const Eigen::Vector2d& point_m,
                                      double distance_m, int count) const;
  /// How the board around a point is seen, from all corners of some markers, in
  /// squares of this length.
  LocalMapping MappingAt(const Eigen::Vector2d& point_m, double square_m,
                         const std::vector<DetectedMarker>& markers) const;

 private:
  std::array<Eigen::Vector2d, 4> CornersOnBoard(
      const DetectedMarker& marker) const;
  Eigen::Matrix3d ImageFromBoard(
      const std::vector<DetectedMarker>& markers) const;
  Eigen::Vector2d CenterOnBoard(const DetectedMarker& marker) const;
  int Confirmations(const DetectedMarker& marker) const;
  bool Confirms(const DetectedMarker& witness,
                const DetectedMarker& marker) const;

  const std::vector<PlacedMarker>* placed_;
  double pitch_m_;
  std::vector<DetectedMarker> seen_;
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_SQUARES_DETECTED_MARKERS_H
