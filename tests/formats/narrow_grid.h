/* A grid of 16 bits as the writer takes it, from a section. */
#ifndef RAYGRID_NARROW_GRID_H
#define RAYGRID_NARROW_GRID_H

#include "blob_layout.h"
#include "bytes.h"
#include "rg_blob.h"

/* Reads the plane and the residuals of a central or an inverse grid's section,
 * which was checked.
 *
 * residuals  room for two of each control point; taken points to them */
static inline void read_narrow_grid(const uint8_t* section, int16_t* residuals,
                                    rg_narrow_grid* taken) {
  const uint8_t* const data =
      section + rg_load_u32(section + RG_GRID_DATA_OFFSET);
  const uint32_t count = 2u * rg_load_u16(section + RG_GRID_COLUMNS) *
                         rg_load_u16(section + RG_GRID_ROWS);
  taken->fraction_bits = rg_load_u16(section + RG_GRID_FRACTION_BITS);
  taken->residuals = residuals;
  for (uint32_t c = 0; c < 2; ++c) {
    taken->origin_q29[c] = rg_load_i32(data + RG_PLANE_ORIGIN + 4 * c);
    taken->column_step_q29[c] =
        rg_load_i32(data + RG_PLANE_COLUMN_STEP + 4 * c);
    taken->row_step_q29[c] = rg_load_i32(data + RG_PLANE_ROW_STEP + 4 * c);
  }
  for (uint32_t k = 0; k < count; ++k)
    residuals[k] = rg_load_i16(data + RG_NARROW_PLANE_SIZE + 2 * k);
}

#endif /* RAYGRID_NARROW_GRID_H */
