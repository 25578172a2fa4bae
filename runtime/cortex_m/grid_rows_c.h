/* B-spline sums of rows of control points in C: cortex_m/grid_rows.h. */
#ifndef RAYGRID_GRID_ROWS_C_H
#define RAYGRID_GRID_ROWS_C_H

#include <stdint.h>

#include "blob_layout.h"
#include "bytes.h"
#include "code_size.h"
#include "config.h"
#include "fixed_point.h"

/* Adds the B-spline of a row of control points, times the row's weight. */
static RG_INLINE void rg_add_point_row(const uint8_t* points,
                                       const int32_t w_q31[4],
                                       int32_t row_weight_q31,
                                       int32_t sums_q27[2]) {
  int32_t b, a = rg_load_i32_pair(points, &b);
  int32_t row_a = rg_multiply_high(a, w_q31[0]);
  int32_t row_b = rg_multiply_high(b, w_q31[0]);
  a = rg_load_i32_pair(points + RG_CONTROL_POINT_SIZE, &b);
  row_a = rg_multiply_high_add(row_a, a, w_q31[1]);
  row_b = rg_multiply_high_add(row_b, b, w_q31[1]);
  a = rg_load_i32_pair(points + 2 * RG_CONTROL_POINT_SIZE, &b);
  row_a = rg_multiply_high_add(row_a, a, w_q31[2]);
  row_b = rg_multiply_high_add(row_b, b, w_q31[2]);
  a = rg_load_i32_pair(points + 3 * RG_CONTROL_POINT_SIZE, &b);
  row_a = rg_multiply_high_add(row_a, a, w_q31[3]);
  row_b = rg_multiply_high_add(row_b, b, w_q31[3]);
  sums_q27[0] = rg_multiply_high_add(sums_q27[0], row_a, row_weight_q31);
  sums_q27[1] = rg_multiply_high_add(sums_q27[1], row_b, row_weight_q31);
}

/* Computes the B-spline of 4 x 4 control points of 32 bits, first along rows
 * and then along the column. Each product is rounded, q29 to q28 and to q27. */
static RG_INLINE void rg_sum_points_in_c(const uint8_t* points,
                                         uint32_t columns, int32_t w_q31[2][4],
                                         int32_t sums_q27[2]) {
  int32_t sums[2] = {0, 0};
  RG_UNROLL
  for (int j = 0; j < 4; ++j) {
    RG_IN_MEMORY(w_q31[1][j]);
    rg_add_point_row(points, w_q31[0], w_q31[1][j], sums);
    points += RG_CONTROL_POINT_SIZE * columns;
    RG_IN_REGISTER(points);
  }
  sums_q27[0] = sums[0];
  sums_q27[1] = sums[1];
}

/* Computes the B-spline of one coordinate of a row of four residuals. */
static RG_INLINE int32_t rg_sum_residual_row(const uint8_t* residuals,
                                             const int32_t w_q31[4]) {
  const uint32_t size = RG_NARROW_POINT_SIZE;
  int32_t sum = rg_multiply_half(w_q31[0], rg_load_i16(residuals));
  sum = rg_add(sum, rg_multiply_half(w_q31[1], rg_load_i16(residuals + size)));
  sum = rg_add(sum,
               rg_multiply_half(w_q31[2], rg_load_i16(residuals + 2 * size)));
  return rg_add(sum,
                rg_multiply_half(w_q31[3], rg_load_i16(residuals + 3 * size)));
}

/* Computes the B-spline of 4 x 4 residuals of 16 bits, times 2^15, plus half,
 * for later rounding. One coordinate at a time, because registers are few. */
static RG_INLINE void rg_sum_residuals_in_c(const uint8_t* residuals,
                                            uint32_t columns, int32_t half,
                                            int32_t w_q31[2][4],
                                            int32_t sums[2]) {
  RG_UNROLL
  for (int c = 0; c < 2; ++c) {
    const uint8_t* row = residuals + 2 * c;
    int32_t sum = half;
    for (int j = 0; j < 4; ++j, row += RG_NARROW_POINT_SIZE * columns)
      sum = rg_multiply_high_add(sum, rg_sum_residual_row(row, w_q31[0]),
                                 w_q31[1][j]);
    sums[c] = sum;
  }
}

/* Computes the B-spline of a row of four line points and adds it, times the
 * row's weight, to the sums. Each product is rounded, q28 to q27 and to q26.
 * Returns the row's last point, and advances *row_weight_q31. */
static RG_INLINE const uint8_t* rg_add_line_row_in_c(
    const uint8_t* points, const int32_t w_q31[4],
    const int32_t** row_weight_q31, int32_t sums_q26[3]) {
  int32_t x = rg_multiply_high(rg_load_i32(points + RG_LINE_POINT_X), w_q31[0]);
  int32_t y = rg_multiply_high(rg_load_i32(points + RG_LINE_POINT_Y), w_q31[0]);
  int32_t z = rg_multiply_high(rg_load_i32(points + RG_LINE_POINT_Z), w_q31[0]);
  RG_UNROLL
  for (int k = 1; k < 4; ++k) {
    points += RG_LINE_POINT_SIZE;
    x = rg_multiply_high_add(x, rg_load_i32(points + RG_LINE_POINT_X),
                             w_q31[k]);
    y = rg_multiply_high_add(y, rg_load_i32(points + RG_LINE_POINT_Y),
                             w_q31[k]);
    z = rg_multiply_high_add(z, rg_load_i32(points + RG_LINE_POINT_Z),
                             w_q31[k]);
  }
  const int32_t weight_q31 = *(*row_weight_q31)++;
  sums_q26[0] = rg_multiply_high_add(sums_q26[0], x, weight_q31);
  sums_q26[1] = rg_multiply_high_add(sums_q26[1], y, weight_q31);
  sums_q26[2] = rg_multiply_high_add(sums_q26[2], z, weight_q31);
  return points;
}

#endif /* RAYGRID_GRID_ROWS_C_H */
