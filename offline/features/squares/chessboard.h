#ifndef RAYGRID_FEATURES_SQUARES_CHESSBOARD_H
#define RAYGRID_FEATURES_SQUARES_CHESSBOARD_H

#include <memory>
#include <optional>

#include "features/board_view/detection.h"

namespace raygrid {

/// Numbers of inner corners along the sides of a chessboard, in its orientation
/// in the image. EstimateChessboardSize() returns the numbers of the first
/// lattice without gaps.
struct ChessboardSize {
  int columns = 0, rows = 0;
};
std::optional<ChessboardSize> EstimateChessboardSize(const GreyImage& image);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_SQUARES_CHESSBOARD_H
