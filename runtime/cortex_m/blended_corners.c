/* The corners of parts between two knots of a stack, for the small walk. */
#include "cortex_m/part_corners.h"
#include "stack_code.h"

#if !RG_FAST_WALK

/* RG_BLEND_STORED() in an order that takes fewer instructions here. */
static RG_INLINE int32_t blend_stored(int32_t lower, int32_t upper,
                                      int32_t weight) {
  return (lower * ((1 << RG_WEIGHT_BITS) - weight) + upper * weight +
          RG_HALF_WEIGHT) >>
         RG_WEIGHT_BITS;
}

/* The residual so many bytes from a vertex's first one. */
static RG_INLINE void blend_residual(uint32_t at, const uint8_t* lower,
                                     const uint8_t* upper, int32_t weight,
                                     uint8_t* blended) {
  const int32_t residual =
      blend_stored(rg_load_i16(lower + at), rg_load_i16(upper + at), weight);
  rg_store_u16(blended + at, (uint16_t)residual);
}

/* The two bends so many bytes from a vertex's first one. */
static RG_INLINE void blend_bends(uint32_t at, const uint8_t* lower,
                                  const uint8_t* upper, int32_t weight,
                                  uint8_t* blended) {
  for (uint32_t k = at; k < at + 2; ++k)
    blended[k] =
        (uint8_t)blend_stored((int8_t)lower[k], (int8_t)upper[k], weight);
}

/* From a copy of the block's vertices, at the condition. */
void rg_pass_blended_part(const rg_camera* camera, rg_part_row* parts,
                          rg_position corners[4]) {
  uint32_t words[4 * RG_BENT_VERTEX_SIZE / 4];
  uint8_t* blended = (uint8_t*)words;
  const int32_t weight = camera->weight_q14;
  const uint32_t vertex_size = parts->vertex_size;
  const uint8_t* lower = parts->block;
  for (uint32_t k = 0;;) {
    const uint8_t* const upper = lower + camera->knot_size;
    blend_residual(RG_VERTEX_X, lower, upper, weight, blended);
    blend_residual(RG_VERTEX_Y, lower, upper, weight, blended);
    if (vertex_size == RG_BENT_VERTEX_SIZE) {
      /* Edges that lead to the vertex from others of the block */
      if ((k & 1) != 0)
        blend_bends(RG_VERTEX_HX, lower, upper, weight, blended);
      if ((k & 2) != 0)
        blend_bends(RG_VERTEX_VX, lower, upper, weight, blended);
    }
    lower += vertex_size;
    blended += vertex_size;
    if (++k == 4) break;
    if (k == 2) lower += parts->row_size - 2 * vertex_size;
  }
  parts->block = (const uint8_t*)words;
  parts->row_size = 2 * vertex_size;
  rg_pass_part(parts, corners);
}

#endif
