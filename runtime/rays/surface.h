/* The spline surface over the calibrated area: the chart position of a pixel.
 */
#ifndef RAYGRID_SURFACE_H
#define RAYGRID_SURFACE_H

#include "blob_layout.h"
#include "bytes.h"
#include "raygrid.h"
#include "rays/stereographic.h"
#include "wide_multiply.h"

/* A position on one axis of a grid: the index of the cell, and the position in
 * it, from 0 to 1 inclusive. */
typedef struct rg_cell_position {
  uint32_t cell;
  int32_t t_q30;
} rg_cell_position;

/* Finds a position on an axis of a grid; axis is the grid's address for x, plus
 * 4 bytes for y. Returns 0 if value is outside. */
static RG_INLINE int rg_find_on_axis(const uint8_t* axis, uint32_t scale,
                                     uint32_t last_cell, int32_t value,
                                     rg_cell_position* position) {
  const uint32_t first = rg_load_u32(axis + RG_GRID_X0);
  const uint32_t offset = (uint32_t)value - first;
  if (offset > rg_load_u32(axis + RG_GRID_X1) - first) return 0;
  uint32_t low;
  const uint32_t high = rg_multiply_unsigned(offset, scale, &low);
  uint32_t cell = high >> 16;
  if (cell > last_cell) cell = last_cell; /* the far edge */
  const uint32_t t_q16 = high - (cell << 16);
  position->cell = cell;
  position->t_q30 = (int32_t)((t_q16 << 14) | (low >> 18));
  return 1;
}

/* A position in a grid, central or inverse, and the value of its spline. */
typedef struct rg_grid_position {
  rg_chart_point value; /* for an inverse grid: pixels in q15 */
  uint32_t cells;       /* column in the lower half, row in the upper */
  int32_t t_q30[2];     /* position in the cell, across and down */
  uint32_t first;       /* index of the first of 16 control points */
  int32_t weights_q31[2][4];
} rg_grid_position;

/* Finds the cell of a pixel in q16, or of a chart position in q27, and
 * evaluates the spline. RG_ERR_OUTSIDE_AREA if the position is outside. */
rg_status rg_evaluate_spline(const uint8_t* grid, int32_t x, int32_t y,
                             rg_grid_position* grid_position);

/* Finds the cell of a position: the first step of rg_evaluate_spline(). */
static RG_INLINE int rg_find_cells(const uint8_t* grid, int32_t x, int32_t y,
                                   rg_grid_position* grid_position) {
  rg_cell_position across, down;
  const uint32_t columns = rg_load_u16(grid + RG_GRID_COLUMNS);
  if (!rg_find_on_axis(grid, rg_load_u32(grid + RG_GRID_SCALE_X), columns - 4,
                       x, &across) ||
      !rg_find_on_axis(grid + 4, rg_load_u32(grid + RG_GRID_SCALE_Y),
                       rg_load_u16(grid + RG_GRID_ROWS) - 4u, y, &down))
    return 0;
  /* In this order, compilers can store two registers at once (STRD). */
  grid_position->cells = down.cell << 16 | across.cell;
  grid_position->t_q30[0] = across.t_q30;
  grid_position->first = down.cell * columns + across.cell;
  grid_position->t_q30[1] = down.t_q30;
  return 1;
}

/* One coordinate of the plane to which 16-bit residuals are added. */
static RG_INLINE int32_t
rg_evaluate_plane(const uint8_t* plane, const rg_grid_position* grid_position) {
  const int32_t column_step_q29 = rg_load_i32(plane + RG_PLANE_COLUMN_STEP);
  const int32_t row_step_q29 = rg_load_i32(plane + RG_PLANE_ROW_STEP);
  /* The B-spline of 0, 1, 2, 3 is 1 + t. */
  const uint32_t corner_q29 =
      rg_load_u32(plane + RG_PLANE_ORIGIN) +
      ((grid_position->cells & 0xffff) + 1) * (uint32_t)column_step_q29 +
      ((grid_position->cells >> 16) + 1) * (uint32_t)row_step_q29;
  const int32_t sum_q27 = rg_multiply_high_add(
      (int32_t)(corner_q29 + 2) >> 2, column_step_q29, grid_position->t_q30[0]);
  return rg_multiply_high_add(sum_q27, row_step_q29, grid_position->t_q30[1]);
}

/* Computes the derivatives of both coordinates of an inverse grid along both
 * chart axes, in q5 pixels per unit. */
void rg_compute_jacobian(const uint8_t* inverse,
                         const rg_grid_position* grid_position,
                         int32_t jacobian_q5[2][2]);

#endif /* RAYGRID_SURFACE_H */
