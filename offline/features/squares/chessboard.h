#ifndef RAYGRID_FEATURES_SQUARES_CHESSBOARD_H
#define RAYGRID_FEATURES_SQUARES_CHESSBOARD_H

#include <memory>
#include <optional>

#include "features/board_view/detection.h"

namespace raygrid {

/// How many inner corners a chessboard in an image has along its sides, as it
/// is seen; of the first one that is seen without gaps.
struct ChessboardSize {
  int columns = 0, rows = 0;
};
std::optional<ChessboardSize> EstimateChessboardSize(const GreyImage& image);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_SQUARES_CHESSBOARD_H
