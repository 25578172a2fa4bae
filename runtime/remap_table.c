#include "remap_table.h"

#include "bytes.h"
#include "rg_blob.h"

static uint32_t vertex_size(const uint8_t* section) {
  return section[10] != 0 ? RG_BENT_VERTEX_SIZE : RG_VERTEX_SIZE;
}

#if RG_KEEP_LINES

/* log2 of the parts of a block, across (axis 0) or down. */
static uint32_t num_log2(const rg_block_walk* walk, uint32_t axis) {
  return (uint32_t)walk->section[8] - walk->part_log2[axis];
}

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
/* From one point, through so much, to another one; bend is eight times the
 * table's, times the number of parts. */
typedef struct bent_line {
  int32_t from;
  uint32_t line;
  int32_t bend;
} bent_line;

/* So many eighths along it: SPEC.md, "Bends", along(), all of it times the
 * number by which a block has fewer parts than eight; modulo 2^32. */
static RG_NOINLINE int32_t along(const bent_line* line, int32_t eighths) {
  const uint32_t bend = (uint32_t)(line->bend * (8 - eighths) >> 3);
  const uint32_t sum = (line->line + bend) * (uint32_t)eighths;
  return rg_add(line->from, (int32_t)(sum + 4) >> 3);
}

/* A column of vertices between two rows of them. */
typedef struct vertex_column {
  const uint8_t *above, *below;
  uint32_t i, j;
} vertex_column;

/* Coordinate c: the column itself; and the bends of what leads to it from the
 * left, in the table's own size. Without bends, others are read, of which
 * nothing remains. */
static RG_NOINLINE void find_lines(const rg_block_walk* walk,
                                   const vertex_column* column, uint32_t c,
                                   bent_line lines[2]) {
  const uint8_t* const section = walk->section;
  const uint32_t across_log2 = walk->part_log2[0];
  const uint8_t* const affine = section + 28 + 4 * c;
  const uint32_t row_step = rg_load_u32(affine + 16);
  const uint32_t plane = rg_load_u32(affine) +
                         column->i * rg_load_u32(affine + 8) +
                         column->j * row_step;
  const int32_t upper = rg_load_i16(column->above + 2 * c);
  const int32_t lower = rg_load_i16(column->below + 2 * c);
  lines[0].from = (int32_t)(plane + ((uint32_t)upper << section[9]));
  lines[0].line = row_step + ((uint32_t)(lower - upper) << section[9]);
  const uint32_t shift = (uint32_t)section[11] - section[10];
  const int8_t* const bends_above = (const int8_t*)column->above + c;
  const int8_t* const bends_below = (const int8_t*)column->below + c;
  const int32_t first = bends_above[RG_LEFT_BEND];
  const int32_t last = bends_below[RG_LEFT_BEND];
  lines[0].bend = bends_below[RG_UPPER_BEND] * (1 << (shift + section[8]));
  lines[1].from = first * (1 << (shift + across_log2));
  lines[1].line = (uint32_t)((last - first) * (1 << (shift + across_log2)));
  lines[1].bend = 0;
}

/* Of the column at the right of the block that begins at or before walk->across
 * eighths; whether that is marked as empty. */
static RG_NOINLINE void find_column(rg_block_walk* walk,
                                    vertex_column* column) {
  const uint8_t* const section = walk->section;
  const uint32_t columns = rg_load_u16(section + 4);
  const uint32_t row_size = columns * vertex_size(section);
  const int32_t i = walk->across >> 3, j = walk->down >> 3;
  const uint8_t* const vertices = section + rg_load_u32(section + 76);
  const uint8_t* const marks =
      vertices + rg_load_u16(section + 6) * row_size;
  const int32_t mark = j * ((int32_t)columns - 1) + i;
  walk->is_empty = (marks[mark >> 3] >> (mark & 7)) & 1;
  column->i = (uint32_t)(i + 1);
  column->j = (uint32_t)j;
  column->above =
      vertices + (uint32_t)j * row_size + column->i * vertex_size(section);
  column->below = column->above + row_size;
}

/* Coordinate c of the corners of the part whose left side is walk->across
 * eighths; before the first column, of none. */
static RG_NOINLINE void find_axis(rg_block_walk* walk,
                                  const vertex_column* column, uint32_t c,
                                  rg_position* corners) {
  bent_line lines[3];
  find_lines(walk, column, c, lines);
  const uint32_t num_log2 = walk->section[8] - walk->part_log2[0];
  const int32_t left = walk->across & 7, right = left + walk->part[0];
  int32_t eighths = walk->down & 7;
  for (uint32_t k = 0; k < 2; ++k) {
    int32_t* const from = &walk->from[2 * k + c];
    const int32_t to = along(&lines[0], eighths);
    lines[2].from = *from;
    lines[2].line = (uint32_t)to - (uint32_t)*from;
    lines[2].bend = along(&lines[1], eighths) * (1 << num_log2);
    if (walk->across >= 0) {
      corners[2 * k].q12[c] = along(&lines[2], left);
      corners[2 * k + 1].q12[c] = along(&lines[2], right);
    }
    if (right == 8) *from = to;
    eighths += walk->part[1];
  }
}

void rg_next_corners(rg_block_walk* walk, rg_position* corners) {
  vertex_column column;
  do {
    find_column(walk, &column);
    find_axis(walk, &column, 0, corners);
    find_axis(walk, &column, 1, corners);
    walk->across = (int16_t)(walk->across + walk->part[0]);
  } while (walk->across == 0);
}

void rg_next_block(rg_block_walk* walk, rg_block* block) {
  block->width_log2 = walk->part_log2[0];
  block->height_log2 = walk->part_log2[1];
  rg_next_corners(walk, block->corners);
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
