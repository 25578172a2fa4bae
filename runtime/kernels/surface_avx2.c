/* rg_find_place(), both coordinates of four control points at once. */
#if defined(__x86_64__)

#include <immintrin.h>

#include "bspline.h"
#include "bytes.h"
#include "rg_blob.h"
#include "surface.h"

#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))), \
                             apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2")
#endif

#define INLINE static inline __attribute__((always_inline))

/* Of a row, or of the column of four rows: the weights in the lower halves of
 * 64 bits, and both coordinates, a b a b a b a b. */

/* From registers: they are not in memory yet. */
INLINE __m256i set_weights(const int32_t w_q31[4]) {
  const __m128i first = _mm_cvtsi32_si128(w_q31[0]);
  const __m128i third = _mm_cvtsi32_si128(w_q31[2]);
  return _mm256_set_m128i(_mm_insert_epi32(third, w_q31[3], 2),
                          _mm_insert_epi32(first, w_q31[1], 2));
}

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
INLINE __m128i add_rows(const __m256i rows[4], const int32_t w_q31[4]) {
  const __m256i sums = _mm256_set_m128i(add_points(rows[2], rows[3]),
                                        add_points(rows[0], rows[1]));
  const __m256i column = multiply_high(sums, set_weights(w_q31));
  return add_points(column, column);
}

INLINE __m128i sum_points(const uint8_t* points, uint32_t row_bytes,
                          const rg_place* place) {
  const __m256i weights = set_weights(place->weights_q31[0]);
  __m256i rows[4];
  _Pragma("GCC unroll 4") for (int j = 0; j < 4; ++j, points += row_bytes)
      rows[j] =
          multiply_high(_mm256_loadu_si256((const __m256i*)points), weights);
  return add_rows(rows, place->weights_q31[1]);
}

INLINE __m128i sum_residuals(const uint8_t* residuals, uint32_t row_bytes,
                             const rg_place* place) {
  const __m256i weights = set_weights(place->weights_q31[0]);
  __m256i rows[4];
  _Pragma("GCC unroll 4") for (int j = 0; j < 4; ++j, residuals += row_bytes)
      rows[j] = multiply_half(
          _mm256_cvtepi16_epi32(_mm_loadu_si128((const __m128i*)residuals)),
          weights);
  return add_rows(rows, place->weights_q31[1]);
}

/* Of control points of 16 bits. */
INLINE __m128i find_narrow_value(const uint8_t* grid, const rg_place* place) {
  const uint8_t* const plane = grid + rg_load_u32(grid + 32);
  const int shift = rg_load_u16(grid + 30) - 13; /* from 2^14 to q27 */
  const __m128i sums = _mm_add_epi32(
      sum_residuals(plane + RG_NARROW_PLANE_SIZE + 4 * place->first,
                    4u * rg_load_u16(grid + 16), place),
      _mm_set1_epi32(1 << (shift - 1)));
  const __m128i value =
      _mm_insert_epi32(_mm_cvtsi32_si128(rg_evaluate_plane(plane, place)),
                       rg_evaluate_plane(plane + 4, place), 1);
  return _mm_add_epi32(value, _mm_sra_epi32(sums, _mm_cvtsi32_si128(shift)));
}

int rg_find_place_avx2(const uint8_t* grid, int32_t x, int32_t y,
                       rg_place* place) {
  if (!rg_find_weights(grid, x, y, place)) return 0;
  const __m128i value =
      rg_load_u16(grid + 30) == RG_CONTROL_POINT_BITS
          ? sum_points(grid + rg_load_u32(grid + 32) + 8 * place->first,
                       8u * rg_load_u16(grid + 16), place)
          : find_narrow_value(grid, place);
  _mm_storel_epi64((__m128i*)place->value.q27, value);
  return 1;
}

#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif

#endif
