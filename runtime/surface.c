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

#if RG_HAVE_SMMULR

/* Both coordinates of a residual of 16 bits, a word, times a weight. */
static RG_INLINE void multiply_pair(const uint8_t* residual, int32_t w_q31,
                                    int32_t products[2]) {
  const uint32_t pair = rg_load_u32(residual);
  __asm__("smulwb %0, %1, %2" : "=r"(products[0]) : "r"(w_q31), "r"(pair));
  __asm__("smulwt %0, %1, %2" : "=r"(products[1]) : "r"(w_q31), "r"(pair));
}

static RG_INLINE void multiply_pair_add(const uint8_t* residual, int32_t w_q31,
                                        int32_t sums[2]) {
  const uint32_t pair = rg_load_u32(residual);
  __asm__("smlawb %0, %1, %2, %0" : "+r"(sums[0]) : "r"(w_q31), "r"(pair));
  __asm__("smlawt %0, %1, %2, %0" : "+r"(sums[1]) : "r"(w_q31), "r"(pair));
}

/* As add_row(), of residuals, times 2^15. */
static RG_INLINE void add_narrow_row(const uint8_t* residuals,
                                     const int32_t w_q31[4],
                                     int32_t row_weight_q31, int32_t sums[2]) {
  int32_t row[2];
  multiply_pair(residuals, w_q31[0], row);
  multiply_pair_add(residuals + 4, w_q31[1], row);
  multiply_pair_add(residuals + 8, w_q31[2], row);
  multiply_pair_add(residuals + 12, w_q31[3], row);
  for (int c = 0; c < 2; ++c)
    sums[c] = rg_multiply_high_add(sums[c], row[c], row_weight_q31);
}

/* To place->value the B-spline of residuals, from the first row of them on. */
static RG_SHARED int add_residuals(rg_place* place, const uint8_t* row,
                                   uint32_t row_bytes, int shift) {
  int32_t sums[2] = {1 << (shift - 1), 1 << (shift - 1)};
  RG_UNROLL_SHARED
  for (int j = 0; j < 4; ++j, row += row_bytes)
    add_narrow_row(row, place->weights_q31[0], place->weights_q31[1][j], sums);
  for (int c = 0; c < 2; ++c)
    place->value.q27[c] = rg_add(place->value.q27[c], sums[c] >> shift);
  return 1;
}

#else

/* One coordinate of a row of residuals, times 2^15. */
static RG_INLINE int32_t sum_row(const uint8_t* residuals,
                                 const int32_t w_q31[4]) {
  int32_t sum = rg_multiply_half(w_q31[0], rg_load_i16(residuals));
  sum = rg_add(sum, rg_multiply_half(w_q31[1], rg_load_i16(residuals + 4)));
  sum = rg_add(sum, rg_multiply_half(w_q31[2], rg_load_i16(residuals + 8)));
  return rg_add(sum, rg_multiply_half(w_q31[3], rg_load_i16(residuals + 12)));
}

/* Likewise, one coordinate after the other: registers are few. */
static RG_SHARED int add_residuals(rg_place* place, const uint8_t* first,
                                   uint32_t row_bytes, int shift) {
  RG_UNROLL_SHARED
  for (int c = 0; c < 2; ++c) {
    const uint8_t* row = first + 2 * c;
    int32_t sum = 1 << (shift - 1);
    RG_UNROLL_SHARED
    for (int j = 0; j < 4; ++j, row += row_bytes)
      sum = rg_multiply_high_add(sum, sum_row(row, place->weights_q31[0]),
                                 place->weights_q31[1][j]);
    place->value.q27[c] = rg_add(place->value.q27[c], sum >> shift);
  }
  return 1;
}

#endif

/* The rest of rg_find_place() where control points have 16 bits. */
static RG_NOINLINE int find_narrow_value(const uint8_t* grid, rg_place* place) {
  const uint8_t* const plane = grid + rg_load_u32(grid + 32);
  for (int c = 0; c < 2; ++c)
    place->value.q27[c] = rg_evaluate_plane(plane + 4 * c, place);
  return add_residuals(place, plane + RG_NARROW_PLANE_SIZE + 4 * place->first,
                       4u * rg_load_u16(grid + 16),
                       rg_load_u16(grid + 30) - 13); /* from 2^14 to q27 */
}

int rg_find_place(const uint8_t* grid, int32_t x, int32_t y, rg_place* place) {
  if (!rg_find_cells(grid, x, y, place)) return 0;
  rg_bspline_weights(place->cells[1].t_q30, place->weights_q31[1]);
  rg_bspline_weights(place->cells[0].t_q30, place->weights_q31[0]);
  if (rg_load_u16(grid + 30) != RG_CONTROL_POINT_BITS)
    return find_narrow_value(grid, place);
  const uint8_t* points = grid + rg_load_u32(grid + 32) + 8 * place->first;
  const uint32_t row_bytes = 8u * rg_load_u16(grid + 16);
  const int32_t* const x_weights = place->weights_q31[0];
  int32_t* const y_weights = place->weights_q31[1];
  int32_t sums_q27[2] = {0, 0};
  RG_UNROLL_ROWS
  for (int j = 0; j < 4; ++j, points = rg_keep_address(points + row_bytes))
    add_row(points, x_weights, rg_read_late(y_weights + j), sums_q27);
  place->value.q27[0] = sums_q27[0];
  place->value.q27[1] = sums_q27[1];
  return 1;
}

/* How one coordinate of residuals changes per cell, times 2^15: the sum of
 * differences of two cells at the four knots around, from residuals so many
 * bytes apart. */
static RG_SHARED int32_t find_slope(const uint8_t* residual, uint32_t apart,
                                    uint32_t row_bytes,
                                    const int32_t weights_q14[4]) {
  int32_t sum = 0;
  RG_UNROLL_SHARED
  for (uint32_t k = 0; k < 4; ++k) {
    const uint8_t* const at = residual + 4 * (k & 1) + row_bytes * (k >> 1);
    sum += weights_q14[k] * (rg_load_i16(at + apart) - rg_load_i16(at));
  }
  return sum;
}

void rg_find_slopes(const uint8_t* inverse, const rg_place* place,
                    int32_t slopes_q5[2][2]) {
  const uint8_t* plane = inverse + rg_load_u32(inverse + 32);
  const uint8_t* residual = plane + RG_NARROW_PLANE_SIZE + 4 * place->first;
  const uint32_t row_bytes = 4u * rg_load_u16(inverse + 16);
  const uint32_t shift = rg_load_u16(inverse + 30) - RG_NARROW_MIN_BITS;
  const int32_t x_q7 = place->cells[0].t_q30 >> 23;
  const int32_t y_q7 = place->cells[1].t_q30 >> 23;
  const int32_t weights_q14[4] = {(128 - x_q7) * (128 - y_q7),
                                  x_q7 * (128 - y_q7), (128 - x_q7) * y_q7,
                                  x_q7 * y_q7};
  const int32_t x_scale_q20 = (int32_t)(rg_load_u32(inverse + 20) >> 1);
  const int32_t y_scale_q20 = (int32_t)(rg_load_u32(inverse + 24) >> 1);
  RG_UNROLL_SHARED
  for (uint32_t c = 0; c < 2; ++c, plane += 4, residual += 2) {
    const int32_t across =
        find_slope(residual + row_bytes, 8, row_bytes, weights_q14);
    const int32_t down =
        find_slope(residual + 4, 2 * row_bytes, row_bytes, weights_q14);
    slopes_q5[0][c] = rg_multiply_high(
        rg_add(rg_load_i32(plane + 8), across >> shift), x_scale_q20);
    slopes_q5[1][c] = rg_multiply_high(
        rg_add(rg_load_i32(plane + 16), down >> shift), y_scale_q20);
  }
}
