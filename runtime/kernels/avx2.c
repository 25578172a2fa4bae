/* Bilinear blending by table lookup: the pixels of a segment read at most 16
 * contiguous bytes of each of three rows, so that byte shuffles take the place
 * of a gather. 128 bits hold a segment of one row, the other 128 bits the same
 * pixels of the next row. Runs with larger steps go to the portable kernels. */
#if defined(__x86_64__)

#include <immintrin.h>

#include "remap_kernels.h"

#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))), \
                             apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2")
#endif

#define INLINE static inline __attribute__((always_inline))

/* How 8 lanes of 16 bits are used. */
typedef struct layout {
  uint32_t channels;
  uint32_t pixels; /* of a segment: 2, 4 or 8 */
  int is_halved;   /* two windows of 8 bytes a segment, for steep rows */
} layout;

/* Two bytes for each of 8 lanes, in both rows. */
#define LANES(a, b, c, d, e, f, g, h) \
  _mm256_setr_epi16(a, b, c, d, e, f, g, h, a, b, c, d, e, f, g, h)

/* The pixel of each lane, counted in its window. */
INLINE __m256i lane_pixels(layout l) {
  if (l.channels == 1 && l.is_halved) return LANES(0, 1, 2, 3, 0, 1, 2, 3);
  if (l.channels == 2 && l.is_halved) return LANES(0, 0, 1, 1, 0, 0, 1, 1);
  if (l.channels == 1) return LANES(0, 1, 2, 3, 4, 5, 6, 7);
  if (l.channels == 2) return LANES(0, 0, 1, 1, 2, 2, 3, 3);
  if (l.channels == 3) return LANES(0, 0, 0, 1, 1, 1, 1, 1);
  return LANES(0, 0, 0, 0, 1, 1, 1, 1);
}

/* Where the window of each lane has the first pixel's left and right sample. */
INLINE __m256i lane_offsets(layout l) {
  if (l.channels == 1 && l.is_halved)
    return LANES(0x100, 0x100, 0x100, 0x100, 0x908, 0x908, 0x908, 0x908);
  if (l.channels == 1) return _mm256_set1_epi16(0x100);
  if (l.channels == 2 && l.is_halved)
    return LANES(0x200, 0x301, 0x200, 0x301, 0xa08, 0xb09, 0xa08, 0xb09);
  if (l.channels == 2)
    return LANES(0x200, 0x301, 0x200, 0x301, 0x200, 0x301, 0x200, 0x301);
  if (l.channels == 3)
    return LANES(0x300, 0x401, 0x502, 0x300, 0x401, 0x502, 0x502, 0x502);
  return LANES(0x400, 0x501, 0x602, 0x703, 0x400, 0x501, 0x602, 0x703);
}

/* Keeps the compiler from taking a multiplication or a blend apart. */
INLINE __m256i as_is(__m256i value) {
  __asm__("" : "+x"(value));
  return value;
}

/* Two rows of a run, one in either half, and what leads to the next two. */
typedef struct row_pair {
  __m256i top;  /* P00, P10 */
  __m256i down; /* (P01 - P00) r, (P11 - P10) r, and half an LSB */
  __m256i two_down;
  __m128i height_log2, width_log2;
  __m256i half_width; /* half an LSB of a step */
  __m256i first_pixel;
} row_pair;

/* One by one, as they were just stored: a load of 16 bytes would wait. */
INLINE __m256i load_corners(const rg_position* p) {
  return _mm256_broadcastsi128_si256(
      _mm_setr_epi32(p[0].q12[0], p[0].q12[1], p[1].q12[0], p[1].q12[1]));
}

INLINE row_pair first_rows(const rg_run* run) {
  const rg_block* const block = &run->block;
  row_pair rows;
  const __m256i top = load_corners(block->corners);
  const __m256i height =
      _mm256_sub_epi32(load_corners(block->corners + 2), top);
  rows.top = _mm256_sub_epi32(
      top,
      _mm256_set1_epi64x((int64_t)((uint64_t)run->first_source_row << 44)));
  const __m256i r = _mm256_add_epi32(_mm256_set1_epi32(run->first_row),
                                     _mm256_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1));
  rows.down = _mm256_add_epi32(_mm256_mullo_epi32(height, r),
                               _mm256_set1_epi32(1 << block->height_log2 >> 1));
  rows.two_down = _mm256_add_epi32(height, height);
  rows.height_log2 = _mm_cvtsi32_si128(block->height_log2);
  rows.width_log2 = _mm_cvtsi32_si128(block->width_log2);
  rows.half_width = _mm256_set1_epi32(1 << block->width_log2 >> 1);
  rows.first_pixel = _mm256_set1_epi32(run->first_pixel);
  return rows;
}

/* x, y, step x, step y of both rows. */
INLINE __m256i find_rows(const row_pair* rows) {
  /* left, right = top + round((bottom - top) r, height_log2) */
  const __m256i edges = _mm256_add_epi32(
      rows->top, _mm256_sra_epi32(rows->down, rows->height_log2));
  /* step = round(right - left, width_log2) */
  const __m256i across = _mm256_add_epi32(
      _mm256_sub_epi32(_mm256_shuffle_epi32(edges, 0x4e), edges),
      rows->half_width);
  const __m256i steps = _mm256_sra_epi32(across, rows->width_log2);
  const __m256i starts =
      _mm256_add_epi32(edges, _mm256_mullo_epi32(steps, rows->first_pixel));
  return _mm256_unpacklo_epi64(starts, steps);
}

/* 32-bit value c of each row to its lanes of 16 bits. */
INLINE __m256i to_lanes(__m256i rows, int c) {
  return _mm256_shuffle_epi8(rows,
                             _mm256_set1_epi16((int16_t)(0x0100 + 0x0404 * c)));
}

/* Where the windows of both rows begin; second ones where rows are halved. */
typedef struct windows {
  const uint8_t *row0, *row1, *second0, *second1;
} windows;

INLINE __m256i load(const windows* w, size_t offset, layout l) {
  if (!l.is_halved)
    return _mm256_inserti128_si256(
        _mm256_castsi128_si256(
            _mm_loadu_si128((const __m128i*)(w->row0 + offset))),
        _mm_loadu_si128((const __m128i*)(w->row1 + offset)), 1);
  int64_t bytes[4];
  __builtin_memcpy(&bytes[0], w->row0 + offset, 8);
  __builtin_memcpy(&bytes[1], w->second0 + offset, 8);
  __builtin_memcpy(&bytes[2], w->row1 + offset, 8);
  __builtin_memcpy(&bytes[3], w->second1 + offset, 8);
  return _mm256_setr_epi64x(bytes[0], bytes[1], bytes[2], bytes[3]);
}

/* start: x in q12, y in q15 of a pixel of both rows. factors: bytes of a pixel
 * and of a row, in 16 bits. */
INLINE void find_windows(const uint8_t* data, __m256i start, __m256i factors,
                         const uint8_t** row0, const uint8_t** row1) {
  const __m256i pixel =
      _mm256_srav_epi32(start, _mm256_setr_epi32(12, 15, 0, 0, 12, 15, 0, 0));
  const __m256i products = _mm256_madd_epi16(pixel, factors);
  const __m256i offsets =
      _mm256_add_epi32(products, _mm256_shuffle_epi32(products, 1));
  *row0 = data + (uint32_t)_mm256_cvtsi256_si32(offsets);
  *row1 =
      data + (uint32_t)_mm_cvtsi128_si32(_mm256_extracti128_si256(offsets, 1));
}

/* The fractions of where windows start, to their lanes. */
INLINE __m256i fractions(__m256i start, __m256i second, int c, layout l) {
  const __m256i mask = _mm256_set1_epi64x(INT64_C(0x7fff00000fff));
  const __m256i first = to_lanes(_mm256_and_si256(start, mask), c);
  if (!l.is_halved) return first;
  return _mm256_blend_epi16(first, to_lanes(_mm256_and_si256(second, mask), c),
                            0xf0);
}

/* A segment of both rows; x in q12 and y in q15 from where the windows start.
 * Results in the low bytes of lanes. */
INLINE __m256i blend_segments(const windows* w, size_t stride, __m256i x_q12,
                              __m256i y_q15, layout l) {
  /* byte indices of left and right sample */
  const __m256i index = _mm256_add_epi16(
      _mm256_mullo_epi16(
          _mm256_srli_epi16(x_q12, 12),
          as_is(_mm256_set1_epi16((int16_t)(0x0101 * l.channels)))),
      lane_offsets(l));
  /* bytes wx - 128 and -wx */
  const __m256i wx =
      _mm256_and_si256(_mm256_srli_epi16(x_q12, 5), _mm256_set1_epi16(127));
  const __m256i weights =
      _mm256_add_epi16(_mm256_mullo_epi16(wx, as_is(_mm256_set1_epi16(-255))),
                       _mm256_set1_epi16(128));
  /* -h of the three rows */
  const __m256i h0 =
      _mm256_maddubs_epi16(_mm256_shuffle_epi8(load(w, 0, l), index), weights);
  const __m256i h1 = _mm256_maddubs_epi16(
      _mm256_shuffle_epi8(load(w, stride, l), index), weights);
  const __m256i h2 = _mm256_maddubs_epi16(
      _mm256_shuffle_epi8(load(w, 2 * stride, l), index), weights);
  /* The sign of y: in the second of the window's rows. */
  const __m256i is_second = as_is(_mm256_srai_epi16(y_q15, 15));
  const __m256i wy = _mm256_and_si256(y_q15, _mm256_set1_epi16(INT16_MAX));
  const __m256i upper = _mm256_blendv_epi8(h0, h1, is_second);
  const __m256i lower = _mm256_blendv_epi8(h1, h2, is_second);
  /* -v = -h0 + ((h0 - h1) wy + 2^14) >> 15 */
  const __m256i v = _mm256_add_epi16(
      upper, _mm256_mulhrs_epi16(_mm256_sub_epi16(lower, upper), wy));
  /* (v + 64) >> 7 */
  return _mm256_mulhrs_epi16(v, _mm256_set1_epi16(-256));
}

/* One row's segment. Three channels leave two bytes of the eight over, which
 * the next segment overwrites. */
INLINE void store(uint8_t* out, __m128i bytes, int is_last, layout l) {
  if (l.channels == 3 && is_last) {
    const uint32_t low = (uint32_t)_mm_cvtsi128_si32(bytes);
    const uint16_t high = (uint16_t)_mm_extract_epi16(bytes, 2);
    __builtin_memcpy(out, &low, 4);
    __builtin_memcpy(out + 4, &high, 2);
  } else {
    _mm_storel_epi64((__m128i*)out, bytes);
  }
}

INLINE int log2_of(uint32_t pixels) {
  return pixels == 8 ? 3 : pixels == 4 ? 2 : pixels == 2 ? 1 : 0;
}
INLINE __m256i times(__m256i values, uint32_t pixels) {
  return _mm256_slli_epi32(values, log2_of(pixels));
}

INLINE void blend_run(const rg_run* run, layout l) {
  const uint8_t* const data = run->data;
  const uint32_t n = run->num_pixels, num_rows = run->num_rows;
  const size_t stride = run->stride, out_stride = run->out_stride;
  uint8_t* out = run->out + run->out_pixel * l.channels;
  row_pair pair = first_rows(run);
  const __m256i factors =
      _mm256_set1_epi64x((int64_t)((uint64_t)stride << 32 | l.channels));
  const uint32_t window_pixels = l.pixels >> l.is_halved;
  const __m256i lanes = lane_pixels(l);
  for (uint32_t r = 0; r < num_rows; r += 2, out += 2 * out_stride) {
    size_t to_next = out_stride;
    if (r + 1 == num_rows) { /* the last one twice */
      pair.down = _mm256_permute2x128_si256(pair.down, pair.down, 0);
      to_next = 0;
    }
    /* y in q15 from here on */
    const __m256i rows = _mm256_sllv_epi32(
        find_rows(&pair), _mm256_setr_epi32(0, 3, 0, 3, 0, 3, 0, 3));
    pair.down = _mm256_add_epi32(pair.down, pair.two_down);

    /* Steps, x in q12 and y in q15; x and y of lanes from the first one. */
    const __m256i steps = _mm256_shuffle_epi32(rows, 0x4e);
    const __m256i lanes_x = _mm256_mullo_epi16(to_lanes(steps, 0), lanes);
    const __m256i from_first_y = _mm256_mullo_epi16(to_lanes(steps, 1), lanes);
    /* The window starts at the first x + 16 and the least y. */
    const __m256i up = _mm256_min_epi32(
        _mm256_and_si256(_mm256_sub_epi32(times(steps, window_pixels), steps),
                         _mm256_set1_epi64x((int64_t)(UINT64_MAX << 32))),
        _mm256_setzero_si256());
    const __m256i lanes_y = _mm256_sub_epi16(from_first_y, to_lanes(up, 1));
    __m256i start =
        _mm256_add_epi32(_mm256_add_epi32(rows, _mm256_set1_epi64x(16)), up);
    for (uint32_t k = 0; k < n; k += l.pixels) {
      if (k + l.pixels > n) { /* the last segment begins earlier */
        const uint32_t back = k + l.pixels - n;
        start = _mm256_sub_epi32(
            start, _mm256_mullo_epi32(steps, _mm256_set1_epi32((int32_t)back)));
        k = n - l.pixels;
      }
      windows w;
      find_windows(data, start, factors, &w.row0, &w.row1);
      const __m256i second =
          _mm256_add_epi32(start, times(steps, window_pixels));
      if (l.is_halved)
        find_windows(data, second, factors, &w.second0, &w.second1);
      const __m256i x =
          _mm256_add_epi16(fractions(start, second, 0, l), lanes_x);
      const __m256i y =
          _mm256_add_epi16(fractions(start, second, 1, l), lanes_y);
      const __m256i v = blend_segments(&w, stride, x, y, l);
      const __m256i bytes = _mm256_packus_epi16(v, v);
      const int is_last = k + l.pixels == n;
      uint8_t* const target = out + k * l.channels;
      store(target, _mm256_castsi256_si128(bytes), is_last, l);
      store(target + to_next, _mm256_extracti128_si256(bytes, 1), is_last, l);
      start = _mm256_add_epi32(start, times(steps, l.pixels));
    }
  }
}

/* Bounds of a run's steps: those between the first row and the last lie between
 * theirs but for rounding, which is less than 2. */
typedef struct step_range {
  int32_t min_x, max_x, max_y;
} step_range;

INLINE step_range find_steps(const rg_run* run) {
  row_pair ends = first_rows(run);
  const __m256i to_last =
      _mm256_mullo_epi32(_mm256_srai_epi32(ends.two_down, 1),
                         _mm256_set1_epi32((int32_t)run->num_rows - 1));
  ends.down = _mm256_add_epi32(
      _mm256_permute2x128_si256(ends.down, ends.down, 0),
      _mm256_inserti128_si256(_mm256_setzero_si256(),
                              _mm256_castsi256_si128(to_last), 1));
  const __m256i steps = _mm256_unpackhi_epi64(find_rows(&ends), ends.down);
  const __m128i first = _mm256_castsi256_si128(steps);
  const __m128i last = _mm256_extracti128_si256(steps, 1);
  const __m128i min = _mm_min_epi32(first, last);
  const __m128i max = _mm_max_epi32(first, last);
  const __m128i max_abs = _mm_max_epi32(_mm_abs_epi32(min), _mm_abs_epi32(max));
  const step_range range = {_mm_cvtsi128_si32(min) - 2,
                            _mm_cvtsi128_si32(max) + 2,
                            _mm_extract_epi32(max_abs, 1) + 2};
  return range;
}

/* Whether a window of some bytes holds some pixels and their neighbours, on two
 * rows: (x & 4095) + 16 + (pixels - 1) step < 4096 (pixels of the window - 1).
 */
INLINE int fits(step_range range, uint32_t pixels, uint32_t window_pixels) {
  const int32_t steps = (int32_t)pixels - 1;
  const int32_t room = (int32_t)(window_pixels - 1) * 4096 - 4112;
  return range.min_x >= 0 && range.max_x < 16384 &&
         range.max_x * steps <= room && range.max_y < 16384 &&
         range.max_y * steps <= 4096;
}

INLINE void blend(const rg_run* run, uint32_t channels, rg_blend* portable) {
  const uint32_t pixels = channels == 1 ? 8 : channels == 2 ? 4 : 2;
  const layout whole = {channels, pixels, 0};
  const layout halved = {channels, pixels, 1};
  const step_range steps = find_steps(run);
  if (run->num_pixels < pixels || run->stride > INT16_MAX)
    portable(run);
  else if (fits(steps, pixels, 16 / channels))
    blend_run(run, whole);
  else if (channels <= 2 && fits(steps, pixels / 2, 8 / channels))
    blend_run(run, halved);
  else
    portable(run);
}

void rg_blend_1_avx2(const rg_run* run) { blend(run, 1, rg_blend_1); }
void rg_blend_2_avx2(const rg_run* run) { blend(run, 2, rg_blend_2); }
void rg_blend_3_avx2(const rg_run* run) { blend(run, 3, rg_blend_3); }
void rg_blend_4_avx2(const rg_run* run) { blend(run, 4, rg_blend_4); }

#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif

#endif
