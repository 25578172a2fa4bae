#include "features/squares/aruco_markers.h"

#include <algorithm>
#include <opencv2/aruco.hpp>

namespace raygrid {
namespace {

cv::Mat MakeCode(const MarkerBits& bits, int border_cells) {
  const int size = bits.size - 2 * border_cells;
  cv::Mat code(size, size, CV_8U);
  for (int row = 0; row < size; ++row)
    for (int column = 0; column < size; ++column)
      code.at<uint8_t>(row, column) =
          !bits.at(column + border_cells, row + border_cells);
  return code;
}

}  // namespace

cv::Ptr<cv::aruco::Dictionary> BoardDictionary(
    const std::vector<PlacedMarker>& markers, int border_cells) {
  auto dictionary = cv::makePtr<cv::aruco::Dictionary>();
  dictionary->markerSize = markers[0].bits.size - 2 * border_cells;
  const int num_bits = dictionary->markerSize * dictionary->markerSize;
  int min_distance = num_bits;
  for (const PlacedMarker& marker : markers) {
    const cv::Mat code = MakeCode(marker.bits, border_cells);
    if (!dictionary->bytesList.empty())
      for (int id = 0; id < dictionary->bytesList.rows; ++id)
        min_distance =
            std::min(min_distance, dictionary->getDistanceToId(code, id, true));
    dictionary->bytesList.push_back(
        cv::aruco::Dictionary::getByteListFromBits(code));
  }
  dictionary->maxCorrectionBits = std::max(0, (min_distance - 1) / 2);
  return dictionary;
}

std::vector<DetectedMarker> FindArucoMarkers(
    const GreyImage& image, const cv::Ptr<cv::aruco::Dictionary>& dictionary,
    int border_cells) {
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
  const auto parameters = cv::aruco::DetectorParameters::create();
  parameters->markerBorderBits = border_cells;
  try {
    cv::aruco::detectMarkers(ReadableImage(image), dictionary, corners, ids,
                             parameters);
  } catch (const cv::Exception&) {
    return {};  // image too small for a marker
  }
  std::vector<DetectedMarker> seen;
  for (size_t i = 0; i < ids.size(); ++i) {
    DetectedMarker marker;
    marker.index = ids[i];
    for (int k = 0; k < 4; ++k)
      marker.corners_px[k] = {corners[i][k].x, corners[i][k].y};
    seen.push_back(marker);
  }
  return seen;
}

}  // namespace raygrid
