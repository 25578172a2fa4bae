#include "rays/surface.h"

#include "bytes.h"
#include "fixed_point.h"
#include "rays/bspline.h"
#include "rg_blob.h"

/* The B-spline of 4 x 4 control points, to place->value: rows, and the column
 * of four rows. Each product is rounded, q29 to q28 and to q27. */
#if RG_ROWS_IN_ASSEMBLER && !RG_IS_FAST

static RG_INLINE void sum_rows(const uint8_t* points, uint32_t columns,
                               rg_place* place) {
  const int32_t* weights_q31 = place->weights_q31[0];
  int32_t a_q27 = 0, b_q27 = 0;
  __asm__(
      "ldmia %[weights]!, {r6, r8, r9, r10}\n"
      "1:\n\t"
      "ldmia.w %[points], {r1, r2, r4, r5}\n\t"
      "smmulr r1, r1, r6\n\t"
      "smmulr r2, r2, r6\n\t"
      "smmlar r1, r4, r8, r1\n\t"
      "smmlar r2, r5, r8, r2\n\t"
      "ldrd r4, r5, [%[points], %[size] * 2]\n\t"
      "smmlar r1, r4, r9, r1\n\t"
      "smmlar r2, r5, r9, r2\n\t"
      "ldrd r4, r5, [%[points], %[size] * 3]\n\t"
      "smmlar r1, r4, r10, r1\n\t"
      "smmlar r2, r5, r10, r2\n\t"
      "ldr r4, [%[weights]], #4\n\t"
      "add %[points], %[points], %[columns], lsl #3\n\t"
      "smmlar %[a], r1, r4, %[a]\n\t"
      "smmlar %[b], r2, r4, %[b]\n\t"
      "adds %[columns], %[columns], #0x40000000\n\t"
      "bcc 1b"
      : [points] "+r"(points), [columns] "+r"(columns), [a] "+r"(a_q27),
        [b] "+r"(b_q27), [weights] "+r"(weights_q31)
      : [size] "i"(RG_CONTROL_POINT_SIZE)
      : "r1", "r2", "r4", "r5", "r6", "r8", "r9", "r10", "cc", "memory");
  place->value.q27[0] = a_q27;
  place->value.q27[1] = b_q27;
}

#else

static RG_INLINE void add_row(const uint8_t* points, const int32_t w_q31[4],
                              int32_t row_weight_q31, int32_t sums_q27[2]) {
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

static RG_INLINE void sum_rows(const uint8_t* points, uint32_t columns,
                               rg_place* place) {
  int32_t sums_q27[2] = {0, 0};
  RG_UNROLL_ROWS
  for (int j = 0; j < 4;
       ++j, points = rg_keep_address(points + RG_CONTROL_POINT_SIZE * columns))
    add_row(points, place->weights_q31[0],
            rg_read_late(place->weights_q31[1] + j), sums_q27);
  place->value.q27[0] = sums_q27[0];
  place->value.q27[1] = sums_q27[1];
}

#endif

/* sum_narrow_rows() sums weighted residuals of 16 bits, times 2^15, and what
 * rounds them later. */
#if RG_ROWS_IN_ASSEMBLER

/* A residual is a word with both coordinates. */
static RG_INLINE void sum_narrow_rows(const uint8_t* residuals,
                                      uint32_t columns, int32_t half,
                                      rg_place* place) {
  const int32_t w0 = place->weights_q31[0][0], w1 = place->weights_q31[0][1];
  const int32_t w2 = place->weights_q31[0][2], w3 = place->weights_q31[0][3];
  const int32_t* row_weight_q31 = place->weights_q31[1];
  int32_t a = half, b = half;
  do {
    __asm__(
        "ldrd r1, r2, [%[residuals]]\n\t"
        "smulwt r5, %[w0], r1\n\t"
        "smulwb r1, %[w0], r1\n\t"
        "smlawt r5, %[w1], r2, r5\n\t"
        "smlawb r1, %[w1], r2, r1\n\t"
        "ldr r2, [%[residuals], %[size] * 2]\n\t"
        "smlawt r5, %[w2], r2, r5\n\t"
        "smlawb r1, %[w2], r2, r1\n\t"
        "ldr r2, [%[residuals], %[size] * 3]\n\t"
        "smlawt r5, %[w3], r2, r5\n\t"
        "smlawb r1, %[w3], r2, r1\n\t"
        "ldr r2, [%[row_weight]], #4\n\t"
        "smmlar %[a], r1, r2, %[a]\n\t"
        "smmlar %[b], r5, r2, %[b]"
        : [a] "+r"(a), [b] "+r"(b), [row_weight] "+r"(row_weight_q31)
        : [residuals] "r"(residuals), [w0] "r"(w0), [w1] "r"(w1), [w2] "r"(w2),
          [w3] "r"(w3), [size] "i"(RG_NARROW_POINT_SIZE)
        : "r1", "r2", "r5", "memory");
    residuals += RG_NARROW_POINT_SIZE * columns;
  } while (rg_turn(&columns));
  place->value.q27[0] = a;
  place->value.q27[1] = b;
}

#else

/* One coordinate of a row of residuals. */
static RG_INLINE int32_t sum_row(const uint8_t* residuals,
                                 const int32_t w_q31[4]) {
  const uint32_t size = RG_NARROW_POINT_SIZE;
  int32_t sum = rg_multiply_half(w_q31[0], rg_load_i16(residuals));
  sum = rg_add(sum, rg_multiply_half(w_q31[1], rg_load_i16(residuals + size)));
  sum = rg_add(sum,
               rg_multiply_half(w_q31[2], rg_load_i16(residuals + 2 * size)));
  return rg_add(sum,
                rg_multiply_half(w_q31[3], rg_load_i16(residuals + 3 * size)));
}

/* One coordinate after the other: registers are few. */
static RG_INLINE void sum_narrow_rows(const uint8_t* residuals,
                                      uint32_t columns, int32_t half,
                                      rg_place* place) {
  RG_UNROLL_SHARED
  for (int c = 0; c < 2; ++c) {
    const uint8_t* row = residuals + 2 * c;
    int32_t sum = half;
    RG_UNROLL_SHARED
    for (int j = 0; j < 4; ++j, row += RG_NARROW_POINT_SIZE * columns)
      sum = rg_multiply_high_add(sum, sum_row(row, place->weights_q31[0]),
                                 place->weights_q31[1][j]);
    place->value.q27[c] = sum;
  }
}

#endif

/* RG_RARE keeps rare cases out of line where speed matters, so that a place in
 * a wide grid has all registers. */
#if RG_IS_FAST
#define RG_RARE RG_NOINLINE
#else
#define RG_RARE RG_INLINE
#endif

/* The rest of rg_find_place() where control points have 16 bits. */
static RG_RARE void find_narrow_value(const uint8_t* grid, rg_place* place) {
  grid = rg_keep_address(grid);
  sum_narrow_rows(grid + rg_load_u32(grid + RG_GRID_DATA_OFFSET) +
                      RG_NARROW_PLANE_SIZE +
                      RG_NARROW_POINT_SIZE * place->first,
                  rg_load_u16(grid + RG_GRID_COLUMNS),
                  1 << (rg_load_u16(grid + RG_GRID_FRACTION_BITS) - 14), place);
  const uint8_t* plane = grid + rg_load_u32(grid + RG_GRID_DATA_OFFSET);
  const int shift =
      rg_load_u16(grid + RG_GRID_FRACTION_BITS) - 13; /* from 2^14 to q27 */
  int32_t* value = place->value.q27;
  RG_UNROLL_SHARED
  for (uint32_t axes = rg_times(2); axes > 0; --axes, ++value, plane += 4)
    *value = rg_add(rg_evaluate_plane(plane, place), *value >> shift);
}

rg_status rg_find_place(const uint8_t* grid, int32_t x, int32_t y,
                        rg_place* place) {
  if (!rg_find_cells(grid, x, y, place)) return RG_ERR_OUTSIDE_AREA;
  rg_bspline_weights(place->t_q30[1], place->weights_q31[1]);
  rg_bspline_weights(place->t_q30[0], place->weights_q31[0]);
  if (rg_load_u16(grid + RG_GRID_FRACTION_BITS) == RG_CONTROL_POINT_BITS)
    sum_rows(grid + rg_load_u32(grid + RG_GRID_DATA_OFFSET) +
                 RG_CONTROL_POINT_SIZE * place->first,
             rg_load_u16(grid + RG_GRID_COLUMNS), place);
  else
    find_narrow_value(grid, place);
  return RG_OK;
}

/* From a to b by so many 128ths, times 128. */
static RG_INLINE int32_t blend(int32_t a, int32_t b, int32_t t_q7) {
  return 128 * a + t_q7 * (b - a);
}

/* How one coordinate of residuals changes per cell, times 2^15: the sum of
 * differences of two cells, bilinear between the four knots around, from
 * residuals so many bytes apart. */
static RG_SHARED int32_t find_slope(const uint8_t* residual, uint32_t apart,
                                    uint32_t row_bytes, const rg_place* place) {
  const int32_t x_q7 = place->t_q30[0] >> 23;
  const int32_t y_q7 = place->t_q30[1] >> 23;
  int32_t above = 0, below = 0;
  RG_UNROLL_SHARED
  for (uint32_t rows = rg_times(2); rows > 0; --rows, residual += row_bytes) {
    const uint8_t* const right = residual + RG_NARROW_POINT_SIZE;
    above = below;
    below = blend(rg_load_i16(residual + apart) - rg_load_i16(residual),
                  rg_load_i16(right + apart) - rg_load_i16(right), x_q7);
  }
  return blend(above, below, y_q7);
}

void rg_find_slopes(const uint8_t* inverse, const rg_place* place,
                    int32_t slopes_q5[2][2]) {
  const uint8_t* plane =
      inverse + rg_load_u32(inverse + RG_INVERSE_DATA_OFFSET);
  const uint8_t* residual =
      plane + RG_NARROW_PLANE_SIZE + RG_NARROW_POINT_SIZE * place->first;
  const uint32_t row_bytes =
      RG_NARROW_POINT_SIZE * rg_load_u16(inverse + RG_INVERSE_COLUMNS);
  const uint32_t shift =
      rg_load_u16(inverse + RG_INVERSE_FRACTION_BITS) - RG_NARROW_MIN_BITS;
  const int32_t x_scale_q20 =
      (int32_t)(rg_load_u32(inverse + RG_INVERSE_SCALE_A) >> 1);
  const int32_t y_scale_q20 =
      (int32_t)(rg_load_u32(inverse + RG_INVERSE_SCALE_B) >> 1);
  RG_UNROLL_SHARED
  for (uint32_t c = 0; c < 2; ++c, plane += 4, residual += 2) {
    const int32_t across = find_slope(
        residual + row_bytes, 2 * RG_NARROW_POINT_SIZE, row_bytes, place);
    const int32_t down = find_slope(residual + RG_NARROW_POINT_SIZE,
                                    2 * row_bytes, row_bytes, place);
    slopes_q5[0][c] = rg_multiply_high(
        rg_add(rg_load_i32(plane + RG_PLANE_COLUMN_STEP), across >> shift),
        x_scale_q20);
    slopes_q5[1][c] = rg_multiply_high(
        rg_add(rg_load_i32(plane + RG_PLANE_ROW_STEP), down >> shift),
        y_scale_q20);
  }
}
