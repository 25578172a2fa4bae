/* Which rows of the source a band of the output needs. */
#include "lattice_map.h"
#include "raygrid.h"

/* Rounding moves a position by less than this, in q12. */
#define SLACK 8

/* Rows in q12; empty while min > max. */
typedef struct row_range {
  int32_t min_q12, max_q12;
} row_range;

static void add(row_range* range, int32_t y_q12) {
  if (y_q12 < range->min_q12) range->min_q12 = y_q12;
  if (y_q12 > range->max_q12) range->max_q12 = y_q12;
}

/* The row's ends where they have a source; otherwise 0, and nothing is added.
 */
static int add_ends(const rg_lattice_map* map, const rg_block_row* row,
                    uint32_t num_pixels, row_range* range) {
  const rg_position last = rg_row_position(row, num_pixels - 1);
  if (!rg_is_between(&map->min, &map->max, &row->start) ||
      !rg_is_between(&map->min, &map->max, &last))
    return 0;
  add(range, row->start.q12[1]);
  add(range, last.q12[1]);
  return 1;
}

/* Pixel by pixel. */
static void add_pixels(const rg_lattice_map* map, const rg_block_row* row,
                       uint32_t num_pixels, row_range* range) {
  for (uint32_t k = 0; k < num_pixels; ++k) {
    const rg_position p = rg_row_position(row, k);
    if (rg_is_between(&map->min, &map->max, &p)) add(range, p.q12[1]);
  }
}

/* Rows [first, last] of a part, which is changed. Positions are bilinear in
 * it: if the ends of the first and the last row are inside, so are the others,
 * and within their range. */
static void add_block(const rg_lattice_map* map, rg_block* block, uint32_t i,
                      uint32_t first, uint32_t last, row_range* range) {
  rg_block_row row;
  rg_lattice_block(map->lattice, block);
  const uint32_t width =
      (uint32_t)rg_load_u16(map->section) >> map->lattice->log2_x;
  const uint32_t rest = width - (i << block->width_log2);
  const uint32_t block_width = 1u << block->width_log2;
  const uint32_t num_pixels = rest < block_width ? rest : block_width;
  rg_find_block_row(block, first, &row);
  int is_whole = add_ends(map, &row, num_pixels, range);
  rg_find_block_row(block, last, &row);
  is_whole &= add_ends(map, &row, num_pixels, range);
  for (uint32_t r = first; r <= last && !is_whole; ++r) {
    rg_find_block_row(block, r, &row);
    add_pixels(map, &row, num_pixels, range);
  }
}

/* Rows [row, end) of the output's lattice. */
static row_range find_range(const rg_lattice_map* map, uint32_t row,
                            uint32_t end) {
  row_range range = {INT32_MAX, INT32_MIN};
  const rg_lattice* const lattice = map->lattice;
  const uint32_t width_log2 = rg_part_log2(map->section, lattice, 0);
  const uint32_t height_log2 = rg_part_log2(map->section, lattice, 1);
  const uint32_t rows_log2 = height_log2 - lattice->log2_y;
  const uint32_t mask = (UINT32_C(1) << rows_log2) - 1;
  const uint32_t num_parts =
      ((rg_load_u16(map->section) - 1u) >> width_log2) + 1;
  while (row < end) {
    const uint32_t j = row >> rows_log2;
    const uint32_t next = (j + 1) << rows_log2;
    const uint32_t last = (next < end ? next : end) - 1;
    rg_block_walk walk;
    rg_start_walk(map->section, width_log2, height_log2, j, &walk);
    for (uint32_t i = 0; i < num_parts; ++i) {
      rg_block block;
      rg_next_block(&walk, &block);
      if (!walk.is_empty)
        add_block(map, &block, i, row & mask, last & mask, &range);
    }
    row = next;
  }
  return range;
}

/* Rows of the image, [first, end); none while first >= end. */
typedef struct image_rows {
  int32_t first, end;
} image_rows;

/* Adds the image rows of a lattice's rows, whole pairs where it has every other
 * one. */
static void add_lattice(const rg_lattice_map* map, uint32_t first_row,
                        uint32_t end_row, image_rows* rows) {
  const uint32_t log2 = map->lattice->log2_y;
  const row_range range = find_range(map, first_row >> log2, end_row >> log2);
  if (range.min_q12 > range.max_q12) return;
  const int32_t height = (int32_t)map->height;
  int32_t first = (range.min_q12 - SLACK) >> 12;
  int32_t end = ((range.max_q12 + SLACK) >> 12) + 2;
  if (first < 0) first = 0;
  if (end > height) end = height;
  if (first << log2 < rows->first) rows->first = first << log2;
  if (end << log2 > rows->end) rows->end = end << log2;
}

rg_status rg_remap_source_rows(const rg_camera* camera, rg_format format,
                               uint16_t first_row, uint16_t num_rows,
                               uint16_t* first_source, uint16_t* num_source) {
  const uint8_t* const section = camera->remap;
  if (!section) return RG_ERR_NO_REMAP;
  const rg_lattice* lattices = 0;
  const uint32_t num_lattices = rg_format_lattices(format, &lattices);
  if (num_lattices == 0) return RG_ERR_FORMAT;
  const uint32_t end_row = (uint32_t)first_row + num_rows;
  const uint32_t pairs = (1u << lattices[num_lattices - 1].log2_y) - 1;
  if (end_row > rg_load_u16(section + 2) || ((first_row | num_rows) & pairs))
    return RG_ERR_ROWS;
  image_rows rows = {INT32_MAX, 0};
  for (uint32_t k = 0; k < num_lattices; ++k) {
    rg_lattice_map map;
    rg_lattice_map_open(&map, section, &lattices[k], camera->width,
                        camera->height);
    add_lattice(&map, first_row, end_row, &rows);
  }
  if (rows.first >= rows.end) rows.first = rows.end = 0;
  rows.first &= ~(int32_t)pairs;
  rows.end = (rows.end + (int32_t)pairs) & ~(int32_t)pairs;
  *first_source = (uint16_t)rows.first;
  *num_source = (uint16_t)(rows.end - rows.first);
  return RG_OK;
}
