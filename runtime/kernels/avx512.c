/* Bilinear interpolation by lookups in tables of 128 bytes: 32 samples of
 * adjacent rows, in lanes of 16 bits, are in a box of bytes that fits into two
 * registers. If pixels require a larger box, the AVX2 kernels are used. */
#include "kernels/kernel.h"

#if RG_SELECT_KERNELS && defined(__x86_64__)

#include <immintrin.h>
#include <stddef.h>

#include "x86_features.h"

RG_BEGIN_FEATURES("avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi,avx512vbmi2")

#define INLINE static inline __attribute__((always_inline))

/* The size of a tile, whose positions are computed together. */
#define TILE_PIXELS 8u
#define TILE_ROWS 8u

/* The maximum stride in bytes for which offsets fit. */
#define MAX_STRIDE (1u << 18)

/* The prefetch distance to the right, in bytes of a row. */
#define AHEAD 128

/* ---- Layouts ------------------------------------------------------------- */

/* Positions are computed for a set: 4 rows of a tile, with one pixel per lane.
 * Samples are interpolated for a group, with one channel per lane: a whole set
 * with one channel, half of its columns with two channels, and half of these
 * rows with three or four channels, which use four lanes per pixel. The box of
 * a group has 8 rows of 16 bytes, or 4 rows of 32. */
typedef struct layout {
  uint32_t channels;
  int is_tile; /* a span is a whole tile of 8 x 8 pixels */
} layout;

INLINE uint32_t num_halves(layout l) { return l.channels == 1 ? 1 : 2; }
INLINE uint32_t group_rows(layout l) { return l.channels <= 2 ? 4 : 2; }

typedef uint8_t bytes_64 __attribute__((vector_size(64)));
typedef uint16_t words_32 __attribute__((vector_size(64)));
typedef uint32_t dwords_16 __attribute__((vector_size(64)));

/* Expressions of these are folded to constants. */
INLINE words_32 lane_numbers(void) {
  const words_32 n = {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10,
                      11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21,
                      22, 23, 24, 25, 26, 27, 28, 29, 30, 31};
  return n;
}

INLINE dwords_16 dword_numbers(void) {
  const dwords_16 n = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  return n;
}

INLINE bytes_64 byte_numbers(void) {
  const bytes_64 n = {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12,
                      13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25,
                      26, 27, 28, 29, 30, 31, 32, 33, 34, 35, 36, 37, 38,
                      39, 40, 41, 42, 43, 44, 45, 46, 47, 48, 49, 50, 51,
                      52, 53, 54, 55, 56, 57, 58, 59, 60, 61, 62, 63};
  return n;
}

/* The indices of a set's words in a tile; in another tile for the second half.
 */
INLINE __m512i x_words(uint32_t set_index, layout l) {
  const words_32 n = lane_numbers();
  const words_32 other = num_halves(l) == 2 ? (n & 4) * 8 : n & 0;
  return (__m512i)((n >> 3) * 2 + other + (uint16_t)(8 * set_index));
}

INLINE __m512i y_words(uint32_t set_index, layout l) {
  return (__m512i)((words_32)x_words(set_index, l) + 16);
}

/* The indices of a group's words in its set. */
INLINE words_32 pixel_words(uint32_t pair, uint32_t half, layout l) {
  const words_32 n = lane_numbers();
  const uint16_t first = (uint16_t)(16 * pair + 4 * half);
  if (l.channels == 1) return n;
  if (l.channels == 2) return (n >> 3) * 8 + (n >> 1 & 3) + first;
  return (n >> 4) * 8 + (n >> 2 & 3) + first;
}

/* Byte offsets from a pixel to the left and right sample of each lane. */
INLINE __m512i lane_samples(layout l) {
  const words_32 n = lane_numbers();
  const uint16_t last = l.channels == 1 ? 0 : l.channels == 2 ? 1 : 3;
  return (__m512i)((n & last) * 0x0101 + (uint16_t)(0x0100 * l.channels));
}

/* Values that fill a register. They are in memory, since compilers would
 * recompute them in each iteration. */
typedef struct fills {
  uint32_t seven_bits, fifteen_bits, left_weight, right_weight, last_factor;
  uint32_t both_bytes;
} fills;
static const fills kFills = {0x007f007f, 0x7fff7fff, 0xff01ff01,
                             0x00800080, 0xff00ff00, 0x01010101};

INLINE __m512i fill(uint32_t value) {
  return _mm512_set1_epi32((int32_t)value);
}

/* ---- Positions ----------------------------------------------------------- */

/* The starts and steps of 8 rows, in 32 bits: x + 16 in the low half of the
 * register and y in the high half. */
typedef struct tile {
  __m512i start, step;
} tile;

#define Y_LANES 0xff00

INLINE __m512i load_position(const rg_position* p) {
  return _mm512_mask_set1_epi32(_mm512_set1_epi32(p->q12[0]), Y_LANES,
                                p->q12[1]);
}

/* (value + 2^(log2 - 1)) >> log2; log2 is 3 in tiles. */
INLINE __m512i round_shift(__m512i value, uint32_t log2, layout l) {
  if (l.is_tile)
    return _mm512_srai_epi32(_mm512_add_epi32(value, _mm512_set1_epi32(4)), 3);
  return _mm512_srav_epi32(
      _mm512_add_epi32(value, _mm512_set1_epi32(1 << log2 >> 1)),
      _mm512_set1_epi32((int32_t)log2));
}

/* Loads two adjacent positions: x, y, x, y. */
INLINE __m128i load_positions(const rg_position* p) {
  return _mm_loadu_si128((const __m128i*)(const void*)p);
}

/* Broadcasts position k of two. */
INLINE __m512i spread(__m128i two, int32_t k) {
  const dwords_16 lanes = (dword_numbers() >> 3) + 2 * (uint32_t)k;
  return _mm512_permutexvar_epi32((__m512i)lanes, _mm512_castsi128_si512(two));
}

/* The points at which rows r of the block intersect its left (0) or right (1)
 * edge. */
INLINE __m512i compute_edge(const rg_span* span, __m128i upper, __m128i lower,
                            int32_t k, __m512i r, layout l) {
  const __m512i down =
      _mm512_mullo_epi32(spread(_mm_sub_epi32(lower, upper), k), r);
  return _mm512_add_epi32(spread(upper, k),
                          round_shift(down, span->block.height_log2, l));
}

/* The rows of the span, starting at t; the last row is repeated to fill the
 * tile. */
INLINE tile compute_tile(const rg_span* span, uint32_t t, layout l) {
  __m512i r = (__m512i)(dword_numbers() & 7);
  if (!l.is_tile) {
    r = _mm512_add_epi32(r, _mm512_set1_epi32((int32_t)t));
    r = _mm512_min_epi32(r, _mm512_set1_epi32(span->num_rows - 1));
    r = _mm512_add_epi32(r, _mm512_set1_epi32(span->first_row));
  }
  const __m128i upper = load_positions(span->block.corners);
  const __m128i lower = load_positions(span->block.corners + 2);
  const __m512i left = compute_edge(span, upper, lower, 0, r, l);
  const __m512i right = compute_edge(span, upper, lower, 1, r, l);
  const rg_position origin = {{16, -4096 * span->first_source_row}};
  tile rows;
  rows.step =
      round_shift(_mm512_sub_epi32(right, left), span->block.width_log2, l);
  rows.start = _mm512_add_epi32(left, load_position(&origin));
  if (!l.is_tile)
    rows.start = _mm512_add_epi32(
        rows.start,
        _mm512_mullo_epi32(rows.step, _mm512_set1_epi32(span->first_pixel)));
  return rows;
}

/* ---- Boxes --------------------------------------------------------------- */

/* Byte distances between pixels and between rows. */
typedef struct source_steps {
  __m512i pixel; /* for x and for y, arranged as in a tile */
  __m256i row;
  __m256i upper_rows, lower_rows; /* relative to a box's first row */
} source_steps;

INLINE source_steps compute_source_steps(const rg_span* span, layout l) {
  const rg_position pixel = {{(int32_t)l.channels, (int32_t)span->stride}};
  const __m512i rows = (__m512i)(dword_numbers() & (group_rows(l) - 1));
  source_steps s;
  s.pixel = load_position(&pixel);
  s.row = _mm256_set1_epi32((int32_t)span->stride);
  s.upper_rows = _mm256_mullo_epi32(s.row, _mm512_castsi512_si256(rows));
  s.lower_rows = _mm256_add_epi32(
      s.upper_rows, _mm256_slli_epi32(s.row, group_rows(l) == 4 ? 2 : 1));
  return s;
}

/* The row offsets of the boxes of a tile's groups, or of the groups in one
 * half: of the upper halves and of the lower halves of the boxes. */
typedef struct boxes {
  int32_t upper[8], lower[8];
} boxes;

/* The minimum or maximum over the rows of each group, in all of its lanes. */
INLINE __m512i compute_min(__m512i a, __m512i b, layout l) {
  __m512i least = _mm512_min_epi32(a, b);
  least = _mm512_min_epi32(least, _mm512_shuffle_epi32(least, 0xb1));
  if (group_rows(l) == 4)
    least = _mm512_min_epi32(least, _mm512_shuffle_epi32(least, 0x4e));
  return least;
}

INLINE __m512i compute_max(__m512i a, __m512i b, layout l) {
  __m512i greatest = _mm512_max_epi32(a, b);
  greatest = _mm512_max_epi32(greatest, _mm512_shuffle_epi32(greatest, 0xb1));
  if (group_rows(l) == 4)
    greatest = _mm512_max_epi32(greatest, _mm512_shuffle_epi32(greatest, 0x4e));
  return greatest;
}

INLINE __m256i low_half(__m512i v) { return _mm512_castsi512_si256(v); }
INLINE __m256i high_half(__m512i v) { return _mm512_extracti64x4_epi64(v, 1); }

/* The boxes for rows from start to end. Rows below the last required one are
 * replaced by it. first: start relative to the box. Returns whether boxes are
 * large enough. */
INLINE int compute_boxes(const source_steps* s, __m512i start, __m512i end,
                         layout l, __m512i* first, boxes* b) {
  const uint32_t columns = 64 / group_rows(l) / l.channels;
  const dwords_16 too_large =
      4096 * (columns - 1) +
      (dword_numbers() >> 3) * (4096 * (2 * group_rows(l) - columns));
  const __m512i pixel = _mm512_srli_epi32(compute_min(start, end, l), 12);
  const __m512i origin = _mm512_slli_epi32(pixel, 12);
  const __m512i size = _mm512_sub_epi32(compute_max(start, end, l), origin);
  if (_mm512_cmpge_epu32_mask(size, (__m512i)too_large) != 0) return 0;
  *first = _mm512_sub_epi32(start, origin);
  const __m512i offset = _mm512_mullo_epi32(pixel, s->pixel);
  const __m256i corner = _mm256_add_epi32(low_half(offset), high_half(offset));
  const __m256i lowest = _mm256_add_epi32(
      _mm256_mullo_epi32(_mm256_srli_epi32(high_half(size), 12), s->row),
      s->row);
  /* Two stores: the loads could not be forwarded from a single 64-byte store.
   */
  _mm256_storeu_si256(
      (__m256i*)(void*)b->upper,
      _mm256_add_epi32(corner, _mm256_min_epu32(s->upper_rows, lowest)));
  _mm256_storeu_si256(
      (__m256i*)(void*)b->lower,
      _mm256_add_epi32(corner, _mm256_min_epu32(s->lower_rows, lowest)));
  __asm__("" : "+m"(*b)); /* keeps the loads from memory */
  return 1;
}

INLINE __m128i load_16(const uint8_t* bytes) {
  return _mm_loadu_si128((const __m128i*)(const void*)bytes);
}

INLINE __m256i load_32(const uint8_t* bytes) {
  return _mm256_loadu_si256((const __m256i*)(const void*)bytes);
}

/* Loads half a box: rows of 16 bytes, or of 32. */
INLINE __m512i load_rows(const uint8_t* data, const int32_t* offsets,
                         layout l) {
  if (group_rows(l) == 2)
    return _mm512_inserti64x4(
        _mm512_castsi256_si512(load_32(data + offsets[0])),
        load_32(data + offsets[1]), 1);
  const __m256i first = _mm256_inserti128_si256(
      _mm256_castsi128_si256(load_16(data + offsets[0])),
      load_16(data + offsets[1]), 1);
  const __m256i second = _mm256_inserti128_si256(
      _mm256_castsi128_si256(load_16(data + offsets[2])),
      load_16(data + offsets[3]), 1);
  return _mm512_inserti64x4(_mm512_castsi256_si512(first), second, 1);
}

/* ---- Sets ---------------------------------------------------------------- */

/* The distances of a set's lanes from the first pixels of their halves. */
typedef struct lane_steps {
  __m512i x, y;
} lane_steps;

INLINE lane_steps compute_lane_steps(__m512i step, __m512i pixels,
                                     uint32_t set_index, layout l) {
  const lane_steps steps = {
      _mm512_mullo_epi16(_mm512_permutexvar_epi16(x_words(set_index, l), step),
                         pixels),
      _mm512_mullo_epi16(_mm512_permutexvar_epi16(y_words(set_index, l), step),
                         pixels)};
  return steps;
}

/* For each pixel of a set: the byte offset from the start of its box, the
 * weights of the left and right sample, and the weight of the lower row. */
typedef struct sample_taps {
  __m512i offset, weights, wy_q15;
} sample_taps;

INLINE __m512i compute_lanes(const __m512i* firsts, __m512i words, layout l) {
  return num_halves(l) == 1
             ? _mm512_permutexvar_epi16(words, firsts[0])
             : _mm512_permutex2var_epi16(firsts[0], words, firsts[1]);
}

/* firsts: the first pixels of the halves, relative to their boxes. */
INLINE sample_taps compute_taps(const __m512i* firsts, uint32_t set_index,
                                const lane_steps* steps, layout l,
                                const fills* f) {
  const __m512i x_q12 = _mm512_add_epi16(
      compute_lanes(firsts, x_words(set_index, l), l), steps->x);
  const __m512i y_q12 = _mm512_add_epi16(
      compute_lanes(firsts, y_words(set_index, l), l), steps->y);
  sample_taps s;
  /* 16 * row + column */
  s.offset = _mm512_shldi_epi16(_mm512_srli_epi16(y_q12, 12), x_q12, 4);
  if (l.channels == 2)
    s.offset = _mm512_add_epi16(s.offset, _mm512_srli_epi16(x_q12, 12));
  else if (l.channels >= 3)
    s.offset = _mm512_permutexvar_epi8(
        s.offset, (__m512i)((byte_numbers() >> 4) * 32 +
                            (byte_numbers() & 15) * (uint8_t)l.channels));
  /* bytes wx - 128 and -wx */
  const __m512i wx =
      _mm512_and_si512(_mm512_srli_epi16(x_q12, 5), fill(f->seven_bits));
  s.weights = _mm512_add_epi16(_mm512_mullo_epi16(wx, fill(f->left_weight)),
                               fill(f->right_weight));
  s.wy_q15 =
      _mm512_and_si512(_mm512_slli_epi16(y_q12, 3), fill(f->fifteen_bits));
  return s;
}

/* ---- Groups -------------------------------------------------------------- */

/* Returns the results in the low bytes of lanes. */
INLINE __m512i blend_group(const uint8_t* data, const boxes* b,
                           const sample_taps* s, uint32_t g, uint32_t half,
                           layout l, const fills* f) {
  const words_32 words = pixel_words(group_rows(l) == 4 ? 0 : g & 1, half, l);
  const __m512i upper_half = load_rows(data, b->upper + group_rows(l) * g, l);
  const __m512i lower_half = load_rows(data, b->lower + group_rows(l) * g, l);
  const __m512i offsets =
      l.channels == 1
          ? _mm512_mullo_epi16(s->offset, fill(f->both_bytes))
          : _mm512_permutexvar_epi8((__m512i)(words * 0x0202), s->offset);
  const __m512i index = _mm512_add_epi8(offsets, lane_samples(l));
  const __m512i next =
      _mm512_add_epi8(index, _mm512_set1_epi8((char)(64 / group_rows(l))));
  __m512i weights = s->weights, wy_q15 = s->wy_q15;
  if (l.channels != 1) {
    weights = _mm512_permutexvar_epi16((__m512i)words, weights);
    wy_q15 = _mm512_permutexvar_epi16((__m512i)words, wy_q15);
  }
  /* negated horizontal interpolations of both rows */
  const __m512i upper = _mm512_maddubs_epi16(
      _mm512_permutex2var_epi8(upper_half, index, lower_half), weights);
  const __m512i lower = _mm512_maddubs_epi16(
      _mm512_permutex2var_epi8(upper_half, next, lower_half), weights);
  /* -v = -h0 + ((h0 - h1) wy + 2^14) >> 15 */
  const __m512i v = _mm512_add_epi16(
      upper, _mm512_mulhrs_epi16(_mm512_sub_epi16(lower, upper), wy_q15));
  /* (v + 64) >> 7 */
  return _mm512_mulhrs_epi16(v, fill(f->last_factor));
}

/* ---- Output -------------------------------------------------------------- */

/* The output of a tile's rows: up to 32 bytes each. */
typedef struct tile_output {
  uint8_t* out;
  size_t stride;
  uint32_t num_rows;
  int prefetches_below; /* prefetch direction: below, or to the right */
  int is_whole;         /* all of its rows and pixels are output */
  __mmask32 bytes;      /* mask for one row */
} tile_output;

INLINE void store_row(const tile_output* t, uint32_t r, __m256i bytes,
                      layout l) {
  uint8_t* const out = t->out + r * t->stride;
  if (!t->is_whole) {
    if (r < t->num_rows) _mm256_mask_storeu_epi8(out, t->bytes, bytes);
  } else if (l.channels == 2) {
    _mm_storeu_si128((__m128i*)(void*)out, _mm256_castsi256_si128(bytes));
  } else if (l.channels == 3) {
    _mm256_mask_storeu_epi8(out, 0xffffff, bytes);
  } else {
    _mm256_storeu_si256((__m256i*)(void*)out, bytes);
  }
}

/* Stores 8 bytes each to rows r and r + 4. */
INLINE void store_both(const tile_output* t, uint32_t r, __m128i bytes,
                       layout l) {
  if (t->is_whole) {
    uint8_t* const out = t->out + r * t->stride;
    uint8_t* const below = out + 4 * t->stride;
    _mm_storel_epi64((__m128i*)(void*)out, bytes);
    _mm_storeh_pi((__m64*)(void*)below, _mm_castsi128_ps(bytes));
  } else {
    const __m128i high = _mm_unpackhi_epi64(bytes, bytes);
    store_row(t, r, _mm256_castsi128_si256(bytes), l);
    store_row(t, r + 4, _mm256_castsi128_si256(high), l);
  }
}

/* Stores 16 bytes to each of four rows, starting at r; with one channel, 8
 * bytes to each of eight rows. */
INLINE void store_four(const tile_output* t, uint32_t r, __m512i rows,
                       layout l) {
#define STORE(k)                                               \
  do {                                                         \
    const __m128i bytes = _mm512_extracti32x4_epi32(rows, k);  \
    if (l.channels == 1)                                       \
      store_both(t, k, bytes, l);                              \
    else                                                       \
      store_row(t, r + (k), _mm256_castsi128_si256(bytes), l); \
  } while (0)
  STORE(0);
  STORE(1);
  STORE(2);
  STORE(3);
#undef STORE
}

/* Stores two rows, starting at r, whose halves are v and w. */
INLINE void store_two(const tile_output* t, uint32_t r, __m512i v, __m512i w,
                      layout l) {
  const bytes_64 b = byte_numbers() & 31;
  const bytes_64 row = (byte_numbers() >> 5) * 32;
  /* with three channels, the unused fourth byte is omitted */
  const bytes_64 in_half = b % 12;
  const bytes_64 index =
      row + (l.channels == 3 ? b / 12 * 64 + in_half / 3 * 8 + in_half % 3 * 2
                             : (b >> 4) * 64 + (b & 15) * 2);
  const __m512i bytes = _mm512_permutex2var_epi8(v, (__m512i)index, w);
  store_row(t, r, low_half(bytes), l);
  store_row(t, r + 1, high_half(bytes), l);
}

/* Prefetches the source and the output of the second tile below, once per 64
 * bytes of output, which depend on up to 128 bytes. This distance is sufficient
 * for memory latency, and the direction of rows seldom changes that much. Large
 * blocks with many channels would evict these lines from the L1 cache before
 * their use: then prefetches to the right. */
INLINE void prefetch_rows(const uint8_t* data, const boxes* b,
                          const tile_output* t) {
  const uint8_t* const out =
      t->out + (t->prefetches_below ? 2 * TILE_ROWS * t->stride : AHEAD);
  data += t->prefetches_below ? 4 * (b->upper[4] - b->upper[0]) : AHEAD;
  for (uint32_t r = 0; r < TILE_ROWS; ++r) {
    __builtin_prefetch(data + b->upper[r]);
    __builtin_prefetch(data + b->upper[r] + 64);
    __builtin_prefetch(data + b->lower[r]);
    __builtin_prefetch(data + b->lower[r] + 64);
    __builtin_prefetch(out + r * t->stride, 1);
  }
}

/* ---- Tiles --------------------------------------------------------------- */

/* Values common to the tiles of a few rows. */
typedef struct tile_row {
  lane_steps upper, lower; /* for both sets */
  /* From the first pixel to the last one, to the last one of the first half,
   * and to the first one of the second half. */
  __m512i to_last, to_half, to_next_half;
} tile_row;

INLINE __m512i times(__m512i step, uint32_t pixels) {
  return _mm512_mullo_epi32(step, _mm512_set1_epi32((int32_t)pixels));
}

INLINE tile_row compute_tile_row(__m512i step, uint32_t num_pixels, layout l) {
  const words_32 n = lane_numbers();
  const uint32_t last = num_pixels - 1;
  __m512i pixels = (__m512i)(num_halves(l) == 1 ? n & 7 : n & 3);
  if (!l.is_tile) { /* the last pixel is repeated */
    const __m512i lasts = _mm512_set1_epi16((int16_t)last);
    pixels = _mm512_min_epu16((__m512i)(n & 7), lasts);
    if (num_halves(l) == 2)
      pixels =
          _mm512_sub_epi16(pixels, _mm512_min_epu16((__m512i)(n & 4), lasts));
  }
  const tile_row row = {compute_lane_steps(step, pixels, 0, l),
                        compute_lane_steps(step, pixels, 1, l),
                        times(step, last), times(step, last < 3 ? last : 3),
                        times(step, last < 4 ? last : 4)};
  return row;
}

/* start: positions of the first pixels of the tile's rows. Returns whether the
 * tile was processed. */
INLINE int blend_tile(const uint8_t* data, const source_steps* s, __m512i start,
                      const tile_row* row, const tile_output* to, layout l,
                      const fills* f) {
  const __m512i end = _mm512_add_epi32(start, row->to_last);
  boxes b[2];
  __m512i firsts[2];
  if (num_halves(l) == 1) {
    if (!compute_boxes(s, start, end, l, &firsts[0], &b[0])) return 0;
  } else {
    if (!compute_boxes(s, start, _mm512_add_epi32(start, row->to_half), l,
                       &firsts[0], &b[0]) ||
        !compute_boxes(s, _mm512_add_epi32(start, row->to_next_half), end, l,
                       &firsts[1], &b[1]))
      return 0;
  }
  if (((uintptr_t)to->out & 63) < TILE_PIXELS * l.channels)
    prefetch_rows(data, &b[0], to);
  const sample_taps upper = compute_taps(firsts, 0, &row->upper, l, f);
  const sample_taps lower = compute_taps(firsts, 1, &row->lower, l, f);
#define GROUP(g, half)                                                    \
  blend_group(data, &b[half], (g)*group_rows(l) < 4 ? &upper : &lower, g, \
              half, l, f)
  if (l.channels == 1) {
    store_four(to, 0, _mm512_packus_epi16(GROUP(0, 0), GROUP(1, 0)), l);
  } else if (l.channels == 2) {
    store_four(to, 0, _mm512_packus_epi16(GROUP(0, 0), GROUP(0, 1)), l);
    store_four(to, 4, _mm512_packus_epi16(GROUP(1, 0), GROUP(1, 1)), l);
  } else {
    store_two(to, 0, GROUP(0, 0), GROUP(0, 1), l);
    store_two(to, 2, GROUP(1, 0), GROUP(1, 1), l);
    store_two(to, 4, GROUP(2, 0), GROUP(2, 1), l);
    store_two(to, 6, GROUP(3, 0), GROUP(3, 1), l);
  }
#undef GROUP
  return 1;
}

/* Returns the number of pixels processed in each row. */
INLINE uint32_t blend_tiles(const uint8_t* data, const source_steps* s,
                            tile rows, tile_output to, uint32_t n, layout l,
                            const fills* f) {
  const uint32_t num_pixels = n < TILE_PIXELS ? n : TILE_PIXELS;
  const tile_row row = compute_tile_row(rows.step, num_pixels, l);
  const __m512i to_next = times(rows.step, TILE_PIXELS);
  uint8_t* const out = to.out;
  uint32_t k = 0;
  for (;;) {
    to.out = out + k * l.channels;
    if (!blend_tile(data, s, rows.start, &row, &to, l, f)) return k;
    k += num_pixels;
    if (k == n) return n;
    rows.start = _mm512_add_epi32(rows.start, to_next);
    if (k + TILE_PIXELS > n) { /* the last tile overlaps the previous one */
      const uint32_t back = k + TILE_PIXELS - n;
      rows.start = _mm512_sub_epi32(rows.start, times(rows.step, back));
      k -= back;
    }
  }
}

/* ---- Spans --------------------------------------------------------------- */

/* Processes num_rows rows, starting at row t and pixel k, with another kernel.
 */
static void blend_elsewhere(const rg_span* span, uint32_t t, uint32_t num_rows,
                            uint32_t k, rg_blend* other) {
  rg_span part = *span;
  part.first_row = (uint8_t)(span->first_row + t);
  part.num_rows = (uint8_t)num_rows;
  part.out += (size_t)t * span->out_stride;
  part.first_pixel = (uint8_t)(span->first_pixel + k);
  part.num_pixels = (uint8_t)(span->num_pixels - k);
  part.out_pixel = (uint16_t)(part.out_pixel + k);
  other(&part);
}

INLINE void blend(const rg_span* span, uint32_t channels, rg_blend* other) {
  const layout l = {channels, 0};
  const uint32_t n = span->num_pixels, num_rows = span->num_rows;
  const uint32_t row_bytes = (n < TILE_PIXELS ? n : TILE_PIXELS) * channels;
  if (span->stride > MAX_STRIDE) {
    other(span);
    return;
  }
  const fills* f = &kFills;
  __asm__("" : "+r"(f)); /* forces loads from there */
  const source_steps s = compute_source_steps(span, l);
  tile_output to = {span->out + span->out_pixel * channels,
                    span->out_stride,
                    0,
                    span->block.height_log2 < 5 || channels <= 2,
                    0,
                    (__mmask32)((UINT64_C(1) << row_bytes) - 1)};
  for (uint32_t t = 0; t < num_rows; t += TILE_ROWS) {
    to.num_rows = num_rows - t < TILE_ROWS ? num_rows - t : TILE_ROWS;
    to.is_whole = to.num_rows == TILE_ROWS && n >= TILE_PIXELS;
    const uint32_t done =
        blend_tiles(span->data, &s, compute_tile(span, t, l), to, n, l, f);
    if (done != n) blend_elsewhere(span, t, to.num_rows, done, other);
    to.out += TILE_ROWS * to.stride;
  }
}

/* Processes adjacent tiles of 8 x 8 pixels. */
INLINE void blend_tile_row(const rg_span* first, const rg_position* corners,
                           uint32_t num_tiles, uint32_t channels,
                           rg_blend* other) {
  const layout l = {channels, 1};
  rg_span span = *first; /* a copy that stores to the output cannot alias */
  const fills* f = &kFills;
  __asm__("" : "+r"(f));
  const source_steps s = compute_source_steps(&span, l);
  tile_output to = {span.out + span.out_pixel * channels,
                    span.out_stride,
                    TILE_ROWS,
                    1,
                    1,
                    0};
  for (; num_tiles != 0; --num_tiles, corners += 4) {
    memcpy(span.block.corners, corners, sizeof(span.block.corners));
    const tile rows = compute_tile(&span, 0, l);
    const tile_row row = compute_tile_row(rows.step, TILE_PIXELS, l);
    if (span.stride > MAX_STRIDE ||
        !blend_tile(span.data, &s, rows.start, &row, &to, l, f))
      other(&span);
    span.out_pixel = (uint16_t)(span.out_pixel + TILE_PIXELS);
    to.out += TILE_PIXELS * channels;
  }
}

#define KERNELS(channels)                                                    \
  void rg_blend_##channels##_avx512(const rg_span* span) {                   \
    blend(span, channels, rg_blend_##channels##_avx2);                       \
  }                                                                          \
  void rg_blend_tile_row_##channels##_avx512(                                \
      const rg_span* span, const rg_position* corners, uint32_t num_tiles) { \
    blend_tile_row(span, corners, num_tiles, channels,                       \
                   rg_blend_##channels##_avx2);                              \
  }
KERNELS(1)
KERNELS(2)
KERNELS(3)
KERNELS(4)
#undef KERNELS

RG_END_FEATURES

#endif
