#include "remap_table.h"

#include "bytes.h"

/* Vertex (i, j): origin + i column_step + j row_step + residual << shift. In
 * the section, the second coordinate of every pair lies behind the first. */
static rg_position vertex(const uint8_t* section, uint32_t i, uint32_t j) {
  const uint32_t index = j * rg_load_u16(section + 4) + i;
  const uint8_t* residual = section + rg_load_u32(section + 76) + 4 * index;
  const uint32_t shift = section[9];
  rg_position p;
  for (int c = 0; c < 2; ++c, section += 4, residual += 2)
    p.q12[c] =
        (int32_t)(rg_load_u32(section + 28) + i * rg_load_u32(section + 36) +
                  j * rg_load_u32(section + 44) +
                  ((uint32_t)rg_load_i16(residual) << shift));
  return p;
}

void rg_remap_block(const uint8_t* section, uint32_t i, uint32_t j,
                    rg_block* block) {
  for (uint32_t k = 0; k < 4; ++k)
    block->corners[k] = vertex(section, i + (k & 1), j + (k >> 1));
  block->width_log2 = block->height_log2 = section[8];
}

int rg_remap_is_empty(const uint8_t* section, uint32_t i, uint32_t j) {
  const uint32_t columns = rg_load_u16(section + 4);
  const uint32_t num_vertices = columns * rg_load_u16(section + 6);
  const uint8_t* const mask =
      section + rg_load_u32(section + 76) + 4 * num_vertices;
  const uint32_t block = j * (columns - 1) + i;
  return (mask[block >> 3] >> (block & 7)) & 1;
}
