/* The corners of tiles interpolated between two samples of an operating-point
 * model, for the small traversal. */
#include "cortex_m/tile_corners.h"
#include "operating_point_ops.h"

#if !RG_FAST_TRAVERSAL

/* RG_BLEND_STORED() with the rounding term, half a weight, in a register. */
static RG_INLINE int32_t lerp_rounded(int32_t lower, int32_t upper,
                                      int32_t weight, int32_t half) {
  return lower + ((weight * (upper - lower) + half) >> RG_WEIGHT_BITS);
}

/* Interpolates the block's vertices at the operating point into a local copy.
 */
void rg_next_blended_tile(rg_tile_row* tiles, rg_position corners[4],
                          const rg_camera* camera) {
  uint32_t words[4 * RG_BENT_VERTEX_SIZE / 4];
  uint8_t* blended = (uint8_t*)words;
  const int32_t weight = camera->weight_q14;
  int32_t half = RG_HALF_WEIGHT;
  RG_FORGET(half);
  const uint32_t vertex_size = tiles->vertex_size;
  const uint8_t* lower = tiles->block;
  const uint8_t* upper = lower + camera->sample_size;
  for (uint32_t k = 0;;) {
    for (uint32_t at = RG_VERTEX_X; at <= RG_VERTEX_Y; at += 2) {
      const int32_t residual = lerp_rounded(
          rg_load_i16(lower + at), rg_load_i16(upper + at), weight, half);
      rg_store_u16(blended + at, (uint16_t)residual);
    }
    if (vertex_size == RG_BENT_VERTEX_SIZE && k != 0) {
      uint32_t at = RG_VERTEX_VX - 2 * (k & 1);
      const uint32_t end = RG_VERTEX_VX + (k & 2);
      do
        blended[at] = (uint8_t)lerp_rounded((int8_t)lower[at],
                                            (int8_t)upper[at], weight, half);
      while (++at != end);
    }
    blended += vertex_size;
    lower += vertex_size;
    upper += vertex_size;
    if (++k == 4) break;
    if (k == 2) {
      const uint32_t row_rest = tiles->row_size - 2 * vertex_size;
      lower += row_rest;
      upper += row_rest;
    }
  }
  tiles->block = (const uint8_t*)words;
  tiles->row_size = 2 * vertex_size;
  rg_next_tile(tiles, corners);
}

#endif
