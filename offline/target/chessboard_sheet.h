#ifndef RAYGRID_TARGET_CHESSBOARD_SHEET_H
#define RAYGRID_TARGET_CHESSBOARD_SHEET_H

#include <string>

namespace raygrid {

/// A page of paper.
struct Page {
  double width_mm = 0, height_mm = 0;
};

/// "A4", "A3", "letter", or "WxHmm"; throws Error(kUsage).
Page ParsePage(const std::string& name);

/// A chessboard to print: columns x rows inner corners.
struct ChessboardSheet {
  int columns = 0, rows = 0;
  double square_mm = 0;
  Page page;  ///< turned, if only then the board fits
};

/// Throws Error(kUsage) if the board does not fit the page.
ChessboardSheet PlanChessboardSheet(int columns, int rows, double square_mm,
                                    Page page);

/// pattern.yaml, and the page as PDF, SVG (one user unit is 1 mm) and PNG. All
/// with a ruler of 100 mm, or of what fits, below the board.
std::string ChessboardYaml(const ChessboardSheet& sheet);
std::string ChessboardPdf(const ChessboardSheet& sheet);
std::string ChessboardSvg(const ChessboardSheet& sheet);
std::string ChessboardPng(const ChessboardSheet& sheet, double dpi);

}  // namespace raygrid

#endif  // RAYGRID_TARGET_CHESSBOARD_SHEET_H
