#include "lattice_map.h"

#include "fixed_point.h"

/* Image coordinate c to lattice coordinate; bias is added where halves are
 * rounded. */
static int32_t to_lattice(const rg_lattice* lattice, int c, int32_t q12,
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
  map->block_width_log2 = (uint8_t)(section[8] - lattice->log2_x);
  map->block_height_log2 = (uint8_t)(section[8] - lattice->log2_y);
  for (int c = 0; c < 2; ++c) {
    const uint8_t* const field = section + 12 + 4 * c;
    map->min.q12[c] = to_lattice(lattice, c, rg_load_i32(field), 1);
    map->max.q12[c] = to_lattice(lattice, c, rg_load_i32(field + 8), 0);
  }
}

/* Half-way between two rows of the image. */
static RG_NOINLINE void average_rows(const uint8_t* section,
                                     const rg_block* block, uint32_t r,
                                     rg_block_row* row) {
  rg_block_row below;
  rg_remap_block_row(section, block, r, row);
  rg_remap_block_row(section, block, r + 1, &below);
  rg_remap_average_rows(section, &below, row);
}

rg_position rg_lattice_position(const rg_lattice* lattice,
                                const rg_position* image_position) {
  rg_position p;
  for (int c = 0; c < 2; ++c)
    p.q12[c] = to_lattice(lattice, c, image_position->q12[c], 1);
  return p;
}

void rg_lattice_block_row(const rg_lattice_map* map, const rg_block* block,
                          uint32_t r, rg_lattice_row* row) {
  const rg_lattice* const lattice = map->lattice;
  const uint32_t image_r = r << lattice->log2_y;
  if (lattice->half_y == 1)
    average_rows(map->section, block, image_r, &row->image_row);
  else
    rg_remap_block_row(map->section, block, image_r + lattice->half_y / 2,
                       &row->image_row);
  row->step.q12[0] = row->image_row.step.q12[0];
  row->step.q12[1] =
      row->image_row.step.q12[1] * (1 << (lattice->log2_x - lattice->log2_y));
}

rg_position rg_lattice_segment(const rg_lattice_map* map,
                               const rg_lattice_row* row, uint32_t k) {
  const rg_lattice* const lattice = map->lattice;
  rg_position p =
      rg_remap_segment(map->section, &row->image_row, k << lattice->log2_x);
  if (lattice->log2_x == 0) return p; /* the image's own pixels */
  for (int c = 0; c < 2; ++c) {
    const int32_t step = row->image_row.step.q12[c];
    const int32_t offset = (lattice->half_x * step + 1) >> 1;
    p.q12[c] = to_lattice(lattice, c, p.q12[c] + offset, 1);
  }
  return p;
}
