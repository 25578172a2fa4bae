/* The corners of the parts of a remap table's blocks, part by part:
 * formats/SPEC.md, "Bends". In C, and for Cortex-M in assembler. */
#ifndef RAYGRID_PART_CORNERS_H
#define RAYGRID_PART_CORNERS_H

#include <stdint.h>

#include "blob_layout.h"
#include "bytes.h"
#include "fixed_point.h"
#include "kernels/block.h"
#include "raygrid.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The extent of a part on an axis, in q16 blocks: what is before it, and its
 * size. */
typedef struct rg_span {
  uint32_t before, size;
} rg_span;

/* A row of parts of the blocks of a remap section, which must be one that
 * rg_select_remap() accepted. */
typedef struct rg_part_row {
  const uint8_t* section;
  const uint8_t* block; /* the upper left vertex of the last part's block */
  uint32_t row_size;    /* bytes from a vertex to the one below it */
  uint8_t bend_shift;   /* for parts of this width */
  uint8_t num_log2;     /* log2 of four times a block's parts across */
  uint8_t is_empty;     /* the table says that no pixel of the last part's block
                           has a source */
  uint8_t vertex_size;  /* in bytes */
  rg_span spans[2];     /* of the next part across, of the row of parts down */
} rg_part_row;

/* Sets the parts' size, 2^width_log2 x 2^height_log2 output pixels: a block is
 * 1 to 8 such parts wide and high, 1 in a table without bends. The section is
 * set. */
static inline void rg_set_parts(rg_part_row* parts, uint32_t width_log2,
                                uint32_t height_log2) {
  const uint8_t* const section = parts->section;
  const uint32_t whole_log2 =
      section[RG_REMAP_BLOCK_LOG2] + 2u; /* of four blocks */
  const uint32_t num_log2 = whole_log2 - width_log2;
  parts->bend_shift = (uint8_t)(rg_bend_shift(section) + width_log2 -
                                section[RG_REMAP_PART_LOG2]);
  parts->num_log2 = (uint8_t)num_log2;
  parts->spans[0].size = UINT32_C(0x40000) >> num_log2;
  parts->spans[1].size = UINT32_C(0x40000) >> (whole_log2 - height_log2);
}

/* Goes to the first part of row j of parts, the size of which is set. */
static RG_INLINE void rg_start_parts(rg_part_row* parts, uint32_t j) {
  parts->spans[0].before = 0;
  parts->spans[1].before = j * parts->spans[1].size;
}

/* Sets the section and the parts' size, and goes to the first part of row j. */
static inline void rg_start_part_row(const uint8_t* section,
                                     uint32_t width_log2, uint32_t height_log2,
                                     uint32_t j, rg_part_row* parts) {
  parts->section = section;
  rg_set_parts(parts, width_log2, height_log2);
  rg_start_parts(parts, j);
}

/* Finds the block that the next part is in, and sizes of its vertices.
 *
 * knot_shift  as rg_camera has it */
static RG_INLINE void rg_find_block_of_part(rg_part_row* parts,
                                            uint32_t knot_shift) {
  const uint8_t* const section = parts->section;
  const uint32_t columns = rg_load_u16(section + RG_REMAP_COLUMNS);
  const uint32_t size = rg_vertex_size(section);
  const uint32_t row_size = columns * size;
  const uint32_t j = parts->spans[1].before >> 16;
  const uint32_t vertex = j * columns + (parts->spans[0].before >> 16);
  const uint32_t mark = vertex - j;
  const uint8_t* const vertices = rg_find_vertices(section);
  const uint8_t* const marks =
      vertices + rg_load_u16(section + RG_REMAP_ROWS) * row_size;
  parts->block = vertices + knot_shift + vertex * size;
  parts->row_size = row_size;
  parts->vertex_size = (uint8_t)size;
  parts->is_empty = (marks[mark >> 3] >> (mark & 7)) & 1;
}

/* Finds the corners of the part, from its block's vertices, and goes on to the
 * next part. Corners of parts are the same, by whatever code: in C, in
 * assembler of Thumb-2, and those that the fast walk finds. */
void rg_pass_part_in_c(rg_part_row* parts, rg_position corners[4]);
void rg_pass_part_in_thumb2(rg_part_row* parts, rg_position corners[4]);

/* rg_pass_part_in_...(), by the code that suits the processor. */
static RG_INLINE void rg_pass_part(rg_part_row* parts, rg_position corners[4]) {
  if (RG_CORNERS_IN_ASSEMBLER)
    rg_pass_part_in_thumb2(parts, corners);
  else
    rg_pass_part_in_c(parts, corners);
}

/* rg_pass_part() between two knots of a stack, for the small walk alone:
 * rg_stack_code. */
#if RG_FAST_WALK
#define RG_PASS_BLENDED_PART 0
#else
void rg_pass_blended_part(rg_part_row* parts, rg_position corners[4],
                          const rg_camera* camera);
#define RG_PASS_BLENDED_PART rg_pass_blended_part
#endif

/* Finds the part as a block, and goes on to the next one. */
void rg_next_block(rg_part_row* parts, rg_block* block);

#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_PART_CORNERS_H */
