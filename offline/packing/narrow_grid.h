#ifndef RAYGRID_PACKING_NARROW_GRID_H
#define RAYGRID_PACKING_NARROW_GRID_H

#include <cstdint>
#include <optional>
#include <vector>

#include "rg_blob.h"

namespace raygrid {

/// Pairs of 32 bits, row by row.
struct ControlPoints {
  int columns = 0, rows = 0;
  std::vector<int32_t> values;  // 2 * columns * rows
};

/// Control points as a plane and residuals of 16 bits.
struct NarrowGrid {
  rg_narrow_grid section = {};  // its residuals are not set
  std::vector<int16_t> residuals;
};

/// The grid with as many fraction bits as fit, up to a limit; nothing where 16
/// bits do not reach.
std::optional<NarrowGrid> Narrow(
    const ControlPoints& points,
    uint32_t max_fraction_bits = RG_NARROW_MAX_BITS);

/// Grids with the same number of fraction bits; nothing where one has none.
std::optional<std::vector<NarrowGrid>> NarrowAlike(
    const std::vector<ControlPoints>& grids);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_NARROW_GRID_H
