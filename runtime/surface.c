#include "surface.h"

#include "bspline.h"
#include "bytes.h"
#include "fixed_point.h"
#include "rg_blob.h"

/* A row of four control points, and the column of four rows. Each product is
 * rounded, q29 to q28 and to q27. */
static RG_INLINE void add_row(const uint8_t* points, const int32_t w_q31[4],
                              int32_t row_weight_q31, int32_t sums_q27[2]) {
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
  sums_q27[0] = rg_multiply_high_add(sums_q27[0], row_a, row_weight_q31);
  sums_q27[1] = rg_multiply_high_add(sums_q27[1], row_b, row_weight_q31);
}

/* The B-spline of one coordinate of residuals of 16 bits, times 2^14. */
static RG_SHARED int32_t sum_residuals(const uint8_t* residuals,
                                         uint32_t row_bytes,
                                         const rg_place* place) {
  const int32_t* const w_q31 = place->x_weights_q31;
  int32_t sum = 0;
  RG_UNROLL_SHARED
  for (int j = 0; j < 4; ++j, residuals += row_bytes) {
    int32_t row = 0; /* times 2^15 */
    row = rg_multiply_half_add(row, w_q31[0], rg_load_i16(residuals));
    row = rg_multiply_half_add(row, w_q31[1], rg_load_i16(residuals + 4));
    row = rg_multiply_half_add(row, w_q31[2], rg_load_i16(residuals + 8));
    row = rg_multiply_half_add(row, w_q31[3], rg_load_i16(residuals + 12));
    sum = rg_multiply_high_add(sum, row, place->y_weights_q31[j]);
  }
  return sum;
}

/* One coordinate of the plane. */
static RG_INLINE int32_t evaluate_plane(const uint8_t* plane,
                                        const rg_place* place) {
  const int32_t column_step_q29 = rg_load_i32(plane + 8);
  const int32_t row_step_q29 = rg_load_i32(plane + 16);
  /* The B-spline of 0, 1, 2, 3 is 1 + t. */
  const int32_t corner_q29 =
      (int32_t)(rg_load_u32(plane) +
                (place->x.cell + 1) * (uint32_t)column_step_q29 +
                (place->y.cell + 1) * (uint32_t)row_step_q29);
  const int32_t sum_q27 = rg_multiply_high_add((corner_q29 + 2) >> 2,
                                               column_step_q29, place->x.t_q30);
  return rg_multiply_high_add(sum_q27, row_step_q29, place->y.t_q30);
}

/* Control points of 16 bits, of a grid's section. */
static RG_SHARED void find_narrow_position(const uint8_t* grid,
                                             rg_place* place) {
  const uint8_t* plane = grid + rg_load_u32(grid + 32);
  const uint8_t* residuals = plane + RG_NARROW_PLANE_SIZE + 4 * place->first;
  const uint32_t row_bytes = 4u * rg_load_u16(grid + 16);
  const int shift = rg_load_u16(grid + 30) - 13; /* to q27 */
  for (int c = 0; c < 2; ++c, plane += 4, residuals += 2) {
    const int32_t sum = sum_residuals(residuals, row_bytes, place);
    place->position.q27[c] =
        evaluate_plane(plane, place) + ((sum + (1 << (shift - 1))) >> shift);
  }
}

/* Where a position lies in a grid, and the weights of the control points; 0 if
 * it lies outside. */
static RG_INLINE int locate(const rg_axis axes[2], const uint16_t last_cell[2],
                            int32_t x, int32_t y, rg_place* place) {
  rg_cell_position across, down;
  if (!rg_find_on_axis(&axes[0], last_cell[0], x, &across) ||
      !rg_find_on_axis(&axes[1], last_cell[1], y, &down))
    return 0;
  place->x = across;
  place->y = down;
  rg_bspline_weights(down.t_q30, place->y_weights_q31);
  rg_bspline_weights(across.t_q30, place->x_weights_q31);
  place->first = down.cell * (last_cell[0] + 4u) + across.cell;
  return 1;
}

int rg_find_place(const rg_camera* camera, int32_t x_q16, int32_t y_q16,
                  rg_place* place) {
  if (!locate(camera->axes, camera->last_cell, x_q16, y_q16, place)) return 0;
  if (!camera->control_points) {
    find_narrow_position(
        rg_find_section(camera->blob, RG_SECTION_CENTRAL_GRID, 0), place);
    return 1;
  }
  const uint8_t* points = camera->control_points + 8 * place->first;
  const uint32_t row_bytes = 8 * (camera->last_cell[0] + 4u);
  const int32_t* const x_weights = place->x_weights_q31;
  int32_t* const y_weights = place->y_weights_q31;
  int32_t sums_q27[2] = {0, 0};
  RG_UNROLL_ROWS
  for (int j = 0; j < 4; ++j, points += row_bytes)
    add_row(points, x_weights, rg_read_late(y_weights + j), sums_q27);
  place->position.q27[0] = sums_q27[0];
  place->position.q27[1] = sums_q27[1];
  return 1;
}

/* How one coordinate of residuals changes per cell along one axis, times 2^15:
 * differences across two cells, which are the spline's derivatives at its
 * knots, and linear between the knots of both axes. Positions are q7. */
static RG_SHARED int32_t find_slope(const uint8_t* residuals, uint32_t along,
                                    uint32_t across, int32_t t, int32_t s) {
  int32_t slopes[2];
  for (int k = 0; k < 2; ++k) {
    residuals += across;
    const int32_t first = rg_load_i16(residuals + 2 * along) -
                          rg_load_i16(residuals);
    const int32_t second = rg_load_i16(residuals + 3 * along) -
                           rg_load_i16(residuals + along);
    slopes[k] = first * (128 - t) + second * t;
  }
  return slopes[0] * (128 - s) + slopes[1] * s;
}

int rg_find_inverse(const uint8_t* inverse, const rg_chart_point* position,
                    rg_inverse_place* found) {
  rg_place place;
  rg_axis axes[2];
  uint16_t last_cell[2];
  for (uint32_t c = 0; c < 2; ++c) {
    rg_read_axis(inverse, c, &axes[c]);
    last_cell[c] = (uint16_t)(rg_load_u16(inverse + 16 + 2 * c) - 4u);
  }
  if (!locate(axes, last_cell, position->q27[0], position->q27[1], &place))
    return 0;
  find_narrow_position(inverse, &place);
  const uint8_t* plane = inverse + rg_load_u32(inverse + 32);
  const uint8_t* residuals = plane + RG_NARROW_PLANE_SIZE + 4 * place.first;
  const uint32_t row_bytes = 4u * rg_load_u16(inverse + 16);
  const uint32_t shift = rg_load_u16(inverse + 30) - RG_NARROW_MIN_BITS;
  const int32_t t = place.x.t_q30 >> 23, s = place.y.t_q30 >> 23;
  for (int c = 0; c < 2; ++c, plane += 4, residuals += 2) {
    const int32_t across = find_slope(residuals, 4, row_bytes, t, s) >> shift;
    const int32_t down = find_slope(residuals, row_bytes, 4, s, t) >> shift;
    found->pixel_q16[c] = 2 * place.position.q27[c];
    found->by_cells_q17[0][c] =
        (int32_t)(rg_load_u32(plane + 8) + (uint32_t)across);
    found->by_cells_q17[1][c] =
        (int32_t)(rg_load_u32(plane + 16) + (uint32_t)down);
  }
  return 1;
}
