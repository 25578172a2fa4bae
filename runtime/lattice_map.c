#include "lattice_map.h"

/* Image coordinate c to lattice coordinate; bias is added where halves are
 * rounded. */
static inline int32_t to_lattice(const rg_lattice* lattice, int c, int32_t q12,
                                 int32_t bias) {
  const uint32_t half = c == 0 ? lattice->half_x : lattice->half_y;
  const uint32_t log2 = c == 0 ? lattice->log2_x : lattice->log2_y;
  q12 -= (int32_t)half * 2048;
  return log2 == 0 ? q12 : (q12 + bias) >> 1;
}

void rg_lattice_map_open(rg_lattice_map* map, const uint8_t* section,
                         const rg_lattice* lattice, uint32_t image_width,
                         uint32_t image_height) {
  map->section = section;
  map->lattice = lattice;
  map->width = (uint16_t)(image_width >> lattice->log2_x);
  map->height = (uint16_t)(image_height >> lattice->log2_y);
  for (int c = 0; c < 2; ++c) {
    const uint8_t* const field = section + 12 + 4 * c;
    map->min.q12[c] = to_lattice(lattice, c, rg_load_i32(field), 1);
    map->max.q12[c] = to_lattice(lattice, c, rg_load_i32(field + 8), 0);
  }
}

/* Moves the corners by (half_x, half_y) half pixels of the output, along the
 * edges that meet in each, and from image to lattice coordinates. */
void rg_lattice_block(const rg_lattice* lattice, rg_block* block) {
  if ((lattice->log2_x | lattice->log2_y) == 0) return; /* image pixels */
  const uint32_t shift = block->width_log2 + 1u;
  for (int c = 0; c < 2; ++c) {
    rg_position* const p = block->corners;
    const int32_t p00 = p[0].q12[c], p10 = p[1].q12[c];
    const int32_t p01 = p[2].q12[c], p11 = p[3].q12[c];
    const int32_t top = (p10 - p00) * lattice->half_x;
    const int32_t bottom = (p11 - p01) * lattice->half_x;
    const int32_t left = (p01 - p00) * lattice->half_y;
    const int32_t right = (p11 - p10) * lattice->half_y;
    p[0].q12[c] =
        to_lattice(lattice, c, p00 + rg_round_shift(top + left, shift), 1);
    p[1].q12[c] =
        to_lattice(lattice, c, p10 + rg_round_shift(top + right, shift), 1);
    p[2].q12[c] =
        to_lattice(lattice, c, p01 + rg_round_shift(bottom + left, shift), 1);
    p[3].q12[c] =
        to_lattice(lattice, c, p11 + rg_round_shift(bottom + right, shift), 1);
  }
  block->width_log2 = (uint8_t)(block->width_log2 - lattice->log2_x);
  block->height_log2 = (uint8_t)(block->height_log2 - lattice->log2_y);
}
