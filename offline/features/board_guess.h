/// Guesses of what images show where a board is not found as the pattern says
/// it is.
#ifndef RAYGRID_FEATURES_BOARD_GUESS_H
#define RAYGRID_FEATURES_BOARD_GUESS_H

#include <optional>
#include <string>

#include "features/pattern_detector.h"

namespace raygrid {

/// For a pattern of one chessboard, ChArUco board or AprilGrid that not enough
/// images show as a whole: looks into some of them for other numbers of columns
/// and rows, other dictionaries and kinds, and for mirrored boards; with stars
/// or markers of any pattern, also for boards in white on black. If most of
/// them agree on one, says so in a line, with what to do; pattern_name is named
/// there. What was found of the board as asked for is by chance then.
std::optional<std::string> GuessOtherBoard(const FolderDetection& found,
                                           const Pattern& pattern,
                                           const std::string& pattern_name,
                                           int num_threads);

/// The end of an error's line where images show no board: what was searched
/// for, and what to check.
std::string DescribeExpectedBoards(const Pattern& pattern,
                                   const std::string& pattern_name);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_BOARD_GUESS_H
