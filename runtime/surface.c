#include "surface.h"

#include "bspline.h"
#include "bytes.h"
#include "fixed_point.h"
#include "rg_blob.h"

/* Control points of 32 bits. Each product is rounded: q29 to q28 in the rows,
 * to q27 in the column. */
static RG_INLINE void sum_wide(const uint8_t* points, uint32_t row_bytes,
                               rg_place* place) {
  const int32_t* const w_q31 = place->x_weights_q31;
  int32_t a_q27 = 0, b_q27 = 0;
  for (int j = 0; j < 4; ++j, points += row_bytes) {
    int32_t b, a = rg_load_i32_pair(points, &b);
    int32_t row_a = rg_multiply_high(a, w_q31[0]);
    int32_t row_b = rg_multiply_high(b, w_q31[0]);
    a = rg_load_i32_pair(points + 8, &b);
    row_a = rg_multiply_high_add(row_a, a, w_q31[1]);
    row_b = rg_multiply_high_add(row_b, b, w_q31[1]);
    a = rg_load_i32_pair(points + 16, &b);
    row_a = rg_multiply_high_add(row_a, a, w_q31[2]);
    row_b = rg_multiply_high_add(row_b, b, w_q31[2]);
    a = rg_load_i32_pair(points + 24, &b);
    row_a = rg_multiply_high_add(row_a, a, w_q31[3]);
    row_b = rg_multiply_high_add(row_b, b, w_q31[3]);
    a_q27 = rg_multiply_high_add(a_q27, row_a, place->y_weights_q31[j]);
    b_q27 = rg_multiply_high_add(b_q27, row_b, place->y_weights_q31[j]);
  }
  place->position.q28[0] = 2 * a_q27;
  place->position.q28[1] = 2 * b_q27;
}

int rg_find_place(const rg_camera* camera, int32_t x_q16, int32_t y_q16,
                  rg_place* place) {
  const uint8_t* const grid = camera->grid;
  rg_cell_position x, y;
  if (!rg_find_on_axis(grid, 0, x_q16, 4, &x) ||
      !rg_find_on_axis(grid, 1, y_q16, 4, &y))
    return 0;
  rg_bspline_weights(y.t_q30, place->y_weights_q31);
  rg_bspline_weights(x.t_q30, place->x_weights_q31);
  const uint32_t columns = rg_load_u16(grid + 16);
  place->first = y.cell * columns + x.cell;
  sum_wide(camera->control_points + 8 * place->first, 8 * columns, place);
  return 1;
}

/* One coordinate of points of 12 bytes. */
static RG_INLINE int32_t sum_coordinate(const uint8_t* points,
                                        uint32_t row_bytes,
                                        const rg_place* place) {
  const int32_t* const w_q31 = place->x_weights_q31;
  int32_t sum_q26 = 0;
  for (int j = 0; j < 4; ++j, points += row_bytes) {
    int32_t row = rg_multiply_high(rg_load_i32(points), w_q31[0]);
    row = rg_multiply_high_add(row, rg_load_i32(points + 12), w_q31[1]);
    row = rg_multiply_high_add(row, rg_load_i32(points + 24), w_q31[2]);
    row = rg_multiply_high_add(row, rg_load_i32(points + 36), w_q31[3]);
    sum_q26 = rg_multiply_high_add(sum_q26, row, place->y_weights_q31[j]);
  }
  return 4 * sum_q26;
}

void rg_surface_line_point(const rg_camera* camera, const rg_place* place,
                           int32_t point_q28[3]) {
  const uint32_t row_bytes = 12u * rg_load_u16(camera->grid + 16);
  const uint8_t* points = camera->line_points +
                          rg_load_u32(camera->line_points + 4) +
                          12 * place->first;
  for (int c = 0; c < 3; ++c, points += 4)
    point_q28[c] = sum_coordinate(points, row_bytes, place);
}
