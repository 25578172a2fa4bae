#ifndef RAYGRID_FEATURES_SQUARES_CHESS_LATTICE_H
#define RAYGRID_FEATURES_SQUARES_CHESS_LATTICE_H

#include <functional>

#include "features/board_view/detection.h"
#include "features/board_view/feature_lattice.h"
#include "features/squares/corner_growth.h"

namespace raygrid {

/// Finds lattices of chessboard corners in images, whatever their numbers are:
/// as features of a chessboard that is so large that the one sought fits on it
/// with any of its corners in the middle. Right below features of even column +
/// row it is dark.
class ChessLatticeFinder {
 public:
  /// A finder for boards of at most max_side corners along each side.
  explicit ChessLatticeFinder(int max_side);

  const Board& canvas() const { return canvas_; }

  /// Calls is_wanted for one lattice after the other until it returns true.
  void Find(const GreyImage& image,
            const std::function<bool(const FeatureLattice&)>& is_wanted) const;

 private:
  Board canvas_;
  CornerGrowth growth_;
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_SQUARES_CHESS_LATTICE_H
