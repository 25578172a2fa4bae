#ifndef RAYGRID_REPORT_COLOR_SCALE_H
#define RAYGRID_REPORT_COLOR_SCALE_H

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "dataset/image_files.h"

namespace raygrid {

/// Colour scales that are readable with colour blindness.
enum class ColorScale {
  kMagnitude,  ///< inferno: from black to bright
  kEven,       ///< cividis: from dark blue to yellow
  kDirection   ///< twilight: cyclic; opposite directions differ most
};

/// Returns blue, green and red of a value from 0 to 1.
std::array<uint8_t, 3> GetColor(ColorScale scale, double part);

/// Formats a gradient for CSS: "linear-gradient(to right,#000004,...)".
std::string CssGradient(ColorScale scale);

/// Draws values row by row, scaled from low to high; NaN is white. Each cell is
/// a square of cell_px pixels.
Image HeatMap(const std::vector<double>& values, int columns, double low,
              double high, int knot_spacing_px,
              ColorScale scale = ColorScale::kEven);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_COLOR_SCALE_H
