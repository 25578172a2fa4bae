/* The corners of parts between two knots of a stack, for the small walk. */
#include "cortex_m/part_corners.h"
#include "stack_code.h"

#if !RG_FAST_WALK

/* The vertices of a block and its mask, behind the fields of a table. */
#define BLOCK_TABLE_SIZE (RG_REMAP_FIELDS_SIZE + 4 * RG_BENT_VERTEX_SIZE + 4)

/* RG_BLEND_STORED() in an order that takes fewer instructions here. */
static RG_INLINE int32_t blend_stored(int32_t lower, int32_t upper,
                                      int32_t weight) {
  return (lower * (1 << RG_WEIGHT_BITS) + RG_HALF_WEIGHT +
          weight * (upper - lower)) >>
         RG_WEIGHT_BITS;
}

/* The number so many bytes from a vertex's first one. */
static RG_INLINE void blend_residual(uint32_t k, const uint8_t* lower,
                                     const uint8_t* upper, int32_t weight,
                                     uint8_t* blended) {
  rg_store_u16(blended + k,
               (uint16_t)blend_stored(rg_load_i16(lower + k),
                                      rg_load_i16(upper + k), weight));
}

static RG_INLINE void blend_bend(uint32_t k, const uint8_t* lower,
                                 const uint8_t* upper, int32_t weight,
                                 uint8_t* blended) {
  blended[k] =
      (uint8_t)blend_stored((int8_t)lower[k], (int8_t)upper[k], weight);
}

/* By a table of the one block that the part is in, at the condition. */
void rg_next_blended_corners(const rg_camera* camera, rg_part_row* parts,
                             rg_position corners[4]) {
  uint32_t words[BLOCK_TABLE_SIZE / 4];
  uint8_t* const table = (uint8_t*)words;
  const uint8_t* const section = parts->section;
  const uint32_t i = parts->spans[0].before >> 16;
  const uint32_t j = parts->spans[1].before >> 16;
  const uint32_t columns = rg_load_u16(section + RG_REMAP_COLUMNS);
  const uint32_t vertex_size = rg_vertex_size(section);
  const uint8_t* const data =
      section + rg_load_u32(section + RG_REMAP_DATA_OFFSET);
  for (uint32_t c = 0; c < 8; c += 4) {
    const uint32_t column_step =
        rg_load_u32(section + RG_REMAP_COLUMN_STEP + c);
    const uint32_t row_step = rg_load_u32(section + RG_REMAP_ROW_STEP + c);
    rg_store_u32(table + RG_REMAP_COLUMN_STEP + c, column_step);
    rg_store_u32(table + RG_REMAP_ROW_STEP + c, row_step);
    rg_store_u32(table + RG_REMAP_ORIGIN + c,
                 rg_load_u32(section + RG_REMAP_ORIGIN + c) + i * column_step +
                     j * row_step);
  }
  rg_store_u32(table + RG_REMAP_BLOCK_LOG2,
               rg_load_u32(section + RG_REMAP_BLOCK_LOG2));
  rg_store_u32(table + RG_REMAP_COLUMNS, 0x20002);
  rg_store_u32(table + RG_REMAP_DATA_OFFSET, RG_REMAP_FIELDS_SIZE);

  const int32_t weight = camera->weight_q14;
  const uint32_t knot_size = camera->knot_size;
  const uint8_t* lower = data + (j * columns + i) * vertex_size;
  uint8_t* blended = table + RG_REMAP_FIELDS_SIZE;
  uint32_t k = 0;
  for (;;) {
    const uint8_t* const upper = lower + knot_size;
    blend_residual(RG_VERTEX_X, lower, upper, weight, blended);
    blend_residual(RG_VERTEX_Y, lower, upper, weight, blended);
    if (vertex_size == RG_BENT_VERTEX_SIZE) {
      /* Edges that lead to the vertex from others of the block */
      if ((k & 1) != 0) {
        blend_bend(RG_VERTEX_HX, lower, upper, weight, blended);
        blend_bend(RG_VERTEX_HY, lower, upper, weight, blended);
      }
      if (k >= 2) {
        blend_bend(RG_VERTEX_VX, lower, upper, weight, blended);
        blend_bend(RG_VERTEX_VY, lower, upper, weight, blended);
      }
    }
    lower += vertex_size;
    blended += vertex_size;
    if (k == 1) lower += (columns - 2) * vertex_size;
    if (++k == 4) break;
  }
  const uint32_t mark = j * (columns - 1) + i;
  const uint8_t* const marks =
      data + rg_load_u16(section + RG_REMAP_ROWS) * columns * vertex_size;
  rg_store_u32(blended, (uint32_t)marks[mark >> 3] >> (mark & 7));

  /* The block is the table's only one. */
  parts->section = table;
  parts->spans[0].before = (uint16_t)parts->spans[0].before;
  parts->spans[1].before = (uint16_t)parts->spans[1].before;
  rg_next_corners(parts, corners);
  parts->section = section;
  parts->spans[0].before += i << 16;
  parts->spans[1].before += j << 16;
}

#endif
