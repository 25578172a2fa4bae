/// ArUco markers of ChArUco boards and OpenCV's GridBoards.
#ifndef RAYGRID_FEATURES_SQUARES_ARUCO_MARKERS_H
#define RAYGRID_FEATURES_SQUARES_ARUCO_MARKERS_H

#include <opencv2/aruco/dictionary.hpp>
#include <vector>

#include "appearance/board_appearance.h"
#include "features/board_view/detection.h"
#include "features/squares/detected_markers.h"

namespace raygrid {

/// Returns a dictionary that contains only the board's markers, in their order,
/// so that other markers are not confused with them.
cv::Ptr<cv::aruco::Dictionary> BoardDictionary(
    const std::vector<PlacedMarker>& markers, int border_cells);

/// Detects markers of a dictionary; indices refer to the dictionary. Corners
/// are accurate to about a pixel.
std::vector<DetectedMarker> FindArucoMarkers(
    const GreyImage& image, const cv::Ptr<cv::aruco::Dictionary>& dictionary,
    int border_cells);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_SQUARES_ARUCO_MARKERS_H
