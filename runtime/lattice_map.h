/* Where the pixels of a lattice come from, in the lattice's own pixels:
 * formats/SPEC.md, "Lattices". */
#ifndef RAYGRID_LATTICE_MAP_H
#define RAYGRID_LATTICE_MAP_H

#include <stdint.h>

#include "pixel_formats.h"
#include "remap_table.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A remap table for one lattice. */
typedef struct rg_lattice_map {
  const uint8_t* section;
  const rg_lattice* lattice;
  uint16_t width, height; /* of the source lattice */
  rg_position min, max;   /* positions with a source, inclusive, q12 */
} rg_lattice_map;

void rg_lattice_map_open(rg_lattice_map* map, const uint8_t* section,
                         const rg_lattice* lattice, uint32_t image_width,
                         uint32_t image_height);

/* log2 of the output pixels that the parts of blocks are wide (axis 0) or high
 * (1): what the table says, but at least 16 for chroma, 8 of its own. */
static inline uint32_t rg_part_log2(const uint8_t* section,
                                    const rg_lattice* lattice, int axis) {
  const uint32_t half = axis == 0 ? lattice->half_x : lattice->half_y;
  if (section[10] == 0) return section[8];
  return section[10] < 4 && half == 1 ? 4 : section[10];
}

/* A part of a block of the table, as the lattice has it. */
void rg_lattice_block(const rg_lattice* lattice, rg_block* block);

static inline int rg_is_between(const rg_position* min, const rg_position* max,
                                const rg_position* p) {
  return p->q12[0] >= min->q12[0] && p->q12[0] <= max->q12[0] &&
         p->q12[1] >= min->q12[1] && p->q12[1] <= max->q12[1];
}

#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_LATTICE_MAP_H */
