/* Source positions of a block's rows, and the portable kernel for grey pixels,
 * which defines the exact results. */
#ifndef RAYGRID_GREY_ROW_H
#define RAYGRID_GREY_ROW_H

#include "fixed_point.h"
#include "kernels/blend.h"
#include "kernels/kernel.h"

/* ---- Edges --------------------------------------------------------------- */

/* x and y of the left edge, then of the right edge, at the current row: four
 * sums, to be shifted right by height_log2, modulo 2^32. The next four are the
 * increments of these sums per row. */
typedef uint32_t rg_edges[8];

/* Starts at the span's first row. edge may be the memory of the corners. */
static RG_INLINE void rg_start_edges(const rg_span* span, const int32_t* corner,
                                     uint32_t* edge) {
  const uint32_t log2 = span->block.height_log2;
  const int32_t* const bottom = corner + 4;
  do {
    const uint32_t top = (uint32_t)*corner;
    const uint32_t height = (uint32_t)corner[4] - top;
    edge[4] = height;
    *edge++ = (top << log2) + height * span->first_row + (1u << log2 >> 1);
  } while (++corner != bottom);
}

/* Computes coordinate c of the next row. */
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

/* Computes the block's next row. */
static RG_INLINE void rg_next_row(const rg_block* block, uint32_t* edges,
                                  rg_block_row* row) {
  rg_next_row_axis(block, edges, 0, row);
  rg_next_row_axis(block, edges, 1, row);
}

/* ---- Grey pixels --------------------------------------------------------- */

/* Advances from one pixel of a row to the next, depending on register width. */
#if defined(__LP64__) || defined(_WIN64)

typedef struct rg_grey_traversal {
  const uint8_t* data;
  uint64_t stride;
  uint64_t position, step; /* x in the upper half */
} rg_grey_traversal;

static RG_INLINE void rg_start_grey_traversal(const rg_span* span,
                                              const rg_block_row* row,
                                              rg_grey_traversal* traversal) {
  traversal->data = span->data;
  traversal->stride = span->stride;
  traversal->position = ((uint64_t)((uint32_t)row->start.q12[0] + 16) << 32) +
                        (uint64_t)(int64_t)row->start.q12[1];
  traversal->step = ((uint64_t)(uint32_t)row->step.q12[0] << 32) +
                    (uint64_t)(int64_t)row->step.q12[1];
}

static RG_INLINE void rg_step_grey_traversal(rg_grey_traversal* traversal) {
  traversal->position += traversal->step;
}

/* h0 (4096 - wy) + h1 wy is the upper half of one product. */
static RG_INLINE uint8_t
rg_blend_grey_pixel(const rg_grey_traversal* traversal) {
  const uint64_t position = traversal->position, stride = traversal->stride;
  const uint8_t* const upper = traversal->data +
                               ((position & UINT32_MAX) >> 12) * stride +
                               (position >> 44);
  const uint64_t bytes = UINT64_C(0x000000ff000000ff);
  const uint64_t pixels =
      rg_load_pair(upper) | (uint64_t)rg_load_pair(upper + stride) << 32;
  const uint64_t left = pixels & bytes, right = (pixels >> 8) & bytes;
  const uint64_t h_q7 = (right - left) * ((position >> 37) & 127) + (left << 7);
  const uint64_t weights =
      (position & 4095) * (1 - (UINT64_C(1) << 32)) + (UINT64_C(4096) << 32);
  return (uint8_t)((h_q7 * weights + ((uint64_t)RG_ROUNDING_8 << 32)) >> 51);
}

#else

typedef struct rg_grey_traversal {
  const uint8_t* data;
  uint32_t stride;
  uint32_t x_q12, y_q12, step_x, step_y;
} rg_grey_traversal;

static RG_INLINE void rg_start_grey_traversal(const rg_span* span,
                                              const rg_block_row* row,
                                              rg_grey_traversal* traversal) {
  traversal->data = span->data;
  traversal->stride = span->stride;
  traversal->x_q12 = (uint32_t)row->start.q12[0] + 16;
  traversal->y_q12 = (uint32_t)row->start.q12[1];
  traversal->step_x = (uint32_t)row->step.q12[0];
  traversal->step_y = (uint32_t)row->step.q12[1];
}

static RG_INLINE void rg_step_grey_traversal(rg_grey_traversal* traversal) {
  traversal->x_q12 += traversal->step_x;
  traversal->y_q12 += traversal->step_y;
}

static RG_INLINE uint8_t
rg_blend_grey_pixel(const rg_grey_traversal* traversal) {
  const uint8_t* const upper = traversal->data +
                               (traversal->y_q12 >> 12) * traversal->stride +
                               (traversal->x_q12 >> 12);
  const uint32_t pixels =
      rg_load_pair(upper) | rg_load_pair(upper + traversal->stride) << 16;
  return (uint8_t)rg_blend_8(rg_even_bytes(pixels), rg_odd_bytes(pixels),
                             (traversal->x_q12 >> 5) & 127,
                             traversal->y_q12 & 4095);
}

#endif

static RG_INLINE void rg_blend_grey_row(const rg_span* span,
                                        const rg_block_row* row, uint8_t* out) {
  rg_grey_traversal traversal;
  rg_start_grey_traversal(span, row, &traversal);
  uint32_t rest = span->num_pixels;
  do {
    *out++ = rg_blend_grey_pixel(&traversal);
    rg_step_grey_traversal(&traversal);
  } while (--rest != 0);
}

#endif /* RAYGRID_GREY_ROW_H */
