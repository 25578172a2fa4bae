#ifndef RAYGRID_FEATURES_SQUARES_CHARUCO_H
#define RAYGRID_FEATURES_SQUARES_CHARUCO_H

#include <memory>

#include "features/board_view/detection.h"

namespace raygrid {

/// Finds the chessboard corners of a ChArUco board, approximately: each through
/// the homography of the markers around it, of which at least one touches it.
class CharucoLocator {
 public:
  explicit CharucoLocator(const Board& board);
  ~CharucoLocator();

  /// Markers may be where OpenCV puts them now, or where it did before 4.6:
  /// what the board says is tried first, and the other with a remark.
  ImageDetection Locate(const GreyImage& image) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_SQUARES_CHARUCO_H
