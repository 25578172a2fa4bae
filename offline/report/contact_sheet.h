#ifndef RAYGRID_REPORT_CONTACT_SHEET_H
#define RAYGRID_REPORT_CONTACT_SHEET_H

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "dataset/image_files.h"

namespace raygrid {

/// RGB components, from 0 to 1.
using SheetColor = std::array<double, 3>;

constexpr SheetColor kValidColor = {0.15, 0.85, 0.25};
constexpr SheetColor kEmptyColor = {0.23, 0.23, 0.23};
constexpr SheetColor kAreaColor = {1.0, 0.85, 0.1};
constexpr SheetColor kStraightColor = {1.0, 0.35, 0.0};
/// Returns the colour of a view by its index; colours repeat cyclically.
SheetColor GetViewColor(size_t view);

/// Strokes over a picture, in pixels; (0, 0) is the centre of the first pixel.
struct SheetCurves {
  std::vector<std::vector<Eigen::Vector2d>> curves;
  SheetColor color = kValidColor;
  double width = 2;  ///< sheet pixels; with dark outline from 2 on
  bool is_dashed = false;
};

/// A picture with its caption.
struct SheetTile {
  std::string title;
  std::vector<std::string> caption;
  Image picture;        ///< 8 bits, grey or BGR; may be empty
  std::string message;  ///< drawn instead of the picture
  std::vector<SheetCurves> curves;
  std::optional<SheetColor> frame;  ///< colour of a frame around it
};

struct SheetRow {
  std::vector<SheetTile> tiles;
};

/// A marker that is explained by the note at the end of the sheet.
struct SheetMark {
  SheetColor color;
  bool is_dashed;
  std::string meaning;
};

/// Draws the rows below each other, each on a new line, with at most four
/// pictures side by side: at most 2400 px wide. Pictures are scaled to the
/// width of their column, or smaller if they are tall. Throws Error(kUsage) if
/// the sheet would exceed the maximum height of an image.
Image ContactSheet(const std::vector<SheetRow>& rows,
                   const std::vector<SheetMark>& marks);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_CONTACT_SHEET_H
