#include "surface.h"

#include "bspline.h"
#include "bytes.h"
#include "fixed_point.h"
#include "rg_blob.h"

/* Cell and weights on one axis, 0 for x and 1 for y; 0 outside the area. */
static RG_INLINE int find_on_axis(const uint8_t* grid, uint32_t axis,
                                  int32_t pixel_q16, rg_place* place) {
  rg_cell_position position;
  if (!rg_find_on_axis(grid, axis, pixel_q16, 3, &position)) return 0;
  place->cell[axis] = position.cell;
  place->t_q31[axis] = (int32_t)(position.t_q32 >> 1);
  rg_bspline_weights(place->t_q31[axis], place->weights_q31[axis]);
  return 1;
}

/* The column of four row sums, whose products with the weights are rounded. */
static RG_INLINE int32_t add_row(int32_t sum, int32_t row, int32_t weight_q31) {
  return rg_multiply_high_add(sum, 2 * row, weight_q31);
}

/* Control points of 32 bits: q29 to q28, each product rounded. */
static RG_INLINE void sum_wide(const uint8_t* points, uint32_t row_bytes,
                               const rg_place* place, int32_t sums_q28[2]) {
  const int32_t* const w_q31 = place->weights_q31[0];
  int32_t a_q28 = 0, b_q28 = 0;
  for (int j = 0; j < 4; ++j, points += row_bytes) {
    int32_t row_a = rg_multiply_high(rg_load_i32(points), w_q31[0]);
    int32_t row_b = rg_multiply_high(rg_load_i32(points + 4), w_q31[0]);
    row_a = rg_multiply_high_add(row_a, rg_load_i32(points + 8), w_q31[1]);
    row_b = rg_multiply_high_add(row_b, rg_load_i32(points + 12), w_q31[1]);
    row_a = rg_multiply_high_add(row_a, rg_load_i32(points + 16), w_q31[2]);
    row_b = rg_multiply_high_add(row_b, rg_load_i32(points + 20), w_q31[2]);
    row_a = rg_multiply_high_add(row_a, rg_load_i32(points + 24), w_q31[3]);
    row_b = rg_multiply_high_add(row_b, rg_load_i32(points + 28), w_q31[3]);
    a_q28 = add_row(a_q28, row_a, place->weights_q31[1][j]);
    b_q28 = add_row(b_q28, row_b, place->weights_q31[1][j]);
  }
  sums_q28[0] = a_q28;
  sums_q28[1] = b_q28;
}

int rg_surface_position(const rg_camera* camera, rg_pixel pixel,
                        rg_place* place, rg_chart_point* position) {
  const uint8_t* const grid = camera->grid;
  if (!find_on_axis(grid, 0, pixel.x_q16, place) ||
      !find_on_axis(grid, 1, pixel.y_q16, place))
    return 0;
  const uint32_t columns = rg_load_u16(grid + 16);
  place->first = place->cell[1] * columns + place->cell[0];
  sum_wide(camera->control_points + 8 * place->first, 8 * columns, place,
           position->q28);
  return 1;
}

/* One coordinate of points of 12 bytes. */
static int32_t sum_coordinate(const uint8_t* points, uint32_t row_bytes,
                              const rg_place* place) {
  const int32_t* const w_q31 = place->weights_q31[0];
  int32_t sum = 0;
  for (int j = 0; j < 4; ++j, points += row_bytes) {
    int32_t row = rg_multiply_high(rg_load_i32(points), w_q31[0]);
    row = rg_multiply_high_add(row, rg_load_i32(points + 12), w_q31[1]);
    row = rg_multiply_high_add(row, rg_load_i32(points + 24), w_q31[2]);
    row = rg_multiply_high_add(row, rg_load_i32(points + 36), w_q31[3]);
    sum = add_row(sum, row, place->weights_q31[1][j]);
  }
  return sum;
}

void rg_surface_line_point(const rg_camera* camera, const rg_place* place,
                           int32_t point_q28[3]) {
  const uint32_t row_bytes = 12u * rg_load_u16(camera->grid + 16);
  const uint8_t* points = camera->line_points +
                          rg_load_u32(camera->line_points + 4) +
                          12 * place->first;
  /* q28 to q27 */
  for (int c = 0; c < 3; ++c, points += 4)
    point_q28[c] = 2 * sum_coordinate(points, row_bytes, place);
}
