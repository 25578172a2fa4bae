#include "target/chessboard_sheet.h"

#include <cairo-pdf.h>
#include <cairo-svg.h>
#include <cairo.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "dataset/error.h"

namespace raygrid {
namespace {

constexpr double kPointsPerMm = 72 / 25.4;
constexpr double kMarginMm = 5;
constexpr double kRulerSpaceMm = 12;  // below the board

double BoardWidth(const ChessboardSheet& sheet) {
  return (sheet.columns + 1) * sheet.square_mm;
}
double BoardHeight(const ChessboardSheet& sheet) {
  return (sheet.rows + 1) * sheet.square_mm;
}
double BoardLeft(const ChessboardSheet& sheet) {
  return (sheet.page.width_mm - BoardWidth(sheet)) / 2;
}
double BoardTop(const ChessboardSheet& sheet) {
  return (sheet.page.height_mm - kRulerSpaceMm - BoardHeight(sheet)) / 2;
}

bool Fits(const ChessboardSheet& sheet) {
  return BoardLeft(sheet) >= kMarginMm && BoardTop(sheet) >= kMarginMm;
}

void DrawRuler(const ChessboardSheet& sheet, cairo_t* cr) {
  const int length_mm = std::clamp(
      static_cast<int>(sheet.page.width_mm - 2 * kMarginMm) / 10 * 10, 10, 100);
  const double left = (sheet.page.width_mm - length_mm) / 2;
  const double y = sheet.page.height_mm - 6;
  cairo_set_line_width(cr, 0.15);
  cairo_move_to(cr, left, y);
  cairo_line_to(cr, left + length_mm, y);
  for (int mm = 0; mm <= length_mm; ++mm) {
    cairo_move_to(cr, left + mm, y);
    cairo_line_to(cr, left + mm, y - (mm % 10 == 0 ? 3 : mm % 5 == 0 ? 2 : 1));
  }
  cairo_stroke(cr);
  cairo_set_font_size(cr, 3);
  cairo_move_to(cr, left, y + 3.5);
  cairo_show_text(
      cr, fmt::format("{} mm - squares {:g} mm, {} x {} inner "
                      "corners - print at 100 %",
                      length_mm, sheet.square_mm, sheet.columns, sheet.rows)
              .c_str());
}

// In user units of a millimetre.
void Draw(const ChessboardSheet& sheet, cairo_t* cr) {
  cairo_set_source_rgb(cr, 1, 1, 1);
  cairo_paint(cr);
  cairo_set_source_rgb(cr, 0, 0, 0);
  for (int row = 0; row <= sheet.rows; ++row)
    for (int column = 0; column <= sheet.columns; ++column)
      if ((row + column) % 2 == 0)
        cairo_rectangle(cr, BoardLeft(sheet) + column * sheet.square_mm,
                        BoardTop(sheet) + row * sheet.square_mm,
                        sheet.square_mm, sheet.square_mm);
  cairo_fill(cr);
  DrawRuler(sheet, cr);
}

cairo_status_t Append(void* text, const unsigned char* data,
                      unsigned int length) {
  static_cast<std::string*>(text)->append(reinterpret_cast<const char*>(data),
                                          length);
  return CAIRO_STATUS_SUCCESS;
}

// Draws on a surface and finishes it.
void DrawOn(const ChessboardSheet& sheet, double units_per_mm,
            cairo_surface_t* surface) {
  cairo_t* cr = cairo_create(surface);
  cairo_scale(cr, units_per_mm, units_per_mm);
  Draw(sheet, cr);
  cairo_destroy(cr);
}

void Finish(cairo_surface_t* surface) {
  cairo_surface_finish(surface);
  const cairo_status_t status = cairo_surface_status(surface);
  cairo_surface_destroy(surface);
  if (status != CAIRO_STATUS_SUCCESS)
    throw Error(ExitCode::kOutput, cairo_status_to_string(status));
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
              fmt::format("--page {}: use A4, A3, letter or WxHmm", name));
}

ChessboardSheet PlanChessboardSheet(int columns, int rows, double square_mm,
                                    Page page) {
  if (columns < 2 || rows < 2 || columns > 1000 || rows > 1000 ||
      !(square_mm > 0) || !std::isfinite(square_mm))
    throw Error(ExitCode::kUsage,
                "a chessboard has 2 to 1000 columns and rows of inner corners, "
                "and squares of more than 0 mm");
  ChessboardSheet sheet = {columns, rows, square_mm, page};
  if (Fits(sheet)) return sheet;
  std::swap(sheet.page.width_mm, sheet.page.height_mm);
  if (Fits(sheet)) return sheet;
  throw Error(
      ExitCode::kUsage,
      fmt::format("a board of {:g} x {:g} mm does not fit a page of "
                  "{:g} x {:g} mm with margins; take smaller squares or "
                  "a larger --page",
                  BoardWidth(sheet), BoardHeight(sheet), page.width_mm,
                  page.height_mm));
}

std::string ChessboardYaml(const ChessboardSheet& sheet) {
  return fmt::format(
      "raygrid_pattern: 1\n"
      "boards:\n"
      "  - {{id: 0, kind: chessboard, columns: {}, rows: {}, square_m: {:g}}}\n"
      "page: {{width_m: {:g}, height_m: {:g}, first_feature_m: [{:g}, "
      "{:g}]}}\n",
      sheet.columns, sheet.rows, sheet.square_mm / 1000,
      sheet.page.width_mm / 1000, sheet.page.height_mm / 1000,
      (BoardLeft(sheet) + sheet.square_mm) / 1000,
      (BoardTop(sheet) + sheet.square_mm) / 1000);
}

std::string ChessboardPdf(const ChessboardSheet& sheet) {
  std::string pdf;
  cairo_surface_t* surface = cairo_pdf_surface_create_for_stream(
      Append, &pdf, sheet.page.width_mm * kPointsPerMm,
      sheet.page.height_mm * kPointsPerMm);
  // The same input gives the same file, whatever the clock says.
  cairo_pdf_surface_set_metadata(surface, CAIRO_PDF_METADATA_CREATE_DATE,
                                 "2000-01-01T00:00:00Z");
  DrawOn(sheet, kPointsPerMm, surface);
  Finish(surface);
  return pdf;
}

std::string ChessboardSvg(const ChessboardSheet& sheet) {
  std::string svg;
  cairo_surface_t* surface = cairo_svg_surface_create_for_stream(
      Append, &svg, sheet.page.width_mm, sheet.page.height_mm);
  cairo_svg_surface_set_document_unit(surface, CAIRO_SVG_UNIT_MM);
  DrawOn(sheet, 1, surface);
  Finish(surface);
  // Cairo numbers all surfaces of a process; nothing refers to this one.
  const size_t id = svg.find(" id=\"surface");
  if (id != std::string::npos) svg.erase(id, svg.find('"', id + 5) + 1 - id);
  return svg;
}

std::string ChessboardPng(const ChessboardSheet& sheet, double dpi) {
  const double pixels_per_mm = dpi / 25.4;
  const double width = std::round(sheet.page.width_mm * pixels_per_mm);
  const double height = std::round(sheet.page.height_mm * pixels_per_mm);
  if (!(width >= 1 && height >= 1 && width <= 32767 && height <= 32767))
    throw Error(ExitCode::kUsage,
                fmt::format("--dpi {:g}: the picture would have {:g} x {:g} "
                            "pixels; 1 to 32767 are possible",
                            dpi, width, height));
  cairo_surface_t* surface = cairo_image_surface_create(
      CAIRO_FORMAT_RGB24, static_cast<int>(width), static_cast<int>(height));
  DrawOn(sheet, pixels_per_mm, surface);
  std::string png;
  const cairo_status_t status =
      cairo_surface_write_to_png_stream(surface, Append, &png);
  Finish(surface);
  if (status != CAIRO_STATUS_SUCCESS)
    throw Error(ExitCode::kOutput, cairo_status_to_string(status));
  return png;
}

}  // namespace raygrid
