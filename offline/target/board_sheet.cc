#include "target/board_sheet.h"

#include <cairo-pdf.h>
#include <cairo-svg.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "appearance/board_appearance.h"
#include "dataset/error.h"
#include "target/board_drawing.h"

namespace raygrid {
namespace {

constexpr double kPointsPerMm = 72 / 25.4;
constexpr double kMarginMm = 5;  // not printable on most printers
constexpr double kTickMm = 3;
constexpr double kTextHeightMm = 3;
constexpr double kBelowBoardMm = 9;         // ruler and text
constexpr double kMarginBesideBoardMm = 5;  // ruler
constexpr int kMaxRulerMm = 200;

Page RotatePage(const Page& page) { return {page.height_mm, page.width_mm}; }

// Returns the width and height available inside margins and rulers.
double FreeWidth(const Page& page) {
  return page.width_mm - 2 * kMarginMm - kMarginBesideBoardMm;
}
double FreeHeight(const Page& page) {
  return page.height_mm - 2 * kMarginMm - kBelowBoardMm;
}

Eigen::Vector2d BoardSizeMm(const Board& board) {
  const Area extent_m = BoardAppearance(board).extent_m();
  return 1000 * Eigen::Vector2d(extent_m.width(), extent_m.height());
}

bool Fits(const Eigen::Vector2d& size_mm, const Page& page) {
  // The tolerance ensures that squares of the size proposed by the error
  // message fit.
  return size_mm.x() <= FreeWidth(page) + 1e-9 &&
         size_mm.y() <= FreeHeight(page) + 1e-9;
}

double ComputeMaxScale(const Eigen::Vector2d& size_mm, const Page& page) {
  return std::min(FreeWidth(page) / size_mm.x(),
                  FreeHeight(page) / size_mm.y());
}

// Describes the maximum number of columns and rows of this square size that fit
// the page; empty if too few.
std::string DescribeMaxCounts(const Board& board, const Page& page) {
  const bool has_gaps = board.IsTagGrid();
  const double square_mm = board.square_m * 1000;
  const double gap_mm = has_gaps ? square_mm * board.spacing_ratio : square_mm;
  const double pitch_mm = has_gaps ? square_mm + gap_mm : square_mm;
  const int columns =
      static_cast<int>(std::floor((FreeWidth(page) - gap_mm) / pitch_mm));
  const int rows =
      static_cast<int>(std::floor((FreeHeight(page) - gap_mm) / pitch_mm));
  if (std::min(columns, rows) < (has_gaps ? 1 : 2)) return "";
  return fmt::format(", or {} x {} {}", columns, rows,
                     has_gaps ? "tags" : "features");
}

[[noreturn]] void ThrowBoardTooLarge(const Board& board, const Page& page) {
  const Eigen::Vector2d size_mm = BoardSizeMm(board);
  const Page turned = RotatePage(page);
  const Page& better =
      ComputeMaxScale(size_mm, turned) > ComputeMaxScale(size_mm, page) ? turned
                                                                        : page;
  const double square_mm = board.square_m * 1000;
  const double max_size_mm =
      std::floor(10 * square_mm * ComputeMaxScale(size_mm, better) + 1e-9) / 10;
  std::string advice = "use a larger --page";
  if (max_size_mm > 0)
    advice += fmt::format("; this page fits {} {:.1f}{}",
                          KindOf(board).LengthOption(), max_size_mm,
                          DescribeMaxCounts(board, better));
  throw Error(ExitCode::kUsage,
              fmt::format("a board of {:g} x {:g} mm does not fit a page of "
                          "{:g} x {:g} mm with margins and rulers; {}",
                          size_mm.x(), size_mm.y(), page.width_mm,
                          page.height_mm, advice));
}

// Centres the board on the page, or as close to the centre as the ruler on the
// right allows.
Area ComputeBoardArea(const Eigen::Vector2d& size_mm, const Page& page) {
  const double x =
      std::min((page.width_mm - size_mm.x()) / 2,
               page.width_mm - kMarginMm - kMarginBesideBoardMm - size_mm.x());
  const double y = (page.height_mm - kBelowBoardMm - size_mm.y()) / 2;
  return {x, y, x + size_mm.x(), y + size_mm.y()};
}

// Returns the ruler length in mm: a multiple of 50 mm if that fits.
int RulerLength(const Page& page) {
  const int space_mm =
      static_cast<int>(std::min({page.width_mm - 2 * kMarginMm,
                                 page.height_mm - 2 * kMarginMm - kBelowBoardMm,
                                 static_cast<double>(kMaxRulerMm)}));
  return space_mm >= 50 ? space_mm / 50 * 50 : std::max(10, space_mm / 10 * 10);
}

// Draws a ruler from (0, 0) to the right, with upward ticks.
void DrawRuler(int length_mm, cairo_t* cr) {
  cairo_set_line_width(cr, 0.15);
  cairo_move_to(cr, 0, 0);
  cairo_line_to(cr, length_mm, 0);
  for (int mm = 0; mm <= length_mm; ++mm) {
    cairo_move_to(cr, mm, 0);
    cairo_line_to(cr, mm,
                  -kTickMm * (mm % 10 == 0  ? 1
                              : mm % 5 == 0 ? 2 / 3.
                                            : 1 / 3.));
  }
  cairo_stroke(cr);
}

void DrawRulers(const BoardSheets& sheets, cairo_t* cr) {
  const Page& page = sheets.page;
  const double below = page.height_mm - kMarginMm - kTextHeightMm - 1;
  cairo_save(cr);
  cairo_translate(cr, (page.width_mm - sheets.ruler_mm) / 2, below);
  DrawRuler(sheets.ruler_mm, cr);
  cairo_restore(cr);
  cairo_save(cr);
  const double bottom = (page.height_mm - kBelowBoardMm + sheets.ruler_mm) / 2;
  cairo_translate(cr, page.width_mm - kMarginMm, bottom);
  cairo_rotate(cr, -M_PI / 2);
  DrawRuler(sheets.ruler_mm, cr);
  cairo_restore(cr);
}

// Draws text, scaled down if the page is too narrow.
void DrawText(const std::string& text, const Page& page, cairo_t* cr) {
  cairo_set_font_size(cr, kTextHeightMm);
  cairo_text_extents_t extents;
  cairo_text_extents(cr, text.c_str(), &extents);
  const double free_mm = page.width_mm - 2 * kMarginMm;
  const double scale =
      std::min(1.0, free_mm / std::max(1e-3, extents.x_advance));
  cairo_set_font_size(cr, kTextHeightMm * scale);
  cairo_move_to(cr, (page.width_mm - scale * extents.x_advance) / 2,
                page.height_mm - kMarginMm - 0.2 * kTextHeightMm);
  cairo_show_text(cr, text.c_str());
}

// Draws a sheet; cairo's user unit is a millimetre.
void DrawSheet(const BoardSheets& sheets, const Board& board, cairo_t* cr) {
  cairo_set_source_rgb(cr, 1, 1, 1);
  cairo_paint(cr);
  DrawBoard(BoardAppearance(board), {sheets.board_mm.x0, sheets.board_mm.y0},
            1000, cr);
  cairo_set_source_rgb(cr, 0, 0, 0);
  DrawRulers(sheets, cr);
  DrawText(fmt::format("{} - print at 100 %: both rulers must be {} mm long",
                       KindOf(board).Describe(board), sheets.ruler_mm),
           sheets.page, cr);
}

}  // namespace

Page ParsePage(const std::string& name) {
  if (name == "A4") return {210, 297};
  if (name == "A3") return {297, 420};
  if (name == "letter") return {215.9, 279.4};
  Page page;
  int length = 0;
  if (std::sscanf(name.c_str(), "%lfx%lfmm%n", &page.width_mm, &page.height_mm,
                  &length) == 2 &&
      length == static_cast<int>(name.size()) && page.width_mm > 0 &&
      page.height_mm > 0 && std::max(page.width_mm, page.height_mm) <= 5000)
    return page;
  throw Error(ExitCode::kUsage,
              fmt::format("--page {}: expected A4, A3, letter or WxHmm", name));
}

BoardSheets PlanBoardSheets(std::vector<Board> boards, const Page& page) {
  RequirePossibleBoards(boards);
  BoardSheets sheets;
  sheets.page = page;
  const Eigen::Vector2d size_mm = BoardSizeMm(boards.front());
  if (!Fits(size_mm, page)) sheets.page = RotatePage(page);
  if (!Fits(size_mm, sheets.page)) ThrowBoardTooLarge(boards.front(), page);
  sheets.boards = std::move(boards);
  sheets.board_mm = ComputeBoardArea(size_mm, sheets.page);
  sheets.ruler_mm = RulerLength(sheets.page);
  return sheets;
}

PrintScale ComputePrintScale(const BoardSheets& sheets, double measured_x_mm,
                             double measured_y_mm) {
  const PrintScale scale = {measured_x_mm / sheets.ruler_mm,
                            measured_y_mm / sheets.ruler_mm};
  for (const double s : {scale.x, scale.y})
    if (!(s > 0.5 && s < 2))
      throw Error(ExitCode::kUsage,
                  fmt::format("--measured-x-mm {:g}, --measured-y-mm {:g}: "
                              "implausible, since the rulers are drawn {} mm "
                              "long; specify their measured lengths in mm",
                              measured_x_mm, measured_y_mm, sheets.ruler_mm));
  return scale;
}

std::string MakeSheetsYaml(const BoardSheets& sheets, const PrintScale& scale) {
  const Area extent_m = BoardAppearance(sheets.boards.front()).extent_m();
  BoardPosition place;
  place.width_mm = sheets.page.width_mm;
  place.height_mm = sheets.page.height_mm;
  place.first_feature_mm = {sheets.board_mm.x0 - 1000 * extent_m.x0,
                            sheets.board_mm.y0 - 1000 * extent_m.y0};
  return MakeBoardsYaml(sheets.boards, place, scale);
}

std::string SheetsPdf(const BoardSheets& sheets) {
  std::string pdf;
  cairo_surface_t* surface = cairo_pdf_surface_create_for_stream(
      AppendBytes, &pdf, sheets.page.width_mm * kPointsPerMm,
      sheets.page.height_mm * kPointsPerMm);
  // A fixed date makes the file reproducible.
  cairo_pdf_surface_set_metadata(surface, CAIRO_PDF_METADATA_CREATE_DATE,
                                 "2000-01-01T00:00:00Z");
  cairo_t* cr = cairo_create(surface);
  cairo_scale(cr, kPointsPerMm, kPointsPerMm);
  for (const Board& board : sheets.boards) {
    DrawSheet(sheets, board, cr);
    cairo_show_page(cr);
  }
  cairo_destroy(cr);
  FinishSurface(surface);
  return pdf;
}

std::string MakeSheetSvg(const BoardSheets& sheets, const Board& board) {
  std::string svg;
  cairo_surface_t* surface = cairo_svg_surface_create_for_stream(
      AppendBytes, &svg, sheets.page.width_mm, sheets.page.height_mm);
  cairo_svg_surface_set_document_unit(surface, CAIRO_SVG_UNIT_MM);
  cairo_t* cr = cairo_create(surface);
  DrawSheet(sheets, board, cr);
  cairo_destroy(cr);
  FinishSurface(surface);
  // Removes the surface ID, which cairo increments within a process and which
  // is not referenced.
  const size_t id = svg.find(" id=\"surface");
  if (id != std::string::npos) svg.erase(id, svg.find('"', id + 5) + 1 - id);
  return svg;
}

std::string RenderSheetPng(const BoardSheets& sheets, const Board& board,
                           double dpi) {
  const double pixels_per_mm = dpi / 25.4;
  const double width = std::round(sheets.page.width_mm * pixels_per_mm);
  const double height = std::round(sheets.page.height_mm * pixels_per_mm);
  if (!(width >= 1 && height >= 1 && width <= 32767 && height <= 32767))
    throw Error(ExitCode::kUsage,
                fmt::format("--dpi {:g}: the image would have {:g} x {:g} "
                            "pixels, the limit is 1 to 32767",
                            dpi, width, height));
  return RenderPng(static_cast<int>(width), static_cast<int>(height),
                   [&](cairo_t* cr) {
                     cairo_scale(cr, pixels_per_mm, pixels_per_mm);
                     DrawSheet(sheets, board, cr);
                   });
}

}  // namespace raygrid
