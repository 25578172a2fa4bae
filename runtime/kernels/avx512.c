/* Bilinear blending by lookups in tables of 128 bytes: a group of pixels of
 * neighbouring rows, 32 samples in lanes of 16 bits, finds its source in a box
 * of bytes in two registers. Where a group needs a larger box, the AVX2 kernels
 * take over. */
#if defined(__x86_64__)

#include <immintrin.h>
#include <stddef.h>

#include "remap_kernels.h"

#if defined(__clang__)
#pragma clang attribute push(                                   \
    __attribute__((target("avx512f,avx512bw,avx512vl,avx512dq," \
                          "avx512vbmi,avx512vbmi2"))),          \
    apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi,avx512vbmi2")
#endif

#define INLINE static inline __attribute__((always_inline))

/* Rows whose positions are found together. */
#define TILE_ROWS 8u

/* How far ahead memory is asked for: bytes of a row. */
#define AHEAD 128

/* ---- Layouts ------------------------------------------------------------- */

/* A group has 4 rows of 8 lanes and a box of 8 rows of 16 bytes, or 2 rows of
 * 16 lanes and a box of 4 rows of 32 bytes. Pixels of three channels have four
 * lanes. */
typedef struct layout {
  uint32_t channels, group_rows;
} layout;

INLINE uint32_t group_pixels(layout l) {
  return 32 / l.group_rows / (l.channels == 3 ? 4 : l.channels);
}
INLINE uint32_t box_rows(layout l) { return 2 * l.group_rows; }
/* Of a column in a box: 16 columns, or 8. */
INLINE uint32_t column_bits(layout l) { return l.channels % 2 == 1 ? 4 : 3; }

#define FOUR(i) i, i, i, i
#define EIGHT(i) FOUR(i), FOUR(i)
#define SIXTEEN(i) EIGHT(i), EIGHT(i)
#define WORDS(i) \
  { SIXTEEN(i), SIXTEEN(i) }

/* Vectors are read from memory: compilers would compose them anew in every
 * turn. */
typedef struct lane_table {
  uint16_t pixels[32];   /* of lanes, from the row's first */
  uint16_t samples[32];  /* bytes from a pixel to left and right sample */
  uint16_t x[4][32];     /* of groups: words of a tile */
  uint16_t y[4][32];     /* likewise */
  uint16_t scale[32];    /* indices for one */
  uint16_t next_row[32]; /* indices from a box's row to the next */
  uint32_t sizes[16];    /* as a tile: too large for a box */
  uint32_t box_rows[16]; /* the first half of a box's rows, of each group */
} lane_table;

#define ROW_OF_8(...) __VA_ARGS__, __VA_ARGS__, __VA_ARGS__, __VA_ARGS__
#define ROW_OF_16(...) __VA_ARGS__, __VA_ARGS__
#define SAMPLES(...) \
  { ROW_OF_8(__VA_ARGS__), ROW_OF_8(__VA_ARGS__) }
#define FOUR_ROWS(i) \
  { EIGHT(i), EIGHT(i + 2), EIGHT(i + 4), EIGHT(i + 6) }
#define TWO_ROWS(i) \
  { SIXTEEN(i), SIXTEEN(i + 2) }
#define GROUPS_OF_4 \
  {FOUR_ROWS(0), FOUR_ROWS(8)}, { FOUR_ROWS(16), FOUR_ROWS(24) }
#define GROUPS_OF_2                                        \
  {TWO_ROWS(0), TWO_ROWS(4), TWO_ROWS(8), TWO_ROWS(12)}, { \
    TWO_ROWS(16), TWO_ROWS(20), TWO_ROWS(24), TWO_ROWS(28) \
  }
#define SIZES(columns, rows) \
  { EIGHT(4096 * (columns - 1)), EIGHT(4096 * (rows - 1)) }

static const lane_table kLanes[4] __attribute__((aligned(64))) = {
    {{ROW_OF_8(0, 1, 2, 3, 4, 5, 6, 7)},
     SAMPLES(0x100, 0x100, 0x100, 0x100),
     GROUPS_OF_4,
     WORDS(0x101),
     WORDS(0x1010),
     SIZES(16, 8),
     {0, 1, 2, 3, 0, 1, 2, 3}},
    {{ROW_OF_8(0, 0, 1, 1, 2, 2, 3, 3)},
     SAMPLES(0x200, 0x301, 0x200, 0x301),
     GROUPS_OF_4,
     WORDS(0x202),
     WORDS(0x1010),
     SIZES(8, 8),
     {0, 1, 2, 3, 0, 1, 2, 3}},
    {{ROW_OF_16(FOUR(0), FOUR(1), FOUR(2), FOUR(3))},
     SAMPLES(0x300, 0x401, 0x502, 0x502),
     GROUPS_OF_2,
     WORDS(0x101),
     WORDS(0x2020),
     SIZES(10, 4),
     {0, 1, 0, 1, 0, 1, 0, 1}},
    {{ROW_OF_16(FOUR(0), FOUR(1), FOUR(2), FOUR(3))},
     SAMPLES(0x400, 0x501, 0x602, 0x703),
     GROUPS_OF_2,
     WORDS(0x404),
     WORDS(0x2020),
     SIZES(8, 4),
     {0, 1, 0, 1, 0, 1, 0, 1}}};

typedef struct shared_table {
  uint16_t seven_bits[32], fifteen_bits[32];
  uint16_t left_weight[32], right_weight[32], last_factor[32];
  uint32_t tile_rows[16];
  uint8_t index_of_three[64];    /* 16 row + column to 32 row + 3 column */
  uint8_t bytes_of_three[64];    /* low bytes of three words of four */
  uint32_t shift[8][4], half[8]; /* by log2 */
} shared_table;

#define COLUMNS_OF_THREE(i)                                               \
  i, i + 3, i + 6, i + 9, i + 12, i + 15, i + 18, i + 21, i + 24, i + 27, \
      i + 30, 0, 0, 0, 0, 0
#define PIXELS_OF_THREE(i)                                                \
  i, i + 2, i + 4, i + 8, i + 10, i + 12, i + 16, i + 18, i + 20, i + 24, \
      i + 26, i + 28, 0, 0, 0, 0

static const shared_table kShared __attribute__((aligned(64))) = {
    WORDS(127),
    WORDS(0x7fff),
    WORDS(0xff01),
    WORDS(128),
    WORDS(0xff00),
    {0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7},
    {COLUMNS_OF_THREE(0), COLUMNS_OF_THREE(32), COLUMNS_OF_THREE(64),
     COLUMNS_OF_THREE(96)},
    {PIXELS_OF_THREE(0), PIXELS_OF_THREE(32)},
    {{0}, {1}, {2}, {3}, {4}, {5}, {6}, {7}},
    {0, 1, 2, 4, 8, 16, 32, 64}};

typedef struct tables {
  const lane_table* lanes;
  const shared_table* shared;
} tables;

INLINE __m512i load_64(const void* bytes) { return _mm512_load_si512(bytes); }

/* Constants of every group, in registers. */
typedef struct constants {
  __m512i seven_bits, fifteen_bits, left_weight, right_weight, last_factor;
  __m512i scale, samples, next_row;
} constants;

INLINE __m512i keep_64(const void* bytes) {
  __m512i value = load_64(bytes);
  __asm__("" : "+v"(value));
  return value;
}

INLINE constants load_constants(const tables* t) {
  const constants c = {
      keep_64(t->shared->seven_bits),  keep_64(t->shared->fifteen_bits),
      keep_64(t->shared->left_weight), keep_64(t->shared->right_weight),
      keep_64(t->shared->last_factor), keep_64(t->lanes->scale),
      keep_64(t->lanes->samples),      keep_64(t->lanes->next_row)};
  return c;
}

/* ---- Positions ----------------------------------------------------------- */

/* Of 8 rows, in 32 bits: x + 16 in the low half and y in the high. */
typedef struct tile {
  __m512i start, step;
} tile;

#define Y_LANES 0xff00

INLINE __m512i load_position(const rg_position* p) {
  return _mm512_mask_set1_epi32(_mm512_set1_epi32(p->q12[0]), Y_LANES,
                                p->q12[1]);
}

/* (value + 2^(log2 - 1)) >> log2 */
INLINE __m512i round_shift(__m512i value, uint32_t log2,
                           const shared_table* shared) {
  return _mm512_sra_epi32(
      _mm512_add_epi32(value, _mm512_set1_epi32((int32_t)shared->half[log2])),
      _mm_load_si128((const __m128i*)(const void*)shared->shift[log2]));
}

/* Where rows r of the block meet the edge from a corner down to another. */
INLINE __m512i find_edge(const rg_run* run, int corner, __m512i r,
                         const shared_table* shared) {
  const rg_position* const corners = run->block.corners;
  const __m512i top = load_position(&corners[corner]);
  const __m512i bottom = load_position(&corners[corner + 2]);
  return _mm512_add_epi32(
      top, round_shift(_mm512_mullo_epi32(_mm512_sub_epi32(bottom, top), r),
                       run->block.height_log2, shared));
}

/* Rows of the run from t on; behind the last row, that one again. */
INLINE tile find_tile(const rg_run* run, uint32_t t,
                      const shared_table* shared) {
  const uint32_t row = run->first_row + t, num_rows = run->num_rows - t;
  __m512i r = load_64(shared->tile_rows);
  if (num_rows < TILE_ROWS)
    r = _mm512_min_epi32(r, _mm512_set1_epi32((int32_t)num_rows - 1));
  if (row != 0) r = _mm512_add_epi32(r, _mm512_set1_epi32((int32_t)row));
  const __m512i left = find_edge(run, 0, r, shared);
  const __m512i right = find_edge(run, 1, r, shared);
  const rg_position origin = {{16, -4096 * run->first_source_row}};
  tile rows;
  rows.step =
      round_shift(_mm512_sub_epi32(right, left), run->block.width_log2, shared);
  rows.start = _mm512_add_epi32(left, load_position(&origin));
  if (run->first_pixel != 0)
    rows.start = _mm512_add_epi32(
        rows.start,
        _mm512_mullo_epi32(rows.step, _mm512_set1_epi32(run->first_pixel)));
  return rows;
}

/* ---- Boxes --------------------------------------------------------------- */

/* Bytes to pixels and rows. */
typedef struct source_steps {
  __m512i pixel; /* of x and of y, as a tile */
  __m256i row;
  __m256i upper_rows, lower_rows; /* of boxes, from their first */
} source_steps;

INLINE source_steps find_source_steps(const rg_run* run, layout l,
                                      const lane_table* lanes) {
  const rg_position pixel = {{(int32_t)l.channels, (int32_t)run->stride}};
  source_steps s;
  s.pixel = load_position(&pixel);
  s.row = _mm256_set1_epi32((int32_t)run->stride);
  s.upper_rows = _mm256_mullo_epi32(
      s.row, _mm256_load_si256((const __m256i*)(const void*)lanes->box_rows));
  s.lower_rows = _mm256_add_epi32(
      s.upper_rows, _mm256_slli_epi32(s.row, l.group_rows == 4 ? 2 : 1));
  return s;
}

/* Where the boxes of a tile have their rows: the upper half of each box, then
 * the lower halves. */
typedef struct boxes {
  int32_t upper[8], lower[8];
} boxes;

/* Least or greatest of the rows of each group, in all of them. */
INLINE __m512i find_least(__m512i a, __m512i b, layout l) {
  __m512i least = _mm512_min_epi32(a, b);
  least = _mm512_min_epi32(least, _mm512_shuffle_epi32(least, 0xb1));
  if (l.group_rows == 4)
    least = _mm512_min_epi32(least, _mm512_shuffle_epi32(least, 0x4e));
  return least;
}

INLINE __m512i find_greatest(__m512i a, __m512i b, layout l) {
  __m512i greatest = _mm512_max_epi32(a, b);
  greatest = _mm512_max_epi32(greatest, _mm512_shuffle_epi32(greatest, 0xb1));
  if (l.group_rows == 4)
    greatest = _mm512_max_epi32(greatest, _mm512_shuffle_epi32(greatest, 0x4e));
  return greatest;
}

INLINE __m256i low_half(__m512i v) { return _mm512_castsi512_si256(v); }
INLINE __m256i high_half(__m512i v) { return _mm512_extracti64x4_epi64(v, 1); }

/* For rows from start to end. Rows below the lowest one that is needed become
 * that one. first: start, from the box. Returns whether boxes are large enough.
 */
INLINE int find_boxes(const source_steps* s, __m512i start, __m512i end,
                      layout l, const lane_table* lanes, __m512i* first,
                      boxes* b) {
  const __m512i pixel = _mm512_srli_epi32(find_least(start, end, l), 12);
  const __m512i origin = _mm512_slli_epi32(pixel, 12);
  const __m512i size = _mm512_sub_epi32(find_greatest(start, end, l), origin);
  if (_mm512_cmpge_epu32_mask(size, load_64(lanes->sizes)) != 0) return 0;
  *first = _mm512_sub_epi32(start, origin);
  const __m512i offset = _mm512_mullo_epi32(pixel, s->pixel);
  const __m256i corner = _mm256_add_epi32(low_half(offset), high_half(offset));
  const __m256i lowest = _mm256_add_epi32(
      _mm256_mullo_epi32(_mm256_srli_epi32(high_half(size), 12), s->row),
      s->row);
  /* By halves: whole registers would not be forwarded to the loads. */
  _mm256_storeu_si256(
      (__m256i*)(void*)b->upper,
      _mm256_add_epi32(corner, _mm256_min_epu32(s->upper_rows, lowest)));
  _mm256_storeu_si256(
      (__m256i*)(void*)b->lower,
      _mm256_add_epi32(corner, _mm256_min_epu32(s->lower_rows, lowest)));
  return 1;
}

INLINE __m128i load_16(const uint8_t* bytes) {
  return _mm_loadu_si128((const __m128i*)(const void*)bytes);
}

INLINE __m256i load_32(const uint8_t* bytes) {
  return _mm256_loadu_si256((const __m256i*)(const void*)bytes);
}

/* Half a box: rows of 16 bytes, inserted by masks, which needs no shuffle; or
 * of 32. */
INLINE __m512i load_rows(const uint8_t* data, const int32_t* offsets,
                         layout l) {
  if (l.group_rows == 2)
    return _mm512_inserti64x4(
        _mm512_castsi256_si512(load_32(data + offsets[0])),
        load_32(data + offsets[1]), 1);
  __m512i rows = _mm512_castsi128_si512(load_16(data + offsets[0]));
  rows = _mm512_mask_broadcast_i32x4(rows, 0x00f0, load_16(data + offsets[1]));
  rows = _mm512_mask_broadcast_i32x4(rows, 0x0f00, load_16(data + offsets[2]));
  return _mm512_mask_broadcast_i32x4(rows, 0xf000, load_16(data + offsets[3]));
}

/* ---- Groups -------------------------------------------------------------- */

/* From a row's first pixel to each lane. */
INLINE __m512i find_lane_steps(__m512i step, const uint16_t* words,
                               __m512i pixels) {
  return _mm512_mullo_epi16(_mm512_permutexvar_epi16(load_64(words), step),
                            pixels);
}

INLINE __m512i find_lanes(__m512i first, const uint16_t* words,
                          __m512i lane_steps) {
  return _mm512_add_epi16(_mm512_permutexvar_epi16(load_64(words), first),
                          lane_steps);
}

/* Indices of left and right samples in the box's upper row. x: the column is in
 * the highest bits. */
INLINE __m512i find_indices(__m512i x, __m512i y_q12, layout l, const tables* t,
                            const constants* c) {
  /* row << column_bits | column */
  const __m512i place =
      l.channels % 2 == 1
          ? _mm512_shldi_epi16(_mm512_srli_epi16(y_q12, 12), x, 4)
          : _mm512_shldi_epi16(_mm512_srli_epi16(y_q12, 12), x, 3);
  __m512i index = _mm512_mullo_epi16(place, c->scale);
  if (l.channels == 3)
    index = _mm512_permutexvar_epi8(index, load_64(t->shared->index_of_three));
  return _mm512_add_epi16(index, c->samples);
}

/* Positions are the box's. Results in the low bytes of lanes. */
INLINE __m512i blend_group(__m512i upper_half, __m512i lower_half, __m512i x,
                           __m512i y_q12, layout l, const tables* t,
                           const constants* c) {
  const __m512i index = find_indices(x, y_q12, l, t, c);
  /* bytes wx - 128 and -wx */
  const __m512i wx = _mm512_and_si512(
      _mm512_srli_epi16(x, l.channels % 2 == 1 ? 5 : 6), c->seven_bits);
  const __m512i weights =
      _mm512_add_epi16(_mm512_mullo_epi16(wx, c->left_weight), c->right_weight);
  const __m512i wy_q15 =
      _mm512_and_si512(_mm512_slli_epi16(y_q12, 3), c->fifteen_bits);
  const __m512i next = _mm512_add_epi16(index, c->next_row);
  /* -h of both rows */
  const __m512i upper = _mm512_maddubs_epi16(
      _mm512_permutex2var_epi8(upper_half, index, lower_half), weights);
  const __m512i lower = _mm512_maddubs_epi16(
      _mm512_permutex2var_epi8(upper_half, next, lower_half), weights);
  /* -v = -h0 + ((h0 - h1) wy + 2^14) >> 15 */
  const __m512i v = _mm512_add_epi16(
      upper, _mm512_mulhrs_epi16(_mm512_sub_epi16(lower, upper), wy_q15));
  /* (v + 64) >> 7 */
  return _mm512_mulhrs_epi16(v, c->last_factor);
}

/* ---- Output -------------------------------------------------------------- */

/* Where the rows of a segment's groups go, up to 16 bytes each. */
typedef struct target {
  uint8_t* out;
  size_t stride;
  uint32_t num_rows;
  int is_whole; /* all rows and pixels are wanted */
  __mmask16 bytes;
} target;

INLINE void store_part(const target* t, uint32_t r, __m128i bytes) {
  if (r < t->num_rows)
    _mm_mask_storeu_epi8(t->out + r * t->stride, t->bytes, bytes);
}

INLINE __m128i* row_of(const target* t, uint32_t r) {
  return (__m128i*)(void*)(t->out + r * t->stride);
}

/* Row r of both groups of four. */
INLINE void store_of_both(const target* t, uint32_t r, __m128i both) {
  if (t->is_whole) {
    _mm_storel_epi64(row_of(t, r), both);
    _mm_storeh_pd((double*)(void*)row_of(t, r + 4), _mm_castsi128_pd(both));
  } else {
    store_part(t, r, both);
    store_part(t, r + 4, _mm_unpackhi_epi64(both, both));
  }
}

INLINE void store_fours(const target* t, __m512i v, __m512i w) {
  const __m512i bytes = _mm512_packus_epi16(v, w);
  store_of_both(t, 0, _mm512_castsi512_si128(bytes));
  store_of_both(t, 1, _mm512_extracti32x4_epi32(bytes, 1));
  store_of_both(t, 2, _mm512_extracti32x4_epi32(bytes, 2));
  store_of_both(t, 3, _mm512_extracti32x4_epi32(bytes, 3));
}

/* Rows r and r + 1. */
INLINE void store_two(const target* t, uint32_t r, __m512i v, layout l,
                      const shared_table* shared) {
  const __m256i bytes = l.channels == 3
                            ? low_half(_mm512_permutexvar_epi8(
                                  load_64(shared->bytes_of_three), v))
                            : _mm512_cvtepi16_epi8(v);
  const __m128i first = _mm256_castsi256_si128(bytes);
  const __m128i second = _mm256_extracti128_si256(bytes, 1);
  if (t->is_whole && l.channels != 3) {
    _mm_storeu_si128(row_of(t, r), first);
    _mm_storeu_si128(row_of(t, r + 1), second);
  } else {
    store_part(t, r, first);
    store_part(t, r + 1, second);
  }
}

/* Asks for what the blocks to the right will read and write: once for 64 bytes
 * of output, which come from up to 128. */
INLINE void look_ahead(const uint8_t* data, const boxes* b, const target* t) {
  for (uint32_t r = 0; r < TILE_ROWS; ++r) {
    __builtin_prefetch(data + b->upper[r] + AHEAD);
    __builtin_prefetch(data + b->upper[r] + AHEAD + 64);
    __builtin_prefetch(data + b->lower[r] + AHEAD);
    __builtin_prefetch(data + b->lower[r] + AHEAD + 64);
    __builtin_prefetch(t->out + r * t->stride + AHEAD, 1);
  }
}

/* ---- Runs ---------------------------------------------------------------- */

/* Returns how many pixels of the tile's rows were done, count at a time. */
INLINE uint32_t blend_tile(const uint8_t* data, const source_steps* s,
                           tile rows, target to, uint32_t n, uint32_t count,
                           layout l, const tables* t) {
  const lane_table* const lanes = t->lanes;
  uint8_t* const out = to.out;
  const constants c = load_constants(t);
  const __m512i pixels = _mm512_min_epu16(
      load_64(lanes->pixels), _mm512_set1_epi16((int16_t)(count - 1)));
  /* Columns to the highest bits. */
  const __m512i step = _mm512_mask_add_epi32(
      rows.step, l.channels % 2 == 1 ? 0 : 0x00ff, rows.step, rows.step);
  const __m512i span =
      _mm512_mullo_epi32(rows.step, _mm512_set1_epi32((int32_t)count - 1));
#define STEPS(g)                                                         \
  const __m512i steps_x##g = find_lane_steps(step, lanes->x[g], pixels), \
                steps_y##g = find_lane_steps(step, lanes->y[g], pixels)
  STEPS(0);
  STEPS(1);
  STEPS(2);
  STEPS(3);
#undef STEPS
  for (uint32_t k = 0; k < n; k += count) {
    if (k + count > n) { /* the last segment begins earlier */
      rows.start = _mm512_sub_epi32(
          rows.start,
          _mm512_mullo_epi32(rows.step,
                             _mm512_set1_epi32((int32_t)(k + count - n))));
      k = n - count;
    }
    const __m512i end = _mm512_add_epi32(rows.start, span);
    __m512i first;
    boxes b;
    if (!find_boxes(s, rows.start, end, l, lanes, &first, &b)) return k;
    __asm__("" : "+m"(b)); /* read from there, not taken from lanes */
    first = _mm512_mask_add_epi32(first, l.channels % 2 == 1 ? 0 : 0x00ff,
                                  first, first);
    to.out = out + k * l.channels;
    if (((uintptr_t)to.out & 63) < group_pixels(l) * l.channels)
      look_ahead(data, &b, &to);
#define GROUP(g)                                                \
  blend_group(load_rows(data, b.upper + l.group_rows * (g), l), \
              load_rows(data, b.lower + l.group_rows * (g), l), \
              find_lanes(first, lanes->x[g], steps_x##g),       \
              find_lanes(first, lanes->y[g], steps_y##g), l, t, &c)
    if (l.group_rows == 4) {
      store_fours(&to, GROUP(0), GROUP(1));
    } else {
      store_two(&to, 0, GROUP(0), l, t->shared);
      store_two(&to, 2, GROUP(1), l, t->shared);
      store_two(&to, 4, GROUP(2), l, t->shared);
      store_two(&to, 6, GROUP(3), l, t->shared);
    }
#undef GROUP
    rows.start = _mm512_add_epi32(end, rows.step);
  }
  return n;
}

/* Rows from t on, pixels from k on. */
static void blend_elsewhere(const rg_run* run, uint32_t t, uint32_t num_rows,
                            uint32_t k, rg_blend* other) {
  rg_run part = *run;
  part.first_row = (uint8_t)(run->first_row + t);
  part.num_rows = (uint8_t)num_rows;
  part.out += (size_t)t * run->out_stride;
  part.first_pixel = (uint8_t)(run->first_pixel + k);
  part.num_pixels = (uint8_t)(run->num_pixels - k);
  part.out_pixel += k;
  other(&part);
}

INLINE void blend(const rg_run* run, layout l, rg_blend* other) {
  const uint32_t n = run->num_pixels, num_rows = run->num_rows;
  const uint32_t count = n < group_pixels(l) ? n : group_pixels(l);
  if (run->stride > 1 << 18) {
    other(run);
    return;
  }
  tables c = {&kLanes[l.channels - 1], &kShared};
  __asm__("" : "+r"(c.lanes), "+r"(c.shared)); /* contents are not known */
  const source_steps s = find_source_steps(run, l, c.lanes);
  target to = {run->out + run->out_pixel * l.channels, run->out_stride, 0, 0,
               (__mmask16)((1u << count * l.channels) - 1)};
  for (uint32_t t = 0; t < num_rows; t += TILE_ROWS) {
    to.num_rows = num_rows - t < TILE_ROWS ? num_rows - t : TILE_ROWS;
    to.is_whole = to.num_rows == TILE_ROWS && count == group_pixels(l);
    const uint32_t done = blend_tile(run->data, &s, find_tile(run, t, c.shared),
                                     to, n, count, l, &c);
    if (done != n) blend_elsewhere(run, t, to.num_rows, done, other);
    to.out += TILE_ROWS * to.stride;
  }
}

void rg_blend_1_avx512(const rg_run* run) {
  const layout l = {1, 4};
  blend(run, l, rg_blend_1_avx2);
}

void rg_blend_2_avx512(const rg_run* run) {
  const layout l = {2, 4};
  blend(run, l, rg_blend_2_avx2);
}

void rg_blend_3_avx512(const rg_run* run) {
  const layout l = {3, 2};
  blend(run, l, rg_blend_3_avx2);
}

void rg_blend_4_avx512(const rg_run* run) {
  const layout l = {4, 2};
  blend(run, l, rg_blend_4_avx2);
}

#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif

#endif
