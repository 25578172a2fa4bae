/* Bilinear interpolation of two rows at once, 128 bits each. If steps are
 * small, by table lookup: the pixels of a segment read at most 16 contiguous
 * bytes of each of three rows, so that byte shuffles replace a gather.
 * Otherwise, the samples of each pixel are loaded separately. */
#include "kernels/kernel.h"
#include "kernels/segments.h"

#if RG_SELECT_KERNELS && defined(__x86_64__)

#include <immintrin.h>
#include <stddef.h>

#include "x86_features.h"

RG_BEGIN_FEATURES("avx2")

#define INLINE static inline __attribute__((always_inline))

/* The number of rows whose positions are computed together. */
#define TILE_ROWS 8u

/* The prefetch distance to the right, in bytes of a row. */
#define AHEAD 128

/* The use of a row's 8 lanes of 16 bits. */
typedef struct layout {
  uint32_t channels;
  uint32_t pixels; /* per segment */
  int is_halved;   /* two windows of 8 bytes per segment, for steep rows */
} layout;

INLINE uint32_t num_windows(layout l) { return l.is_halved ? 2 : 1; }

INLINE uint32_t window_pixels(layout l) { return l.pixels / num_windows(l); }

/* Two bytes for each of 8 lanes, repeated for both rows. */
#define LANES(a, b, c, d, e, f, g, h) \
  _mm256_setr_epi16(a, b, c, d, e, f, g, h, a, b, c, d, e, f, g, h)

/* The pixel of each lane, relative to its window. */
INLINE __m256i lane_pixels(layout l) {
  if (l.channels == 1 && l.is_halved) return LANES(0, 1, 2, 3, 0, 1, 2, 3);
  if (l.channels == 1) return LANES(0, 1, 2, 3, 4, 5, 6, 7);
  if (l.is_halved) return LANES(0, 0, 1, 1, 0, 0, 1, 1);
  return LANES(0, 0, 1, 1, 2, 2, 3, 3);
}

/* The byte offsets of the first pixel's left and right samples in each lane's
 * window. */
INLINE __m256i lane_offsets(layout l) {
  if (l.channels == 1 && l.is_halved)
    return LANES(0x100, 0x100, 0x100, 0x100, 0x908, 0x908, 0x908, 0x908);
  if (l.channels == 1) return _mm256_set1_epi16(0x100);
  if (l.is_halved)
    return LANES(0x200, 0x301, 0x200, 0x301, 0xa08, 0xb09, 0xa08, 0xb09);
  return LANES(0x200, 0x301, 0x200, 0x301, 0x200, 0x301, 0x200, 0x301);
}

/* Prevents the compiler from decomposing a multiplication. */
INLINE __m256i as_is(__m256i value) {
  __asm__("" : "+x"(value));
  return value;
}

/* b where the mask's bytes are negative; without assembler, the compiler would
 * insert a comparison. */
INLINE __m256i choose(__m256i a, __m256i b, __m256i mask) {
  __asm__("vpblendvb %2, %1, %0, %0" : "+x"(a) : "x"(b), "x"(mask));
  return a;
}

/* ---- Positions ----------------------------------------------------------- */

/* The source of a span, and values common to its rows. They are loaded once,
 * since the compiler must assume that stores to the output modify the span. */
typedef struct span_source {
  const uint8_t* data;
  size_t stride, out_stride;
  uint32_t num_pixels;
  int prefetches_below;
  __m256i stride_lanes;
  __m256i top[4], height[4]; /* of x and y, at the left and at the right edge */
  __m256i half_height, half_width, first_pixel;
  __m128i height_log2, width_log2;
} span_source;

INLINE span_source compute_source(const rg_span* span) {
  const rg_position* const p = span->block.corners;
  span_source s;
  s.data = span->data;
  s.stride = span->stride;
  s.out_stride = span->out_stride;
  s.num_pixels = span->num_pixels;
  s.prefetches_below = span->block.height_log2 < 5;
  s.stride_lanes = _mm256_set1_epi32((int32_t)span->stride);
#define EDGE(k, corner, c)                        \
  s.top[k] = _mm256_set1_epi32(p[corner].q12[c]); \
  s.height[k] =                                   \
      _mm256_sub_epi32(_mm256_set1_epi32(p[corner + 2].q12[c]), s.top[k])
  EDGE(0, 0, 0);
  EDGE(1, 0, 1);
  EDGE(2, 1, 0);
  EDGE(3, 1, 1);
#undef EDGE
  const __m256i first_row =
      _mm256_set1_epi32((int32_t)(span->first_source_row * 4096u));
  s.top[1] = _mm256_sub_epi32(s.top[1], first_row);
  s.top[3] = _mm256_sub_epi32(s.top[3], first_row);
  s.half_height = _mm256_set1_epi32(1 << span->block.height_log2 >> 1);
  s.half_width = _mm256_set1_epi32(1 << span->block.width_log2 >> 1);
  s.first_pixel = _mm256_set1_epi32(span->first_pixel);
  s.height_log2 = _mm_cvtsi32_si128(span->block.height_log2);
  s.width_log2 = _mm_cvtsi32_si128(span->block.width_log2);
  return s;
}

/* The start positions of 8 rows (x + 16 and y) and their steps. */
typedef struct tile {
  __m256i x, y, step_x, step_y;
} tile;

/* top + round((bottom - top) r, log2) */
INLINE __m256i compute_edge(const span_source* s, int k, __m256i r) {
  const __m256i down =
      _mm256_add_epi32(_mm256_mullo_epi32(s->height[k], r), s->half_height);
  return _mm256_add_epi32(_mm256_sra_epi32(down, s->height_log2), s->top[k]);
}

INLINE __m256i compute_step(const span_source* s, __m256i left, __m256i right) {
  return _mm256_sra_epi32(
      _mm256_add_epi32(_mm256_sub_epi32(right, left), s->half_width),
      s->width_log2);
}

/* The rows r of the block. */
INLINE tile compute_tile(const span_source* s, __m256i r) {
  tile rows;
  const __m256i x = compute_edge(s, 0, r), y = compute_edge(s, 1, r);
  rows.step_x = compute_step(s, x, compute_edge(s, 2, r));
  rows.step_y = compute_step(s, y, compute_edge(s, 3, r));
  rows.x = _mm256_add_epi32(_mm256_add_epi32(x, _mm256_set1_epi32(16)),
                            _mm256_mullo_epi32(rows.step_x, s->first_pixel));
  rows.y = _mm256_add_epi32(y, _mm256_mullo_epi32(rows.step_y, s->first_pixel));
  return rows;
}

INLINE void advance(tile* rows, int32_t pixels) {
  const __m256i count = _mm256_set1_epi32(pixels);
  rows->x = _mm256_add_epi32(rows->x, _mm256_mullo_epi32(rows->step_x, count));
  rows->y = _mm256_add_epi32(rows->y, _mm256_mullo_epi32(rows->step_y, count));
}

/* Byte offsets of positions' pixels from the source's start. */
INLINE __m256i compute_offsets(const span_source* s, __m256i x, __m256i y,
                               uint32_t channels) {
  const __m256i column = _mm256_srli_epi32(x, 12);
  const __m256i row =
      _mm256_mullo_epi32(_mm256_srli_epi32(y, 12), s->stride_lanes);
  const __m256i twice = _mm256_add_epi32(column, column);
  return _mm256_add_epi32(row, channels == 1   ? column
                               : channels == 2 ? twice
                               : channels == 3
                                   ? _mm256_add_epi32(twice, column)
                                   : _mm256_add_epi32(twice, twice));
}

/* Prefetch distances in bytes, relative to the source and the output of a row.
 */
typedef struct outlook {
  ptrdiff_t source, out;
} outlook;

/* The distance to the second tile below: sufficient for memory latency, and the
 * direction of rows seldom changes that much. Large blocks with many channels
 * would evict these lines from the L1 cache before their use: then to the
 * right. first, last: offsets of a tile's rows. */
INLINE outlook compute_outlook(const span_source* s, uint32_t first,
                               uint32_t last, uint32_t channels) {
  outlook look = {AHEAD, AHEAD};
  if (s->prefetches_below || channels <= 2) {
    look.source = 2 * ((ptrdiff_t)last - (ptrdiff_t)first);
    look.out = (ptrdiff_t)(2 * TILE_ROWS * s->out_stride);
  }
  return look;
}

/* Prefetches once per 64 bytes of output, which depend on up to 128 bytes. */
INLINE int is_line_begun(const uint8_t* out, uint32_t num_bytes) {
  return ((uintptr_t)out & 63) < num_bytes;
}

INLINE void prefetch_rows(const span_source* s, const outlook* look,
                          const uint8_t* source, const uint8_t* out) {
  source += look->source;
  _mm_prefetch((const char*)source, _MM_HINT_T0);
  _mm_prefetch((const char*)source + 64, _MM_HINT_T0);
  source += s->stride;
  _mm_prefetch((const char*)source, _MM_HINT_T0);
  _mm_prefetch((const char*)source + 64, _MM_HINT_T0);
  __builtin_prefetch(out + look->out, 1);
}

/* ---- Blending ------------------------------------------------------------ */

/* The bytes wx - 128 and -wx. */
INLINE __m256i compute_weights(__m256i x_q12) {
  const __m256i wx =
      _mm256_and_si256(_mm256_srli_epi16(x_q12, 5), _mm256_set1_epi16(127));
  return _mm256_add_epi16(
      _mm256_mullo_epi16(wx, as_is(_mm256_set1_epi16(-255))),
      _mm256_set1_epi16(128));
}

/* upper, lower: -h of the two rows (h: horizontal interpolation). */
INLINE __m256i blend_down(__m256i upper, __m256i lower, __m256i wy_q15) {
  /* -v = -h0 + ((h0 - h1) wy + 2^14) >> 15 */
  const __m256i v = _mm256_add_epi16(
      upper, _mm256_mulhrs_epi16(_mm256_sub_epi16(lower, upper), wy_q15));
  /* (v + 64) >> 7 */
  return _mm256_mulhrs_epi16(v, _mm256_set1_epi16(-256));
}

/* ---- Table lookup in windows --------------------------------------------- */

/* The windows of a segment: their offsets, and the positions of their first
 * pixels relative to these, x in q12 in the low half and y in q15 in the high
 * half. The windows of a row are contiguous. */
typedef struct window_starts {
  uint32_t offsets[2 * TILE_ROWS], starts[2 * TILE_ROWS];
} window_starts;

INLINE void interleave(__m256i first, __m256i second, uint32_t* out) {
  const __m256i low = _mm256_unpacklo_epi32(first, second);
  const __m256i high = _mm256_unpackhi_epi32(first, second);
  _mm256_storeu_si256((__m256i*)(void*)out,
                      _mm256_permute2x128_si256(low, high, 0x20));
  _mm256_storeu_si256((__m256i*)(void*)(out + 8),
                      _mm256_permute2x128_si256(low, high, 0x31));
}

/* up: the offset from a window's first pixel to its minimum y. */
INLINE __m256i compute_window_starts(const tile* rows, __m256i up) {
  const __m256i y_q15 = _mm256_srli_epi32(
      _mm256_slli_epi32(_mm256_add_epi32(rows->y, up), 20), 1);
  return _mm256_or_si256(_mm256_and_si256(rows->x, _mm256_set1_epi32(4095)),
                         _mm256_sub_epi32(y_q15, _mm256_slli_epi32(up, 19)));
}

/* Computes the windows of a segment and advances to the next one. */
INLINE void compute_windows(const span_source* s, tile* rows, __m256i up,
                            layout l, window_starts* w) {
  __m256i offsets[2], starts[2];
  for (uint32_t k = 0; k < num_windows(l); ++k) {
    offsets[k] =
        compute_offsets(s, rows->x, _mm256_add_epi32(rows->y, up), l.channels);
    starts[k] = compute_window_starts(rows, up);
    advance(rows, (int32_t)window_pixels(l));
  }
  if (l.is_halved) {
    interleave(offsets[0], offsets[1], w->offsets);
    interleave(starts[0], starts[1], w->starts);
  } else {
    _mm256_storeu_si256((__m256i*)(void*)w->offsets, offsets[0]);
    _mm256_storeu_si256((__m256i*)(void*)w->starts, starts[0]);
  }
}

/* Distributes half c of the 32-bit values of two rows, or of their windows, to
 * lanes. */
INLINE __m256i to_lanes(const uint32_t* values, int c, int is_halved) {
  const int16_t half = (int16_t)(0x0100 + 0x0202 * c);
  __m256i pair;
  if (is_halved) {
    pair = _mm256_broadcastsi128_si256(
        _mm_loadu_si128((const __m128i*)(const void*)values));
    const __m128i in_row =
        _mm_setr_epi16(0, 0, 0, 0, 0x404, 0x404, 0x404, 0x404);
    const __m256i lanes = _mm256_inserti128_si256(
        _mm256_castsi128_si256(in_row),
        _mm_add_epi16(in_row, _mm_set1_epi16(0x808)), 1);
    return _mm256_shuffle_epi8(
        pair, _mm256_add_epi16(lanes, _mm256_set1_epi16(half)));
  }
  pair = _mm256_set1_epi64x(
      _mm_cvtsi128_si64(_mm_loadl_epi64((const __m128i*)(const void*)values)));
  return _mm256_shuffle_epi8(
      pair,
      _mm256_inserti128_si256(_mm256_set1_epi16(half),
                              _mm_set1_epi16((int16_t)(half + 0x404)), 1));
}

/* Loads 8 bytes each into the halves of a register. */
INLINE __m128i load_two(const uint8_t* a, const uint8_t* b) {
  double low, high; /* loadable from any address */
  __builtin_memcpy(&low, a, 8);
  __builtin_memcpy(&high, b, 8);
  return _mm_castpd_si128(_mm_set_pd(high, low));
}

INLINE __m256i load_four(const uint8_t* a, const uint8_t* b, const uint8_t* c,
                         const uint8_t* d) {
  return _mm256_inserti128_si256(_mm256_castsi128_si256(load_two(a, b)),
                                 load_two(c, d), 1);
}

/* 16 bytes of both rows, or 8 bytes of each of their windows. */
INLINE __m256i load(const uint8_t* const* windows, size_t offset, layout l) {
  if (!l.is_halved)
    return _mm256_inserti128_si256(
        _mm256_castsi128_si256(_mm_loadu_si128(
            (const __m128i*)(const void*)(windows[0] + offset))),
        _mm_loadu_si128((const __m128i*)(const void*)(windows[1] + offset)), 1);
  return load_four(windows[0] + offset, windows[1] + offset,
                   windows[2] + offset, windows[3] + offset);
}

/* A segment of both rows; x in q12 and y in q15 relative to the windows'
 * starts. */
INLINE __m256i blend_windows(const uint8_t* const* windows, size_t stride,
                             __m256i x_q12, __m256i y_q15, layout l) {
  /* byte indices of left and right sample */
  const __m256i index = _mm256_add_epi16(
      _mm256_mullo_epi16(
          _mm256_srli_epi16(x_q12, 12),
          as_is(_mm256_set1_epi16((int16_t)(0x0101 * l.channels)))),
      lane_offsets(l));
  const __m256i weights = compute_weights(x_q12);
  /* negated horizontal interpolations of the three rows */
  const __m256i h0 = _mm256_maddubs_epi16(
      _mm256_shuffle_epi8(load(windows, 0, l), index), weights);
  const __m256i h1 = _mm256_maddubs_epi16(
      _mm256_shuffle_epi8(load(windows, stride, l), index), weights);
  const __m256i h2 = _mm256_maddubs_epi16(
      _mm256_shuffle_epi8(load(windows, 2 * stride, l), index), weights);
  /* The sign bit of y selects the second of the window's rows. */
  const __m256i is_second = _mm256_srai_epi16(y_q15, 15);
  return blend_down(choose(h0, h1, is_second), choose(h1, h2, is_second),
                    _mm256_and_si256(y_q15, _mm256_set1_epi16(INT16_MAX)));
}

/* The distances of each lane from its window's first x and y, for pairs of
 * rows. */
typedef struct lane_steps {
  __m256i x[TILE_ROWS / 2], y[TILE_ROWS / 2];
} lane_steps;

INLINE void compute_lanes(const tile* rows, layout l, lane_steps* lanes) {
  uint32_t steps[TILE_ROWS];
  _mm256_storeu_si256(
      (__m256i*)(void*)steps,
      _mm256_or_si256(_mm256_and_si256(rows->step_x, _mm256_set1_epi32(65535)),
                      _mm256_slli_epi32(rows->step_y, 19)));
  for (uint32_t p = 0; p < TILE_ROWS / 2; ++p) {
    lanes->x[p] =
        _mm256_mullo_epi16(to_lanes(steps + 2 * p, 0, 0), lane_pixels(l));
    lanes->y[p] =
        _mm256_mullo_epi16(to_lanes(steps + 2 * p, 1, 0), lane_pixels(l));
  }
}

/* Processes the segments of up to 8 rows, starting at out. */
INLINE void blend_tile(const span_source* s, tile rows, uint32_t num_rows,
                       uint8_t* out, layout l) {
  const uint32_t n = s->num_pixels, per_row = num_windows(l);
  lane_steps lanes;
  compute_lanes(&rows, l, &lanes);
  const __m256i last_y = _mm256_mullo_epi32(
      rows.step_y, _mm256_set1_epi32((int32_t)window_pixels(l) - 1));
  const __m256i up = _mm256_min_epi32(last_y, _mm256_setzero_si256());
  for (uint32_t k = 0; k < n; k += l.pixels) {
    if (k + l.pixels > n) { /* the last segment overlaps the previous one */
      advance(&rows, (int32_t)(n - l.pixels) - (int32_t)k);
      k = n - l.pixels;
    }
    window_starts w;
    compute_windows(s, &rows, up, l, &w);
    uint8_t* target = out + k * l.channels;
    const int looks = is_line_begun(target, 8);
    const outlook look = compute_outlook(
        s, w.offsets[0], w.offsets[(TILE_ROWS - 1) * per_row], l.channels);
    for (uint32_t r = 0; r < num_rows; r += 2) {
      const uint32_t *offset = w.offsets + r * per_row,
                     *start = w.starts + r * per_row;
      const uint8_t* const at[4] = {
          s->data + offset[0], s->data + offset[1],
          l.is_halved ? s->data + offset[2] : s->data,
          l.is_halved ? s->data + offset[3] : s->data};
      if (looks) {
        prefetch_rows(s, &look, at[0], target);
        prefetch_rows(s, &look, at[per_row], target + s->out_stride);
      }
      const __m256i x =
          _mm256_add_epi16(to_lanes(start, 0, l.is_halved), lanes.x[r / 2]);
      const __m256i y =
          _mm256_add_epi16(to_lanes(start, 1, l.is_halved), lanes.y[r / 2]);
      const __m256i v = blend_windows(at, s->stride, x, y, l);
      const __m256i bytes = _mm256_packus_epi16(v, v);
      _mm_storel_epi64((__m128i*)(void*)target, _mm256_castsi256_si128(bytes));
      if (r + 1 < num_rows)
        _mm_storel_epi64((__m128i*)(void*)(target + s->out_stride),
                         _mm256_extracti128_si256(bytes, 1));
      target += 2 * s->out_stride;
    }
  }
}

/* Whether windows of `pixels` pixels, twice as many including neighbours,
 * contain the samples of these pixels in two rows: (x & 4095) + (pixels - 1)
 * step < 4096 (2 pixels - 1), and likewise y. */
INLINE int fits(const tile* rows, uint32_t pixels) {
  const __m256i max_x = _mm256_set1_epi32(8192);
  const __m256i max_y = _mm256_set1_epi32(4096 / ((int32_t)pixels - 1));
  const __m256i abs_y = _mm256_abs_epi32(rows->step_y);
  const __m256i is_small = _mm256_and_si256(
      _mm256_cmpeq_epi32(_mm256_min_epu32(rows->step_x, max_x), rows->step_x),
      _mm256_cmpeq_epi32(_mm256_min_epu32(abs_y, max_y), abs_y));
  return _mm256_movemask_epi8(is_small) == -1;
}

/* ---- Separate loads for each pixel --------------------------------------- */

/* 8 bytes of each of the pixels 0, 1, 4, 5, or 2, 3, 6, 7 if k is 2. */
INLINE __m256i load_pixels(const uint8_t* data, const uint32_t* offsets,
                           int k) {
  offsets += k;
  return load_four(data + offsets[0], data + offsets[1], data + offsets[4],
                   data + offsets[5]);
}

/* Interleaves left and right samples. */
INLINE __m256i to_pairs(__m256i samples, uint32_t channels) {
  if (channels == 1) return samples;
  const __m128i pairs =
      channels == 2
          ? _mm_setr_epi8(0, 2, 1, 3, 4, 6, 5, 7, 8, 10, 9, 11, 12, 14, 13, 15)
      : channels == 3
          ? _mm_setr_epi8(0, 3, 1, 4, 2, 5, 6, 7, 8, 11, 9, 12, 10, 13, 14, 15)
          : _mm_setr_epi8(0, 4, 1, 5, 2, 6, 3, 7, 8, 12, 9, 13, 10, 14, 11, 15);
  return _mm256_shuffle_epi8(samples, _mm256_broadcastsi128_si256(pairs));
}

/* Distributes the low halves of pixels to all of their lanes, starting at pixel
 * k of each half. */
INLINE __m256i spread(__m256i values, uint32_t channels, int k) {
  const __m128i lanes = channels <= 2
                            ? _mm_setr_epi16(0x100, 0x100, 0x504, 0x504, 0x908,
                                             0x908, 0xd0c, 0xd0c)
                            : _mm_setr_epi16(0x100, 0x100, 0x100, 0x100, 0x504,
                                             0x504, 0x504, 0x504);
  return _mm256_shuffle_epi8(values,
                             _mm256_add_epi8(_mm256_broadcastsi128_si256(lanes),
                                             _mm256_set1_epi8((char)(4 * k))));
}

/* -h of pixels k and k + 1 of both halves, or of all pixels. */
INLINE __m256i blend_across(const uint8_t* row, const uint32_t* offsets,
                            __m256i weights, uint32_t channels, int k) {
  const __m256i samples =
      channels <= 2
          ? _mm256_i32gather_epi32(
                (const int*)(const void*)row,
                _mm256_loadu_si256((const __m256i*)(const void*)offsets), 1)
          : load_pixels(row, offsets, k);
  return _mm256_maddubs_epi16(to_pairs(samples, channels),
                              spread(weights, channels, k));
}

/* Returns the results in the low bytes of lanes. */
INLINE __m256i blend_pixels(const span_source* s, const uint32_t* offsets,
                            __m256i weights, __m256i wy_q15, uint32_t channels,
                            int k) {
  const __m256i upper = blend_across(s->data, offsets, weights, channels, k);
  const __m256i lower =
      blend_across(s->data + s->stride, offsets, weights, channels, k);
  return blend_down(upper, lower, spread(wy_q15, channels, k));
}

/* Stores 8 pixels. */
INLINE void store_pixels(__m256i v, uint8_t* out, uint32_t channels) {
  __m128i low = _mm256_castsi256_si128(v);
  __m128i high = _mm256_extracti128_si256(v, 1);
  if (channels == 4) {
    _mm256_storeu_si256((__m256i*)(void*)out, v);
  } else if (channels == 3) {
    const __m128i packed =
        _mm_setr_epi8(0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, 14, 14, 14, 14);
    low = _mm_shuffle_epi8(low, packed);
    high = _mm_shuffle_epi8(high, packed);
    _mm_storeu_si128((__m128i*)(void*)out, low);
    const int32_t rest = _mm_extract_epi32(high, 2);
    _mm_storel_epi64((__m128i*)(void*)(out + 12), high);
    __builtin_memcpy(out + 20, &rest, 4);
  } else if (channels == 2) {
    _mm_storeu_si128((__m128i*)(void*)out, _mm_unpacklo_epi64(low, high));
  } else {
    const __m128i even = _mm_unpacklo_epi64(low, high);
    _mm_storel_epi64(
        (__m128i*)(void*)out,
        _mm_packus_epi16(_mm_and_si128(even, _mm_set1_epi16(255)), even));
  }
}

/* Processes a row that starts at (x, y), where x includes the offset 16. */
INLINE void blend_row(const span_source* s, const outlook* look, int32_t x,
                      int32_t y, int32_t step_x, int32_t step_y, uint8_t* out,
                      uint32_t channels) {
  const int32_t n = (int32_t)s->num_pixels;
  const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
  const __m256i lanes_x = _mm256_mullo_epi32(_mm256_set1_epi32(step_x), lane);
  const __m256i lanes_y = _mm256_mullo_epi32(_mm256_set1_epi32(step_y), lane);
  for (int32_t k = 0; k < n; k += 8) {
    if (k + 8 > n) k = n - 8; /* the last pixels overlap the previous ones */
    const __m256i xs =
        _mm256_add_epi32(_mm256_set1_epi32(x + k * step_x), lanes_x);
    const __m256i ys =
        _mm256_add_epi32(_mm256_set1_epi32(y + k * step_y), lanes_y);
    uint32_t offsets[8];
    _mm256_storeu_si256((__m256i*)(void*)offsets,
                        compute_offsets(s, xs, ys, channels));
    __asm__("" : "+m"(offsets)); /* keeps the loads from memory */
    uint8_t* const target = out + (uint32_t)k * channels;
    if (is_line_begun(target, 8 * channels))
      prefetch_rows(s, look, s->data + offsets[0], target);
    const __m256i wy_q15 = _mm256_srli_epi32(_mm256_slli_epi32(ys, 20), 17);
    const __m256i wx = compute_weights(xs);
    const __m256i v = blend_pixels(s, offsets, wx, wy_q15, channels, 0);
    const __m256i w =
        channels <= 2 ? v : blend_pixels(s, offsets, wx, wy_q15, channels, 2);
    store_pixels(_mm256_packus_epi16(v, w), target, channels);
  }
}

INLINE void blend_rows(const span_source* s, const tile* rows,
                       uint32_t num_rows, uint8_t* out, uint32_t channels) {
  uint32_t offsets[TILE_ROWS];
  _mm256_storeu_si256((__m256i*)(void*)offsets,
                      compute_offsets(s, rows->x, rows->y, channels));
  const outlook look =
      compute_outlook(s, offsets[0], offsets[TILE_ROWS - 1], channels);
  int32_t values[4][TILE_ROWS];
  _mm256_storeu_si256((__m256i*)(void*)values[0], rows->x);
  _mm256_storeu_si256((__m256i*)(void*)values[1], rows->y);
  _mm256_storeu_si256((__m256i*)(void*)values[2], rows->step_x);
  _mm256_storeu_si256((__m256i*)(void*)values[3], rows->step_y);
  for (uint32_t r = 0; r < num_rows; ++r, out += s->out_stride)
    blend_row(s, &look, values[0][r], values[1][r], values[2][r], values[3][r],
              out, channels);
}

/* ---- Spans --------------------------------------------------------------- */

/* Processes num_rows rows, starting at row t. */
static void blend_portably(const rg_span* span, uint32_t t, uint32_t num_rows,
                           rg_blend* portable) {
  rg_span part = *span;
  part.first_row = (uint8_t)(span->first_row + t);
  part.num_rows = (uint8_t)num_rows;
  part.out += (size_t)t * span->out_stride;
  portable(&part);
}

INLINE void blend(const rg_span* span, uint32_t channels, rg_blend* portable) {
  const layout whole = {channels, 8 / channels, 0};
  const layout halved = {channels, 8 / channels, 1};
  const uint32_t least = channels == 2 ? 4 : 8;
  if (span->num_pixels < least || span->stride > 1 << 18) {
    portable(span);
    return;
  }
  const span_source s = compute_source(span);
  uint8_t* out = span->out + span->out_pixel * channels;
  const uint32_t num_rows = span->num_rows;
  const __m256i last_row =
      _mm256_set1_epi32(span->first_row + span->num_rows - 1);
  __m256i r = _mm256_add_epi32(_mm256_set1_epi32(span->first_row),
                               _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
  for (uint32_t t = 0; t < num_rows; t += TILE_ROWS) {
    /* The last row is repeated to fill the tile. */
    const tile rows = compute_tile(&s, _mm256_min_epi32(r, last_row));
    const uint32_t in_tile =
        num_rows - t < TILE_ROWS ? num_rows - t : TILE_ROWS;
    if (channels <= 2 && fits(&rows, window_pixels(whole)))
      blend_tile(&s, rows, in_tile, out, whole);
    else if (channels <= 2 && fits(&rows, window_pixels(halved)))
      blend_tile(&s, rows, in_tile, out, halved);
    else if (span->num_pixels >= 8)
      blend_rows(&s, &rows, in_tile, out, channels);
    else
      blend_portably(span, t, in_tile, portable);
    out += TILE_ROWS * s.out_stride;
    r = _mm256_add_epi32(r, _mm256_set1_epi32(TILE_ROWS));
  }
}

void rg_blend_1_avx2(const rg_span* span) { blend(span, 1, rg_blend_1); }
void rg_blend_2_avx2(const rg_span* span) { blend(span, 2, rg_blend_2); }
void rg_blend_3_avx2(const rg_span* span) { blend(span, 3, rg_blend_3); }
void rg_blend_4_avx2(const rg_span* span) { blend(span, 4, rg_blend_4); }

/* ---- Words of RGB565 ----------------------------------------------------- */

/* One field of 8 pixels, 32 bits each. Samples of the upper and of the lower
 * row have the left one in the low half and the right one in the high half. The
 * weights across are arranged alike; those down are for the upper row in the
 * low half and the lower row in the high half. */
INLINE __m256i blend_field(__m256i upper, __m256i lower, __m256i across,
                           __m256i down) {
  const __m256i upper_q8 = _mm256_madd_epi16(upper, across);
  const __m256i lower_q8 = _mm256_madd_epi16(lower, across);
  /* The horizontal interpolation of a row is at most 63 * 256. */
  const __m256i rows =
      _mm256_or_si256(upper_q8, _mm256_slli_epi32(lower_q8, 16));
  const __m256i sums_q16 = _mm256_add_epi32(_mm256_madd_epi16(rows, down),
                                            _mm256_set1_epi32(0x8000));
  return _mm256_srli_epi32(sums_q16, 16);
}

/* 256 - w in the low halves, w in the high halves: the upper 8 fraction bits of
 * positions. */
INLINE __m256i expand_weights(__m256i q12) {
  const __m256i w =
      _mm256_and_si256(_mm256_srli_epi32(q12, 4), _mm256_set1_epi32(255));
  return _mm256_add_epi32(_mm256_mullo_epi32(w, _mm256_set1_epi32(65535)),
                          _mm256_set1_epi32(256));
}

/* Loads the two adjacent words at each offset. */
INLINE __m256i gather_words(const uint8_t* row, __m256i offsets) {
  return _mm256_i32gather_epi32((const int*)(const void*)row, offsets, 1);
}

/* Processes 8 pixels; y is relative to the uppermost row. */
INLINE void blend_words(const uint8_t* top, uint32_t stride, __m256i x_q12,
                        __m256i y_q12, uint8_t* out) {
  const __m256i offsets =
      _mm256_add_epi32(_mm256_mullo_epi32(_mm256_srli_epi32(y_q12, 12),
                                          _mm256_set1_epi32((int32_t)stride)),
                       _mm256_slli_epi32(_mm256_srli_epi32(x_q12, 12), 1));
  const __m256i upper = gather_words(top, offsets);
  const __m256i lower = gather_words(top + stride, offsets);
  const __m256i across = expand_weights(x_q12), down = expand_weights(y_q12);
  const __m256i green = _mm256_set1_epi16(63), blue = _mm256_set1_epi16(31);
  const __m256i r = blend_field(_mm256_srli_epi16(upper, 11),
                                _mm256_srli_epi16(lower, 11), across, down);
  const __m256i g = blend_field(
      _mm256_and_si256(_mm256_srli_epi16(upper, 5), green),
      _mm256_and_si256(_mm256_srli_epi16(lower, 5), green), across, down);
  const __m256i b = blend_field(_mm256_and_si256(upper, blue),
                                _mm256_and_si256(lower, blue), across, down);
  const __m256i words = _mm256_or_si256(
      b, _mm256_or_si256(_mm256_slli_epi32(g, 5), _mm256_slli_epi32(r, 11)));
  const __m256i halves =
      _mm256_permute4x64_epi64(_mm256_packus_epi32(words, words), 8);
  _mm_storeu_si128((__m128i*)(void*)out, _mm256_castsi256_si128(halves));
}

/* At most 16 pixels per pixel: the offsets of 8 pixels then fit into 32 bits.
 */
#define MAX_WORD_STEP_Q12 65536

/* The positions of the row already include the rounding term. */
INLINE void blend_row_of_words(const rg_span* span, const rg_block_row* row,
                               uint8_t* out) {
  const int32_t n = span->num_pixels;
  const int32_t step_x = row->step.q12[0], step_y = row->step.q12[1];
  const __m256i lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
  const __m256i lanes_x = _mm256_mullo_epi32(_mm256_set1_epi32(step_x), lanes);
  const __m256i lanes_y = _mm256_mullo_epi32(_mm256_set1_epi32(step_y), lanes);
  const int32_t up = step_y < 0 ? 7 * step_y : 0;
  for (int32_t k = 0; k < n; k += 8) {
    if (k + 8 > n) k = n - 8; /* the last segment overlaps the previous one */
    const int32_t x = row->start.q12[0] + k * step_x;
    const int32_t y = row->start.q12[1] + k * step_y;
    const int32_t top = (y + up) >> 12;
    blend_words(span->data + (size_t)(uint32_t)top * span->stride, span->stride,
                _mm256_add_epi32(_mm256_set1_epi32(x), lanes_x),
                _mm256_add_epi32(_mm256_set1_epi32(y - top * 4096), lanes_y),
                out + 2 * (size_t)(uint32_t)k);
  }
}

static int may_gather_words(const rg_span* span) {
  for (uint32_t k = 0; k < 2; ++k)
    for (int c = 0; c < 2; ++c) {
      const int32_t step = rg_edge_step(span, k, c);
      if (step < 2 - MAX_WORD_STEP_Q12 || step > MAX_WORD_STEP_Q12 - 2)
        return 0;
    }
  return span->num_pixels >= 8 && span->stride <= 1 << 18;
}

int rg_blend_words_avx2(const rg_span* span) {
  if (!may_gather_words(span)) return 0;
  uint8_t* out = span->out + 2 * (size_t)span->out_pixel;
  for (uint32_t r = 0; r < span->num_rows; ++r, out += span->out_stride) {
    rg_block_row row;
    rg_compute_span_row(span, r, &row);
    row.start.q12[0] += 8;
    row.start.q12[1] += 8;
    blend_row_of_words(span, &row, out);
  }
  return 1;
}

RG_END_FEATURES

#endif
