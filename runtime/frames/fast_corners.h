/* The corners of the tiles of a row, computed by the fast traversal along two
 * lines, above and below the row of tiles. Values shared by tiles are kept from
 * one tile to the next, and vectors contain two positions. formats/SPEC.md,
 * "Bends". Positions are q12 source pixels. */
#ifndef RAYGRID_FAST_CORNERS_H
#define RAYGRID_FAST_CORNERS_H

#include "config.h"

#if RG_FAST_TRAVERSAL

#include <stdint.h>

#include "blob_layout.h"
#include "bytes.h"
#include "frames/component_map.h"
#include "kernels/block.h"
#include "operating_point_ops.h"

/* ---- Lanes --------------------------------------------------------------- */

/* x, y of two positions. */
typedef int32_t rg_lanes __attribute__((vector_size(16)));
typedef uint32_t rg_modular_lanes __attribute__((vector_size(16)));
typedef int64_t rg_lane_pairs __attribute__((vector_size(16)));

/* Duplicates a position. */
static RG_INLINE rg_lanes rg_twice(int32_t x, int32_t y) {
  const rg_lanes both = {x, y, x, y};
  return both;
}

/* Duplicates position k of two. */
static RG_INLINE rg_lanes rg_twice_pair(rg_lanes lanes, uint32_t k) {
  const rg_lane_pairs pairs = (rg_lane_pairs)lanes;
  const rg_lane_pairs both = {pairs[k], pairs[k]};
  return (rg_lanes)both;
}

/* ---- Lines --------------------------------------------------------------- */

/* The lines above and below a row of tiles in the blocks of a remap section,
 * which must have been accepted by rg_select_remap(). */
typedef struct rg_corner_lines {
  const uint8_t* section;
  const uint8_t* vertices;        /* vertices of the table, or of a sample */
  uint8_t is_block_empty;         /* no pixel of the last tile's block
                                     has a source */
  uint8_t tile_log2[2];           /* log2 of tile size in output px: x, y */
  uint16_t row;                   /* index of the row of tiles */
  uint16_t next_tile;             /* index of the next tile in the row */
  uint32_t vertex_size, row_size; /* bytes per vertex, per row of vertices */
  uint32_t sample_size;           /* as in rg_camera */
  int32_t weight;
  int32_t residual_shift, bend_shift[2], num_log2[2]; /* tiles/block, log2 */
  uint32_t next_mark;                                 /* next block index */
  const uint8_t* marks;         /* one bit per block; 1: empty */
  const uint8_t* above;         /* next column's vertex above the row */
  rg_modular_lanes plane;       /* next column's vertices above and below the
                                   row, without their residuals */
  rg_modular_lanes column_step; /* increment of plane per column */
  rg_lanes line, rest;          /* tiles from the block's upper edge to the two
                                   lines, and from there to its lower edge */
  /* The lines at the right edge of the last tile: right are their positions;
   * sums are the positions times the number of tiles, plus rounding; steps are
   * the first differences of sums per tile, and turns the second ones. */
  rg_lanes right, sums, steps, turns;
} rg_corner_lines;

/* Interpolates where the lines cross the edge between two vertices. */
static RG_INLINE rg_lanes rg_cross_edges(const rg_corner_lines* lines,
                                         rg_lanes edges, rg_lanes bends) {
  const int32_t log2 = lines->num_log2[1];
  const rg_lanes from = rg_twice_pair(edges, 0);
  const rg_lanes to = rg_twice_pair(edges, 1);
  const rg_lanes sums = (to - from + bends * lines->rest) * lines->line;
  return from + ((sums + (1 << log2 >> 1)) >> log2);
}

/* Loads the residuals of two vertices. */
static RG_INLINE rg_lanes rg_load_residuals(const uint8_t* above,
                                            const uint8_t* below) {
  const uint32_t a = rg_load_u32(above), b = rg_load_u32(below);
  const rg_modular_lanes halves = {a << 16, a, b << 16, b};
  return (rg_lanes)halves >> 16;
}

/* Loads the bends of the block edges to the left of two vertices. */
static RG_INLINE rg_lanes rg_load_level_bends(const uint8_t* above,
                                              const uint8_t* below) {
  const uint32_t a = rg_load_u32(above + RG_VERTEX_HX);
  const uint32_t b = rg_load_u32(below + RG_VERTEX_HX);
  const rg_modular_lanes bytes = {a << 24, a << 16, b << 24, b << 16};
  return (rg_lanes)bytes >> 24;
}

/* Loads the bend of the block edge from above to below, into both positions. */
static RG_INLINE rg_lanes rg_load_steep_bend(const uint8_t* above,
                                             const uint8_t* below) {
  (void)above;
  const uint32_t b = rg_load_u32(below + RG_VERTEX_HX);
  const rg_modular_lanes bytes = {b << 8, b, b << 8, b};
  return (rg_lanes)bytes >> 24;
}

/* Loads values of the next column's vertices with one of these functions; for
 * operating-point models, interpolates between the samples. */
typedef rg_lanes rg_load_numbers(const uint8_t* above, const uint8_t* below);
static RG_INLINE rg_lanes rg_load_column(const rg_corner_lines* lines,
                                         rg_load_numbers* load) {
  const uint8_t* const above = lines->above;
  const uint8_t* const below = above + lines->row_size;
  const rg_lanes lower = load(above, below);
  if (lines->weight == 0) return lower;
  const rg_lanes upper =
      load(above + lines->sample_size, below + lines->sample_size);
  return RG_BLEND_STORED(lower, upper, lines->weight);
}

static RG_INLINE rg_lanes rg_shift_lanes(rg_lanes lanes, int32_t shift) {
  return (rg_lanes)((rg_modular_lanes)lanes << shift);
}

/* Advances to the next column of vertices. Returns the crossings of the lines
 * with it, and twice the bends of the edges to it in *turns (one tile: 0). */
static RG_INLINE rg_lanes rg_next_column(rg_corner_lines* lines,
                                         rg_lanes* turns) {
  const rg_lanes none = {0, 0, 0, 0};
  const rg_lanes residuals = rg_shift_lanes(
      rg_load_column(lines, rg_load_residuals), lines->residual_shift);
  rg_lanes ends = (rg_lanes)(lines->plane + (rg_modular_lanes)residuals);
  lines->plane += lines->column_step;
  *turns = none;
  if (lines->vertex_size == RG_BENT_VERTEX_SIZE) {
    if (lines->num_log2[0] != 0)
      *turns =
          2 * rg_cross_edges(
                  lines,
                  rg_shift_lanes(rg_load_column(lines, rg_load_level_bends),
                                 lines->bend_shift[0]),
                  none);
    ends =
        rg_cross_edges(lines, ends,
                       rg_shift_lanes(rg_load_column(lines, rg_load_steep_bend),
                                      lines->bend_shift[1]));
  }
  lines->above += lines->vertex_size;
  return ends;
}

/* log2 of the tiles per block, across (axis 0) or down. */
static inline uint32_t rg_num_tiles_log2(const rg_corner_lines* lines,
                                         uint32_t axis) {
  return (uint32_t)lines->section[RG_REMAP_BLOCK_LOG2] - lines->tile_log2[axis];
}

/* Moves to the first column of vertices of the row of tiles. The section,
 * vertices, tile size and row must be set. */
static inline void rg_start_columns(rg_corner_lines* lines) {
  const uint8_t* const section = lines->section;
  const uint32_t log2 = rg_num_tiles_log2(lines, 1);
  const uint32_t j = (uint32_t)lines->row >> log2;
  const int32_t line = lines->row & ((1 << log2) - 1);
  const int32_t rest = (1 << log2) - line;
  const uint32_t columns = rg_load_u16(section + RG_REMAP_COLUMNS);
  const int32_t bend_shift =
      (int32_t)rg_bend_shift(section) - section[RG_REMAP_PART_LOG2];
  rg_lanes turns;
  lines->vertex_size = rg_vertex_size(section);
  lines->row_size = columns * lines->vertex_size;
  lines->above = lines->vertices + j * lines->row_size;
  lines->marks =
      lines->vertices + rg_load_u16(section + RG_REMAP_ROWS) * lines->row_size;
  lines->next_mark = j * (columns - 1);
  lines->residual_shift = section[RG_REMAP_RESIDUAL_SHIFT];
  for (uint32_t axis = 0; axis < 2; ++axis) {
    lines->num_log2[axis] = (int32_t)rg_num_tiles_log2(lines, axis);
    lines->bend_shift[axis] = bend_shift + lines->tile_log2[axis];
  }
  for (int k = 0; k < 4; ++k) {
    const uint8_t* const origin = section + RG_REMAP_ORIGIN + 4 * (k & 1);
    const uint32_t row = j + (uint32_t)(k >> 1);
    lines->plane[k] =
        rg_load_u32(origin) +
        row * rg_load_u32(origin + RG_REMAP_ROW_STEP - RG_REMAP_ORIGIN);
    lines->column_step[k] =
        rg_load_u32(origin + RG_REMAP_COLUMN_STEP - RG_REMAP_ORIGIN);
    lines->line[k] = line + (k >> 1);
    lines->rest[k] = rest - (k >> 1);
  }
  lines->right = rg_next_column(lines, &turns);
}

/* Advances to the block that starts with the next tile. */
static RG_SHARED void rg_enter_block(rg_corner_lines* lines) {
  const int32_t log2 = lines->num_log2[0];
  const uint32_t mark = lines->next_mark++;
  lines->is_block_empty = (lines->marks[mark >> 3] >> (mark & 7)) & 1;
  rg_lanes turns;
  const rg_lanes from = lines->right, to = rg_next_column(lines, &turns);
  const rg_lanes bends = turns >> 1;
  lines->sums = (rg_lanes)((rg_modular_lanes)from << log2) + (1 << log2 >> 1);
  lines->steps =
      to - from - bends + (rg_lanes)((rg_modular_lanes)bends << log2);
  lines->turns = turns;
}

/* Computes the corners of the next tile, on the upper and the lower line, after
 * rg_start_columns(). */
static RG_INLINE void rg_follow_lines(rg_corner_lines* lines, rg_lanes* upper,
                                      rg_lanes* lower) {
  const int32_t log2 = lines->num_log2[0];
  if ((lines->next_tile++ & ((1u << log2) - 1)) == 0) rg_enter_block(lines);
  /* Differences: the sum of k steps is k (to - from + bend (num - k)). */
  const rg_lane_pairs left = (rg_lane_pairs)lines->right;
  lines->sums += lines->steps;
  lines->steps -= lines->turns;
  lines->right = lines->sums >> log2;
  const rg_lane_pairs right = (rg_lane_pairs)lines->right;
  const rg_lane_pairs above = {left[0], right[0]};
  const rg_lane_pairs below = {left[1], right[1]};
  *upper = (rg_lanes)above;
  *lower = (rg_lanes)below;
}

/* ---- Components ---------------------------------------------------------- */

/* The transformation of tile corners for a component: rg_transform_block(). */
typedef struct rg_component_lanes {
  rg_lanes offset, is_coarse; /* half-pixel offset per coordinate; all bits set
                                 where the component is subsampled */
  int32_t half[2];            /* half-pixel phase per axis */
  int32_t tile_width_shift;   /* log2 of twice the tile width */
} rg_component_lanes;

static RG_INLINE rg_component_lanes rg_get_component_lanes(
    const rg_component* component, uint32_t tile_width_log2) {
  const rg_component_lanes found = {
      rg_twice(component->half[0] * 2048, component->half[1] * 2048),
      rg_twice(-(int32_t)component->log2[0], -(int32_t)component->log2[1]),
      {component->half[0], component->half[1]},
      (int32_t)tile_width_log2 + 1};
  return found;
}

/* Transforms the corners on a line; across and down are edges of the tile. */
static RG_INLINE rg_lanes
rg_to_component_lanes(const rg_component_lanes* component, rg_lanes corners,
                      rg_lanes across, rg_lanes down) {
  const rg_lanes moved =
      across * component->half[0] + down * component->half[1];
  const rg_lanes at = corners +
                      ((moved + (1 << component->tile_width_shift >> 1)) >>
                       component->tile_width_shift) -
                      component->offset;
  return at ^ ((at ^ ((at + 1) >> 1)) & component->is_coarse);
}

/* Returns the vector from the first of two corners to the second, twice. */
static RG_INLINE rg_lanes rg_edge_lanes(rg_lanes corners) {
  return rg_twice_pair(corners, 1) - rg_twice_pair(corners, 0);
}

/* Transforms the corners of a tile from image to component pixels. */
static RG_INLINE void rg_transform_corner_lanes(
    const rg_component_lanes* component, rg_lanes* upper, rg_lanes* lower) {
  const rg_lanes down = *lower - *upper;
  *upper =
      rg_to_component_lanes(component, *upper, rg_edge_lanes(*upper), down);
  *lower =
      rg_to_component_lanes(component, *lower, rg_edge_lanes(*lower), down);
}

#endif

#endif /* RAYGRID_FAST_CORNERS_H */
