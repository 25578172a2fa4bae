#ifndef RAYGRID_FEATURES_CHESSBOARD_H
#define RAYGRID_FEATURES_CHESSBOARD_H

#include "features/detection.h"

namespace raygrid {

/// Finds the inner corners of a whole chessboard, approximately; all or none.
///
/// Which corner is the first follows from the colours: the square right below
/// it is dark. That settles it if one side of the board is even and the other
/// odd; else the first corner is the one that leaves the board upright in the
/// image. A board that the colours show to be mirrored is numbered as it was
/// before it was mirrored, with a remark.
ImageDetection LocateChessboard(const GreyImage& image, const Board& board);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_CHESSBOARD_H
