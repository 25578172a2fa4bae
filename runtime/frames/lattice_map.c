#include "frames/lattice_map.h"

/* The difference of coordinate c between two positions; modulo 2^32. */
static uint32_t edge_of(const rg_position* from, const rg_position* to, int c) {
  return (uint32_t)to->q12[c] - (uint32_t)from->q12[c];
}

/* Shifts by (half[0], half[1]) half output pixels, along the adjacent edges of
 * each corner, then converts image to component coordinates. */
void rg_move_corners(const rg_lattice* lattice, uint32_t part_width_log2,
                     rg_position corners[4]) {
  if ((lattice->log2[0] | lattice->log2[1]) == 0) return; /* image pixels */
  const uint32_t shift = part_width_log2 + 1;
  for (int c = 0; c < 2; ++c) {
    rg_position* corner = corners;
    const uint32_t half_y = lattice->half[1];
    const uint32_t left = edge_of(&corner[0], &corner[2], c) * half_y;
    const uint32_t right = edge_of(&corner[1], &corner[3], c) * half_y;
    for (int k = 0; k < 2; ++k, corner += 2) {
      const int32_t from = corner[0].q12[c], to = corner[1].q12[c];
      const uint32_t edge =
          edge_of(&corner[0], &corner[1], c) * lattice->half[0];
      corner[0].q12[c] = rg_to_lattice(
          lattice, c, rg_add(from, rg_round_shift(edge + left, shift)), 1);
      corner[1].q12[c] = rg_to_lattice(
          lattice, c, rg_add(to, rg_round_shift(edge + right, shift)), 1);
    }
  }
}

void rg_lattice_block(const rg_lattice* lattice, rg_block* block) {
  rg_move_corners(lattice, block->width_log2, block->corners);
  block->width_log2 = (uint8_t)(block->width_log2 - lattice->log2[0]);
  block->height_log2 = (uint8_t)(block->height_log2 - lattice->log2[1]);
}
