#ifndef RAYGRID_TARGET_BOARD_SHEET_H
#define RAYGRID_TARGET_BOARD_SHEET_H

#include <string>
#include <vector>

#include "camera/area.h"
#include "dataset/pattern.h"
#include "target/board_yaml.h"

namespace raygrid {

/// Page size.
struct Page {
  double width_mm = 0, height_mm = 0;
};

/// Parses "A4", "A3", "letter", or "WxHmm". Throws Error(kUsage).
Page ParsePage(const std::string& name);

/// Boards of equal size to print, one per page. Every page has a ruler below
/// the board and one to its right, to check the printer's scale in both
/// directions, and a line that describes the board.
struct BoardSheets {
  std::vector<Board> boards;
  Page page;         ///< landscape if the boards fit only then
  Area board_mm;     ///< position of the ink on the page
  int ruler_mm = 0;  ///< nominal length of both rulers
};

/// Throws Error(kUsage) for boards that are invalid or exceed the page.
BoardSheets PlanBoardSheets(std::vector<Board> boards, const Page& page);

/// Returns the print scale, from the measured lengths of the rulers. Throws
/// Error(kUsage) if they are implausible.
PrintScale ComputePrintScale(const BoardSheets& sheets, double measured_x_mm,
                             double measured_y_mm);

std::string MakeSheetsYaml(const BoardSheets& sheets,
                           const PrintScale& scale = {});

/// Formats all pages as PDF. Cairo rounds coordinates to 1/256 point, 1.4 um.
std::string SheetsPdf(const BoardSheets& sheets);
/// Formats a page; the SVG unit is 1 mm. Cairo rounds to 1/256 mm, 4 um.
std::string MakeSheetSvg(const BoardSheets& sheets, const Board& board);
std::string RenderSheetPng(const BoardSheets& sheets, const Board& board,
                           double dpi);

}  // namespace raygrid

#endif  // RAYGRID_TARGET_BOARD_SHEET_H
