// Boards that simulated cameras see.
#ifndef RAYGRID_TESTS_OFFLINE_TEST_BOARDS_H
#define RAYGRID_TESTS_OFFLINE_TEST_BOARDS_H

#include "dataset/pattern.h"

namespace raygrid {

inline Pattern TestBoard() { return ChessboardPattern(14, 10, 0.03); }

/// Two of them, boards 0 and 7.
inline Pattern TwoTestBoards() {
  Pattern pattern = TestBoard();
  pattern.boards.push_back(pattern.boards[0]);
  pattern.boards[1].id = 7;
  return pattern;
}

/// One of many points, where accuracy is measured.
inline Pattern FineTestBoard() { return ChessboardPattern(30, 24, 0.02); }

}  // namespace raygrid

#endif  // RAYGRID_TESTS_OFFLINE_TEST_BOARDS_H
