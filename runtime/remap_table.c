#include "remap_table.h"

#include "bytes.h"
#include "rg_blob.h"

/* Offsets in a vertex that has bends: of the edges to its left and above. */
#define LEFT_BEND 4
#define UPPER_BEND 6

static int32_t load_bend(const uint8_t* byte, uint32_t shift) {
  return (int32_t)(int8_t)*byte * (1 << shift);
}

/* Point k of 2^log2 along a line from a point to another one; bend is four
 * times how far its middle lies off. */
static int32_t along_line(int32_t from, int32_t to, int32_t bend, uint32_t k,
                          uint32_t log2) {
  const int32_t rest = (int32_t)((1u << log2) - k);
  const int32_t slope = to - from + rg_round_shift(bend * rest, log2);
  return from + rg_round_shift(slope * (int32_t)k, log2);
}

/* One coordinate of the next vertex above (0) or below (1): origin +
 * i column_step + j row_step + residual << shift. */
static int32_t next_vertex(rg_block_walk* walk, uint32_t k, uint32_t c) {
  const int32_t affine = walk->affine[k].q12[c];
  walk->affine[k].q12[c] =
      (int32_t)((uint32_t)affine + (uint32_t)walk->column_step.q12[c]);
  return affine +
         rg_load_i16(walk->vertices[k] + 2 * c) * (1 << walk->residual_shift);
}

/* The lines go on to the next column of vertices. */
static void next_column(rg_block_walk* walk) {
  const uint8_t* const above = walk->vertices[0];
  const uint8_t* const below = walk->vertices[1];
  const uint32_t log2 = walk->num_log2[1], shift = walk->bend_shift;
  for (uint32_t c = 0; c < 2; ++c) {
    const int32_t top = next_vertex(walk, 0, c);
    const int32_t bottom = next_vertex(walk, 1, c);
    int32_t bends[3] = {0, 0, 0}; /* of the edges left of above, of below;
                                     between the two */
    if (walk->vertex_size == RG_BENT_VERTEX_SIZE) {
      bends[0] = load_bend(above + LEFT_BEND + c, shift);
      bends[1] = load_bend(below + LEFT_BEND + c, shift);
      bends[2] = load_bend(below + UPPER_BEND + c, shift);
    }
    for (uint32_t k = 0; k < 2; ++k) {
      rg_bent_line* const line = &walk->lines[k];
      line->left.q12[c] = line->right.q12[c];
      line->right.q12[c] =
          along_line(top, bottom, bends[2], walk->row + k, log2);
      line->bend.q12[c] =
          along_line(bends[0], bends[1], 0, walk->row + k, log2);
    }
  }
  for (uint32_t k = 0; k < 2; ++k) walk->vertices[k] += walk->vertex_size;
}

void rg_start_walk(const uint8_t* section, uint32_t width_log2,
                   uint32_t height_log2, uint32_t j, rg_block_walk* walk) {
  const uint32_t block_log2 = section[8];
  walk->residual_shift = section[9];
  walk->bend_shift = section[11];
  walk->vertex_size = section[10] != 0 ? RG_BENT_VERTEX_SIZE : RG_VERTEX_SIZE;
  walk->part_log2[0] = (uint8_t)width_log2;
  walk->part_log2[1] = (uint8_t)height_log2;
  walk->num_log2[0] = (uint8_t)(block_log2 - width_log2);
  walk->num_log2[1] = (uint8_t)(block_log2 - height_log2);
  walk->row = (uint8_t)(j & ((1u << walk->num_log2[1]) - 1));
  j >>= walk->num_log2[1];
  const uint32_t row_bytes = walk->vertex_size * rg_load_u16(section + 4);
  for (uint32_t k = 0; k < 2; ++k, ++j) {
    walk->vertices[k] = section + rg_load_u32(section + 76) + j * row_bytes;
    /* The second coordinate of every pair lies behind the first. */
    for (uint32_t c = 0; c < 2; ++c)
      walk->affine[k].q12[c] = (int32_t)(rg_load_u32(section + 28 + 4 * c) +
                                         j * rg_load_u32(section + 44 + 4 * c));
  }
  for (int c = 0; c < 2; ++c)
    walk->column_step.q12[c] = rg_load_i32(section + 36 + 4 * c);
  for (uint32_t k = 0; k < 2; ++k)
    for (int c = 0; c < 2; ++c) walk->lines[k].right.q12[c] = 0;
  next_column(walk);
  for (uint32_t k = 0; k < 2; ++k) walk->lines[k].last = walk->lines[k].right;
  walk->next_part = 0;
}

void rg_next_block(rg_block_walk* walk, rg_block* block) {
  const uint32_t log2 = walk->num_log2[0];
  if (walk->next_part == 0) next_column(walk);
  const uint32_t end = walk->next_part + 1u;
  for (uint32_t k = 0; k < 2; ++k) {
    rg_bent_line* const line = &walk->lines[k];
    block->corners[2 * k] = line->last;
    for (int c = 0; c < 2; ++c)
      line->last.q12[c] = along_line(line->left.q12[c], line->right.q12[c],
                                     line->bend.q12[c], end, log2);
    block->corners[2 * k + 1] = line->last;
  }
  walk->next_part = (uint8_t)(end & ((1u << log2) - 1));
  block->width_log2 = walk->part_log2[0];
  block->height_log2 = walk->part_log2[1];
}

int rg_remap_is_empty(const uint8_t* section, uint32_t i, uint32_t j) {
  const uint32_t columns = rg_load_u16(section + 4);
  const uint32_t num_vertices = columns * rg_load_u16(section + 6);
  const uint32_t vertex_size =
      section[10] != 0 ? RG_BENT_VERTEX_SIZE : RG_VERTEX_SIZE;
  const uint8_t* const mask =
      section + rg_load_u32(section + 76) + vertex_size * num_vertices;
  const uint32_t block = j * (columns - 1) + i;
  return (mask[block >> 3] >> (block & 7)) & 1;
}
