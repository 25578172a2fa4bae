/* The kernels that define the others' bits. */
#include <stddef.h>

#include "bytes.h"
#include "fixed_point.h"
#include "remap_kernels.h"

/* Two neighbours, the left one in the low byte. */
static inline uint32_t load_pair(const uint8_t* p) {
  return p[0] | (uint32_t)p[1] << 8;
}

/* ---- Tiles ---------------------------------------------------------------
 *
 * 8 x 8 pixels, in loops over all of them that GCC makes vectors of; clang 14
 * does so with few, which is slower than one pixel after the other. Lanes are a
 * tile's rows, so that one sum leads to the next column. Sources are counted in
 * 16 bits from a pixel nearby. */
#if RG_IS_FAST && defined(__SSE2__) && defined(__GNUC__) && __GNUC__ >= 12
#define HAS_TILES 1

#define TILE 8
#define TILE_PIXELS (TILE * TILE)

/* x, y of where a row begins, and where it ends, times the height of the block;
 * what rounds them is added, to the ends also what rounds a step. And how these
 * change to the next row. */
typedef struct tile_edges {
  int32_t sums[4], heights[4];
  uint32_t width_log2, height_log2;
} tile_edges;

static RG_INLINE void start_tile_edges(const rg_run* run, int32_t bias_x,
                                       int32_t bias_y, tile_edges* edges) {
  const uint32_t log2 = run->block.height_log2;
  const int32_t half_step = INT32_C(1) << run->block.width_log2 >> 1;
  const int32_t first_row = run->first_row, half = INT32_C(1) << log2 >> 1;
  const int32_t y = bias_y - ((int32_t)run->first_source_row << 12);
  const int32_t bias[4] = {bias_x, y, bias_x + half_step, y + half_step};
  int32_t upper[4], lower[4];
  memcpy(upper, run->block.corners, sizeof(upper));
  memcpy(lower, run->block.corners + 2, sizeof(lower));
  for (uint32_t k = 0; k < 4; ++k) {
    edges->heights[k] = lower[k] - upper[k];
    edges->sums[k] = (upper[k] + bias[k]) * (1 << log2) +
                     (lower[k] - upper[k]) * first_row + half;
  }
  edges->width_log2 = run->block.width_log2;
  edges->height_log2 = log2;
}

/* One coordinate of where rows begin and of their steps, modulo 2^16; of the
 * first row, as it is. */
typedef struct tile_rows {
  uint16_t start[TILE], step[TILE];
  int32_t first_start, first_step;
} tile_rows;

static RG_INLINE void find_tile_rows(const tile_edges* edges, int c,
                                     tile_rows* rows) {
  const uint32_t log2 = edges->height_log2, width_log2 = edges->width_log2;
  const int32_t left = edges->sums[c], left_height = edges->heights[c];
  const int32_t right = edges->sums[2 + c];
  const int32_t right_height = edges->heights[2 + c];
  int32_t lefts[TILE], rights[TILE];
  for (int32_t r = 0; r < TILE / 2; ++r) {
    lefts[r] = left + r * left_height;
    rights[r] = right + r * right_height;
  }
  for (int32_t r = 0; r < TILE / 2; ++r) {
    lefts[r + TILE / 2] = lefts[r] + TILE / 2 * left_height;
    rights[r + TILE / 2] = rights[r] + TILE / 2 * right_height;
  }
  for (uint32_t r = 0; r < TILE; ++r) {
    const int32_t start = lefts[r] >> log2;
    rows->start[r] = (uint16_t)start;
    rows->step[r] = (uint16_t)(((rights[r] >> log2) - start) >> width_log2);
  }
  rows->first_start = left >> log2;
  rows->first_step = ((right >> log2) - rows->first_start) >> width_log2;
}

/* To the tile on the right. */
static RG_INLINE void go_right(tile_rows* rows) {
  for (uint32_t r = 0; r < TILE; ++r)
    rows->start[r] = (uint16_t)(rows->start[r] + TILE * rows->step[r]);
  rows->first_start += TILE * rows->first_step;
}

/* More than rounding moves the pixels of a tile. */
#define TILE_MARGIN 64

/* Whether a run is made of tiles, and their sources can be counted in 16 bits,
 * the offsets of 1 or 2 channels too. reach: how far before the source of a
 * tile's first pixel those of others lie at most, in q12. */
static RG_INLINE int find_reach(const rg_run* run, uint32_t channels,
                                int32_t reach[2]) {
  const rg_position* const corners = run->block.corners;
  uint32_t pixels[2];
  if (run->first_pixel != 0 || run->stride > UINT16_MAX ||
      ((run->num_pixels | run->num_rows) & (TILE - 1)) != 0)
    return 0;
  for (int c = 0; c < 2; ++c) {
    const int32_t width = corners[1].q12[c] - corners[0].q12[c];
    const int32_t height = corners[2].q12[c] - corners[0].q12[c];
    const int32_t lower_width = corners[3].q12[c] - corners[2].q12[c];
    const int32_t across = (width >> run->block.width_log2) * (TILE - 1);
    const int32_t down = (height >> run->block.height_log2) * (TILE - 1);
    /* The edges of any tile differ less from these than those of the block. */
    const uint32_t slack = rg_magnitude(lower_width - width) + TILE_MARGIN;
    const uint32_t extent =
        rg_magnitude(across) + rg_magnitude(down) + 2 * slack + 4095;
    if (extent > UINT16_MAX) return 0;
    pixels[c] = extent >> 12;
    reach[c] =
        (int32_t)slack - (across < 0 ? across : 0) - (down < 0 ? down : 0);
  }
  return channels > 2 ||
         pixels[1] * run->stride + pixels[0] * channels <= UINT16_MAX;
}

/* The pixel, or row, that the sources of a tile are counted from. */
static inline uint32_t find_origin(const tile_rows* rows, int32_t reach) {
  const int32_t first = rows->first_start - reach;
  return first < 0 ? 0 : (uint32_t)first >> 12;
}

/* Counted from there; offsets in bytes, of 1 or 2 channels, and of more. */
typedef struct tile {
  uint16_t x_q12[TILE_PIXELS], y_q12[TILE_PIXELS];
  uint16_t offsets[TILE_PIXELS];
  uint32_t far_offsets[TILE_PIXELS];
} tile;

static RG_INLINE void find_tile(const tile_rows* x, const tile_rows* y,
                                uint32_t column, uint32_t row, uint32_t stride,
                                uint32_t channels, tile* t) {
  uint16_t x_q12[TILE], y_q12[TILE];
  for (uint32_t r = 0; r < TILE; ++r) {
    x_q12[r] = (uint16_t)(x->start[r] - (column << 12));
    y_q12[r] = (uint16_t)(y->start[r] - (row << 12));
  }
  for (uint32_t k = 0; k < TILE_PIXELS; k += TILE) {
    for (uint32_t r = 0; r < TILE; ++r) {
      const uint16_t right = x_q12[r] >> 12, down = y_q12[r] >> 12;
      t->x_q12[k + r] = x_q12[r];
      t->y_q12[k + r] = y_q12[r];
      if (channels <= 2)
        t->offsets[k + r] =
            (uint16_t)(down * (uint16_t)stride + right * channels);
      else
        t->far_offsets[k + r] =
            (uint32_t)down * (uint16_t)stride + right * channels;
      x_q12[r] = (uint16_t)(x_q12[r] + x->step[r]);
      y_q12[r] = (uint16_t)(y_q12[r] + y->step[r]);
    }
  }
}

static RG_INLINE size_t offset_of(const tile* t, uint32_t i,
                                  uint32_t channels) {
  return channels <= 2 ? t->offsets[i] : t->far_offsets[i];
}

/* What belongs to pixels: planes of channels, or of words. */
typedef uint16_t tile_planes[4][TILE_PIXELS];

/* Of two neighbours: two bytes of the upper row, and of the lower one. */
static RG_INLINE void load_words(const tile* t, const uint8_t* upper,
                                 size_t stride, uint32_t channels,
                                 uint16_t* upper_words, uint16_t* lower_words) {
  const uint8_t* const lower = upper + stride;
  for (uint32_t i = 0; i < TILE_PIXELS; ++i) {
    const size_t offset = offset_of(t, i, channels);
    upper_words[i] = (uint16_t)load_pair(upper + offset);
    lower_words[i] = (uint16_t)load_pair(lower + offset);
  }
}

/* As rg_blend_8(), in lanes of 16 bits. */
static RG_INLINE uint16_t blend_lane(uint32_t upper_left, uint32_t upper_right,
                                     uint32_t lower_left, uint32_t lower_right,
                                     uint16_t x_q12, uint16_t y_q12) {
  const uint16_t right_q7 = (x_q12 >> 5) & 127;
  const uint16_t left_q7 = (uint16_t)(128 - right_q7);
  const uint16_t upper_q7 =
      (uint16_t)(upper_left * left_q7 + upper_right * right_q7);
  const uint16_t lower_q7 =
      (uint16_t)(lower_left * left_q7 + lower_right * right_q7);
  const int16_t down_q7 = (int16_t)(lower_q7 - upper_q7);
  const int16_t wy_q15 = (int16_t)((y_q12 & 4095) << 3);
  /* The product in two halves; the lower one is a multiple of 8. */
  const uint16_t high = (uint16_t)(((int32_t)down_q7 * wy_q15) >> 16);
  const uint16_t low = (uint16_t)((uint16_t)down_q7 * (uint32_t)wy_q15);
  const uint16_t rounded = (uint16_t)((low >> 3) + 2047) >> 12;
  return (uint16_t)(upper_q7 + 64 + 2 * high + rounded) >> 7;
}

/* Byte k of two neighbours. */
static RG_INLINE uint32_t byte_of(tile_planes words, uint32_t k, uint32_t i) {
  return (k & 1) != 0 ? words[k >> 1][i] >> 8 : words[k >> 1][i] & 255;
}

static RG_INLINE void blend_channel(const tile* t, tile_planes upper,
                                    tile_planes lower, uint32_t channels,
                                    uint32_t c, uint16_t* out) {
  for (uint32_t i = 0; i < TILE_PIXELS; ++i)
    out[i] = blend_lane(byte_of(upper, c, i), byte_of(upper, c + channels, i),
                        byte_of(lower, c, i), byte_of(lower, c + channels, i),
                        t->x_q12[i], t->y_q12[i]);
}

/* Byte k of the tile's rows. */
static RG_INLINE const uint16_t* byte_lanes(tile_planes values,
                                            uint32_t channels, uint32_t k) {
  return values[k % channels] + k / channels * TILE;
}

/* Four bytes at once: processors with these vectors are little-endian. */
static RG_INLINE void store_tile(tile_planes values, uint32_t channels,
                                 uint8_t* out, size_t out_stride) {
  uint32_t words[4 * TILE_PIXELS / 4];
  const uint32_t num_words = TILE * channels / 4;
  for (uint32_t k = 0; k < num_words; ++k) {
    const uint16_t* const a = byte_lanes(values, channels, 4 * k);
    const uint16_t* const b = byte_lanes(values, channels, 4 * k + 1);
    const uint16_t* const c = byte_lanes(values, channels, 4 * k + 2);
    const uint16_t* const d = byte_lanes(values, channels, 4 * k + 3);
    for (uint32_t r = 0; r < TILE; ++r) {
      const uint16_t low = (uint16_t)(a[r] | b[r] << 8);
      const uint16_t high = (uint16_t)(c[r] | d[r] << 8);
      words[k * TILE + r] = low | (uint32_t)high << 16;
    }
  }
  for (uint32_t r = 0; r < TILE; ++r, out += out_stride)
    for (uint32_t k = 0; k < num_words; ++k)
      memcpy(out + 4 * k, &words[k * TILE + r], 4);
}

static RG_INLINE void blend_tile(const tile* t, const uint8_t* data,
                                 size_t stride, uint32_t channels, uint8_t* out,
                                 size_t out_stride) {
  tile_planes upper, lower, values;
  for (uint32_t k = 0; k < channels; ++k)
    load_words(t, data + 2 * k, stride, channels, upper[k], lower[k]);
  blend_channel(t, upper, lower, channels, 0, values[0]);
  if (channels > 1) blend_channel(t, upper, lower, channels, 1, values[1]);
  if (channels > 2) blend_channel(t, upper, lower, channels, 2, values[2]);
  if (channels > 3) blend_channel(t, upper, lower, channels, 3, values[3]);
  store_tile(values, channels, out, out_stride);
}

static RG_INLINE void copy_tile(const tile* t, const uint8_t* data,
                                uint32_t channels, uint8_t* out,
                                size_t out_stride) {
  for (uint32_t r = 0; r < TILE; ++r, out += out_stride)
    for (uint32_t k = 0; k < TILE; ++k) {
      const uint8_t* const from = data + offset_of(t, k * TILE + r, channels);
      for (uint32_t c = 0; c < channels; ++c) out[k * channels + c] = from[c];
    }
}

/* Returns whether the run was done. */
static RG_INLINE int do_tiles(const rg_run* run, uint32_t channels,
                              int is_copy) {
  int32_t reach[2];
  if (!find_reach(run, channels, reach)) return 0;
  const uint8_t* const data = run->data;
  const uint32_t stride = run->stride, num_pixels = run->num_pixels;
  const size_t out_stride = run->out_stride;
  uint8_t* out = run->out + run->out_pixel * channels;
  tile_edges edges;
  start_tile_edges(run, is_copy ? 2048 : 16, is_copy ? 2048 : 0, &edges);
  for (uint32_t rows = run->num_rows; rows != 0; rows -= TILE) {
    tile_rows x, y;
    find_tile_rows(&edges, 0, &x);
    find_tile_rows(&edges, 1, &y);
    for (uint32_t k = 0; k < num_pixels; k += TILE) {
      const uint32_t column = find_origin(&x, reach[0]);
      const uint32_t row = find_origin(&y, reach[1]);
      const uint8_t* const from =
          data + (size_t)row * stride + (size_t)column * channels;
      tile t;
      find_tile(&x, &y, column, row, stride, channels, &t);
      if (is_copy)
        copy_tile(&t, from, channels, out + k * channels, out_stride);
      else
        blend_tile(&t, from, stride, channels, out + k * channels, out_stride);
      go_right(&x);
      go_right(&y);
    }
    for (uint32_t k = 0; k < 4; ++k) edges.sums[k] += TILE * edges.heights[k];
    out += TILE * out_stride;
  }
  return 1;
}

#else

static RG_INLINE int do_tiles(const rg_run* run, uint32_t channels,
                              int is_copy) {
  (void)run, (void)channels, (void)is_copy;
  return 0;
}

#endif

/* ---- Grey pixels --------------------------------------------------------- */

/* From one pixel of a row to the next: three ways, by what registers hold. */
#if defined(__ARM_FEATURE_SIMD32)

/* x is mirrored, 4095 - (x + 16): its fraction is the left samples' weight
 * less one. */
#define ORIGIN_X (4095 - 16)

typedef uint32_t blended;
typedef struct row_walk {
  const uint8_t* data;
  uint32_t stride;
  uint32_t x_q12, y_q12, step_x, step_y;
  uint32_t factor, one, apart; /* constants */
} row_walk;

static RG_INLINE void start_walk(const rg_run* run, const rg_block_row* row,
                                 row_walk* walk) {
  walk->data = run->data;
  walk->stride = run->stride;
  walk->x_q12 = 0u - (uint32_t)row->start.q12[0];
  walk->y_q12 = (uint32_t)row->start.q12[1];
  walk->step_x = 0u - (uint32_t)row->step.q12[0];
  walk->step_y = (uint32_t)row->step.q12[1];
  walk->factor = 65535;
  walk->one = 4096;
  walk->apart = 257;
  RG_IN_REGISTER(walk->factor);
  RG_IN_REGISTER(walk->one);
  RG_IN_REGISTER(walk->apart);
}

static RG_INLINE void step_on(row_walk* walk) {
  walk->x_q12 += walk->step_x;
  walk->y_q12 += walk->step_y;
  RG_IN_REGISTER(walk->x_q12); /* else more sums than two */
  RG_IN_REGISTER(walk->y_q12);
}

static RG_INLINE uint32_t blend_pixel(const row_walk* walk, blended rounding) {
  const uint8_t* upper = walk->data + (walk->y_q12 >> 12) * walk->stride;
  RG_IN_REGISTER(upper); /* likewise */
  upper -= (int32_t)walk->x_q12 >> 12;
  RG_IN_REGISTER(upper);
  const uint32_t pixels = load_pair(upper) | load_pair(upper + walk->stride)
                                                 << 16;
  const uint32_t right = rg_odd_bytes(pixels);
  const uint32_t difference = pixels - right * walk->apart; /* left - right */
  const uint32_t h_q7 =
      difference * ((walk->x_q12 >> 5) & 127) + (difference + (right << 7));
  const uint32_t weights = (walk->y_q12 & 4095) * walk->factor + walk->one;
  return (uint32_t)__smlad((int16x2_t)h_q7, (int16x2_t)weights,
                           (int32_t)rounding) >>
         19;
}

#elif defined(__LP64__) || defined(_WIN64)

#define ORIGIN_X (-16)

typedef uint64_t blended; /* in the upper half */
typedef struct row_walk {
  const uint8_t* data;
  uint64_t stride;
  uint64_t position, step; /* x in the upper half */
  uint64_t factor;         /* 1 - 2^32 */
} row_walk;

static RG_INLINE void start_walk(const rg_run* run, const rg_block_row* row,
                                 row_walk* walk) {
  walk->data = run->data;
  walk->stride = run->stride;
  walk->position = ((uint64_t)(uint32_t)row->start.q12[0] << 32) +
                   (uint64_t)(int64_t)row->start.q12[1];
  walk->step = ((uint64_t)(uint32_t)row->step.q12[0] << 32) +
               (uint64_t)(int64_t)row->step.q12[1];
  walk->factor = 1 - (UINT64_C(1) << 32);
  RG_IN_REGISTER(walk->factor);
}

static RG_INLINE void step_on(row_walk* walk) { walk->position += walk->step; }

/* h0 (4096 - wy) + h1 wy is the upper half of one product. */
static RG_INLINE uint64_t blend_pixel(const row_walk* walk, blended rounding) {
  const uint64_t position = walk->position, stride = walk->stride;
  const uint8_t* const upper =
      walk->data + ((position & UINT32_MAX) >> 12) * stride + (position >> 44);
  const uint64_t bytes = UINT64_C(0x000000ff000000ff);
  const uint64_t pixels = load_pair(upper) | (uint64_t)load_pair(upper + stride)
                                                 << 32;
  const uint64_t left = pixels & bytes, right = (pixels >> 8) & bytes;
  const uint64_t h_q7 = (right - left) * ((position >> 37) & 127) + (left << 7);
  const uint64_t weights =
      (position & 4095) * walk->factor + (UINT64_C(4096) << 32);
  return (h_q7 * weights + rounding) >> 51;
}

#else

#define ORIGIN_X (-16)

typedef uint32_t blended;
typedef struct row_walk {
  const uint8_t* data;
  uint32_t stride;
  uint32_t x_q12, y_q12, step_x, step_y;
} row_walk;

static RG_INLINE void start_walk(const rg_run* run, const rg_block_row* row,
                                 row_walk* walk) {
  walk->data = run->data;
  walk->stride = run->stride;
  walk->x_q12 = (uint32_t)row->start.q12[0];
  walk->y_q12 = (uint32_t)row->start.q12[1];
  walk->step_x = (uint32_t)row->step.q12[0];
  walk->step_y = (uint32_t)row->step.q12[1];
}

static RG_INLINE void step_on(row_walk* walk) {
  walk->x_q12 += walk->step_x;
  walk->y_q12 += walk->step_y;
  RG_IN_REGISTER(walk->x_q12); /* else more sums than two */
  RG_IN_REGISTER(walk->y_q12);
}

static RG_INLINE uint32_t blend_pixel(const row_walk* walk, blended rounding) {
  const uint8_t* const upper =
      walk->data + (walk->y_q12 >> 12) * walk->stride + (walk->x_q12 >> 12);
  const uint32_t pixels = load_pair(upper) | load_pair(upper + walk->stride)
                                                 << 16;
  return rg_blend_8(rg_even_bytes(pixels), rg_odd_bytes(pixels), walk->x_q12,
                    walk->y_q12, rounding);
}

#endif

/* ---- Rows ---------------------------------------------------------------- */

/* A coordinate of an edge of a block, row by row: sum >> height_log2. Two of
 * the left edge, and two of the right one with what rounds a step. */
typedef struct edge_walk {
  int32_t sum, height;
} edge_walk;

static RG_INLINE void start_edges(const rg_run* run, int32_t origin_x,
                                  edge_walk edges[4]) {
  const uint32_t log2 = run->block.height_log2;
  const int32_t half_step = INT32_C(1) << run->block.width_log2 >> 1;
  int32_t origin = origin_x;
  for (uint32_t c = 0; c < 2; ++c, ++edges) {
    for (uint32_t k = 0; k < 2; ++k) {
      const int32_t top = run->block.corners[k].q12[c];
      const int32_t height = run->block.corners[2 + k].q12[c] - top;
      edges[2 * k].height = height;
      edges[2 * k].sum =
          (top - origin + (k == 0 ? 0 : half_step)) * (1 << log2) +
          height * run->first_row + (1 << log2 >> 1);
    }
    origin = (int32_t)run->first_source_row << 12;
  }
}

static inline int32_t next_position(edge_walk* edge, uint32_t log2) {
  const int32_t sum = edge->sum;
  edge->sum = sum + edge->height;
  return sum >> log2;
}

static RG_INLINE void next_row(const rg_run* run, edge_walk edges[4],
                               rg_block_row* row) {
  for (uint32_t c = 0; c < 2; ++c) {
    const int32_t left = next_position(&edges[c], run->block.height_log2);
    const int32_t right = next_position(&edges[2 + c], run->block.height_log2);
    const int32_t step = (right - left) >> run->block.width_log2;
    row->start.q12[c] = left + step * run->first_pixel;
    row->step.q12[c] = step;
  }
}

/* Two pixels a turn; the turns that are left, 16 at most, are counted in the
 * bits above a blended pixel. */
#define ROUNDING ((blended)RG_ROUNDING_8 << (8 * sizeof(blended) - 32))
#define TURN ((blended)1 << (8 * sizeof(blended) - 5))

static RG_INLINE int has_turns(blended rounding) {
  return rounding >> (8 * sizeof(blended) - 1) != 0;
}

/* Where an odd row enters the loop at its middle. */
#define IS_SHORT (!RG_IS_FAST && !RG_KEEP_LINES)

static RG_INLINE void blend_row_1(const rg_run* run, edge_walk edges[4],
                                  uint8_t* out) {
  rg_block_row row;
  next_row(run, edges, &row);
  const uint32_t num_pixels = run->num_pixels;
  blended rounding = ROUNDING - ((num_pixels + 1) >> 1) * TURN;
  row_walk walk;
  start_walk(run, &row, &walk);
  if ((num_pixels & 1) != 0) { /* half a turn */
    if (IS_SHORT) goto second;
    *out++ = (uint8_t)blend_pixel(&walk, rounding);
    step_on(&walk);
    rounding += TURN;
    if (!has_turns(rounding)) return;
  }
  do {
    *out++ = (uint8_t)blend_pixel(&walk, rounding);
    step_on(&walk);
    RG_IN_REGISTER(out);
  second:
    *out++ = (uint8_t)blend_pixel(&walk, rounding);
    step_on(&walk);
    if (IS_SHORT) RG_IN_REGISTER(out);
    rounding += TURN;
  } while (has_turns(rounding));
}

void rg_blend_1(const rg_run* run) {
  if (do_tiles(run, 1, 0)) return;
  uint8_t* out = run->out + run->out_pixel;
  edge_walk edges[4];
  start_edges(run, ORIGIN_X, edges);
  uint32_t rows = run->num_rows;
  do {
    uint8_t* const row = out;
    RG_IN_MEMORY(out);
    RG_IN_MEMORY(rows);
    blend_row_1(run, edges, row);
    RG_IN_MEMORY(run);
    out += run->out_stride;
  } while (--rows != 0);
}

/* ---- Any lattice ----------------------------------------------------------
 */

static RG_SHARED uint32_t mix_samples(uint32_t kind, const rg_neighbors* at,
                                      uint32_t index) {
  return rg_blend_wide(kind, at, index);
}

static RG_SHARED void mix_bytes(const rg_neighbors* at, uint32_t index,
                                uint8_t* out, uint32_t num_channels) {
  do {
    *out++ = (uint8_t)rg_blend_bytes(at->upper + index, at->lower + index,
                                     at->right, at->x_q12, at->y_q12);
    ++index;
  } while (--num_channels != 0);
}

static RG_INLINE uint32_t first_sample_of(const rg_lattice* lattice,
                                          uint32_t pixel) {
  return lattice->first_sample + pixel * lattice->sample_step;
}

void rg_blend_pixel(const rg_lattice* lattice, const rg_neighbors* at,
                    uint8_t* row, uint32_t out_pixel) {
  const uint32_t index = first_sample_of(lattice, at->x_q12 >> 12);
  if (lattice->kind == RG_SAMPLE_8) {
    mix_bytes(at, index, row + first_sample_of(lattice, out_pixel),
              lattice->num_channels);
  } else {
    const uint32_t value = mix_samples(lattice->kind, at, index);
    RG_READ_LATE(lattice);
    rg_put_sample(lattice->kind, row, first_sample_of(lattice, out_pixel),
                  value);
  }
}

/* With all that the compiler knows of the lattice. is_copy: all neighbours are
 * the same one. */
static RG_INLINE void do_pixel(const rg_lattice* lattice, uint32_t kind,
                               uint32_t num_channels, const rg_neighbors* at,
                               int is_copy, uint8_t* row, uint32_t out_pixel) {
  uint32_t index = first_sample_of(lattice, at->x_q12 >> 12);
  uint32_t target = first_sample_of(lattice, out_pixel);
  for (uint32_t c = 0; c < num_channels; ++c, ++index, ++target)
    rg_store_sample(kind, row, target,
                    is_copy ? rg_load_sample(kind, at->upper, index)
                            : rg_blend_samples(kind, at, index));
}

static RG_INLINE void do_rows(const rg_run* run, const rg_lattice* lattice,
                              uint32_t kind, uint32_t num_channels,
                              int is_copy) {
  edge_walk edges[4];
#if RG_IS_FAST
  /* Of its own, which no byte that is stored can be part of. Value by value:
   * some were stored just now, by themselves. */
  rg_run own;
  own.data = run->data;
  own.stride = run->stride;
  own.out_stride = run->out_stride;
  own.out = run->out;
  own.block.width_log2 = run->block.width_log2;
  own.block.height_log2 = run->block.height_log2;
  own.out_pixel = run->out_pixel;
  own.num_rows = run->num_rows;
  own.first_pixel = run->first_pixel;
  own.num_pixels = run->num_pixels;
  start_edges(run, 0, edges);
  run = &own;
#else
  (void)edges;
#endif
  const uint32_t below = is_copy ? 0 : run->stride;
  rg_neighbors at;
  at.right = is_copy ? 0 : lattice->sample_step;
  uint8_t* out = run->out;
  uint32_t r = 0;
  do {
    rg_block_row row;
    if (RG_IS_FAST) {
      next_row(run, edges, &row);
    } else {
      rg_find_block_row(&run->block, run->first_row + r, &row);
      rg_move_to_run(run, &row);
    }
    if (!RG_IS_FAST)
      kind = lattice->kind; /* read late: that takes less stack */
    at.x_q12 =
        (uint32_t)row.start.q12[0] + (is_copy ? 2048 : rg_rounding(kind, 0));
    at.y_q12 =
        (uint32_t)row.start.q12[1] + (is_copy ? 2048 : rg_rounding(kind, 1));
    for (uint32_t k = 0; k < run->num_pixels; ++k) {
      at.upper = run->data + (size_t)(at.y_q12 >> 12) * run->stride;
      at.lower = at.upper + below;
      if (RG_IS_FAST)
        do_pixel(lattice, kind, num_channels, &at, is_copy, out,
                 run->out_pixel + k);
      else
        rg_blend_pixel(lattice, &at, out, run->out_pixel + k);
      at.x_q12 += (uint32_t)row.step.q12[0];
      at.y_q12 += (uint32_t)row.step.q12[1];
    }
    out += run->out_stride;
  } while (++r != run->num_rows);
}

/* With lattice and sampling known to the compiler, where speed matters. */
static RG_SHARED void do_lattice(const rg_run* run, const rg_lattice* lattice,
                                 int is_copy) {
  if (!RG_IS_FAST)
    do_rows(run, lattice, lattice->kind, lattice->num_channels, is_copy);
  else if (lattice->kind == RG_SAMPLE_8)
    do_rows(run, lattice, RG_SAMPLE_8, lattice->num_channels, is_copy);
  else
    do_rows(run, lattice, lattice->kind, 1, is_copy);
}

static const rg_lattice kInterleaved[4] = {
    {RG_SAMPLE_8, 0, 0, 1, 1, {0, 0}, {0, 0}, 0, 1, 0},
    {RG_SAMPLE_8, 0, 0, 2, 2, {0, 0}, {0, 0}, 0, 1, 0},
    {RG_SAMPLE_8, 0, 0, 3, 3, {0, 0}, {0, 0}, 0, 1, 0},
    {RG_SAMPLE_8, 0, 0, 4, 4, {0, 0}, {0, 0}, 0, 1, 0}};

void rg_blend_lattice(const rg_run* run, const rg_lattice* lattice) {
  do_lattice(run, lattice, 0);
}

void rg_blend_2(const rg_run* run) {
  if (!do_tiles(run, 2, 0)) do_lattice(run, &kInterleaved[1], 0);
}

void rg_blend_3(const rg_run* run) {
  if (!do_tiles(run, 3, 0)) do_lattice(run, &kInterleaved[2], 0);
}

void rg_blend_4(const rg_run* run) {
  if (!do_tiles(run, 4, 0)) do_lattice(run, &kInterleaved[3], 0);
}

void rg_copy_lattice(const rg_run* run, const rg_lattice* lattice) {
  if (RG_IS_FAST && lattice->kind == RG_SAMPLE_8 && lattice->sample_step == 1) {
    if (!do_tiles(run, 1, 1)) do_lattice(run, &kInterleaved[0], 1);
  } else {
    do_lattice(run, lattice, 1);
  }
}
