/* The source positions of a remap table as rg_remap() computes them, for
 * programs that measure tables: tiles (tile_corners.h), their rows (block.h),
 * and the components of pixel formats. Other headers of the runtime are
 * private. */
#ifndef RAYGRID_TABLE_POSITIONS_H
#define RAYGRID_TABLE_POSITIONS_H

#include "cortex_m/tile_corners.h"
#include "frames/component_map.h"
#include "frames/pixel_formats.h"
#include "kernels/block.h"

#endif /* RAYGRID_TABLE_POSITIONS_H */
