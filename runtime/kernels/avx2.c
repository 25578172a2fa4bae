/* Bilinear blending by table lookup: the pixels of a segment read at most 16
 * contiguous bytes of each of three rows, so that byte shuffles take the place
 * of a gather. 128 bits hold a segment of one row, the other 128 bits the same
 * pixels of the next row. Runs with larger steps go to the portable kernels. */
#if defined(__x86_64__)

#include "remap_kernels.h"

#pragma GCC target("avx2")
#include <immintrin.h>

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
/* As byte indices of a shuffle: lane n for every lane. */
#define PICK(n) (0x0100 + 0x0202 * (n))

/* The pixel of each lane. */
INLINE __m256i lane_pixels(layout l) {
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

/* The first and the last lane of the window that a lane belongs to. */
INLINE __m256i first_lane(layout l) {
  if (!l.is_halved) return _mm256_set1_epi16(PICK(0));
  return LANES(PICK(0), PICK(0), PICK(0), PICK(0), PICK(4), PICK(4), PICK(4),
               PICK(4));
}
INLINE __m256i last_lane(layout l) {
  if (!l.is_halved) return _mm256_set1_epi16(PICK(7));
  return LANES(PICK(3), PICK(3), PICK(3), PICK(3), PICK(7), PICK(7), PICK(7),
               PICK(7));
}

/* x, y, step x, step y of two rows; the steps are kept in 16 bits too. */
INLINE __m256i find_rows(const rg_run* run, uint32_t r, uint32_t next) {
  const rg_block* const block = &run->block;
  const __m256i top = _mm256_broadcastsi128_si256(
      _mm_loadu_si128((const __m128i*)block->corners));
  const __m256i bottom = _mm256_broadcastsi128_si256(
      _mm_loadu_si128((const __m128i*)(block->corners + 2)));
  const __m256i rows = _mm256_inserti128_si256(
      _mm256_set1_epi32((int32_t)(run->first_row + r)),
      _mm_set1_epi32((int32_t)(run->first_row + next)), 1);
  /* left, right = top + round((bottom - top) r, height_log2) */
  const __m256i down = _mm256_add_epi32(
      _mm256_mullo_epi32(_mm256_sub_epi32(bottom, top), rows),
      _mm256_set1_epi32(1 << block->height_log2 >> 1));
  const __m256i edges = _mm256_add_epi32(
      top, _mm256_sra_epi32(down, _mm_cvtsi32_si128(block->height_log2)));
  /* step = round(right - left, width_log2) */
  const __m256i across = _mm256_add_epi32(
      _mm256_sub_epi32(_mm256_shuffle_epi32(edges, 0x4e), edges),
      _mm256_set1_epi32(1 << block->width_log2 >> 1));
  const __m256i steps =
      _mm256_sra_epi32(across, _mm_cvtsi32_si128(block->width_log2));
  const __m256i origin =
      _mm256_set1_epi64x((int64_t)((uint64_t)run->first_source_row << 44));
  const __m256i starts = _mm256_sub_epi32(
      _mm256_add_epi32(edges,
                       _mm256_mullo_epi32(
                           steps, _mm256_set1_epi32(run->first_pixel))),
      origin);
  return _mm256_unpacklo_epi64(starts, steps);
}

/* 32-bit value c of each row to its lanes of 16 bits. */
INLINE __m256i to_lanes(__m256i rows, int c) {
  return _mm256_shuffle_epi8(rows,
                             _mm256_set1_epi16((int16_t)(0x0100 + 0x0404 * c)));
}

/* The windows of both rows. */
INLINE __m256i load(const uint8_t* const windows[4], size_t offset, layout l) {
  if (!l.is_halved)
    return _mm256_inserti128_si256(
        _mm256_castsi128_si256(
            _mm_loadu_si128((const __m128i*)(windows[0] + offset))),
        _mm_loadu_si128((const __m128i*)(windows[2] + offset)), 1);
  uint64_t bytes[4];
  for (int k = 0; k < 4; ++k)
    __builtin_memcpy(&bytes[k], windows[k] + offset, 8);
  return _mm256_setr_epi64x((int64_t)bytes[0], (int64_t)bytes[1],
                            (int64_t)bytes[2], (int64_t)bytes[3]);
}

/* Two segments: windows are those of row 0, row 0 second half, row 1, ...; x
 * in q12 and y in q15 modulo 2^16. Results in the low bytes of lanes. */
INLINE __m256i blend_segments(const uint8_t* const windows[4], size_t stride,
                              __m256i x, __m256i y, __m256i y_pick, layout l) {
  /* pixel of the window and 12 bits of fraction */
  const __m256i x_start = _mm256_and_si256(
      _mm256_shuffle_epi8(x, first_lane(l)), _mm256_set1_epi16(-4096));
  const __m256i x_q12 = _mm256_sub_epi16(x, x_start);
  /* byte indices of left and right sample */
  const __m256i index = _mm256_add_epi16(
      _mm256_mullo_epi16(_mm256_srli_epi16(x_q12, 12),
                         _mm256_set1_epi16((int16_t)(0x0101 * l.channels))),
      lane_offsets(l));
  /* bytes wx - 128 and -wx */
  const __m256i wx = _mm256_and_si256(_mm256_srli_epi16(x_q12, 5),
                                      _mm256_set1_epi16(127));
  const __m256i weights =
      _mm256_add_epi16(_mm256_mullo_epi16(wx, _mm256_set1_epi16(-255)),
                       _mm256_set1_epi16(128));
  /* -h of the three rows */
  const __m256i h0 = _mm256_maddubs_epi16(
      _mm256_shuffle_epi8(load(windows, 0, l), index), weights);
  const __m256i h1 = _mm256_maddubs_epi16(
      _mm256_shuffle_epi8(load(windows, stride, l), index), weights);
  const __m256i h2 = _mm256_maddubs_epi16(
      _mm256_shuffle_epi8(load(windows, 2 * stride, l), index), weights);
  /* sign: in the second of the window's rows */
  const __m256i y_start = _mm256_and_si256(_mm256_shuffle_epi8(y, y_pick),
                                           _mm256_set1_epi16(INT16_MIN));
  const __m256i y_q15 = _mm256_xor_si256(y, y_start);
  const __m256i is_second = _mm256_srai_epi16(y_q15, 15);
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

INLINE void blend_rows(const rg_run* run, uint32_t r, layout l) {
  const uint32_t next = r + 1 < run->num_rows ? r + 1 : r;
  const uint32_t n = run->num_pixels;
  const size_t stride = run->stride;
  const __m256i rows = find_rows(run, r, next);
  int32_t row[8] __attribute__((aligned(32))); /* x, y, step x, step y; ... */
  _mm256_store_si256((__m256i*)row, rows);

  const __m256i step_x = to_lanes(rows, 2);
  const __m256i step_y = _mm256_slli_epi16(to_lanes(rows, 3), 3);
  __m256i x = _mm256_add_epi16(
      _mm256_add_epi16(to_lanes(rows, 0), _mm256_set1_epi16(16)),
      _mm256_mullo_epi16(step_x, lane_pixels(l)));
  __m256i y = _mm256_add_epi16(_mm256_slli_epi16(to_lanes(rows, 1), 3),
                               _mm256_mullo_epi16(step_y, lane_pixels(l)));
  const __m256i x_segment = _mm256_mullo_epi16(
      step_x, _mm256_set1_epi16((int16_t)l.pixels));
  const __m256i y_segment = _mm256_mullo_epi16(
      step_y, _mm256_set1_epi16((int16_t)l.pixels));
  /* The lane with the uppermost row. */
  const __m256i y_pick = _mm256_blendv_epi8(
      first_lane(l), last_lane(l),
      _mm256_shuffle_epi8(_mm256_srai_epi32(rows, 31),
                          _mm256_set1_epi8(12)));
  const int32_t window_pixels = (int32_t)l.pixels >> l.is_halved;
  int32_t above[2];
  for (int k = 0; k < 2; ++k) {
    const int32_t down = row[4 * k + 3] * (window_pixels - 1);
    above[k] = down < 0 ? down : 0;
  }
  uint8_t* const out0 =
      run->out + (size_t)r * run->out_stride + run->out_pixel * l.channels;
  uint8_t* const out1 = out0 + (size_t)(next - r) * run->out_stride;
  for (uint32_t k = 0; k < n; k += l.pixels) {
    if (k + l.pixels > n) { /* the last segment begins earlier */
      const __m256i back = _mm256_set1_epi16((int16_t)(k + l.pixels - n));
      x = _mm256_sub_epi16(x, _mm256_mullo_epi16(step_x, back));
      y = _mm256_sub_epi16(y, _mm256_mullo_epi16(step_y, back));
      k = n - l.pixels;
    }
    const uint8_t* windows[4];
    for (int w = 0; w < 4; ++w) {
      if (w % 2 == 1 && !l.is_halved) continue;
      const int32_t* const start = row + 4 * (w / 2);
      const int32_t pixel = (int32_t)k + (w % 2) * window_pixels;
      const int32_t column = (start[0] + pixel * start[2] + 16) >> 12;
      const int32_t line = (start[1] + pixel * start[3] + above[w / 2]) >> 12;
      windows[w] = run->data + (size_t)line * stride +
                   (size_t)column * l.channels;
    }
    const __m256i v = blend_segments(windows, stride, x, y, y_pick, l);
    __m256i bytes = _mm256_packus_epi16(v, v);
    store(out0 + k * l.channels, _mm256_castsi256_si128(bytes),
          k + l.pixels == n, l);
    store(out1 + k * l.channels, _mm256_extracti128_si256(bytes, 1),
          k + l.pixels == n, l);
    x = _mm256_add_epi16(x, x_segment);
    y = _mm256_add_epi16(y, y_segment);
  }
}

/* Bounds of a run's steps: those between the first row and the last lie between
 * theirs but for rounding, which is less than 2. */
typedef struct step_range {
  int32_t min_x, max_x, max_y;
} step_range;

INLINE step_range find_steps(const rg_run* run) {
  step_range range = {INT32_MAX, INT32_MIN, 0};
  for (uint32_t k = 0; k < 2; ++k) {
    rg_block_row row;
    rg_find_block_row(&run->block,
                      run->first_row + (k == 0 ? 0 : run->num_rows - 1u), &row);
    const int32_t x = row.step.q12[0], y = row.step.q12[1];
    if (x < range.min_x) range.min_x = x;
    if (x > range.max_x) range.max_x = x;
    if (y > range.max_y) range.max_y = y;
    if (-y > range.max_y) range.max_y = -y;
  }
  range.min_x -= 2;
  range.max_x += 2;
  range.max_y += 2;
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
  if (run->num_pixels < pixels) {
    portable(run);
  } else if (fits(steps, pixels, 16 / channels)) {
    for (uint32_t r = 0; r < run->num_rows; r += 2) blend_rows(run, r, whole);
  } else if (channels <= 2 && fits(steps, pixels / 2, 8 / channels)) {
    for (uint32_t r = 0; r < run->num_rows; r += 2) blend_rows(run, r, halved);
  } else {
    portable(run);
  }
}

void rg_blend_1_avx2(const rg_run* run) { blend(run, 1, rg_blend_1); }
void rg_blend_2_avx2(const rg_run* run) { blend(run, 2, rg_blend_2); }
void rg_blend_3_avx2(const rg_run* run) { blend(run, 3, rg_blend_3); }
void rg_blend_4_avx2(const rg_run* run) { blend(run, 4, rg_blend_4); }

#endif
