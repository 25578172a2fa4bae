#include "remap_table.h"

#include "bytes.h"
#include "rg_blob.h"

/* Offsets in a vertex that has bends: of the edges to its left and above. */
#define LEFT_BEND 4
#define UPPER_BEND 6

static int32_t load_bend(const uint8_t* byte, uint32_t shift) {
  return (int32_t)(int8_t)*byte * (1 << shift);
}

/* Point k of 2^log2 along a bent edge. */
static int32_t along_edge(int32_t from, int32_t to, int32_t bend, uint32_t k,
                          uint32_t log2) {
  const int32_t rest = (int32_t)((1u << log2) - k);
  return from + rg_round_shift((to - from + bend * rest) * (int32_t)k, log2);
}

static uint32_t vertex_size(const uint8_t* section) {
  return section[10] != 0 ? RG_BENT_VERTEX_SIZE : RG_VERTEX_SIZE;
}

/* log2 of the parts of a block, across (axis 0) or down. */
static uint32_t num_log2(const rg_block_walk* walk, uint32_t axis) {
  return (uint32_t)walk->section[8] - walk->part_log2[axis];
}

/* Where a column of vertices crosses the lines above and below the row of
 * parts: ends[0] and ends[2]. So far, where it crosses those of the blocks. */
static RG_SHARED const uint8_t* find_vertices(const rg_block_walk* walk,
                                              uint32_t column,
                                              rg_position* ends) {
  const uint8_t* const section = walk->section;
  const uint32_t j = (uint32_t)walk->row >> num_log2(walk, 1);
  const uint32_t size = vertex_size(section);
  const uint32_t columns = rg_load_u16(section + 4);
  const uint8_t* const above =
      section + rg_load_u32(section + 76) + (j * columns + column) * size;
  const uint8_t* const below = above + columns * size;
  const int32_t scale = 1 << section[9];
  for (uint32_t c = 0; c < 2; ++c) {
    /* Of pairs of 32 bits: origin, column_step, row_step. */
    const uint8_t* const affine = section + 28 + 4 * c;
    const uint32_t row_step = rg_load_u32(affine + 16);
    const uint32_t plane =
        rg_load_u32(affine) + column * rg_load_u32(affine + 8) + j * row_step;
    ends[0].q12[c] = (int32_t)plane + rg_load_i16(above + 2 * c) * scale;
    ends[2].q12[c] =
        (int32_t)(plane + row_step) + rg_load_i16(below + 2 * c) * scale;
  }
  return above;
}

/* Whether a block of the row is marked as empty. */
static uint8_t is_block_empty(const rg_block_walk* walk, uint32_t column) {
  const uint8_t* const section = walk->section;
  const uint32_t columns = rg_load_u16(section + 4);
  const uint8_t* const marks =
      section + rg_load_u32(section + 76) +
      rg_load_u16(section + 6) * columns * vertex_size(section);
  const uint32_t block =
      ((uint32_t)walk->row >> num_log2(walk, 1)) * (columns - 1) + column;
  return (marks[block >> 3] >> (block & 7)) & 1;
}

#if RG_KEEP_LINES

/* From the vertices to the lines, which cross the edges between them; and the
 * lines' bends from the column before to this one. */
static RG_NOINLINE void bend_ends(const rg_block_walk* walk,
                                  const uint8_t* above, rg_position* ends,
                                  rg_position* bends) {
  const uint8_t* const section = walk->section;
  const uint8_t* const below =
      above + RG_BENT_VERTEX_SIZE * rg_load_u16(section + 4);
  const uint32_t log2 = num_log2(walk, 1);
  const uint32_t row = walk->row & ((1u << log2) - 1);
  const uint32_t shift = (uint32_t)section[11] - section[10];
  for (uint32_t c = 0; c < 2; ++c) {
    const uint32_t across = shift + walk->part_log2[0];
    const uint32_t down = shift + walk->part_log2[1];
    const int32_t top = ends[0].q12[c], bottom = ends[2].q12[c];
    const int32_t bend = load_bend(below + UPPER_BEND + c, down);
    const int32_t top_bend = load_bend(above + LEFT_BEND + c, across);
    const int32_t bottom_bend = load_bend(below + LEFT_BEND + c, across);
    for (uint32_t k = 0; k < 2; ++k) {
      ends[2 * k].q12[c] = along_edge(top, bottom, bend, row + k, log2);
      bends[k].q12[c] = along_edge(top_bend, bottom_bend, 0, row + k, log2);
    }
  }
}

static void find_ends(const rg_block_walk* walk, uint32_t column,
                      rg_position* ends, rg_position* bends) {
  const uint8_t* const above = find_vertices(walk, column, ends);
  if (walk->section[10] != 0) bend_ends(walk, above, ends, bends);
}

/* From a block's part to the next one by differences: the sum of k steps is
 * k (to - from + bend (num - k)). */
void rg_next_block(rg_block_walk* walk, rg_block* block) {
  const uint32_t log2 = num_log2(walk, 0);
  const uint32_t part = walk->next_part++;
  const int32_t num = 1 << log2;
  rg_position* const ends = walk->ends;
  rg_position* const corners = block->corners;
  block->width_log2 = walk->part_log2[0];
  block->height_log2 = walk->part_log2[1];
  if (part == 0) find_ends(walk, 0, ends + 1, walk->bends);
  if ((part & ((uint32_t)num - 1)) == 0) {
    const uint32_t column = part >> log2;
    walk->is_empty = is_block_empty(walk, column);
    ends[0] = ends[1];
    ends[2] = ends[3];
    find_ends(walk, column + 1, ends + 1, walk->bends);
    if (log2 == 0) { /* one part */
      for (uint32_t k = 0; k < 4; ++k) corners[k] = ends[k];
      return;
    }
    for (uint32_t k = 0; k < 2; ++k) {
      for (int c = 0; c < 2; ++c) {
        const int32_t from = ends[2 * k].q12[c];
        walk->sums[k].q12[c] = from * num + num / 2;
        walk->steps[k].q12[c] =
            ends[2 * k + 1].q12[c] - from + walk->bends[k].q12[c] * (num - 1);
      }
    }
  }
  for (uint32_t k = 0; k < 2; ++k) {
    for (int c = 0; c < 2; ++c) {
      const int32_t sum = walk->sums[k].q12[c], step = walk->steps[k].q12[c];
      corners[2 * k].q12[c] = sum >> log2;
      corners[2 * k + 1].q12[c] = (sum + step) >> log2;
      walk->sums[k].q12[c] = sum + step;
      walk->steps[k].q12[c] = step - 2 * walk->bends[k].q12[c];
    }
  }
}

#else

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
    const uint32_t place = RG_BENT_VERTEX_SIZE + LEFT_BEND + c;
    int32_t bends[2] = {load_bend(vertex + place, across),
                        load_bend(below + place, across)};
    cut_edge(walk, 1, &bends[0], &bends[1], 0);
    for (uint32_t i = 0; i < 2; ++i)
      cut_edge(walk, 1, &corners[i].q12[c], &corners[2 + i].q12[c],
               load_bend(below + i * RG_BENT_VERTEX_SIZE + UPPER_BEND + c,
                         shift + walk->part_log2[1]));
    for (uint32_t i = 0; i < 2; ++i)
      cut_edge(walk, 0, &corners[2 * i].q12[c], &corners[2 * i + 1].q12[c],
               bends[i]);
  }
}

/* Each part from the vertices of its block: nothing is kept. */
void rg_next_block(rg_block_walk* walk, rg_block* block) {
  const uint32_t log2 = num_log2(walk, 0);
  const uint32_t part = walk->next_part++;
  const uint32_t column = part >> log2;
  block->width_log2 = walk->part_log2[0];
  block->height_log2 = walk->part_log2[1];
  walk->is_empty = is_block_empty(walk, column);
  rg_position* const corners = block->corners;
  find_vertices(walk, column + 1, corners + 1);
  const uint8_t* const vertex = find_vertices(walk, column, corners);
  if (walk->section[10] != 0) find_part(walk, vertex, corners);
}

#endif

void rg_find_block_row(const rg_block* block, uint32_t r, rg_block_row* row) {
  rg_find_row(block, r, row);
}
