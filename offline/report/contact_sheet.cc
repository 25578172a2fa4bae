#include "report/contact_sheet.h"

#include <cairo.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/imgproc.hpp>

#include "dataset/error.h"

namespace raygrid {
namespace {

constexpr int kMaxSheetWidth = 2400, kMaxSheetHeight = 32000;
constexpr int kMaxColumns = 4;
constexpr int kMaxTileWidth = 760;
constexpr int kColumnGap = 24;
constexpr double kTitleSize = 17, kTextSize = 15, kLineHeight = 21;
constexpr double kMinTextSize = 10;
constexpr SheetColor kPaper = {1, 1, 1}, kInk = {0.1, 0.1, 0.12};

void SetColor(const SheetColor& color, double alpha, cairo_t* cr) {
  cairo_set_source_rgba(cr, color[0], color[1], color[2], alpha);
}

// ---- Text ------------------------------------------------------------------

double TextWidth(const std::string& text, cairo_t* cr) {
  cairo_text_extents_t extents;
  cairo_text_extents(cr, text.c_str(), &extents);
  return extents.x_advance;
}

// Removes the last character of a UTF-8 text.
void DropLastCharacter(std::string* text) {
  while (!text->empty() && (text->back() & 0xc0) == 0x80) text->pop_back();
  if (!text->empty()) text->pop_back();
}

// Draws a line of text, with a smaller font if it is too long, and truncated if
// necessary.
void DrawLine(std::string text, double x, double baseline, double width,
              double size, cairo_t* cr) {
  cairo_set_font_size(cr, size);
  const double needed = TextWidth(text, cr);
  if (needed > width)
    cairo_set_font_size(cr, std::max(kMinTextSize, size * width / needed));
  if (TextWidth(text, cr) > width) {
    while (!text.empty() && TextWidth(text + "...", cr) > width)
      DropLastCharacter(&text);
    text += "...";
  }
  cairo_move_to(cr, x, baseline);
  cairo_show_text(cr, text.c_str());
}

std::vector<std::string> FormatWrapped(const std::string& text, double width,
                                       cairo_t* cr) {
  std::vector<std::string> lines = {""};
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find(' ', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    std::string& line = lines.back();
    if (line.empty())
      line = word;
    else if (TextWidth(line + " " + word, cr) <= width)
      line += " " + word;
    else
      lines.push_back(word);
    begin = end + 1;
  }
  return lines;
}

void SelectFont(bool is_bold, cairo_t* cr) {
  cairo_select_font_face(
      cr, "sans", CAIRO_FONT_SLANT_NORMAL,
      is_bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
}

// ---- Pictures --------------------------------------------------------------

struct Box {
  double x = 0, y = 0, width = 0, height = 0;
};

// Returns a picture's size in a column: the height is limited to the column's
// width.
Box ComputeSizeInColumn(const Image& picture, int column_width) {
  const double width = picture.size.width, height = picture.size.height;
  Box box;
  box.width = column_width;
  box.height = column_width * 0.75;
  if (width < 1 || height < 1) return box;
  const double scale = std::min(column_width / width, column_width / height);
  box.width = std::max(1.0, std::round(width * scale));
  box.height = std::max(1.0, std::round(height * scale));
  return box;
}

// Returns the picture, resized to a box, in cairo's pixel format.
cv::Mat ResizeImage(const Image& picture, const Box& box) {
  const cv::Mat whole(picture.size.height, picture.size.width,
                      CV_8UC(picture.channels),
                      const_cast<uint8_t*>(picture.pixels.data()));
  const bool is_smaller = box.width < picture.size.width;
  cv::Mat resized, result;
  cv::resize(whole, resized,
             {static_cast<int>(box.width), static_cast<int>(box.height)}, 0, 0,
             is_smaller ? cv::INTER_AREA : cv::INTER_LINEAR);
  cv::cvtColor(
      resized, result,
      picture.channels == 1 ? cv::COLOR_GRAY2BGRA : cv::COLOR_BGR2BGRA);
  return result;
}

void DrawImage(const Image& picture, const Box& box, cairo_t* cr) {
  cv::Mat pixels = ResizeImage(picture, box);
  cairo_surface_t* surface = cairo_image_surface_create_for_data(
      pixels.data, CAIRO_FORMAT_RGB24, pixels.cols, pixels.rows,
      static_cast<int>(pixels.step));
  cairo_set_source_surface(cr, surface, box.x, box.y);
  cairo_paint(cr);
  cairo_surface_destroy(surface);
}

void DrawMessage(const std::string& message, const Box& box, cairo_t* cr) {
  SetColor(kEmptyColor, 1, cr);
  cairo_rectangle(cr, box.x, box.y, box.width, box.height);
  cairo_fill(cr);
  SetColor(kPaper, 1, cr);
  SelectFont(false, cr);
  cairo_set_font_size(cr, kTextSize);
  const double width = box.width - 2 * kColumnGap;
  const std::vector<std::string> lines = FormatWrapped(message, width, cr);
  double y = box.y + box.height / 2 - kLineHeight * (lines.size() - 1) / 2;
  for (const std::string& line : lines) {
    DrawLine(line, box.x + kColumnGap, y, width, kTextSize, cr);
    y += kLineHeight;
  }
}

void DrawCurves(const SheetCurves& drawn, const ImageSize& size, const Box& box,
                cairo_t* cr) {
  cairo_save(cr);
  cairo_rectangle(cr, box.x, box.y, box.width, box.height);
  cairo_clip(cr);
  for (const auto& curve : drawn.curves) {
    cairo_new_sub_path(cr);
    for (const Eigen::Vector2d& pixel : curve)
      cairo_line_to(cr, box.x + (pixel.x() + 0.5) * box.width / size.width,
                    box.y + (pixel.y() + 0.5) * box.height / size.height);
  }
  cairo_set_line_cap(cr, CAIRO_LINE_CAP_ROUND);
  cairo_set_line_join(cr, CAIRO_LINE_JOIN_ROUND);
  const double dashes[] = {8, 6};
  if (drawn.is_dashed) cairo_set_dash(cr, dashes, 2, 0);
  if (drawn.width >= 2) {
    cairo_set_line_width(cr, drawn.width + 2);
    SetColor({0, 0, 0}, 0.5, cr);
    cairo_stroke_preserve(cr);
  }
  cairo_set_line_width(cr, drawn.width);
  SetColor(drawn.color, drawn.width >= 2 ? 1 : 0.9, cr);
  cairo_stroke(cr);
  cairo_restore(cr);
}

double CaptionHeight(const SheetTile& tile) {
  return kLineHeight * (1 + tile.caption.size()) + 6;
}

// Draws the title and the caption above the picture.
void DrawTile(const SheetTile& tile, double x, double y, double caption_height,
              int column_width, cairo_t* cr) {
  SetColor(kInk, 1, cr);
  SelectFont(true, cr);
  double baseline = y + kTitleSize;
  DrawLine(tile.title, x, baseline, column_width, kTitleSize, cr);
  SelectFont(false, cr);
  for (const std::string& line : tile.caption)
    DrawLine(line, x, baseline += kLineHeight, column_width, kTextSize, cr);
  Box box = ComputeSizeInColumn(tile.picture, column_width);
  box.x = x;
  box.y = y + caption_height;
  if (tile.picture.size.width > 0)
    DrawImage(tile.picture, box, cr);
  else
    DrawMessage(tile.message, box, cr);
  for (const SheetCurves& curves : tile.curves)
    DrawCurves(curves, tile.picture.size, box, cr);
  if (!tile.frame) return;
  SetColor(*tile.frame, 1, cr);
  cairo_set_line_width(cr, 3);
  cairo_rectangle(cr, box.x - 1.5, box.y - 1.5, box.width + 3, box.height + 3);
  cairo_stroke(cr);
}

// ---- The sheet -------------------------------------------------------------

// A row of tiles.
struct Line {
  std::vector<const SheetTile*> tiles;
  double caption_height = 0, height = 0;
};

std::vector<Line> WrapLines(const std::vector<SheetRow>& rows, int columns,
                            int column_width) {
  std::vector<Line> lines;
  for (const SheetRow& row : rows) {
    for (size_t k = 0; k < row.tiles.size(); ++k) {
      if (k % columns == 0) lines.emplace_back();
      lines.back().tiles.push_back(&row.tiles[k]);
    }
  }
  for (Line& line : lines) {
    double image_height = 0;
    for (const SheetTile* tile : line.tiles) {
      line.caption_height = std::max(line.caption_height, CaptionHeight(*tile));
      image_height =
          std::max(image_height,
                   ComputeSizeInColumn(tile->picture, column_width).height);
    }
    line.height = line.caption_height + image_height + kColumnGap;
  }
  return lines;
}

void DrawMarks(const std::vector<SheetMark>& marks, double y, double width,
               cairo_t* cr) {
  constexpr double kStroke = 34;
  double x = kColumnGap;
  SelectFont(false, cr);
  cairo_set_font_size(cr, kTextSize);
  for (const SheetMark& mark : marks) {
    const double needed = kStroke + 8 + TextWidth(mark.meaning, cr);
    if (x > kColumnGap && x + needed > width - kColumnGap) {
      x = kColumnGap;
      y += kLineHeight;
    }
    const double dashes[] = {8, 6};
    if (mark.is_dashed) cairo_set_dash(cr, dashes, 2, 0);
    SetColor(mark.color, 1, cr);
    cairo_set_line_width(cr, 3);
    cairo_move_to(cr, x, y - 5);
    cairo_line_to(cr, x + kStroke, y - 5);
    cairo_stroke(cr);
    cairo_set_dash(cr, nullptr, 0, 0);
    SetColor(kInk, 1, cr);
    cairo_move_to(cr, x + kStroke + 8, y);
    cairo_show_text(cr, mark.meaning.c_str());
    x += needed + kColumnGap;
  }
}

Image CopySurface(cairo_surface_t* surface) {
  cairo_surface_flush(surface);
  const cv::Mat pixels(cairo_image_surface_get_height(surface),
                       cairo_image_surface_get_width(surface), CV_8UC4,
                       cairo_image_surface_get_data(surface),
                       cairo_image_surface_get_stride(surface));
  cv::Mat picture;
  cv::cvtColor(pixels, picture, cv::COLOR_BGRA2BGR);
  Image image;
  image.size = {picture.cols, picture.rows};
  image.channels = 3;
  image.pixels.assign(picture.datastart, picture.dataend);
  return image;
}

}  // namespace

SheetColor GetViewColor(size_t view) {
  constexpr SheetColor kColors[] = {{0.20, 0.55, 1.00}, {1.00, 0.20, 0.75},
                                    {0.10, 0.80, 0.85}, {0.65, 0.40, 1.00},
                                    {0.80, 0.10, 0.15}, {0.60, 0.45, 0.25}};
  return kColors[view % std::size(kColors)];
}

Image ContactSheet(const std::vector<SheetRow>& rows,
                   const std::vector<SheetMark>& marks) {
  int columns = 1;
  for (const SheetRow& row : rows)
    columns = std::max(columns, static_cast<int>(row.tiles.size()));
  columns = std::min(columns, kMaxColumns);
  const int column_width = std::min(
      kMaxTileWidth, (kMaxSheetWidth - kColumnGap * (columns + 1)) / columns);
  const int width = columns * (column_width + kColumnGap) + kColumnGap;
  const std::vector<Line> lines = WrapLines(rows, columns, column_width);
  constexpr double kMarkLines = 3;
  double height = kColumnGap + kMarkLines * kLineHeight;
  for (const Line& line : lines) height += line.height;
  if (height > kMaxSheetHeight)
    throw Error(ExitCode::kUsage,
                fmt::format("the sheet would be {:.0f} px high, above the "
                            "limit of {}; use fewer files",
                            height, kMaxSheetHeight));
  const std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>
      surface(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width,
                                         static_cast<int>(height)),
              cairo_surface_destroy);
  const std::unique_ptr<cairo_t, decltype(&cairo_destroy)> context(
      cairo_create(surface.get()), cairo_destroy);
  cairo_t* const cr = context.get();
  SetColor(kPaper, 1, cr);
  cairo_paint(cr);
  double y = kColumnGap;
  for (const Line& line : lines) {
    double x = kColumnGap;
    for (const SheetTile* tile : line.tiles) {
      DrawTile(*tile, x, y, line.caption_height, column_width, cr);
      x += column_width + kColumnGap;
    }
    y += line.height;
  }
  DrawMarks(marks, y + kLineHeight / 2, width, cr);
  if (cairo_status(cr) != CAIRO_STATUS_SUCCESS)
    throw Error(ExitCode::kOutputFailed,
                std::string("cannot draw the sheet: ") +
                    cairo_status_to_string(cairo_status(cr)));
  return CopySurface(surface.get());
}

}  // namespace raygrid
