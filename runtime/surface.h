/* The spline surface over the calibrated area: the chart position of a pixel,
 * and the point of its line. */
#ifndef RAYGRID_SURFACE_H
#define RAYGRID_SURFACE_H

#include "bytes.h"
#include "raygrid.h"
#include "stereographic.h"
#include "wide_multiply.h"

/* A position on one axis of a grid: in which cell, and how far into it. */
typedef struct rg_cell_position {
  uint32_t cell;
  uint32_t t_q32;
} rg_cell_position;

/* Offset times scale must be q48 cells; an offset beyond the last cell counts
 * as its far edge. */
static inline rg_cell_position rg_find_cell(uint32_t offset, uint32_t scale,
                                            uint32_t num_cells) {
  uint32_t low;
  const uint32_t high = rg_multiply_unsigned(offset, scale, &low);
  rg_cell_position position = {high >> 16, (high << 16) | (low >> 16)};
  if (position.cell >= num_cells) {
    position.cell = num_cells - 1;
    position.t_q32 = 0xffffffffu;
  }
  return position;
}

/* The same on axis 0 or 1 of a section that begins with low ends, high ends,
 * counts and scales, of which there are two each; count is that of the cells
 * and surplus more. 0 if value lies outside. */
static inline int rg_find_on_axis(const uint8_t* section, uint32_t axis,
                                  int32_t value, uint32_t surplus,
                                  rg_cell_position* position) {
  const uint32_t low = rg_load_u32(section + 4 * axis);
  const uint32_t high = rg_load_u32(section + 8 + 4 * axis);
  const uint32_t offset = (uint32_t)value - low;
  if (offset > high - low) return 0;
  *position = rg_find_cell(offset, rg_load_u32(section + 20 + 4 * axis),
                           rg_load_u16(section + 16 + 2 * axis) - surplus);
  return 1;
}

/* Where a pixel lies in the grid. */
typedef struct rg_place {
  uint32_t first; /* of the 16 control points around it */
  uint32_t cell[2];
  int32_t t_q31[2];
  int32_t weights_q31[2][4];
} rg_place;

/* Chart position of a pixel; 0 if it lies outside the area. */
int rg_surface_position(const rg_camera* camera, rg_pixel pixel,
                        rg_place* place, rg_chart_point* position);

/* The line's point at a place; the camera must have line points. */
void rg_surface_line_point(const rg_camera* camera, const rg_place* place,
                           int32_t point_q28[3]);

#endif /* RAYGRID_SURFACE_H */
