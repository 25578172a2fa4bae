/* A tile of output pixels, and the source positions of its pixels:
 * formats/SPEC.md, "Remap arithmetic". All positions are q12 source pixels. */
#ifndef RAYGRID_BLOCK_H
#define RAYGRID_BLOCK_H

#include <stdint.h>

#include "fixed_point.h"

/* A position: x, y. */
typedef struct rg_position {
  int32_t q12[2];
} rg_position;

/* A block, or a tile of one, of 2^width_log2 x 2^height_log2 pixels, with the
 * source positions of its corners: top left, top right, bottom left, right. */
typedef struct rg_block {
  uint8_t width_log2, height_log2;
  rg_position corners[4];
} rg_block;

/* A row of a block: pixel k has the source position start + k step. */
typedef struct rg_block_row {
  rg_position start, step;
} rg_block_row;

/* (value + 2^(shift - 1)) >> shift; the sum modulo 2^32. */
static RG_INLINE int32_t rg_round_shift(uint32_t value, uint32_t shift) {
  return (int32_t)(value + (UINT32_C(1) << shift >> 1)) >> shift;
}

/* from + round((to - from) r / 2^shift), modulo 2^32. */
static RG_INLINE int32_t rg_lerp(int32_t from, int32_t to, uint32_t r,
                                 uint32_t shift) {
  return rg_add(from,
                rg_round_shift(((uint32_t)to - (uint32_t)from) * r, shift));
}

/* Computes coordinate c of row r of a block, r less than its height. Modulo
 * 2^32: malformed tables may overflow. */
static RG_INLINE void rg_compute_row_axis(const rg_block* block, uint32_t r,
                                          int c, rg_block_row* row) {
  const rg_position* const corners = block->corners;
  const int32_t left =
      rg_lerp(corners[0].q12[c], corners[2].q12[c], r, block->height_log2);
  const int32_t right =
      rg_lerp(corners[1].q12[c], corners[3].q12[c], r, block->height_log2);
  row->start.q12[c] = left;
  row->step.q12[c] =
      rg_round_shift((uint32_t)right - (uint32_t)left, block->width_log2);
}

/* Computes row r of a block, inlined. */
static RG_INLINE void rg_compute_row(const rg_block* block, uint32_t r,
                                     rg_block_row* row) {
  rg_compute_row_axis(block, r, 0, row);
  rg_compute_row_axis(block, r, 1, row);
}

#ifdef __cplusplus
extern "C"
#endif
    /* Computes row r of a block, not inlined. */
    void
    rg_compute_block_row(const rg_block* block, uint32_t r, rg_block_row* row);

/* Advances to the position of the next pixel of a row. */
static RG_INLINE void rg_advance_position(const rg_position* step,
                                          rg_position* position) {
  for (int c = 0; c < 2; ++c)
    position->q12[c] = rg_add(position->q12[c], step->q12[c]);
}

/* Returns the position of pixel k of a row, modulo 2^32. */
static RG_INLINE rg_position rg_row_position(const rg_block_row* row,
                                             uint32_t k) {
  rg_position p;
  for (int c = 0; c < 2; ++c)
    p.q12[c] =
        (int32_t)((uint32_t)row->start.q12[c] + k * (uint32_t)row->step.q12[c]);
  return p;
}

#endif /* RAYGRID_BLOCK_H */
