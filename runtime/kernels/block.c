#include "kernels/block.h"

void rg_compute_block_row(const rg_block* block, uint32_t r,
                          rg_block_row* row) {
  int end = 2;
  RG_FORGET(end); /* prevents unrolling */
  int c = 0;
  do {
    rg_compute_row_axis(block, r, c, row);
  } while (++c != end);
}
