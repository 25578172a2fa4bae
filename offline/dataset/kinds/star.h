#ifndef RAYGRID_DATASET_KINDS_STAR_H
#define RAYGRID_DATASET_KINDS_STAR_H

#include <vector>

#include "dataset/pattern.h"

namespace raygrid {

/// Star boards that differ in their tags.
struct StarBoardOptions {
  int columns = 0, rows = 0;  ///< feature points
  double square_mm = 0;
  int segments = 16;
  int num_boards = 1;
  int num_tags = 1;     ///< on each board
  int tag_id = 0;       ///< of the first tag; the others count on
  int tag_squares = 0;  ///< side of a tag, white margin included; 0: chosen
};

/// The side of a tag, if none is asked for: about 40 mm, but 2 squares at
/// least, and no more than half of a small board.
int DefaultTagSquares(int columns, int rows, double square_mm);

/// Boards 0, 1, ... with their tags spread evenly; one tag stands in the
/// middle, or half a square left of it or above. Throws Error(kUsage).
std::vector<Board> StarBoards(const StarBoardOptions& options);

/// Whether segment of a star is black at an offset from the star's centre, in
/// any unit.
bool IsBlackInStar(int segments, double right, double down);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_KINDS_STAR_H
