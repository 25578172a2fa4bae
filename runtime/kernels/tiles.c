/* The portable kernels' results for tiles of 8 x 8 pixels, in loops over whole
 * tiles that GCC vectorizes; clang 14 vectorizes few of them, which is slower
 * than pixel by pixel. Lanes are a tile's rows, so that a single addition
 * advances to the next column. Source positions have 16 bits, relative to a
 * nearby pixel. */
#include "kernels/tiles.h"

#include <stddef.h>

#if RG_HAS_TILES

/* Two adjacent bytes, the left one in the low byte. */
static inline uint32_t load_pair(const uint8_t* p) {
  return p[0] | (uint32_t)p[1] << 8;
}

#define TILE 8
#define TILE_PIXELS (TILE * TILE)

/* x, y of a row's start and of its end, times the height of the block,
 * including the rounding term and, for ends, also that of a step; and their
 * increments to the next row. */
typedef struct tile_edges {
  int32_t sums[4], heights[4];
  uint32_t width_log2, height_log2;
} tile_edges;

static RG_INLINE void start_tile_edges(const rg_span* span, int32_t bias_x,
                                       int32_t bias_y, tile_edges* edges) {
  const uint32_t log2 = span->block.height_log2;
  const int32_t half_step = INT32_C(1) << span->block.width_log2 >> 1;
  const int32_t first_row = span->first_row, half = INT32_C(1) << log2 >> 1;
  const int32_t y = bias_y - ((int32_t)span->first_source_row << 12);
  const int32_t bias[4] = {bias_x, y, bias_x + half_step, y + half_step};
  int32_t upper[4], lower[4];
  memcpy(upper, span->block.corners, sizeof(upper));
  memcpy(lower, span->block.corners + 2, sizeof(lower));
  for (uint32_t k = 0; k < 4; ++k) {
    edges->heights[k] = lower[k] - upper[k];
    edges->sums[k] = (upper[k] + bias[k]) * (1 << log2) +
                     (lower[k] - upper[k]) * first_row + half;
  }
  edges->width_log2 = span->block.width_log2;
  edges->height_log2 = log2;
}

/* One coordinate of the rows' starts and steps, modulo 2^16; in full precision
 * for the first row. */
typedef struct tile_rows {
  uint16_t start[TILE], step[TILE];
  int32_t first_start, first_step;
} tile_rows;

static RG_INLINE void compute_tile_rows(const tile_edges* edges, int c,
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

/* Advances to the next tile on the right. */
static RG_INLINE void go_right(tile_rows* rows) {
  for (uint32_t r = 0; r < TILE; ++r)
    rows->start[r] = (uint16_t)(rows->start[r] + TILE * rows->step[r]);
  rows->first_start += TILE * rows->first_step;
}

/* A margin larger than the effect of rounding on a tile's pixels. */
#define TILE_MARGIN 64

/* Whether a span consists of tiles whose source positions fit into 16 bits, and
 * with 1 or 2 channels their byte offsets as well. reach: the maximum distance,
 * in q12, of the tile's sources before that of its first pixel. */
static RG_INLINE int compute_reach(const rg_span* span, uint32_t channels,
                                   int32_t reach[2]) {
  const rg_position* const corners = span->block.corners;
  uint32_t pixels[2];
  if (span->first_pixel != 0 || span->stride > UINT16_MAX ||
      ((span->num_pixels | span->num_rows) & (TILE - 1)) != 0)
    return 0;
  for (int c = 0; c < 2; ++c) {
    const int32_t width = corners[1].q12[c] - corners[0].q12[c];
    const int32_t height = corners[2].q12[c] - corners[0].q12[c];
    const int32_t lower_width = corners[3].q12[c] - corners[2].q12[c];
    const int32_t across = (width >> span->block.width_log2) * (TILE - 1);
    const int32_t down = (height >> span->block.height_log2) * (TILE - 1);
    /* The edges of any tile differ from these by less than those of the block
     * do. */
    const uint32_t slack = rg_magnitude(lower_width - width) + TILE_MARGIN;
    const uint32_t extent =
        rg_magnitude(across) + rg_magnitude(down) + 2 * slack + 4095;
    if (extent > UINT16_MAX) return 0;
    pixels[c] = extent >> 12;
    reach[c] =
        (int32_t)slack - (across < 0 ? across : 0) - (down < 0 ? down : 0);
  }
  return channels > 2 ||
         pixels[1] * span->stride + pixels[0] * channels <= UINT16_MAX;
}

/* The pixel, or row, that a tile's source positions are relative to. */
static inline uint32_t compute_origin(const tile_rows* rows, int32_t reach) {
  const int32_t first = rows->first_start - reach;
  return first < 0 ? 0 : (uint32_t)first >> 12;
}

/* Source positions relative to the origin; byte offsets for 1 or 2 channels,
 * and for more channels. */
typedef struct tile {
  uint16_t x_q12[TILE_PIXELS], y_q12[TILE_PIXELS];
  uint16_t offsets[TILE_PIXELS];
  uint32_t far_offsets[TILE_PIXELS];
} tile;

static RG_INLINE void compute_tile(const tile_rows* x, const tile_rows* y,
                                   uint32_t column, uint32_t row,
                                   uint32_t stride, uint32_t channels,
                                   tile* t) {
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

static RG_INLINE size_t get_offset(const tile* t, uint32_t i,
                                   uint32_t channels) {
  return channels <= 2 ? t->offsets[i] : t->far_offsets[i];
}

/* Planar values of a tile's pixels: channels, or words. */
typedef uint16_t tile_planes[4][TILE_PIXELS];

/* Loads two adjacent bytes of the upper and of the lower row for each pixel. */
static RG_INLINE void load_words(const tile* t, const uint8_t* upper,
                                 size_t stride, uint32_t channels,
                                 uint16_t* upper_words, uint16_t* lower_words) {
  const uint8_t* const lower = upper + stride;
  for (uint32_t i = 0; i < TILE_PIXELS; ++i) {
    const size_t offset = get_offset(t, i, channels);
    upper_words[i] = (uint16_t)load_pair(upper + offset);
    lower_words[i] = (uint16_t)load_pair(lower + offset);
  }
}

/* rg_blend_8() with 16-bit lanes. */
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
  /* The product in two halves; the low half is a multiple of 8. */
  const uint16_t high = (uint16_t)(((int32_t)down_q7 * wy_q15) >> 16);
  const uint16_t low = (uint16_t)((uint16_t)down_q7 * (uint32_t)wy_q15);
  const uint16_t rounded = (uint16_t)((low >> 3) + 2047) >> 12;
  return (uint16_t)(upper_q7 + 64 + 2 * high + rounded) >> 7;
}

/* Byte k of the bytes loaded for pixel i. */
static RG_INLINE uint32_t get_byte(tile_planes words, uint32_t k, uint32_t i) {
  return (k & 1) != 0 ? words[k >> 1][i] >> 8 : words[k >> 1][i] & 255;
}

static RG_INLINE void blend_channel(const tile* t, tile_planes upper,
                                    tile_planes lower, uint32_t channels,
                                    uint32_t c, uint16_t* out) {
  for (uint32_t i = 0; i < TILE_PIXELS; ++i)
    out[i] = blend_lane(get_byte(upper, c, i), get_byte(upper, c + channels, i),
                        get_byte(lower, c, i), get_byte(lower, c + channels, i),
                        t->x_q12[i], t->y_q12[i]);
}

/* Byte k of each of the tile's rows. */
static RG_INLINE const uint16_t* byte_lanes(tile_planes values,
                                            uint32_t channels, uint32_t k) {
  return values[k % channels] + k / channels * TILE;
}

/* Stores four bytes at once: processors with these vectors are little-endian.
 */
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
    _Pragma("GCC unroll 8") for (uint32_t k = 0; k < TILE; ++k) {
      const uint8_t* const from = data + get_offset(t, k * TILE + r, channels);
      for (uint32_t c = 0; c < channels; ++c) out[k * channels + c] = from[c];
    }
}

/* Returns whether the span was processed. */
static RG_INLINE int process_tiles(const rg_span* span, uint32_t channels,
                                   int is_copy) {
  int32_t reach[2];
  if (!compute_reach(span, channels, reach)) return 0;
  const uint8_t* const data = span->data;
  const uint32_t stride = span->stride, num_pixels = span->num_pixels;
  const size_t out_stride = span->out_stride;
  uint8_t* out = span->out + span->out_pixel * channels;
  tile_edges edges;
  start_tile_edges(span, is_copy ? 2048 : 16, is_copy ? 2048 : 0, &edges);
  for (uint32_t rows = span->num_rows; rows != 0; rows -= TILE) {
    tile_rows x, y;
    compute_tile_rows(&edges, 0, &x);
    compute_tile_rows(&edges, 1, &y);
    for (uint32_t k = 0; k < num_pixels; k += TILE) {
      const uint32_t column = compute_origin(&x, reach[0]);
      const uint32_t row = compute_origin(&y, reach[1]);
      const uint8_t* const from =
          data + (size_t)row * stride + (size_t)column * channels;
      tile t;
      compute_tile(&x, &y, column, row, stride, channels, &t);
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

int rg_blend_tiles(const rg_span* span, uint32_t channels) {
  if (channels == 1) return process_tiles(span, 1, 0);
  if (channels == 2) return process_tiles(span, 2, 0);
  if (channels == 3) return process_tiles(span, 3, 0);
  return process_tiles(span, 4, 0);
}

int rg_copy_tiles(const rg_span* span) { return process_tiles(span, 1, 1); }

#endif
