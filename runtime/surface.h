/* The spline surface over the calibrated area: the chart position of a pixel,
 * and the point of its line. */
#ifndef RAYGRID_SURFACE_H
#define RAYGRID_SURFACE_H

#include "bytes.h"
#include "raygrid.h"
#include "stereographic.h"
#include "wide_multiply.h"

/* A position on one axis of a grid: in which cell, and how far into it, 1
 * included. */
typedef struct rg_cell_position {
  uint32_t cell;
  int32_t t_q30;
} rg_cell_position;

/* Offset times scale must be q48 cells; positions end with the last cell. */
static inline rg_cell_position rg_find_cell(uint32_t offset, uint32_t scale,
                                            uint32_t last_cell) {
  uint32_t low;
  const uint32_t high = rg_multiply_unsigned(offset, scale, &low);
  uint32_t cell = high >> 16;
  if (cell > last_cell) cell = last_cell;
  const uint32_t t_q16 = high - (cell << 16);
  const rg_cell_position position = {cell,
                                     (int32_t)((t_q16 << 14) | (low >> 18))};
  return position;
}

/* The same on axis 0 or 1 of a section that begins with low ends, high ends,
 * counts and scales, of which there are two each; count is the number of the
 * last cell and surplus more. 0 if value lies outside. */
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

/* Where a pixel of the area lies in the grid, and in the chart. */
typedef struct rg_place {
  rg_chart_point position;
  uint32_t first; /* of the 16 control points around it */
  int32_t x_weights_q31[4], y_weights_q31[4];
} rg_place;

/* 0 if the pixel lies outside the area. */
int rg_find_place(const rg_camera* camera, int32_t x_q16, int32_t y_q16,
                  rg_place* place);

/* The line's point at a place; the camera must have line points. */
void rg_surface_line_point(const rg_camera* camera, const rg_place* place,
                           int32_t point_q28[3]);

#endif /* RAYGRID_SURFACE_H */
