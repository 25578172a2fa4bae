#ifndef RAYGRID_FEATURES_SQUARES_CHESS_LATTICE_H
#define RAYGRID_FEATURES_SQUARES_CHESS_LATTICE_H

#include <functional>

#include "features/board_view/detection.h"
#include "features/board_view/feature_lattice.h"
#include "features/squares/corner_growth.h"

namespace raygrid {

/// Detects lattices of chessboard corners of any size in images, as features of
/// a canvas: a chessboard that is large enough for the lattice to grow in any
/// direction from its centre. The square to the lower right of features with
/// even column + row is dark.
class ChessLatticeFinder {
 public:
  /// max_side: maximum number of corners along a side of the board.
  explicit ChessLatticeFinder(int max_side);

  const Board& canvas() const { return canvas_; }

  /// Calls is_wanted for each lattice until it returns true.
  void Find(const GreyImage& image,
            const std::function<bool(const FeatureLattice&)>& is_wanted) const;

 private:
  Board canvas_;
  CornerGrowth growth_;
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_SQUARES_CHESS_LATTICE_H
