// Boards of each kind for tests of what is printed.
#ifndef RAYGRID_TESTS_OFFLINE_BOARDS_TO_PRINT_H
#define RAYGRID_TESTS_OFFLINE_BOARDS_TO_PRINT_H

#include "dataset/kinds/star.h"
#include "dataset/pattern.h"

namespace raygrid {

inline Board Chessboard(int columns, int rows, double square_mm) {
  Board board;
  board.kind = "chessboard";
  board.columns = columns;
  board.rows = rows;
  board.square_m = square_mm / 1000;
  return board;
}

inline Board Charuco(int columns, int rows, double square_mm) {
  Board board = Chessboard(columns, rows, square_mm);
  board.kind = "charuco";
  board.marker_m = 0.75 * board.square_m;
  board.dictionary = "DICT_4X4_50";
  return board;
}

inline Board AprilGrid(int tag_columns, int tag_rows, double tag_mm) {
  Board board = Chessboard(2 * tag_columns, 2 * tag_rows, tag_mm);
  board.kind = "aprilgrid";
  board.tag_family = "tag36h11";
  board.spacing_ratio = 0.3;
  return board;
}

// A grid as OpenCV's GridBoard and AprilTag's mosaics are.
inline Board PlainTagGrid(int tag_columns, int tag_rows, double tag_mm) {
  Board board = AprilGrid(tag_columns, tag_rows, tag_mm);
  SetCornerSquares(false, &board);
  return board;
}

inline StarBoardOptions Stars(int columns, int rows, double square_mm) {
  StarBoardOptions options;
  options.columns = columns;
  options.rows = rows;
  options.square_mm = square_mm;
  return options;
}

}  // namespace raygrid

#endif  // RAYGRID_TESTS_OFFLINE_BOARDS_TO_PRINT_H
