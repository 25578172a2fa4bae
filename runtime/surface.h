/* The spline surface over the calibrated area: the chart position of a pixel.
 */
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

/* Reads axis 0 or 1 of a section that begins with two low ends, two high ends,
 * two counts and two scales. */
static inline void rg_read_axis(const uint8_t* section, uint32_t c,
                                rg_axis* axis) {
  axis->low = rg_load_i32(section + 4 * c);
  axis->span = rg_load_u32(section + 8 + 4 * c) - (uint32_t)axis->low;
  axis->scale = rg_load_u32(section + 20 + 4 * c);
}

/* 0 if value lies outside. */
static RG_INLINE int rg_find_on_axis(const rg_axis* axis, uint32_t last_cell,
                                     int32_t value,
                                     rg_cell_position* position) {
  const uint32_t offset = (uint32_t)value - (uint32_t)axis->low;
  if (offset > axis->span) return 0;
  uint32_t low;
  const uint32_t high = rg_multiply_unsigned(offset, axis->scale, &low);
  uint32_t cell = high >> 16;
  if (cell > last_cell) cell = last_cell; /* the far edge */
  const uint32_t t_q16 = high - (cell << 16);
  position->cell = cell;
  position->t_q30 = (int32_t)((t_q16 << 14) | (low >> 18));
  return 1;
}

/* Where a pixel of the area lies in the grid, and in the chart. */
typedef struct rg_place {
  rg_chart_point position;
  uint32_t first; /* of the 16 control points around it */
  rg_cell_position cells[2];
  int32_t weights_q31[2][4]; /* across, down */
} rg_place;

/* 0 if the pixel lies outside the area. */
int rg_find_place(const rg_camera* camera, int32_t x_q16, int32_t y_q16,
                  rg_place* place);

/* What an inverse grid says of a chart position. */
typedef struct rg_inverse_place {
  int32_t pixel_q16[2];       /* about where it is seen, within 16384 px */
  int32_t by_cells_q17[2][2]; /* how x and y change per cell across; down */
} rg_inverse_place;

/* 0 if the position lies outside the grid. */
int rg_find_inverse(const uint8_t* inverse, const rg_chart_point* position,
                    rg_inverse_place* place);

#endif /* RAYGRID_SURFACE_H */
