/// ArUco markers, as ChArUco boards and OpenCV's GridBoards have them.
#ifndef RAYGRID_FEATURES_SQUARES_ARUCO_MARKERS_H
#define RAYGRID_FEATURES_SQUARES_ARUCO_MARKERS_H

#include <opencv2/aruco/dictionary.hpp>
#include <vector>

#include "appearance/board_appearance.h"
#include "features/board_view/detection.h"
#include "features/squares/detected_markers.h"

namespace raygrid {

/// A dictionary of a board's markers only, in their order: others cannot be
/// mistaken for them.
cv::Ptr<cv::aruco::Dictionary> BoardDictionary(
    const std::vector<PlacedMarker>& markers, int border_cells);

/// The markers of a dictionary in an image; their indices are those of the
/// dictionary. Corners are accurate to about a pixel.
std::vector<DetectedMarker> FindArucoMarkers(
    const GreyImage& image, const cv::Ptr<cv::aruco::Dictionary>& dictionary,
    int border_cells);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_SQUARES_ARUCO_MARKERS_H
