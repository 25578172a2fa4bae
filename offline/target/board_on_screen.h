#ifndef RAYGRID_TARGET_BOARD_ON_SCREEN_H
#define RAYGRID_TARGET_BOARD_ON_SCREEN_H

#include <string>
#include <vector>

#include "camera/area.h"
#include "dataset/pattern.h"

namespace raygrid {

/// Boards of equal size to show on a monitor, one at a time: centred, with an
/// integer number of pixels per square, on mid-grey, which keeps the exposure
/// constant.
struct ScreenBoards {
  std::vector<Board> boards;
  ImageSize screen;
  int square_px = 0;
  double left_px = 0, top_px = 0;  ///< top-left corner of the ink
};

/// square_px: pixels per square; 0: the maximum. Throws Error(kUsage) for
/// boards that are invalid or exceed the screen.
ScreenBoards PlanScreenBoards(std::vector<Board> boards,
                              const ImageSize& screen, int square_px = 0);

/// Returns the pixels per square of a board on a monitor of this pixel pitch.
/// Throws Error(kUsage).
int SquarePx(const Board& board, double pixels_per_inch);

/// Returns the boards with their lengths on a monitor of this pixel pitch.
ScreenBoards WithPixelPitch(ScreenBoards boards, double pixels_per_inch);

/// A length to measure on the monitor: from the first to the last feature of a
/// row, or of a column if that is longer.
struct ScreenLength {
  bool is_row = true;
  double squares = 0;
};
ScreenLength GetMeasurableLength(const Board& board);

std::string MakeScreenYaml(const ScreenBoards& boards);
std::string RenderScreenPng(const ScreenBoards& boards, const Board& board);

}  // namespace raygrid

#endif  // RAYGRID_TARGET_BOARD_ON_SCREEN_H
