#include "remap_table.h"

#include "bytes.h"

/* (value + 2^(shift - 1)) >> shift */
static int32_t round_shift(int32_t value, int shift) {
  return (value + (INT32_C(1) << (shift - 1))) >> shift;
}

static rg_position vertex(const rg_remap_section* table, uint32_t i,
                          uint32_t j) {
  const uint8_t* residual = table->vertices + 4 * (j * table->columns + i);
  const uint32_t dx = (uint32_t)rg_load_i16(residual);
  const uint32_t dy = (uint32_t)rg_load_i16(residual + 2);
  const uint32_t x =
      (uint32_t)table->origin_x_q12 + i * (uint32_t)table->column_step_x_q12 +
      j * (uint32_t)table->row_step_x_q12 + (dx << table->residual_shift);
  const uint32_t y =
      (uint32_t)table->origin_y_q12 + i * (uint32_t)table->column_step_y_q12 +
      j * (uint32_t)table->row_step_y_q12 + (dy << table->residual_shift);
  const rg_position p = {(int32_t)x, (int32_t)y};
  return p;
}

/* from + (to - from) k / 2^shift. |to - from| < 2^26 and k < 32, so the product
 * fits. */
static rg_position between(rg_position from, rg_position to, int32_t k,
                           int shift) {
  const rg_position p = {
      from.x_q12 + round_shift((to.x_q12 - from.x_q12) * k, shift),
      from.y_q12 + round_shift((to.y_q12 - from.y_q12) * k, shift)};
  return p;
}

void rg_remap_block_row(const rg_remap_section* table, uint32_t i, uint32_t j,
                        uint32_t r, rg_block_row* row) {
  const int shift = table->block_log2;
  const int32_t k = (int32_t)r;
  row->left = between(vertex(table, i, j), vertex(table, i, j + 1), k, shift);
  row->right =
      between(vertex(table, i + 1, j), vertex(table, i + 1, j + 1), k, shift);
  row->step.x_q12 = round_shift(row->right.x_q12 - row->left.x_q12, shift);
  row->step.y_q12 = round_shift(row->right.y_q12 - row->left.y_q12, shift);
}

rg_position rg_remap_segment(const rg_remap_section* table,
                             const rg_block_row* row, uint32_t k) {
  return between(row->left, row->right, (int32_t)k, table->block_log2);
}
