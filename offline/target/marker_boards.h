#ifndef RAYGRID_TARGET_MARKER_BOARDS_H
#define RAYGRID_TARGET_MARKER_BOARDS_H

#include <vector>

#include "dataset/pattern.h"

namespace raygrid {

/// Boards 0, 1, ... like a ChArUco board or AprilGrid, but with markers of
/// their own: each goes on counting where the one before ended. Throws
/// Error(kUsage) if there are too few markers.
std::vector<Board> MarkerBoards(Board board, int num_boards);

}  // namespace raygrid

#endif  // RAYGRID_TARGET_MARKER_BOARDS_H
