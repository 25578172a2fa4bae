#ifndef RAYGRID_TARGET_BOARD_ON_SCREEN_H
#define RAYGRID_TARGET_BOARD_ON_SCREEN_H

#include <string>
#include <vector>

#include "camera/area.h"
#include "dataset/pattern.h"

namespace raygrid {

/// Boards of one size to show on a monitor, one at a time: with a whole number
/// of pixels per square, in the middle of mid-grey, which keeps the exposure
/// where it is.
struct ScreenBoards {
  std::vector<Board> boards;
  ImageSize screen;
  int square_px = 0;
  double left_px = 0, top_px = 0;  ///< the ink's top-left corner
};

/// Squares of so many pixels; 0: as large as fits. Throws Error(kUsage) for
/// boards that cannot be or do not fit the screen.
ScreenBoards PlanScreenBoards(std::vector<Board> boards,
                              const ImageSize& screen, int square_px = 0);

/// How many pixels a board's squares have on a monitor of this pixel pitch.
/// Throws Error(kUsage).
int SquarePx(const Board& board, double pixels_per_inch);

/// The boards with their lengths on a monitor of this pixel pitch.
ScreenBoards WithPixelPitch(ScreenBoards boards, double pixels_per_inch);

/// The length to measure on the monitor: from the first feature to the last of
/// a row, or of a column where that is longer.
struct ScreenLength {
  bool is_row = true;
  double squares = 0;
};
ScreenLength GetMeasurableLength(const Board& board);

std::string ScreenYaml(const ScreenBoards& boards);
std::string ScreenPng(const ScreenBoards& boards, const Board& board);

}  // namespace raygrid

#endif  // RAYGRID_TARGET_BOARD_ON_SCREEN_H
