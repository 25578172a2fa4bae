#ifndef RAYGRID_REPORT_CONTACT_SHEET_H
#define RAYGRID_REPORT_CONTACT_SHEET_H

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "dataset/image_files.h"

namespace raygrid {

/// Red, green and blue, 0 to 1.
using SheetColor = std::array<double, 3>;

constexpr SheetColor kTrustedColor = {0.15, 0.85, 0.25};
constexpr SheetColor kEmptyColor = {0.23, 0.23, 0.23};
constexpr SheetColor kAreaColor = {1.0, 0.85, 0.1};
constexpr SheetColor kStraightColor = {1.0, 0.35, 0.0};
/// The colour of a row's view by its number, again from the first one on after
/// the last one.
SheetColor ColorOfView(size_t view);

/// Strokes over a picture, in its pixels; (0, 0) is the centre of the first.
struct SheetCurves {
  std::vector<std::vector<Eigen::Vector2d>> curves;
  SheetColor color = kTrustedColor;
  double width = 2;  ///< in pixels of the sheet; from 2 on with a dark rim
  bool is_dashed = false;
};

/// A picture with its caption.
struct SheetTile {
  std::string title;
  std::vector<std::string> caption;
  Image picture;        ///< of 8 bits, grey or BGR; of no size: none
  std::string message;  ///< stands in the place of the picture
  std::vector<SheetCurves> curves;
  std::optional<SheetColor> frame;  ///< around the picture
};

struct SheetRow {
  std::vector<SheetTile> tiles;
};

/// A mark that the note at the sheet's end explains.
struct SheetMark {
  SheetColor color;
  bool is_dashed;
  std::string meaning;
};

/// The rows below each other, each from a line of its own on, at most four
/// pictures beside each other: 2400 px wide or less. Pictures are made as wide
/// as their column, or smaller where they are tall. Throws Error(kUsage) if
/// the sheet would be too high for a picture.
Image ContactSheet(const std::vector<SheetRow>& rows,
                   const std::vector<SheetMark>& marks);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_CONTACT_SHEET_H
