#ifndef RAYGRID_DATASET_KINDS_STAR_H
#define RAYGRID_DATASET_KINDS_STAR_H

#include <vector>

#include "dataset/pattern.h"

namespace raygrid {

/// Options of star boards that differ only in their tags.
struct StarBoardOptions {
  int columns = 0, rows = 0;  ///< feature points
  double square_mm = 0;
  int segments = 16;
  int num_boards = 1;
  int num_tags = 1;     ///< per board
  int tag_id = 0;       ///< ID of the first tag; others are consecutive
  int tag_squares = 0;  ///< side of a tag with its white margin; 0: default
};

/// Returns the default side of a tag in squares: about 40 mm, but at least 2
/// squares, and at most half of the shorter side of the board.
int DefaultTagSquares(int columns, int rows, double square_mm);

/// Returns boards 0, 1, ... with evenly distributed tags; a single tag is at
/// the centre, or half a square to the left of it or above. Throws
/// Error(kUsage).
std::vector<Board> StarBoards(const StarBoardOptions& options);

/// Whether a star's pattern is black at an offset from its centre, in any unit
/// of length.
bool IsBlackInStar(int segments, double right, double down);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_KINDS_STAR_H
