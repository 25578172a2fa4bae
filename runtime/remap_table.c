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

/* From the vertices above and below to where the lines cross the edge between
 * them. */
static void bend_lines(rg_block_walk* walk) {
  const uint8_t* const above = walk->vertices[0];
  const uint8_t* const below = walk->vertices[1];
  const uint32_t log2 = walk->num_log2[1], shift = walk->bend_shift[0];
  for (uint32_t c = 0; c < 2; ++c) {
    const int32_t top = walk->ends[0].q12[c];
    const int32_t bottom = walk->ends[1].q12[c];
    const int32_t bend = load_bend(below + UPPER_BEND + c, walk->bend_shift[1]);
    const int32_t top_bend = load_bend(above + LEFT_BEND + c, shift);
    const int32_t bottom_bend = load_bend(below + LEFT_BEND + c, shift);
    for (uint32_t k = 0; k < 2; ++k) {
      const uint32_t row = walk->row + k;
      walk->ends[k].q12[c] = along_edge(top, bottom, bend, row, log2);
      walk->bends[k].q12[c] = along_edge(top_bend, bottom_bend, 0, row, log2);
    }
  }
}

/* The next ends of the lines, from the next vertices: origin + i column_step +
 * j row_step + residual << shift. */
static void next_column(rg_block_walk* walk) {
  for (uint32_t k = 0; k < 2; ++k) {
    const uint8_t* const residual = walk->vertices[k];
    for (int c = 0; c < 2; ++c) {
      const int32_t affine = walk->affine[k].q12[c];
      walk->ends[k].q12[c] =
          affine + rg_load_i16(residual + 2 * c) * (1 << walk->residual_shift);
      walk->affine[k].q12[c] =
          (int32_t)((uint32_t)affine + (uint32_t)walk->column_step.q12[c]);
    }
  }
  if (walk->vertex_size == RG_BENT_VERTEX_SIZE) bend_lines(walk);
  for (uint32_t k = 0; k < 2; ++k) walk->vertices[k] += walk->vertex_size;
}

void rg_start_walk(const uint8_t* section, uint32_t width_log2,
                   uint32_t height_log2, uint32_t j, rg_block_walk* walk) {
  walk->residual_shift = section[9];
  walk->vertex_size = section[10] != 0 ? RG_BENT_VERTEX_SIZE : RG_VERTEX_SIZE;
  walk->part_log2[0] = (uint8_t)width_log2;
  walk->part_log2[1] = (uint8_t)height_log2;
  for (uint32_t axis = 0; axis < 2; ++axis) {
    const uint32_t log2 = walk->part_log2[axis];
    walk->num_log2[axis] = (uint8_t)(section[8] - log2);
    walk->bend_shift[axis] = (uint8_t)(section[11] + log2 - section[10]);
  }
  walk->row = (uint8_t)(j & ((1u << walk->num_log2[1]) - 1));
  j >>= walk->num_log2[1];
  const uint32_t columns = rg_load_u16(section + 4);
  const uint32_t row_bytes = walk->vertex_size * columns;
  const uint8_t* const vertices = section + rg_load_u32(section + 76);
  walk->empty_blocks = vertices + rg_load_u16(section + 6) * row_bytes;
  walk->next_block = j * (columns - 1);
  for (uint32_t c = 0; c < 2; ++c)
    walk->column_step.q12[c] = rg_load_i32(section + 36 + 4 * c);
  for (uint32_t k = 0; k < 2; ++k, ++j) {
    walk->vertices[k] = vertices + j * row_bytes;
    /* The second coordinate of every pair lies behind the first. */
    for (uint32_t c = 0; c < 2; ++c) {
      walk->affine[k].q12[c] = (int32_t)(rg_load_u32(section + 28 + 4 * c) +
                                         j * rg_load_u32(section + 44 + 4 * c));
    }
  }
  next_column(walk);
  walk->next_part = 0;
}

/* The lines across a block, from its left corners to where they end now: the
 * sum of k steps is k (to - from + bend (num - k)). */
static void start_lines(rg_block_walk* walk, const rg_position* corners) {
  const int32_t num = (int32_t)(1u << walk->num_log2[0]);
  for (uint32_t k = 0; k < 2; ++k) {
    for (int c = 0; c < 2; ++c) {
      const int32_t from = corners[2 * k].q12[c];
      walk->sums[k].q12[c] = from * num + (num >> 1);
      walk->steps[k].q12[c] =
          walk->ends[k].q12[c] - from + walk->bends[k].q12[c] * (num - 1);
    }
  }
}

void rg_next_block(rg_block_walk* walk, rg_block* block) {
  const uint32_t log2 = walk->num_log2[0];
  block->width_log2 = walk->part_log2[0];
  block->height_log2 = walk->part_log2[1];
  if (walk->next_part == 0) {
    block->corners[0] = walk->ends[0];
    block->corners[2] = walk->ends[1];
    next_column(walk);
    const uint32_t k = walk->next_block++;
    walk->is_empty = (walk->empty_blocks[k >> 3] >> (k & 7)) & 1;
    if (log2 == 0) { /* one part */
      block->corners[1] = walk->ends[0];
      block->corners[3] = walk->ends[1];
      return;
    }
    start_lines(walk, block->corners);
  }
  walk->next_part = (uint8_t)((walk->next_part + 1u) & ((1u << log2) - 1));
  for (uint32_t k = 0; k < 2; ++k) {
    for (int c = 0; c < 2; ++c) {
      const int32_t sum = walk->sums[k].q12[c], step = walk->steps[k].q12[c];
      block->corners[2 * k].q12[c] = sum >> log2;
      block->corners[2 * k + 1].q12[c] = (sum + step) >> log2;
      walk->sums[k].q12[c] = sum + step;
      walk->steps[k].q12[c] = step - 2 * walk->bends[k].q12[c];
    }
  }
}
