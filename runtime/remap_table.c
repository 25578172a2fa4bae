#include "remap_table.h"

#include "bytes.h"

/* The next vertex above (0) or below (1): origin + i column_step + j row_step +
 * residual << shift. */
static rg_position next_vertex(rg_block_walk* walk, uint32_t k) {
  const uint8_t* const residual = walk->residuals[k];
  walk->residuals[k] = residual + 4;
  rg_position p;
  for (int c = 0; c < 2; ++c) {
    const int32_t affine = walk->affine[k].q12[c];
    p.q12[c] =
        affine + rg_load_i16(residual + 2 * c) * (1 << walk->residual_shift);
    walk->affine[k].q12[c] =
        (int32_t)((uint32_t)affine + (uint32_t)walk->column_step.q12[c]);
  }
  return p;
}

void rg_start_walk(const uint8_t* section, uint32_t j, rg_block_walk* walk) {
  const uint32_t row_bytes = 4u * rg_load_u16(section + 4);
  walk->residual_shift = section[9];
  walk->block_log2 = section[8];
  for (uint32_t k = 0; k < 2; ++k, ++j) {
    walk->residuals[k] = section + rg_load_u32(section + 76) + j * row_bytes;
    /* The second coordinate of every pair lies behind the first. */
    for (uint32_t c = 0; c < 2; ++c)
      walk->affine[k].q12[c] = (int32_t)(rg_load_u32(section + 28 + 4 * c) +
                                         j * rg_load_u32(section + 44 + 4 * c));
  }
  for (int c = 0; c < 2; ++c)
    walk->column_step.q12[c] = rg_load_i32(section + 36 + 4 * c);
  for (uint32_t k = 0; k < 2; ++k) walk->last[k] = next_vertex(walk, k);
}

void rg_next_block(rg_block_walk* walk, rg_block* block) {
  for (uint32_t k = 0; k < 2; ++k) {
    block->corners[2 * k] = walk->last[k];
    block->corners[2 * k + 1] = walk->last[k] = next_vertex(walk, k);
  }
  block->width_log2 = block->height_log2 = walk->block_log2;
}

int rg_remap_is_empty(const uint8_t* section, uint32_t i, uint32_t j) {
  const uint32_t columns = rg_load_u16(section + 4);
  const uint32_t num_vertices = columns * rg_load_u16(section + 6);
  const uint8_t* const mask =
      section + rg_load_u32(section + 76) + 4 * num_vertices;
  const uint32_t block = j * (columns - 1) + i;
  return (mask[block >> 3] >> (block & 7)) & 1;
}
