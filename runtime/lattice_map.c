#include "lattice_map.h"

/* Moves the corners by (half[0], half[1]) half pixels of the output, along the
 * edges that meet in each, and from image to lattice coordinates. */
void rg_lattice_block(const rg_lattice* lattice, rg_block* block) {
  if ((lattice->log2[0] | lattice->log2[1]) == 0) return; /* image pixels */
  const uint32_t shift = block->width_log2 + 1u;
  for (int c = 0; c < 2; ++c) {
    int32_t from[4];
    for (uint32_t k = 0; k < 4; ++k) from[k] = block->corners[k].q12[c];
    for (uint32_t k = 0; k < 4; ++k) {
      const int32_t across = (from[k | 1] - from[k & 2]) * lattice->half[0];
      const int32_t down = (from[k | 2] - from[k & 1]) * lattice->half[1];
      block->corners[k].q12[c] = rg_to_lattice(
          lattice, c, from[k] + rg_round_shift(across + down, shift), 1);
    }
  }
  block->width_log2 = (uint8_t)(block->width_log2 - lattice->log2[0]);
  block->height_log2 = (uint8_t)(block->height_log2 - lattice->log2[1]);
}
