/* Where the pixels of a lattice come from, in the lattice's own pixels:
 * formats/SPEC.md, "Lattices". */
#ifndef RAYGRID_LATTICE_MAP_H
#define RAYGRID_LATTICE_MAP_H

#include <stdint.h>

#include "pixel_formats.h"
#include "remap_table.h"

/* A remap table for one lattice. */
typedef struct rg_lattice_map {
  const uint8_t* section;
  const rg_lattice* lattice;
  uint16_t width, height; /* of the source lattice */
  uint8_t block_width_log2, block_height_log2;
  rg_position min, max; /* positions with a source, inclusive, q12 */
} rg_lattice_map;

void rg_lattice_map_open(rg_lattice_map* map, const uint8_t* section,
                         const rg_lattice* lattice, uint32_t image_width,
                         uint32_t image_height);

/* A row of a block: pixels of a segment are a step apart. */
typedef struct rg_lattice_row {
  rg_block_row image_row;
  rg_position step;
} rg_lattice_row;

/* Row r of a block. */
void rg_lattice_block_row(const rg_lattice_map* map, const rg_block* block,
                          uint32_t r, rg_lattice_row* row);

/* An image position in lattice pixels. */
rg_position rg_lattice_position(const rg_lattice* lattice,
                                const rg_position* image_position);

/* Position of pixel k of the row, which begins a segment or ends the row. */
rg_position rg_lattice_segment(const rg_lattice_map* map,
                               const rg_lattice_row* row, uint32_t k);

static inline int rg_is_between(const rg_position* min, const rg_position* max,
                                const rg_position* p) {
  return p->q12[0] >= min->q12[0] && p->q12[0] <= max->q12[0] &&
         p->q12[1] >= min->q12[1] && p->q12[1] <= max->q12[1];
}

static inline int rg_has_source(const rg_lattice_map* map,
                                const rg_position* p) {
  return rg_is_between(&map->min, &map->max, p);
}

static inline void rg_next_pixel(rg_position* p, const rg_position* step) {
  p->q12[0] += step->q12[0];
  p->q12[1] += step->q12[1];
}

#endif /* RAYGRID_LATTICE_MAP_H */
