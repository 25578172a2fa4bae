#include "remap_table.h"

#include "bytes.h"

/* (value + 2^(shift - 1)) >> shift */
static int32_t round_shift(int32_t value, int shift) {
  return (value + (INT32_C(1) << (shift - 1))) >> shift;
}

/* from + (to - from) k / 2^shift. |to - from| < 2^26 and k < 32, so the product
 * fits. */
static int32_t between(int32_t from, int32_t to, int32_t k, int shift) {
  return from + round_shift((to - from) * k, shift);
}

/* One coordinate, 0 for x and 1 for y, of a vertex. In the section, the second
 * coordinate of every pair lies behind the first. */
static int32_t vertex(const uint8_t* section, uint32_t i, uint32_t j,
                      uint32_t coordinate) {
  const uint8_t* const fields = section + 4 * coordinate;
  const uint32_t index = j * rg_load_u16(section + 4) + i;
  const uint8_t* const residual =
      section + rg_load_u32(section + 76) + 4 * index + 2 * coordinate;
  const uint32_t shift = section[9];
  return (int32_t)(rg_load_u32(fields + 28) + i * rg_load_u32(fields + 36) +
                   j * rg_load_u32(fields + 44) +
                   ((uint32_t)rg_load_i16(residual) << shift));
}

void rg_remap_block(const uint8_t* section, uint32_t i, uint32_t j,
                    rg_block* block) {
  for (uint32_t k = 0; k < 4; ++k)
    for (uint32_t c = 0; c < 2; ++c)
      block->corners[k].q12[c] = vertex(section, i + (k & 1), j + (k >> 1), c);
}

void rg_remap_block_row(const uint8_t* section, const rg_block* block,
                        uint32_t r, rg_block_row* row) {
  const int shift = section[8];
  const rg_position* const corners = block->corners;
  for (int c = 0; c < 2; ++c) {
    const int32_t left =
        between(corners[0].q12[c], corners[2].q12[c], (int32_t)r, shift);
    const int32_t right =
        between(corners[1].q12[c], corners[3].q12[c], (int32_t)r, shift);
    row->left.q12[c] = left;
    row->right.q12[c] = right;
    row->step.q12[c] = round_shift(right - left, shift);
  }
}

rg_position rg_remap_segment(const uint8_t* section, const rg_block_row* row,
                             uint32_t k) {
  rg_position start;
  for (int c = 0; c < 2; ++c)
    start.q12[c] =
        between(row->left.q12[c], row->right.q12[c], (int32_t)k, section[8]);
  return start;
}

void rg_remap_average_rows(const uint8_t* section, const rg_block_row* other,
                           rg_block_row* row) {
  for (uint32_t c = 0; c < 2; ++c) {
    row->left.q12[c] = round_shift(row->left.q12[c] + other->left.q12[c], 1);
    row->right.q12[c] = round_shift(row->right.q12[c] + other->right.q12[c], 1);
    row->step.q12[c] =
        round_shift(row->right.q12[c] - row->left.q12[c], section[8]);
  }
}

int rg_remap_is_empty(const uint8_t* section, uint32_t i, uint32_t j) {
  const uint32_t columns = rg_load_u16(section + 4);
  const uint32_t num_vertices = columns * rg_load_u16(section + 6);
  const uint8_t* const mask =
      section + rg_load_u32(section + 76) + 4 * num_vertices;
  const uint32_t block = j * (columns - 1) + i;
  return (mask[block >> 3] >> (block & 7)) & 1;
}
