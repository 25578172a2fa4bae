/* Bilinear interpolation by table lookup as in avx2.c, with half its width: 8
 * lanes of one row, whose pixels read at most 16 contiguous bytes of each of
 * three rows. Spans with larger steps are processed by the portable kernels. */
#include "kernels/kernel.h"
#include "kernels/segments.h"

#if RG_SELECT_KERNELS && defined(__x86_64__)

#include <smmintrin.h>
#include <stddef.h>

#include "x86_features.h"

RG_BEGIN_FEATURES("sse4.1")

#define INLINE static inline __attribute__((always_inline))

/* The pixels of a segment: 2, 4 or 8. */
typedef struct layout {
  uint32_t channels, pixels;
} layout;

/* The pixel of each lane, relative to its window. */
INLINE __m128i lane_pixels(layout l) {
  if (l.channels == 1) return _mm_setr_epi16(0, 1, 2, 3, 4, 5, 6, 7);
  if (l.channels == 2) return _mm_setr_epi16(0, 0, 1, 1, 2, 2, 3, 3);
  if (l.channels == 3) return _mm_setr_epi16(0, 0, 0, 1, 1, 1, 1, 1);
  return _mm_setr_epi16(0, 0, 0, 0, 1, 1, 1, 1);
}

/* The byte offsets in the window of the first pixel's left and right sample. */
INLINE __m128i lane_offsets(layout l) {
  if (l.channels == 1) return _mm_set1_epi16(0x100);
  if (l.channels == 2)
    return _mm_setr_epi16(0x200, 0x301, 0x200, 0x301, 0x200, 0x301, 0x200,
                          0x301);
  if (l.channels == 3)
    return _mm_setr_epi16(0x300, 0x401, 0x502, 0x300, 0x401, 0x502, 0x502,
                          0x502);
  return _mm_setr_epi16(0x400, 0x501, 0x602, 0x703, 0x400, 0x501, 0x602, 0x703);
}

/* Prevents the compiler from decomposing a multiplication or a blend. */
INLINE __m128i as_is(__m128i value) {
  __asm__("" : "+x"(value));
  return value;
}

/* -h of one row: the horizontal interpolation, times 128. */
INLINE __m128i blend_across(const uint8_t* row, __m128i index,
                            __m128i weights) {
  const __m128i bytes = _mm_loadu_si128((const __m128i*)(const void*)row);
  return _mm_maddubs_epi16(_mm_shuffle_epi8(bytes, index), weights);
}

/* x in q12 and y in q15, relative to the window's start; results are in the low
 * bytes of lanes. */
INLINE __m128i blend_segment(const uint8_t* window, size_t stride,
                             __m128i x_q12, __m128i y_q15, layout l) {
  /* byte indices of left and right sample */
  const __m128i index = _mm_add_epi16(
      _mm_mullo_epi16(_mm_srli_epi16(x_q12, 12),
                      as_is(_mm_set1_epi16((int16_t)(0x0101 * l.channels)))),
      lane_offsets(l));
  /* bytes wx - 128 and -wx */
  const __m128i wx =
      _mm_and_si128(_mm_srli_epi16(x_q12, 5), _mm_set1_epi16(127));
  const __m128i weights = _mm_add_epi16(
      _mm_mullo_epi16(wx, as_is(_mm_set1_epi16(-255))), _mm_set1_epi16(128));
  const __m128i h0 = blend_across(window, index, weights);
  const __m128i h1 = blend_across(window + stride, index, weights);
  const __m128i h2 = blend_across(window + 2 * stride, index, weights);
  /* The sign bit of y selects the second of the window's rows. */
  const __m128i is_second = as_is(_mm_srai_epi16(y_q15, 15));
  const __m128i wy = _mm_and_si128(y_q15, _mm_set1_epi16(INT16_MAX));
  const __m128i upper = _mm_blendv_epi8(h0, h1, is_second);
  const __m128i lower = _mm_blendv_epi8(h1, h2, is_second);
  /* -v = -h0 + ((h0 - h1) wy + 2^14) >> 15 */
  const __m128i v =
      _mm_add_epi16(upper, _mm_mulhrs_epi16(_mm_sub_epi16(lower, upper), wy));
  /* (v + 64) >> 7 */
  return _mm_mulhrs_epi16(v, _mm_set1_epi16(-256));
}

/* With three channels, two of the eight bytes are unused; the next segment
 * overwrites them. */
INLINE void store(uint8_t* out, __m128i bytes, int is_last, layout l) {
  if (l.channels == 3 && is_last) {
    const uint32_t low = (uint32_t)_mm_cvtsi128_si32(bytes);
    const uint16_t high = (uint16_t)_mm_extract_epi16(bytes, 2);
    __builtin_memcpy(out, &low, 4);
    __builtin_memcpy(out + 4, &high, 2);
  } else {
    _mm_storel_epi64((__m128i*)(void*)out, bytes);
  }
}

INLINE void blend_row(const rg_span* span, const rg_block_row* row,
                      uint8_t* out, layout l) {
  const int32_t pixels = (int32_t)l.pixels, n = span->num_pixels;
  const int32_t step_x = row->step.q12[0], step_y = row->step.q12[1];
  /* The window starts at the first x + 16 and the minimum y. */
  const int32_t up = step_y < 0 ? (pixels - 1) * step_y : 0;
  const __m128i lanes = lane_pixels(l);
  const __m128i lanes_x =
      _mm_mullo_epi16(_mm_set1_epi16((int16_t)step_x), lanes);
  const __m128i lanes_y = _mm_sub_epi16(
      _mm_mullo_epi16(_mm_set1_epi16((int16_t)(8 * step_y)), lanes),
      _mm_set1_epi16((int16_t)(8 * up)));
  int32_t x = row->start.q12[0] + 16, y = row->start.q12[1] + up;
  for (int32_t k = 0; k < n; k += pixels) {
    if (k + pixels > n) { /* the last segment overlaps the previous one */
      const int32_t back = k + pixels - n;
      x -= back * step_x;
      y -= back * step_y;
      k = n - pixels;
    }
    const uint8_t* const window = span->data +
                                  (size_t)((uint32_t)y >> 12) * span->stride +
                                  ((uint32_t)x >> 12) * l.channels;
    const __m128i x_q12 =
        _mm_add_epi16(_mm_set1_epi16((int16_t)(x & 4095)), lanes_x);
    const __m128i y_q15 =
        _mm_add_epi16(_mm_set1_epi16((int16_t)((y & 4095) << 3)), lanes_y);
    const __m128i v = blend_segment(window, span->stride, x_q12, y_q15, l);
    store(out + (uint32_t)k * l.channels, _mm_packus_epi16(v, v),
          k + pixels == n, l);
    x += pixels * step_x;
    y += pixels * step_y;
  }
}

INLINE void blend(const rg_span* span, layout l, rg_blend* portable) {
  if (!rg_fits_windows(span, l.pixels, 16 / l.channels)) {
    portable(span);
    return;
  }
  uint8_t* out = span->out + span->out_pixel * l.channels;
  for (uint32_t r = 0; r < span->num_rows; ++r, out += span->out_stride) {
    rg_block_row row;
    rg_compute_span_row(span, r, &row);
    blend_row(span, &row, out, l);
  }
}

#define BLEND(channels, pixels)                          \
  void rg_blend_##channels##_sse4(const rg_span* span) { \
    const layout l = {channels, pixels};                 \
    blend(span, l, rg_blend_##channels);                 \
  }
BLEND(1, 8)
BLEND(2, 4)
BLEND(3, 2)
BLEND(4, 2)

RG_END_FEATURES

#endif
