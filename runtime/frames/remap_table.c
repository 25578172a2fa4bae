#include "frames/remap_table.h"

#include "bytes.h"
#include "rg_blob.h"

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
  walk->vertex_size = rg_vertex_size(section);
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
    /* Fields that are pairs of 32 bits: origin, column_step, row_step. */
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

#if !RG_CORNERS_IN_ASSEMBLER

/* In place of an edge's ends, those of the part at a place. SPEC.md, "Bends",
 * along(), with eight for 2^n: k is multiplied by what makes it so. bend is b
 * times 4 2^n; modulo 2^32. */
static RG_NOINLINE void cut_edge(int32_t* from, int32_t* to, int32_t bend,
                                 const rg_span* span) {
  const uint32_t first = (uint32_t)*from, line = (uint32_t)*to - first;
  uint32_t k = span->before << 16 >> 29;
  for (;;) {
    const int32_t aside = bend * (int32_t)(8 - k) >> 5;
    const uint32_t sum = (line + (uint32_t)aside) * k;
    *from = rg_add((int32_t)first, (int32_t)(sum + 4) >> 3);
    if (from == to) break;
    from = to;
    k += span->size >> 13;
  }
}

static int32_t load_bend(const uint8_t* byte, uint32_t shift) {
  return (int32_t)(int8_t)*byte * (1 << shift);
}

/* A coordinate of the part's corners: from corner on, every other one; vertex
 * is the block's upper left one's number. */
static RG_INLINE void find_axis(const rg_block_walk* walk, uint32_t c,
                                uint32_t vertex, int32_t* corner) {
  const uint8_t* const section = walk->section;
  const uint32_t size = rg_vertex_size(section);
  const uint8_t* const affine = section + 4 * c;
  const uint8_t* above =
      section + rg_load_u32(section + 76) + vertex * size + c;
  const uint8_t* below = above + rg_load_u16(section + 4) * size;
  const uint32_t row_step = rg_load_u32(affine + 44);
  uint32_t plane = rg_load_u32(affine + 28) +
                   (walk->spans[0].before >> 16) * rg_load_u32(affine + 36) +
                   (walk->spans[1].before >> 16) * row_step;
  const uint32_t bend_shift = walk->bend_shift;
  int32_t bends[2];
  for (uint32_t side = 0; side < 2; ++side, corner += 2) {
    const uint32_t shift = section[9];
    const uint32_t upper = (uint32_t)rg_load_i16(above + c) << shift;
    const uint32_t lower = (uint32_t)rg_load_i16(below + c) << shift;
    corner[0] = (int32_t)(plane + upper);
    corner[4] = (int32_t)(plane + row_step + lower);
    plane += rg_load_u32(affine + 36);
    if (size == RG_BENT_VERTEX_SIZE) {
      cut_edge(&corner[0], &corner[4],
               load_bend(below + RG_UPPER_BEND, bend_shift + walk->num_log2),
               &walk->spans[1]);
      bends[0] = load_bend(above + RG_LEFT_BEND, bend_shift);
      bends[1] = load_bend(below + RG_LEFT_BEND, bend_shift);
    }
    above += size;
    below += size;
  }
  if (size != RG_BENT_VERTEX_SIZE) return; /* the block is the part */
  cut_edge(&bends[0], &bends[1], 0, &walk->spans[1]);
  const int32_t num = 1 << walk->num_log2;
  corner -= 4;
  cut_edge(&corner[0], &corner[2], bends[0] * num, &walk->spans[0]);
  cut_edge(&corner[4], &corner[6], bends[1] * num, &walk->spans[0]);
}

void rg_next_corners(rg_block_walk* walk, rg_position corners[4]) {
  const uint8_t* const section = walk->section;
  const uint32_t columns = rg_load_u16(section + 4);
  const uint32_t j = walk->spans[1].before >> 16;
  const uint32_t vertex = j * columns + (walk->spans[0].before >> 16);
  const uint32_t mark = vertex - j;
  const uint8_t* const marks =
      section + rg_load_u32(section + 76) +
      rg_load_u16(section + 6) * columns * rg_vertex_size(section);
  walk->is_empty = (marks[mark >> 3] >> (mark & 7)) & 1;
  const uint32_t end = rg_times(2);
  uint32_t c = 0;
  do {
    find_axis(walk, c, vertex, &corners->q12[c]);
  } while (++c != end);
  walk->spans[0].before += walk->spans[0].size;
}

#endif

static uint8_t part_log2(const rg_block_walk* walk, const rg_span* span) {
  uint32_t log2 = walk->section[8];
  for (uint32_t size = span->size; size < 0x10000; size *= 2) --log2;
  return (uint8_t)log2;
}

void rg_next_block(rg_block_walk* walk, rg_block* block) {
  block->width_log2 = part_log2(walk, &walk->spans[0]);
  block->height_log2 = part_log2(walk, &walk->spans[1]);
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
