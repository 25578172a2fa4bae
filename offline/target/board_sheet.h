#ifndef RAYGRID_TARGET_BOARD_SHEET_H
#define RAYGRID_TARGET_BOARD_SHEET_H

#include <string>
#include <vector>

#include "camera/area.h"
#include "dataset/pattern.h"
#include "target/board_yaml.h"

namespace raygrid {

/// A page of paper.
struct Page {
  double width_mm = 0, height_mm = 0;
};

/// "A4", "A3", "letter", or "WxHmm"; throws Error(kUsage).
Page ParsePage(const std::string& name);

/// Boards of one size to print, each on a page of its own. Every page has a
/// ruler below the board and one at its right, to check the printer's scale
/// both ways, and a line that says what the board is.
struct BoardSheets {
  std::vector<Board> boards;
  Page page;         ///< turned, if only then the boards fit
  Area board_mm;     ///< the ink's place on the page
  int ruler_mm = 0;  ///< length of both rulers, as drawn
};

/// Throws Error(kUsage) for boards that cannot be or do not fit the page.
BoardSheets PlanBoardSheets(std::vector<Board> boards, const Page& page);

/// The boards with lengths as printed, given that of the rulers as measured;
/// throws Error(kUsage) if that cannot be.
PrintScale ComputePrintScale(const BoardSheets& sheets, double measured_x_mm,
                             double measured_y_mm);

std::string SheetsYaml(const BoardSheets& sheets, const PrintScale& scale = {});

/// All pages in one file. Cairo rounds places to 1/256 point, 1.4 um.
std::string SheetsPdf(const BoardSheets& sheets);
/// One page; a user unit is 1 mm. Cairo rounds places to 1/256 mm, 4 um.
std::string SheetSvg(const BoardSheets& sheets, const Board& board);
std::string SheetPng(const BoardSheets& sheets, const Board& board, double dpi);

}  // namespace raygrid

#endif  // RAYGRID_TARGET_BOARD_SHEET_H
