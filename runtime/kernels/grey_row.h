/* Rows of a block: where their pixels come from, and the kernel for grey pixels
 * that defines the others' bits. */
#ifndef RAYGRID_GREY_ROW_H
#define RAYGRID_GREY_ROW_H

#include "fixed_point.h"
#include "kernels/blend.h"
#include "kernels/kernel.h"

/* ---- Edges --------------------------------------------------------------- */

/* x and y of the left edge, and of the right one, row by row: four sums >>
 * height_log2, modulo 2^32; and behind them, four heights that these change by.
 */
typedef uint32_t rg_edges[8];

/* edges may be the corners themselves. */
static RG_INLINE void rg_start_edges(const rg_run* run, const int32_t* corner,
                                     uint32_t* edge) {
  const uint32_t log2 = run->block.height_log2;
  const int32_t* const bottom = corner + 4;
  do {
    const uint32_t top = (uint32_t)*corner;
    const uint32_t height = (uint32_t)corner[4] - top;
    edge[4] = height;
    *edge++ = (top << log2) + height * run->first_row + (1u << log2 >> 1);
  } while (++corner != bottom);
}

/* Coordinate c of the next row. */
static RG_INLINE void rg_next_row_axis(const rg_block* block, uint32_t* edges,
                                       int c, rg_block_row* row) {
  const uint32_t left = edges[c], right = edges[2 + c];
  edges[c] = left + edges[4 + c];
  edges[2 + c] = right + edges[6 + c];
  const int32_t start = (int32_t)left >> block->height_log2;
  const int32_t end = (int32_t)right >> block->height_log2;
  row->start.q12[c] = start;
  row->step.q12[c] =
      rg_round_shift((uint32_t)end - (uint32_t)start, block->width_log2);
}

/* The block's next row. */
static RG_INLINE void rg_next_row(const rg_block* block, uint32_t* edges,
                                  rg_block_row* row) {
  rg_next_row_axis(block, edges, 0, row);
  rg_next_row_axis(block, edges, 1, row);
}

/* ---- Grey pixels --------------------------------------------------------- */

/* From one pixel of a row to the next: three ways, by what registers hold. */
#if RG_HAVE_SIMD32

/* x is mirrored, 4095 - (x + 16): its fraction is the left samples' weight
 * less one. */
#define RG_MIRROR UINT32_C(4079)

typedef uint32_t rg_blended;
typedef struct rg_grey_walk {
  const uint8_t* data;
  uint32_t stride;
  uint32_t x_q12, y_q12, step_x, step_y;
  uint32_t factor, one, apart; /* constants */
} rg_grey_walk;

static RG_INLINE void rg_start_grey_walk(const rg_run* run,
                                         const rg_block_row* row,
                                         rg_grey_walk* walk) {
  walk->data = run->data;
  walk->stride = run->stride;
  walk->x_q12 = RG_MIRROR - (uint32_t)row->start.q12[0];
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

static RG_INLINE void rg_step_grey_walk(rg_grey_walk* walk) {
  walk->x_q12 += walk->step_x;
  walk->y_q12 += walk->step_y;
  RG_IN_REGISTER(walk->x_q12); /* else more sums than two */
  RG_IN_REGISTER(walk->y_q12);
}

static RG_INLINE uint32_t rg_blend_grey_pixel(const rg_grey_walk* walk,
                                              rg_blended rounding) {
  const uint8_t* upper = walk->data + (walk->y_q12 >> 12) * walk->stride;
  RG_IN_REGISTER(upper); /* likewise */
  upper -= (int32_t)walk->x_q12 >> 12;
  RG_IN_REGISTER(upper);
  const uint32_t pixels =
      rg_load_pair(upper) | rg_load_pair(upper + walk->stride) << 16;
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

typedef uint64_t rg_blended; /* in the upper half */
typedef struct rg_grey_walk {
  const uint8_t* data;
  uint64_t stride;
  uint64_t position, step; /* x in the upper half */
  uint64_t factor;         /* 1 - 2^32 */
} rg_grey_walk;

static RG_INLINE void rg_start_grey_walk(const rg_run* run,
                                         const rg_block_row* row,
                                         rg_grey_walk* walk) {
  walk->data = run->data;
  walk->stride = run->stride;
  walk->position = ((uint64_t)((uint32_t)row->start.q12[0] + 16) << 32) +
                   (uint64_t)(int64_t)row->start.q12[1];
  walk->step = ((uint64_t)(uint32_t)row->step.q12[0] << 32) +
               (uint64_t)(int64_t)row->step.q12[1];
  walk->factor = 1 - (UINT64_C(1) << 32);
  RG_IN_REGISTER(walk->factor);
}

static RG_INLINE void rg_step_grey_walk(rg_grey_walk* walk) {
  walk->position += walk->step;
}

/* h0 (4096 - wy) + h1 wy is the upper half of one product. */
static RG_INLINE uint64_t rg_blend_grey_pixel(const rg_grey_walk* walk,
                                              rg_blended rounding) {
  const uint64_t position = walk->position, stride = walk->stride;
  const uint8_t* const upper =
      walk->data + ((position & UINT32_MAX) >> 12) * stride + (position >> 44);
  const uint64_t bytes = UINT64_C(0x000000ff000000ff);
  const uint64_t pixels =
      rg_load_pair(upper) | (uint64_t)rg_load_pair(upper + stride) << 32;
  const uint64_t left = pixels & bytes, right = (pixels >> 8) & bytes;
  const uint64_t h_q7 = (right - left) * ((position >> 37) & 127) + (left << 7);
  const uint64_t weights =
      (position & 4095) * walk->factor + (UINT64_C(4096) << 32);
  return (h_q7 * weights + rounding) >> 51;
}

#else

typedef uint32_t rg_blended;
typedef struct rg_grey_walk {
  const uint8_t* data;
  uint32_t stride;
  uint32_t x_q12, y_q12, step_x, step_y;
} rg_grey_walk;

static RG_INLINE void rg_start_grey_walk(const rg_run* run,
                                         const rg_block_row* row,
                                         rg_grey_walk* walk) {
  walk->data = run->data;
  walk->stride = run->stride;
  walk->x_q12 = (uint32_t)row->start.q12[0] + 16;
  walk->y_q12 = (uint32_t)row->start.q12[1];
  walk->step_x = (uint32_t)row->step.q12[0];
  walk->step_y = (uint32_t)row->step.q12[1];
}

static RG_INLINE void rg_step_grey_walk(rg_grey_walk* walk) {
  walk->x_q12 += walk->step_x;
  walk->y_q12 += walk->step_y;
  RG_IN_REGISTER(walk->x_q12); /* else more sums than two */
  RG_IN_REGISTER(walk->y_q12);
}

static RG_INLINE uint32_t rg_blend_grey_pixel(const rg_grey_walk* walk,
                                              rg_blended rounding) {
  const uint8_t* const upper =
      walk->data + (walk->y_q12 >> 12) * walk->stride + (walk->x_q12 >> 12);
  const uint32_t pixels =
      rg_load_pair(upper) | rg_load_pair(upper + walk->stride) << 16;
  return rg_blend_8(rg_even_bytes(pixels), rg_odd_bytes(pixels),
                    (walk->x_q12 >> 5) & 127, walk->y_q12 & 4095, rounding);
}

#endif

/* Two pixels a turn; the turns that are left, 16 at most, are counted in the
 * bits above a blended pixel. */
#define RG_GREY_ROUNDING \
  ((rg_blended)RG_ROUNDING_8 << (8 * sizeof(rg_blended) - 32))
#define RG_TURN ((rg_blended)1 << (8 * sizeof(rg_blended) - 5))

static RG_INLINE int rg_has_turns(rg_blended rounding) {
  return rounding >> (8 * sizeof(rg_blended) - 1) != 0;
}

/* Whether an odd row enters the loop at its middle. */
#define RG_ENTERS_LOOP (!RG_IS_FAST && !RG_FAST_WALK)

/* The rounding that a row of so many pixels begins with. */
static RG_INLINE rg_blended rg_rounding_of(uint32_t num_pixels) {
  return RG_GREY_ROUNDING - ((num_pixels + 1) >> 1) * RG_TURN;
}

static RG_INLINE void rg_blend_grey_row(const rg_run* run,
                                        const rg_block_row* row,
                                        rg_blended rounding, uint8_t* out) {
  const uint32_t num_pixels = run->num_pixels;
  rg_grey_walk walk;
  rg_start_grey_walk(run, row, &walk);
  if ((num_pixels & 1) != 0) { /* half a turn */
    if (RG_ENTERS_LOOP) goto second;
    *out++ = (uint8_t)rg_blend_grey_pixel(&walk, rounding);
    rg_step_grey_walk(&walk);
    rounding += RG_TURN;
    if (!rg_has_turns(rounding)) return;
  }
  do {
    *out++ = (uint8_t)rg_blend_grey_pixel(&walk, rounding);
    rg_step_grey_walk(&walk);
    RG_IN_REGISTER(out);
  second:
    *out++ = (uint8_t)rg_blend_grey_pixel(&walk, rounding);
    rg_step_grey_walk(&walk);
    if (RG_ENTERS_LOOP) RG_IN_REGISTER(out);
    rounding += RG_TURN;
  } while (rg_has_turns(rounding));
}

#endif /* RAYGRID_GREY_ROW_H */
