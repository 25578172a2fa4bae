/* The spline surface over the calibrated area: chart position of a pixel, and
 * its derivative. */
#ifndef RAYGRID_SURFACE_H
#define RAYGRID_SURFACE_H

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

/* Where a pixel of the area lies in the grid, x then y. */
static inline void rg_find_cells(const rg_camera* camera, rg_pixel pixel,
                                 rg_cell_position cells[2]) {
  cells[0] = rg_find_cell((uint32_t)(pixel.x_q16 - camera->x0_q16),
                          camera->scale_x_q32, camera->columns - 3u);
  cells[1] = rg_find_cell((uint32_t)(pixel.y_q16 - camera->y0_q16),
                          camera->scale_y_q32, camera->rows - 3u);
}

static inline int rg_is_in_area(const rg_camera* camera, rg_pixel pixel) {
  return pixel.x_q16 >= camera->x0_q16 && pixel.x_q16 <= camera->x1_q16 &&
         pixel.y_q16 >= camera->y0_q16 && pixel.y_q16 <= camera->y1_q16;
}

/* Chart position of a pixel of the area. */
void rg_surface_position(const rg_camera* camera, rg_pixel pixel,
                         rg_chart_point* position);

/* The line's point of a pixel of the area; the camera must have line points. */
void rg_surface_line_point(const rg_camera* camera, rg_pixel pixel,
                           int32_t point_q28[3]);

/* by_pixel[i][j]: of chart coordinate i by pixel coordinate j, in q26 per
 * pixel. */
typedef struct rg_tangent {
  rg_chart_point position;
  int32_t by_pixel_q26[2][2];
} rg_tangent;

/* The same, and the derivative. */
void rg_surface_tangent(const rg_camera* camera, rg_pixel pixel,
                        rg_tangent* tangent);

#endif /* RAYGRID_SURFACE_H */
