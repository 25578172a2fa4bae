/* The corners of parts between two knots of a stack, for the small walk. */
#include "cortex_m/part_corners.h"
#include "stack_code.h"

#if !RG_FAST_WALK

/* The vertices of a block and its mask, behind the fields of a table. */
#define BLOCK_TABLE_SIZE (RG_REMAP_FIELDS_SIZE + 4 * RG_BENT_VERTEX_SIZE + 4)

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
  for (uint32_t k = RG_REMAP_ORIGIN; k != RG_REMAP_FX; k += 4)
    rg_store_u32(table + k, rg_load_u32(section + k));
  for (uint8_t* origin = table + RG_REMAP_ORIGIN;
       origin != table + RG_REMAP_COLUMN_STEP; origin += 4)
    rg_store_u32(
        origin,
        rg_load_u32(origin) +
            i * rg_load_u32(origin + RG_REMAP_COLUMN_STEP - RG_REMAP_ORIGIN) +
            j * rg_load_u32(origin + RG_REMAP_ROW_STEP - RG_REMAP_ORIGIN));
  rg_store_u32(table + RG_REMAP_BLOCK_LOG2,
               rg_load_u32(section + RG_REMAP_BLOCK_LOG2));
  rg_store_u32(table + RG_REMAP_COLUMNS, 0x20002);
  rg_store_u32(table + RG_REMAP_DATA_OFFSET, RG_REMAP_FIELDS_SIZE);

  const int32_t weight = camera->weight_q14;
  const uint32_t knot_size = camera->knot_size;
  const uint8_t* lower = data + (j * columns + i) * vertex_size;
  uint8_t* blended = table + RG_REMAP_FIELDS_SIZE;
  for (uint32_t k = 0; k < 4; ++k) {
    for (uint32_t n = 0; n < 4; n += 2)
      rg_store_u16(blended + n,
                   (uint16_t)RG_BLEND_STORED(rg_load_i16(lower + n),
                                             rg_load_i16(lower + n + knot_size),
                                             weight));
    if (vertex_size == RG_BENT_VERTEX_SIZE)
      /* Edges that lead to the vertex from others of the block */
      for (uint32_t n = 6 - 2 * (k & 1); n != 6 + (k & 2); ++n)
        blended[n] = (uint8_t)RG_BLEND_STORED(
            (int8_t)lower[n], (int8_t)lower[n + knot_size], weight);
    lower += vertex_size;
    if (k == 1) lower += (columns - 2) * vertex_size;
    blended += vertex_size;
  }
  const uint32_t mark = j * (columns - 1) + i;
  const uint8_t* const marks =
      data + rg_load_u16(section + RG_REMAP_ROWS) * columns * vertex_size;
  rg_store_u32(blended, (uint32_t)marks[mark >> 3] >> (mark & 7));

  /* Field by field, as compilers may call memcpy() for a whole structure. */
  rg_part_row part;
  part.section = table;
  part.bend_shift = parts->bend_shift;
  part.num_log2 = parts->num_log2;
  for (int c = 0; c < 2; ++c) {
    part.spans[c].before = (uint16_t)parts->spans[c].before;
    part.spans[c].size = parts->spans[c].size;
  }
  rg_next_corners(&part, corners);
  parts->is_empty = part.is_empty;
  parts->spans[0].before += parts->spans[0].size;
}

#endif
