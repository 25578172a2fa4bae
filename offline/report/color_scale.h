#ifndef RAYGRID_REPORT_COLOR_SCALE_H
#define RAYGRID_REPORT_COLOR_SCALE_H

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "dataset/image_files.h"

namespace raygrid {

/// Scales that the colour-blind read too.
enum class ColorScale {
  kMagnitude,  ///< inferno: from black to bright
  kEven,       ///< cividis: from dark blue to yellow
  kDirection  ///< twilight: a circle; dark and light, red and blue are opposite
};

/// Blue, green, red for a part from 0 to 1.
std::array<uint8_t, 3> ColorOf(ColorScale scale, double part);

/// "linear-gradient(to right,#000004,...)".
std::string CssGradient(ColorScale scale);

/// Values row by row, from low to high; white where there is none. Each is
/// cell_px wide and high.
Image HeatMap(const std::vector<double>& values, int columns, double low,
              double high, int cell_px, ColorScale scale = ColorScale::kEven);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_COLOR_SCALE_H
