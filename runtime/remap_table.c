#include "remap_table.h"

#include "bytes.h"
#include "rg_blob.h"

/* Offsets in a vertex that has bends: of the edges to its left and above. */
#define LEFT_BEND 4
#define UPPER_BEND 6

static uint32_t vertex_size(const uint8_t* section) {
  return section[10] != 0 ? RG_BENT_VERTEX_SIZE : RG_VERTEX_SIZE;
}

/* log2 of the parts of a block, across (axis 0) or down. */
static uint32_t num_log2(const rg_block_walk* walk, uint32_t axis) {
  return (uint32_t)walk->section[8] - walk->part_log2[axis];
}

#if RG_KEEP_LINES

static rg_lanes twice(rg_lane_pairs pairs, uint32_t k) {
  const rg_lane_pairs both = {pairs[k], pairs[k]};
  return (rg_lanes)both;
}

/* As along_edge(), for edges from one position to the other: where the lines
 * cross them. */
static rg_lanes cross_edges(const rg_block_walk* walk, rg_lanes edges,
                            rg_lanes bends) {
  const int32_t log2 = (int32_t)num_log2(walk, 1);
  const rg_lanes from = twice((rg_lane_pairs)edges, 0);
  const rg_lanes to = twice((rg_lane_pairs)edges, 1);
  const rg_lanes sums = (to - from + bends * walk->rest) * walk->line;
  return from + ((sums + (1 << log2 >> 1)) >> log2);
}

/* The signed byte on top of each lane. */
static rg_lanes load_bends(uint32_t a, uint32_t b, uint32_t c, uint32_t d,
                           uint32_t shift) {
  const rg_modular_lanes bytes = {a, b, c, d};
  return (rg_lanes)((rg_modular_lanes)((rg_lanes)bytes >> 24) << shift);
}

/* To the next column of vertices: where the lines cross it, and their bends
 * from the column before to it, twice, if blocks have several parts. */
static RG_INLINE rg_lanes next_column(rg_block_walk* walk, rg_lanes* turns) {
  const uint8_t* const section = walk->section;
  const uint8_t* const above = walk->above;
  const uint8_t* const below = above + walk->row_size;
  const uint32_t a = rg_load_u32(above), b = rg_load_u32(below);
  const rg_modular_lanes halves = {a << 16, a, b << 16, b};
  const rg_modular_lanes residuals = (rg_modular_lanes)((rg_lanes)halves >> 16)
                                     << section[9];
  const rg_lanes ends = (rg_lanes)(walk->plane + residuals);
  const rg_lanes none = {0, 0, 0, 0};
  walk->plane += walk->column_step;
  *turns = none;
  if (section[10] == 0) {
    walk->above = above + RG_VERTEX_SIZE;
    return ends;
  }
  walk->above = above + RG_BENT_VERTEX_SIZE;
  const uint32_t shift = (uint32_t)section[11] - section[10];
  const uint32_t c = rg_load_u32(above + LEFT_BEND);
  const uint32_t d = rg_load_u32(below + LEFT_BEND);
  if (num_log2(walk, 0) != 0)
    *turns = 2 * cross_edges(walk,
                             load_bends(c << 24, c << 16, d << 24, d << 16,
                                        shift + walk->part_log2[0]),
                             none);
  return cross_edges(
      walk, ends, load_bends(d << 8, d, d << 8, d, shift + walk->part_log2[1]));
}

/* To the first column. */
static rg_lanes start_columns(rg_block_walk* walk) {
  const uint8_t* const section = walk->section;
  const uint32_t log2 = num_log2(walk, 1);
  const uint32_t j = (uint32_t)walk->row >> log2;
  const int32_t line = walk->row & ((1 << log2) - 1);
  const int32_t rest = (1 << log2) - line;
  const uint32_t columns = rg_load_u16(section + 4);
  const uint8_t* const vertices = section + rg_load_u32(section + 76);
  walk->row_size = columns * vertex_size(section);
  walk->above = vertices + j * walk->row_size;
  walk->marks = vertices + rg_load_u16(section + 6) * walk->row_size;
  walk->next_mark = j * (columns - 1);
  for (int k = 0; k < 4; ++k) {
    /* Of pairs of 32 bits: origin, column_step, row_step. */
    const uint8_t* const affine = section + 28 + 4 * (k & 1);
    const uint32_t row = j + (uint32_t)(k >> 1);
    walk->plane[k] = rg_load_u32(affine) + row * rg_load_u32(affine + 16);
    walk->column_step[k] = rg_load_u32(affine + 8);
    walk->line[k] = line + (k >> 1);
    walk->rest[k] = rest - (k >> 1);
  }
  return next_column(walk, &walk->turns);
}

void rg_start_block(rg_block_walk* walk) {
  const uint32_t log2 = num_log2(walk, 0);
  const uint32_t column = (walk->next_part - 1u) >> log2;
  const int32_t num = 1 << log2;
  rg_lanes turns;
  if (column == 0) walk->right = start_columns(walk);
  const uint32_t mark = walk->next_mark++;
  walk->is_empty = (walk->marks[mark >> 3] >> (mark & 7)) & 1;
  const rg_lanes from = walk->right, to = next_column(walk, &turns);
  walk->sums = from * num + num / 2;
  walk->steps = to - from + (turns >> 1) * (num - 1);
  walk->turns = turns;
}

void rg_next_block(rg_block_walk* walk, rg_block* block) {
  rg_lanes upper, lower;
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
    const int32_t scale = 1 << section[9];
    ends[0].q12[c] = (int32_t)plane + rg_load_i16(above + 2 * c) * scale;
    ends[2].q12[c] =
        (int32_t)(plane + row_step) + rg_load_i16(below + 2 * c) * scale;
  }
  return above;
}

static int32_t load_bend(const uint8_t* byte, uint32_t shift) {
  return (int32_t)(int8_t)*byte * (1 << shift);
}

/* Point k of 2^log2 along a bent edge. */
static int32_t along_edge(int32_t from, int32_t to, int32_t bend, uint32_t k,
                          uint32_t log2) {
  const int32_t rest = (int32_t)((1u << log2) - k);
  return from + rg_round_shift((to - from + bend * rest) * (int32_t)k, log2);
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
