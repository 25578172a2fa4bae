/// Guesses the board that images show if the pattern's board is not detected as
/// specified.
#ifndef RAYGRID_FEATURES_BOARD_GUESS_H
#define RAYGRID_FEATURES_BOARD_GUESS_H

#include <optional>
#include <string>

#include "features/pattern_detector.h"

namespace raygrid {

/// For a pattern of one chessboard, ChArUco board or AprilGrid that too few
/// images show completely: searches some of them for other numbers of columns
/// and rows, other dictionaries and kinds, and mirrored boards; for stars or
/// markers of any pattern, also for white-on-black boards. If most agree on one
/// board, returns a line with the remedy, which contains pattern_name; features
/// detected of the specified board are then spurious.
std::optional<std::string> SuggestOtherBoard(const FolderDetection& found,
                                             const Pattern& pattern,
                                             const std::string& pattern_name,
                                             int num_threads);

/// Returns the second half of an error message for images without boards: the
/// expected boards, and what the user should check.
std::string DescribeExpectedBoards(const Pattern& pattern,
                                   const std::string& pattern_name);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_BOARD_GUESS_H
