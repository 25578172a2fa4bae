#include "surface.h"

#include "blob_checks.h"
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

/* The B-spline of one coordinate along a row of residuals of 16 bits, times
 * 2^15. */
static RG_ROW int32_t sum_row(const uint8_t* row, const int32_t w_q31[4]) {
  int32_t sum = 0;
  sum = rg_multiply_half_add(sum, w_q31[0], rg_load_i16(row));
  sum = rg_multiply_half_add(sum, w_q31[1], rg_load_i16(row + 4));
  sum = rg_multiply_half_add(sum, w_q31[2], rg_load_i16(row + 8));
  return rg_multiply_half_add(sum, w_q31[3], rg_load_i16(row + 12));
}

/* Between a spline's slopes at two knots. */
static RG_INLINE int32_t blend_slopes(int32_t first, int32_t second,
                                      int32_t t_q7) {
  return first * (128 - t_q7) + second * t_q7;
}

/* One coordinate of the plane. */
static RG_INLINE int32_t evaluate_plane(const uint8_t* plane,
                                        const rg_place* place) {
  const int32_t column_step_q29 = rg_load_i32(plane + 8);
  const int32_t row_step_q29 = rg_load_i32(plane + 16);
  /* The B-spline of 0, 1, 2, 3 is 1 + t. */
  const uint32_t corner_q29 =
      rg_load_u32(plane) +
      (place->cells[0].cell + 1) * (uint32_t)column_step_q29 +
      (place->cells[1].cell + 1) * (uint32_t)row_step_q29;
  const int32_t sum_q27 = rg_multiply_high_add(
      (int32_t)(corner_q29 + 2) >> 2, column_step_q29, place->cells[0].t_q30);
  return rg_multiply_high_add(sum_q27, row_step_q29, place->cells[1].t_q30);
}

/* One coordinate of a position in a grid of 16 bits, of its section; *down is
 * how it changes per cell down but for the plane, times 2^15. */
static RG_SHARED int32_t find_narrow_position(const uint8_t* grid, uint32_t c,
                                              const rg_place* place,
                                              int32_t* down) {
  const uint8_t* const plane = grid + rg_load_u32(grid + 32) + 4 * c;
  const uint8_t* row = plane + RG_NARROW_PLANE_SIZE - 2 * c + 4 * place->first;
  const uint32_t row_bytes = 4u * rg_load_u16(grid + 16);
  const int shift = rg_load_u16(grid + 30) - 13; /* from 2^14 to q27 */
  const int32_t* const across_q31 = place->weights_q31[0];
  const int32_t* const down_q31 = place->weights_q31[1];
  const int32_t row0 = sum_row(row, across_q31);
  row += row_bytes;
  const int32_t row1 = sum_row(row, across_q31);
  row += row_bytes;
  const int32_t row2 = sum_row(row, across_q31);
  row += row_bytes;
  const int32_t row3 = sum_row(row, across_q31);
  int32_t sum = rg_multiply_high_add(1 << (shift - 1), row0, down_q31[0]);
  sum = rg_multiply_high_add(sum, row1, down_q31[1]);
  sum = rg_multiply_high_add(sum, row2, down_q31[2]);
  sum = rg_multiply_high_add(sum, row3, down_q31[3]);
  /* Differences of two cells. */
  *down = blend_slopes((row2 - row0) >> 8, (row3 - row1) >> 8,
                       place->cells[1].t_q30 >> 23);
  return evaluate_plane(plane, place) + (sum >> shift);
}

/* The rest of rg_find_place() where control points have 16 bits. */
static RG_NOINLINE int find_narrow_place(const uint8_t* blob, rg_place* place) {
  const uint8_t* const grid =
      blob + rg_load_u32(rg_find_entry(blob, RG_SECTION_CENTRAL_GRID, 0) + 4);
  for (uint32_t c = 0; c < 2; ++c) {
    int32_t down;
    place->position.q27[c] = find_narrow_position(grid, c, place, &down);
  }
  return 1;
}

int rg_find_place(const rg_camera* camera, int32_t x_q16, int32_t y_q16,
                  rg_place* place) {
  rg_cell_position x, y;
  if (!rg_find_on_axis(&camera->axes[0], camera->last_cell[0], x_q16, &x) ||
      !rg_find_on_axis(&camera->axes[1], camera->last_cell[1], y_q16, &y))
    return 0;
  place->cells[0] = x;
  place->cells[1] = y;
  rg_bspline_weights(y.t_q30, place->weights_q31[1]);
  rg_bspline_weights(x.t_q30, place->weights_q31[0]);
  const uint32_t columns = camera->last_cell[0] + 4u;
  place->first = y.cell * columns + x.cell;
  if (!camera->control_points) return find_narrow_place(camera->blob, place);
  const uint8_t* points = camera->control_points + 8 * place->first;
  const uint32_t row_bytes = 8 * columns;
  const int32_t* const x_weights = place->weights_q31[0];
  int32_t* const y_weights = place->weights_q31[1];
  int32_t sums_q27[2] = {0, 0};
  RG_UNROLL_ROWS
  for (int j = 0; j < 4; ++j, points += row_bytes)
    add_row(points, x_weights, rg_read_late(y_weights + j), sums_q27);
  place->position.q27[0] = sums_q27[0];
  place->position.q27[1] = sums_q27[1];
  return 1;
}

/* How one coordinate of residuals changes per cell across, times 2^8, from one
 * row: differences of two cells. */
static RG_SHARED int32_t find_slope(const uint8_t* row, int32_t t_q7) {
  return blend_slopes(rg_load_i16(row + 8) - rg_load_i16(row),
                      rg_load_i16(row + 12) - rg_load_i16(row + 4), t_q7);
}

int rg_find_inverse(const uint8_t* inverse, const rg_chart_point* position,
                    rg_inverse_place* found) {
  rg_place place;
  RG_UNROLL_SHARED
  for (uint32_t c = 0; c < 2; ++c) {
    rg_axis axis;
    rg_read_axis(inverse, c, &axis);
    if (!rg_find_on_axis(&axis, rg_load_u16(inverse + 16 + 2 * c) - 4u,
                         position->q27[c], &place.cells[c]))
      return 0;
    rg_bspline_weights(place.cells[c].t_q30, place.weights_q31[c]);
  }
  const uint32_t columns = rg_load_u16(inverse + 16);
  place.first = place.cells[1].cell * columns + place.cells[0].cell;
  const uint8_t* plane = inverse + rg_load_u32(inverse + 32);
  /* The row above the position. */
  const uint8_t* row =
      plane + RG_NARROW_PLANE_SIZE + 4 * (place.first + columns);
  const uint32_t shift = rg_load_u16(inverse + 30) - RG_NARROW_MIN_BITS;
  const int32_t t_q7 = place.cells[0].t_q30 >> 23;
  RG_UNROLL_SHARED
  for (uint32_t c = 0; c < 2; ++c, plane += 4, row += 2) {
    int32_t down;
    found->pixel_q16[c] =
        rg_shift_left(find_narrow_position(inverse, c, &place, &down), 1);
    const int32_t across =
        blend_slopes(find_slope(row, t_q7), find_slope(row + 4 * columns, t_q7),
                     place.cells[1].t_q30 >> 23);
    found->by_cells_q17[0][c] =
        (int32_t)(rg_load_u32(plane + 8) + (uint32_t)(across >> shift));
    found->by_cells_q17[1][c] =
        (int32_t)(rg_load_u32(plane + 16) + (uint32_t)(down >> shift));
  }
  return 1;
}
