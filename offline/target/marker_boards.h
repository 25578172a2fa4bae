#ifndef RAYGRID_TARGET_MARKER_BOARDS_H
#define RAYGRID_TARGET_MARKER_BOARDS_H

#include <vector>

#include "dataset/kinds/target_kind.h"

namespace raygrid {

/// Returns boards 0, 1, ... that equal a board with numbered markers except for
/// the markers' numbers, which continue after those of the previous board.
/// Throws Error(kUsage) if there are too few markers.
std::vector<Board> MarkerBoards(Board board, int num_boards);

/// Returns the requested boards of a kind. Throws Error(kUsage).
std::vector<Board> MakeBoards(const TargetKind& kind,
                              const BoardRequest& request);

}  // namespace raygrid

#endif  // RAYGRID_TARGET_MARKER_BOARDS_H
