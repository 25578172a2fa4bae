#ifndef RAYGRID_FEATURES_SQUARES_APRILGRID_H
#define RAYGRID_FEATURES_SQUARES_APRILGRID_H

#include <memory>
#include <vector>

#include "features/board_view/detection.h"
#include "features/board_view/tag_detection.h"

namespace raygrid {

/// Finds the corners of an AprilGrid's tags, approximately. Tags as Kalibr
/// prints them: tag36h11 with a black border of two cells.
class AprilGridLocator {
 public:
  explicit AprilGridLocator(const Board& board);
  ~AprilGridLocator();

  ImageDetection Locate(const GreyImage& image) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// All tags with a border of two cells, whatever board they are on.
std::vector<DetectedTag> FindGridTags(const GreyImage& image);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_SQUARES_APRILGRID_H
