#include "lattice_map.h"

/* Moves the corners by (half[0], half[1]) half pixels of the output, along the
 * edges that meet in each, and from image to lattice coordinates. */
void rg_lattice_block(const rg_lattice* lattice, rg_block* block) {
  if ((lattice->log2[0] | lattice->log2[1]) == 0) return; /* image pixels */
  const uint32_t shift = block->width_log2 + 1u;
  for (int c = 0; c < 2; ++c) {
    rg_position* corner = block->corners;
    const int32_t half_y = lattice->half[1];
    const int32_t left = (corner[2].q12[c] - corner[0].q12[c]) * half_y;
    const int32_t right = (corner[3].q12[c] - corner[1].q12[c]) * half_y;
    for (int k = 0; k < 2; ++k, corner += 2) {
      const int32_t from = corner[0].q12[c], to = corner[1].q12[c];
      const int32_t edge = (to - from) * lattice->half[0];
      corner[0].q12[c] = rg_to_lattice(
          lattice, c, from + rg_round_shift(edge + left, shift), 1);
      corner[1].q12[c] = rg_to_lattice(
          lattice, c, to + rg_round_shift(edge + right, shift), 1);
    }
  }
  block->width_log2 = (uint8_t)(block->width_log2 - lattice->log2[0]);
  block->height_log2 = (uint8_t)(block->height_log2 - lattice->log2[1]);
}
