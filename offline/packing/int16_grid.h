#ifndef RAYGRID_PACKING_INT16_GRID_H
#define RAYGRID_PACKING_INT16_GRID_H

#include <cstdint>
#include <optional>
#include <vector>

#include "rg_blob.h"

namespace raygrid {

/// Pairs of 32-bit values, row by row.
struct ControlPoints {
  int columns = 0, rows = 0;
  std::vector<int32_t> values;  // 2 * columns * rows
};

/// Control points as a plane and 16-bit residuals.
struct Int16Grid {
  rg_narrow_grid section = {};  // without its residuals
  std::vector<int16_t> residuals;
};

/// Converts a grid to 16 bits with the maximum number of fraction bits that
/// fits, up to a limit; nullopt if 16 bits do not suffice.
std::optional<Int16Grid> QuantizeToInt16(
    const ControlPoints& points,
    uint32_t max_fraction_bits = RG_NARROW_MAX_BITS);

/// Converts grids to 16 bits with a common number of fraction bits; nullopt if
/// one does not fit.
std::optional<std::vector<Int16Grid>> QuantizeToInt16Together(
    const std::vector<ControlPoints>& grids);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_INT16_GRID_H
