#ifndef RAYGRID_FEATURES_SQUARES_CHESSBOARD_H
#define RAYGRID_FEATURES_SQUARES_CHESSBOARD_H

#include <memory>
#include <optional>

#include "features/board_view/detection.h"

namespace raygrid {

/// Finds the inner corners of a chessboard, approximately, in pictures that
/// show it wholly or in part.
///
/// Which corner is the first follows from the colours: the square right below
/// it is dark. That settles it if one side of the board is even and the other
/// odd; else the first corner is the one that leaves the board upright in the
/// image. A board that the colours show to be mirrored is numbered as it was
/// before it was mirrored, with a remark.
///
/// Corners have no numbers on them: a part of a board is numbered only if where
/// the board is seen to end, its size and its colours leave no other way. Else
/// nothing is found, with a remark.
class ChessboardLocator {
 public:
  explicit ChessboardLocator(const Board& board);
  ~ChessboardLocator();

  ImageDetection Locate(const GreyImage& image) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// How many inner corners a chessboard in an image has along its sides, as it
/// is seen; of the first one that is seen without gaps.
struct ChessboardSize {
  int columns = 0, rows = 0;
};
std::optional<ChessboardSize> SeenChessboardSize(const GreyImage& image);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_SQUARES_CHESSBOARD_H
