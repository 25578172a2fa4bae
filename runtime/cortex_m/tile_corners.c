#include "cortex_m/tile_corners.h"

/* Replaces the ends of a block's edge by those of the tile's part of it:
 * along() of SPEC.md, "Bends", with 8 for 2^n, to which k is scaled. bend is 4
 * 2^n b; sums are modulo 2^32. */
static void cut_edge(int32_t* from, int32_t* to, int32_t bend,
                     const rg_tile_extent* extent) {
  const uint32_t first = (uint32_t)*from, line = (uint32_t)*to - first;
  uint32_t k = extent->before << 16 >> 29;
  for (;;) {
    const int32_t aside = bend * (int32_t)(8 - k) >> 5;
    const uint32_t sum = (line + (uint32_t)aside) * k;
    *from = rg_add((int32_t)first, (int32_t)(sum + 4) >> 3);
    if (from == to) break;
    from = to;
    k += extent->size >> 13;
  }
}

static int32_t load_bend(const uint8_t* byte, uint32_t shift) {
  return (int32_t)(int8_t)*byte * (1 << shift);
}

/* Computes one coordinate of the tile's corners and stores it in every other
 * element, starting at corner. */
static RG_INLINE void compute_axis(const rg_tile_row* tiles, uint32_t c,
                                   int32_t* corner) {
  const uint8_t* const section = tiles->section;
  const uint32_t size = tiles->vertex_size;
  const uint8_t* const affine = section + 4 * c;
  const uint8_t* above = tiles->block + c;
  const uint8_t* below = above + tiles->row_size;
  const uint32_t row_step = rg_load_u32(affine + RG_REMAP_ROW_STEP);
  uint32_t plane = rg_load_u32(affine + RG_REMAP_ORIGIN) +
                   (tiles->extents[0].before >> 16) *
                       rg_load_u32(affine + RG_REMAP_COLUMN_STEP) +
                   (tiles->extents[1].before >> 16) * row_step;
  const uint32_t bend_shift = tiles->bend_shift;
  int32_t bends[2];
  for (uint32_t side = 0; side < 2; ++side, corner += 2) {
    const uint32_t shift = section[RG_REMAP_RESIDUAL_SHIFT];
    const uint32_t upper = (uint32_t)rg_load_i16(above + RG_VERTEX_X + c)
                           << shift;
    const uint32_t lower = (uint32_t)rg_load_i16(below + RG_VERTEX_X + c)
                           << shift;
    corner[0] = (int32_t)(plane + upper);
    corner[4] = (int32_t)(plane + row_step + lower);
    plane += rg_load_u32(affine + RG_REMAP_COLUMN_STEP);
    if (size == RG_BENT_VERTEX_SIZE) {
      cut_edge(&corner[0], &corner[4],
               load_bend(below + RG_VERTEX_VX, bend_shift + tiles->num_log2),
               &tiles->extents[1]);
      bends[0] = load_bend(above + RG_VERTEX_HX, bend_shift);
      bends[1] = load_bend(below + RG_VERTEX_HX, bend_shift);
    }
    above += size;
    below += size;
  }
  if (size != RG_BENT_VERTEX_SIZE) return; /* the block is a single tile */
  cut_edge(&bends[0], &bends[1], 0, &tiles->extents[1]);
  const int32_t num = 1 << tiles->num_log2;
  corner -= 4;
  cut_edge(&corner[0], &corner[2], bends[0] * num, &tiles->extents[0]);
  cut_edge(&corner[4], &corner[6], bends[1] * num, &tiles->extents[0]);
}

void rg_next_tile_in_c(rg_tile_row* tiles, rg_position corners[4]) {
  for (uint32_t c = 0; c < 2; ++c) compute_axis(tiles, c, &corners->q12[c]);
  tiles->extents[0].before += tiles->extents[0].size;
}

static uint8_t tile_log2(const rg_tile_row* tiles,
                         const rg_tile_extent* extent) {
  uint32_t log2 = tiles->section[RG_REMAP_BLOCK_LOG2];
  for (uint32_t size = extent->size; size < 0x10000; size *= 2) --log2;
  return (uint8_t)log2;
}

void rg_next_block(rg_tile_row* tiles, rg_block* block) {
  block->width_log2 = tile_log2(tiles, &tiles->extents[0]);
  block->height_log2 = tile_log2(tiles, &tiles->extents[1]);
  rg_find_tile_block(tiles, 0);
  rg_next_tile(tiles, block->corners);
}
