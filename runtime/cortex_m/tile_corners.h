/* Corners of the tiles of a remap table's blocks, tile by tile:
 * formats/SPEC.md, "Bends". In C, and in assembly for Cortex-M. */
#ifndef RAYGRID_TILE_CORNERS_H
#define RAYGRID_TILE_CORNERS_H

#include <stdint.h>

#include "blob_layout.h"
#include "bytes.h"
#include "fixed_point.h"
#include "kernels/block.h"
#include "raygrid.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The extent of a tile on an axis, in q16 blocks: its start and its size. */
typedef struct rg_tile_extent {
  uint32_t before, size;
} rg_tile_extent;

/* A row of tiles across the blocks of a remap section that rg_select_remap()
 * accepted. */
typedef struct rg_tile_row {
  const uint8_t* section;
  const uint8_t* block;   /* upper left vertex of the last tile's block */
  uint32_t row_size;      /* bytes from a vertex to the one below it */
  uint8_t bend_shift;     /* shift of bends for tiles of this width */
  uint8_t num_log2;       /* log2 of four times the tiles per block, across */
  uint8_t is_block_empty; /* no pixel of the last tile's block has a source */
  uint8_t vertex_size;    /* in bytes */
  rg_tile_extent extents[2]; /* next tile across, row of tiles down */
} rg_tile_row;

/* Sets the tile size, 2^width_log2 x 2^height_log2 output pixels: a block has 1
 * to 8 tiles in each direction, 1 in a table without bends. The section must be
 * set. */
static inline void rg_set_tile_size(rg_tile_row* tiles, uint32_t width_log2,
                                    uint32_t height_log2) {
  const uint8_t* const section = tiles->section;
  const uint32_t whole_log2 =
      section[RG_REMAP_BLOCK_LOG2] + 2u; /* block of four blocks */
  const uint32_t num_log2 = whole_log2 - width_log2;
  tiles->bend_shift = (uint8_t)(rg_bend_shift(section) + width_log2 -
                                section[RG_REMAP_PART_LOG2]);
  tiles->num_log2 = (uint8_t)num_log2;
  tiles->extents[0].size = UINT32_C(0x40000) >> num_log2;
  tiles->extents[1].size = UINT32_C(0x40000) >> (whole_log2 - height_log2);
}

/* Moves to the first tile of row j. The tile size must be set. */
static RG_INLINE void rg_start_tile_row(rg_tile_row* tiles, uint32_t j) {
  tiles->extents[0].before = 0;
  tiles->extents[1].before = j * tiles->extents[1].size;
}

/* Sets the section and the tile size, and moves to the first tile of row j. */
static inline void rg_init_tile_row(const uint8_t* section, uint32_t width_log2,
                                    uint32_t height_log2, uint32_t j,
                                    rg_tile_row* tiles) {
  tiles->section = section;
  rg_set_tile_size(tiles, width_log2, height_log2);
  rg_start_tile_row(tiles, j);
}

/* Finds the block that contains the next tile, and the sizes of its vertices.
 *
 * sample_shift  as in rg_camera */
static RG_INLINE void rg_find_tile_block(rg_tile_row* tiles,
                                         uint32_t sample_shift) {
  const uint8_t* const section = tiles->section;
  const uint32_t columns = rg_load_u16(section + RG_REMAP_COLUMNS);
  const uint32_t size = rg_vertex_size(section);
  const uint32_t row_size = columns * size;
  const uint32_t j = tiles->extents[1].before >> 16;
  const uint32_t vertex = j * columns + (tiles->extents[0].before >> 16);
  const uint32_t mark = vertex - j;
  const uint8_t* const vertices = rg_find_vertices(section);
  const uint8_t* const marks =
      vertices + rg_load_u16(section + RG_REMAP_ROWS) * row_size;
  tiles->block = vertices + sample_shift + vertex * size;
  tiles->row_size = row_size;
  tiles->vertex_size = (uint8_t)size;
  tiles->is_block_empty = (marks[mark >> 3] >> (mark & 7)) & 1;
}

/* Computes the corners of the next tile from the vertices of its block, and
 * advances. All versions compute the same corners: in C, in Thumb-2 assembly,
 * and in the fast traversal (fast_corners.h). */
void rg_next_tile_in_c(rg_tile_row* tiles, rg_position corners[4]);
void rg_next_tile_in_thumb2(rg_tile_row* tiles, rg_position corners[4]);

/* Calls the version of rg_next_tile_in_...() for the target. */
static RG_INLINE void rg_next_tile(rg_tile_row* tiles, rg_position corners[4]) {
  if (RG_CORNERS_IN_ASSEMBLER)
    rg_next_tile_in_thumb2(tiles, corners);
  else
    rg_next_tile_in_c(tiles, corners);
}

/* rg_next_tile() interpolated between two samples of the operating-point stack,
 * for the small traversal only: rg_operating_point_ops. */
#if RG_FAST_TRAVERSAL
#define RG_NEXT_BLENDED_TILE 0
#else
void rg_next_blended_tile(rg_tile_row* tiles, rg_position corners[4],
                          const rg_camera* camera);
#define RG_NEXT_BLENDED_TILE rg_next_blended_tile
#endif

/* Sets *block to the next tile and advances. */
void rg_next_block(rg_tile_row* tiles, rg_block* block);

#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_TILE_CORNERS_H */
