#include "remap_table.h"

#include "bytes.h"
#include "rg_blob.h"

static uint32_t vertex_size(const uint8_t* section) {
  return section[10] != 0 ? RG_BENT_VERTEX_SIZE : RG_VERTEX_SIZE;
}

/* log2 of the parts of a block, across (axis 0) or down. */
static uint32_t num_log2(const rg_block_walk* walk, uint32_t axis) {
  return (uint32_t)walk->section[8] - walk->part_log2[axis];
}

#if RG_KEEP_LINES

void rg_start_columns(rg_block_walk* walk) {
  const uint8_t* const section = walk->section;
  const uint32_t log2 = num_log2(walk, 1);
  const uint32_t j = (uint32_t)walk->row >> log2;
  const int32_t line = walk->row & ((1 << log2) - 1);
  const int32_t rest = (1 << log2) - line;
  const uint32_t columns = rg_load_u16(section + 4);
  const uint8_t* const vertices = section + rg_load_u32(section + 76);
  const int32_t bend_shift = section[11] - section[10];
  rg_lanes turns;
  walk->vertex_size = vertex_size(section);
  walk->row_size = columns * walk->vertex_size;
  walk->above = vertices + j * walk->row_size;
  walk->marks = vertices + rg_load_u16(section + 6) * walk->row_size;
  walk->next_mark = j * (columns - 1);
  walk->residual_shift = section[9];
  for (uint32_t axis = 0; axis < 2; ++axis) {
    walk->num_log2[axis] = (int32_t)num_log2(walk, axis);
    walk->bend_shift[axis] = bend_shift + walk->part_log2[axis];
  }
  for (int k = 0; k < 4; ++k) {
    /* Of pairs of 32 bits: origin, column_step, row_step. */
    const uint8_t* const affine = section + 28 + 4 * (k & 1);
    const uint32_t row = j + (uint32_t)(k >> 1);
    walk->plane[k] = rg_load_u32(affine) + row * rg_load_u32(affine + 16);
    walk->column_step[k] = rg_load_u32(affine + 8);
    walk->line[k] = line + (k >> 1);
    walk->rest[k] = rest - (k >> 1);
  }
  walk->right = rg_next_column(walk, &turns);
}

void rg_start_block(rg_block_walk* walk) { rg_enter_block(walk); }

void rg_next_block(rg_block_walk* walk, rg_block* block) {
  rg_lanes upper, lower;
  if (walk->next_part == 0) rg_start_columns(walk);
  rg_next_corners(walk, &upper, &lower);
  rg_store_corners(upper, lower, block->corners);
  block->width_log2 = walk->part_log2[0];
  block->height_log2 = walk->part_log2[1];
}

#else
/* Where vertices (i, j) and (i, j + 1) stand: ends[0] and ends[2]. Returns the
 * former. */
static RG_SHARED const uint8_t* find_vertices(const uint8_t* section,
                                              uint32_t i, uint32_t j,
                                              rg_position* ends) {
  const uint32_t columns = rg_load_u16(section + 4);
  const uint32_t size = vertex_size(section);
  const uint8_t* const above =
      section + rg_load_u32(section + 76) + (j * columns + i) * size;
  const uint8_t* const below = above + columns * size;
  for (uint32_t c = 0; c < 2; ++c) {
    /* Of pairs of 32 bits: origin, column_step, row_step. */
    const uint8_t* const affine = section + 28 + 4 * c;
    const uint32_t row_step = rg_load_u32(affine + 16);
    const uint32_t plane =
        rg_load_u32(affine) + i * rg_load_u32(affine + 8) + j * row_step;
    const uint32_t upper = (uint32_t)rg_load_i16(above + 2 * c) << section[9];
    const uint32_t lower = (uint32_t)rg_load_i16(below + 2 * c) << section[9];
    ends[0].q12[c] = (int32_t)(plane + upper);
    ends[2].q12[c] = (int32_t)(plane + row_step + lower);
  }
  return above;
}

static int32_t load_bend(const uint8_t* byte, uint32_t shift) {
  return (int32_t)(int8_t)*byte * (1 << shift);
}

/* Point k of 2^log2 along a bent edge; modulo 2^32. */
static int32_t along_edge(int32_t from, int32_t to, int32_t bend, uint32_t k,
                          uint32_t log2) {
  const uint32_t sum =
      (uint32_t)to - (uint32_t)from + (uint32_t)bend * ((1u << log2) - k);
  return rg_add(from, rg_round_shift(sum * k, log2));
}

/* Across (axis 0) or down: the part's corners in place of an edge's ends,
 * coordinate c. */
static RG_NOINLINE void cut_edge(const rg_block_walk* walk, uint32_t axis,
                                 int32_t* from, int32_t* to, int32_t bend) {
  const uint32_t log2 = num_log2(walk, axis);
  const uint32_t part = axis == 0 ? walk->next_part - 1u : walk->row;
  const uint32_t k = part & ((1u << log2) - 1);
  const int32_t a = *from, b = *to;
  *from = along_edge(a, b, bend, k, log2);
  *to = along_edge(a, b, bend, k + 1, log2);
}

/* From the corners of a block, the first of which is the vertex given, to those
 * of the part. */
static RG_NOINLINE void find_part(const rg_block_walk* walk,
                                  const uint8_t* vertex, rg_position* corners) {
  const uint8_t* const section = walk->section;
  const uint8_t* const below =
      vertex + RG_BENT_VERTEX_SIZE * rg_load_u16(section + 4);
  const uint32_t shift = (uint32_t)section[11] - section[10];
  const uint32_t across = shift + walk->part_log2[0];
  for (uint32_t c = 0; c < 2; ++c) {
    const uint32_t place = RG_BENT_VERTEX_SIZE + RG_LEFT_BEND + c;
    int32_t bends[2] = {load_bend(vertex + place, across),
                        load_bend(below + place, across)};
    cut_edge(walk, 1, &bends[0], &bends[1], 0);
    for (uint32_t i = 0; i < 2; ++i)
      cut_edge(walk, 1, &corners[i].q12[c], &corners[2 + i].q12[c],
               load_bend(below + i * RG_BENT_VERTEX_SIZE + RG_UPPER_BEND + c,
                         shift + walk->part_log2[1]));
    for (uint32_t i = 0; i < 2; ++i)
      cut_edge(walk, 0, &corners[2 * i].q12[c], &corners[2 * i + 1].q12[c],
               bends[i]);
  }
}

/* Whether block (i, j) is marked as empty. */
static uint8_t is_block_empty(const uint8_t* section, uint32_t i, uint32_t j) {
  const uint32_t columns = rg_load_u16(section + 4);
  const uint32_t num_vertices = rg_load_u16(section + 6) * columns;
  const uint8_t* const marks =
      section + rg_load_u32(section + 76) + num_vertices * vertex_size(section);
  const uint32_t block = j * (columns - 1) + i;
  return (marks[block >> 3] >> (block & 7)) & 1;
}

/* Each part from the vertices of its block: nothing is kept. */
void rg_next_block(rg_block_walk* walk, rg_block* block) {
  const uint8_t* const section = walk->section;
  const uint32_t i = (uint32_t)walk->next_part++ >> num_log2(walk, 0);
  const uint32_t j = (uint32_t)walk->row >> num_log2(walk, 1);
  block->width_log2 = walk->part_log2[0];
  block->height_log2 = walk->part_log2[1];
  walk->is_empty = is_block_empty(section, i, j);
  find_vertices(section, i + 1, j, block->corners + 1);
  const uint8_t* const vertex = find_vertices(section, i, j, block->corners);
  if (section[10] != 0) find_part(walk, vertex, block->corners);
}

#endif

void rg_find_block_row(const rg_block* block, uint32_t r, rg_block_row* row) {
#if RG_KEEP_LINES
  rg_find_row(block, r, row);
#else
  const int end = (int)rg_times(2);
  int c = 0;
  do {
    rg_find_row_axis(block, r, c, row);
  } while (++c != end);
#endif
}
