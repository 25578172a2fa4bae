/* rg_evaluate_spline() and rg_compute_jacobian(), for both coordinates of
 * several control points in parallel. */
#include "rays/surface_avx2.h"

#if RG_SELECT_SURFACE

#include <immintrin.h>

#include "bytes.h"
#include "rg_blob.h"
#include "x86_features.h"

/* Precedes all functions that are compiled for AVX2. */
int rg_has_avx2_surface(void) { return rg_has_avx2(); }

RG_BEGIN_FEATURES("avx2")

#define INLINE static inline __attribute__((always_inline))

/* Registers of a row, or of the column of four rows: the weights are in the
 * lower halves of 64 bits, the coordinates are a b a b a b a b. */

/* rg_multiply_high() */
INLINE __m256i multiply_high(__m256i points, __m256i weights) {
  const __m256i half = _mm256_set1_epi64x(INT64_C(0x80000000));
  const __m256i a = _mm256_mul_epi32(points, weights);
  const __m256i b = _mm256_mul_epi32(_mm256_srli_epi64(points, 32), weights);
  return _mm256_blend_epi32(_mm256_srli_epi64(_mm256_add_epi64(a, half), 32),
                            _mm256_add_epi64(b, half), 0xaa);
}

/* rg_multiply_half() */
INLINE __m256i multiply_half(__m256i residuals, __m256i weights) {
  const __m256i a = _mm256_mul_epi32(residuals, weights);
  const __m256i b = _mm256_mul_epi32(_mm256_srli_epi64(residuals, 32), weights);
  return _mm256_blend_epi32(_mm256_srli_epi64(a, 16), _mm256_slli_epi64(b, 16),
                            0xaa);
}

/* The sums of two rows: a b of the first, a b of the second. */
INLINE __m128i add_points(__m256i row, __m256i next) {
  const __m128i u = _mm_add_epi32(_mm256_castsi256_si128(row),
                                  _mm256_extracti128_si256(row, 1));
  const __m128i v = _mm_add_epi32(_mm256_castsi256_si128(next),
                                  _mm256_extracti128_si256(next, 1));
  return _mm_add_epi32(_mm_unpacklo_epi64(u, v), _mm_unpackhi_epi64(u, v));
}

/* The sum of four rows: a b in the lower half. */
INLINE __m128i add_rows(const __m256i rows[4], __m256i weights) {
  const __m256i sums = _mm256_set_m128i(add_points(rows[2], rows[3]),
                                        add_points(rows[0], rows[1]));
  const __m256i column = multiply_high(sums, weights);
  return add_points(column, column);
}

/* rg_multiply_high() of the lower halves of 64 bits, non-negative. */
INLINE __m128i multiply_positive(__m128i a, __m128i b) {
  const __m128i half = _mm_set1_epi64x(INT64_C(0x80000000));
  return _mm_srli_epi64(_mm_add_epi64(_mm_mul_epi32(a, b), half), 32);
}

/* The weights of the four points across and down. */
typedef struct weights {
  __m256i across, down;
} weights;

INLINE void store_weights(__m256i w, int32_t w_q31[4]) {
  const __m256i lower = _mm256_setr_epi32(0, 2, 4, 6, 0, 2, 4, 6);
  _mm_storeu_si128((__m128i*)w_q31, _mm256_castsi256_si128(
                                        _mm256_permutevar8x32_epi32(w, lower)));
}

/* rg_bspline_weights() of both axes. */
INLINE weights compute_surface_weights(rg_grid_position* grid_position) {
  const __m128i sixth_q31 = _mm_set1_epi32(357913941);
  const __m128i t = _mm_insert_epi32(_mm_cvtsi32_si128(grid_position->t_q30[0]),
                                     grid_position->t_q30[1], 2);
  const __m128i t2 = _mm_slli_epi32(multiply_positive(t, t), 2);
  const __m128i t3 = _mm_slli_epi32(multiply_positive(t2, t), 2);
  const __m128i w3 = multiply_positive(t3, _mm_set1_epi32(1431655765));
  const __m128i w0 =
      _mm_sub_epi32(_mm_add_epi32(_mm_sub_epi32(sixth_q31, t), t2), w3);
  const __m128i w2 =
      _mm_add_epi32(_mm_add_epi32(sixth_q31, t), _mm_sub_epi32(t2, t3));
  const __m128i w1 = _mm_sub_epi32(_mm_sub_epi32(_mm_set1_epi32(INT32_MIN), w0),
                                   _mm_add_epi32(w2, w3));
  const weights found = {
      _mm256_set_m128i(_mm_unpacklo_epi64(w2, w3), _mm_unpacklo_epi64(w0, w1)),
      _mm256_set_m128i(_mm_unpackhi_epi64(w2, w3), _mm_unpackhi_epi64(w0, w1))};
  store_weights(found.across, grid_position->weights_q31[0]);
  store_weights(found.down, grid_position->weights_q31[1]);
  return found;
}

INLINE __m128i sum_points(const uint8_t* points, uint32_t row_bytes,
                          const weights* w) {
  __m256i rows[4];
  _Pragma("GCC unroll 4") for (int j = 0; j < 4; ++j, points += row_bytes)
      rows[j] =
          multiply_high(_mm256_loadu_si256((const __m256i*)points), w->across);
  return add_rows(rows, w->down);
}

INLINE __m128i sum_residuals(const uint8_t* residuals, uint32_t row_bytes,
                             const weights* w) {
  __m256i rows[4];
  _Pragma("GCC unroll 4") for (int j = 0; j < 4; ++j, residuals += row_bytes)
      rows[j] = multiply_half(
          _mm256_cvtepi16_epi32(_mm_loadu_si128((const __m128i*)residuals)),
          w->across);
  return add_rows(rows, w->down);
}

/* The value of a grid with 16-bit control points at a position. */
INLINE __m128i compute_residual_value(const uint8_t* grid,
                                      const rg_grid_position* grid_position,
                                      const weights* w) {
  const uint8_t* const plane = grid + rg_load_u32(grid + RG_GRID_DATA_OFFSET);
  const int shift =
      rg_load_u16(grid + RG_GRID_FRACTION_BITS) - 13; /* from 2^14 to q27 */
  const __m128i sums = _mm_add_epi32(
      sum_residuals(plane + RG_NARROW_PLANE_SIZE +
                        RG_NARROW_POINT_SIZE * grid_position->first,
                    RG_NARROW_POINT_SIZE * rg_load_u16(grid + RG_GRID_COLUMNS),
                    w),
      _mm_set1_epi32(1 << (shift - 1)));
  const __m128i value = _mm_insert_epi32(
      _mm_cvtsi32_si128(rg_evaluate_plane(plane, grid_position)),
      rg_evaluate_plane(plane + 4, grid_position), 1);
  return _mm_add_epi32(value, _mm_sra_epi32(sums, _mm_cvtsi32_si128(shift)));
}

rg_status rg_evaluate_spline_avx2(const uint8_t* grid, int32_t x, int32_t y,
                                  rg_grid_position* grid_position) {
  if (!rg_find_cells(grid, x, y, grid_position)) return RG_ERR_OUTSIDE_AREA;
  const weights w = compute_surface_weights(grid_position);
  const __m128i value =
      rg_load_u16(grid + RG_GRID_FRACTION_BITS) == RG_CONTROL_POINT_BITS
          ? sum_points(
                grid + rg_load_u32(grid + RG_GRID_DATA_OFFSET) +
                    RG_CONTROL_POINT_SIZE * grid_position->first,
                RG_CONTROL_POINT_SIZE * rg_load_u16(grid + RG_GRID_COLUMNS), &w)
          : compute_residual_value(grid, grid_position, &w);
  _mm_storel_epi64((__m128i*)grid_position->value.q27, value);
  return RG_OK;
}

/* ---- Derivatives --------------------------------------------------------- */

/* Residuals of two neighbours, a b a b. */
INLINE __m128i load_two(const uint8_t* residuals) {
  return _mm_cvtepi16_epi32(_mm_loadl_epi64((const __m128i*)residuals));
}

/* Differences of two knots above and two below, interpolated bilinearly: a b in
 * the lower half. */
INLINE __m128i blend_samples(__m128i above, __m128i below, __m128i w_above,
                             __m128i w_below) {
  const __m128i sums = _mm_add_epi32(_mm_mullo_epi32(above, w_above),
                                     _mm_mullo_epi32(below, w_below));
  return _mm_add_epi32(sums, _mm_unpackhi_epi64(sums, sums));
}

void rg_compute_jacobian_avx2(const uint8_t* inverse,
                              const rg_grid_position* grid_position,
                              int32_t jacobian_q5[2][2]) {
  const uint8_t* const plane =
      inverse + rg_load_u32(inverse + RG_INVERSE_DATA_OFFSET);
  const uint32_t row_bytes =
      RG_NARROW_POINT_SIZE * rg_load_u16(inverse + RG_INVERSE_COLUMNS);
  const uint8_t* const first = plane + RG_NARROW_PLANE_SIZE +
                               RG_NARROW_POINT_SIZE * grid_position->first;
  const uint8_t* const second = first + row_bytes;
  const uint8_t* const third = second + row_bytes;
  const int shift =
      rg_load_u16(inverse + RG_INVERSE_FRACTION_BITS) - (int)RG_NARROW_MIN_BITS;
  const int x_q7 = grid_position->t_q30[0] >> 23;
  const int y_q7 = grid_position->t_q30[1] >> 23;
  const __m128i left_right = _mm_setr_epi32(128 - x_q7, 128 - x_q7, x_q7, x_q7);
  const __m128i w_above =
      _mm_mullo_epi32(left_right, _mm_set1_epi32(128 - y_q7));
  const __m128i w_below = _mm_mullo_epi32(left_right, _mm_set1_epi32(y_q7));
  const __m128i across =
      blend_samples(_mm_sub_epi32(load_two(second + 2 * RG_NARROW_POINT_SIZE),
                                  load_two(second)),
                    _mm_sub_epi32(load_two(third + 2 * RG_NARROW_POINT_SIZE),
                                  load_two(third)),
                    w_above, w_below);
  const __m128i down = blend_samples(
      _mm_sub_epi32(load_two(third + RG_NARROW_POINT_SIZE),
                    load_two(first + RG_NARROW_POINT_SIZE)),
      _mm_sub_epi32(load_two(third + row_bytes + RG_NARROW_POINT_SIZE),
                    load_two(second + RG_NARROW_POINT_SIZE)),
      w_above, w_below);
  /* The steps of the plane are contiguous as well. */
  const __m128i jacobian = _mm_add_epi32(
      _mm_loadu_si128((const __m128i*)(plane + RG_PLANE_COLUMN_STEP)),
      _mm_sra_epi32(_mm_unpacklo_epi64(across, down),
                    _mm_cvtsi32_si128(shift)));
  const __m128i scale_q20 =
      _mm_set_epi64x((int64_t)(rg_load_u32(inverse + RG_INVERSE_SCALE_B) >> 1),
                     (int64_t)(rg_load_u32(inverse + RG_INVERSE_SCALE_A) >> 1));
  const __m128i half = _mm_set1_epi64x(INT64_C(0x80000000));
  const __m128i a = _mm_mul_epi32(jacobian, scale_q20);
  const __m128i b = _mm_mul_epi32(_mm_srli_epi64(jacobian, 32), scale_q20);
  _mm_storeu_si128((__m128i*)jacobian_q5,
                   _mm_blend_epi32(_mm_srli_epi64(_mm_add_epi64(a, half), 32),
                                   _mm_add_epi64(b, half), 0xa));
}

RG_END_FEATURES

#endif
