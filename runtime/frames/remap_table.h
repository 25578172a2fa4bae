/* The source positions of a block's pixels: formats/SPEC.md, "Remap
 * arithmetic". All positions are q12 source pixels. */
#ifndef RAYGRID_REMAP_TABLE_H
#define RAYGRID_REMAP_TABLE_H

#include <stdint.h>

#include "bytes.h"
#include "fixed_point.h"
#include "rg_blob.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Offsets in a vertex that has bends: of the edges to its left and above. */
#define RG_LEFT_BEND 4
#define RG_UPPER_BEND 6

/* x, y */
typedef struct rg_position {
  int32_t q12[2];
} rg_position;

#if RG_KEEP_LINES
/* x, y of one position and of another. */
typedef int32_t rg_lanes __attribute__((vector_size(16)));
typedef uint32_t rg_modular_lanes __attribute__((vector_size(16)));
typedef int64_t rg_lane_pairs __attribute__((vector_size(16)));
#define RG_FOR_LANES __attribute__((aligned(16)))
#else
#define RG_FOR_LANES
#endif

/* A block, or a part of one, of 2^width_log2 x 2^height_log2 pixels, and where
 * its corners come from: top left, top right, bottom left, bottom right. */
typedef struct rg_block {
  uint8_t width_log2, height_log2;
#if !RG_KEEP_LINES
  uint8_t is_safe; /* none of its pixels asks for care, not even a ring's */
#endif
  RG_FOR_LANES rg_position corners[4];
} rg_block;

#if !RG_KEEP_LINES
/* The extent of a part on an axis, in q16 blocks: what is before it, and its
 * size. */
typedef struct rg_span {
  uint32_t before, size;
} rg_span;
#endif

/* A row of parts of the blocks of a remap section, which must be one that
 * rg_select_remap() accepted. */
typedef struct rg_block_walk {
  const uint8_t* section;
  uint8_t is_empty; /* the table says that no pixel of the last part's block
                       has a source */
#if RG_KEEP_LINES
  uint8_t is_clamped;   /* such pixels take the nearest source: none is empty */
  uint8_t part_log2[2]; /* output pixels of a part: across, down */
  uint16_t row;         /* of parts */
  uint16_t next_part;   /* in the row */
  uint32_t vertex_size, row_size; /* of vertices, in bytes */
  int32_t residual_shift, bend_shift[2], num_log2[2]; /* of a block's parts */
  uint32_t next_mark;                                 /* the next block's */
  const uint8_t* marks;         /* of empty blocks, in bits */
  const uint8_t* above;         /* the next column's vertex above the row */
  rg_modular_lanes plane;       /* the next column's vertices above and below
                                   the row but for their residuals */
  rg_modular_lanes column_step; /* of that */
  rg_lanes line, rest;          /* the lines above and below the row of parts,
                                   counted in the block from above and below */
  /* The lines at the last part's end: right has their positions; sums are these
   * times the number of parts, and rounded; steps change sums to the next part,
   * and turns change steps. */
  rg_lanes right, sums, steps, turns;
#else
  uint8_t is_void;    /* all of the lattice's are, whatever the table says */
  uint8_t bend_shift; /* for parts of this width */
  uint8_t num_log2;   /* log2 of four times a block's parts across */
  rg_span spans[2];   /* of the next part across, of the row of parts down */
#endif
} rg_block_walk;

static inline uint32_t rg_vertex_size(const uint8_t* section) {
  return section[10] != 0 ? RG_BENT_VERTEX_SIZE : RG_VERTEX_SIZE;
}

/* To the first part of row j of parts, the sizes of which are known. */
static RG_INLINE void rg_start_parts(rg_block_walk* walk, uint32_t j) {
#if RG_KEEP_LINES
  walk->row = (uint16_t)j;
  walk->next_part = 0;
#else
  uint32_t first = 0;
  RG_IN_REGISTER(first); /* else a loop around this keeps it */
  walk->spans[0].before = first;
  walk->spans[1].before = j * walk->spans[1].size;
#endif
}

/* Parts of 2^width_log2 x 2^height_log2 output pixels: a block is 1 to 8 such
 * parts wide and high, 1 in a table without bends. */
static RG_INLINE void rg_set_parts(rg_block_walk* walk, uint32_t width_log2,
                                   uint32_t height_log2) {
#if RG_KEEP_LINES
  walk->part_log2[0] = (uint8_t)width_log2;
  walk->part_log2[1] = (uint8_t)height_log2;
#else
  const uint8_t* const section = walk->section;
  const uint32_t whole_log2 = section[8] + 2u; /* of four blocks */
  const uint32_t num_log2 = whole_log2 - width_log2;
  walk->bend_shift = (uint8_t)(section[11] + width_log2 - section[10]);
  walk->num_log2 = (uint8_t)num_log2;
  walk->spans[0].size = UINT32_C(0x40000) >> num_log2;
  walk->spans[1].size = UINT32_C(0x40000) >> (whole_log2 - height_log2);
#endif
}

/* Sets the section and the parts' size, and goes to the first part of row j. */
static inline void rg_start_walk(const uint8_t* section, uint32_t width_log2,
                                 uint32_t height_log2, uint32_t j,
                                 rg_block_walk* walk) {
  walk->section = section;
  rg_set_parts(walk, width_log2, height_log2);
  rg_start_parts(walk, j);
}

/* The corners of the part, and on to the next one. */
void rg_next_block(rg_block_walk* walk, rg_block* block);

#if !RG_KEEP_LINES

/* The corners of the part, without its size, and on to the next one. */
void rg_next_corners(rg_block_walk* walk, rg_position corners[4]);

#else

static RG_INLINE rg_lanes rg_twice(int32_t x, int32_t y) {
  const rg_lanes both = {x, y, x, y};
  return both;
}

/* To the first column of vertices. */
void rg_start_columns(rg_block_walk* walk);

static RG_INLINE rg_lanes rg_twice_pair(rg_lanes lanes, uint32_t k) {
  const rg_lane_pairs pairs = (rg_lane_pairs)lanes;
  const rg_lane_pairs both = {pairs[k], pairs[k]};
  return (rg_lanes)both;
}

/* The points where the lines cross edges from one position to the other. */
static RG_INLINE rg_lanes rg_cross_edges(const rg_block_walk* walk,
                                         rg_lanes edges, rg_lanes bends) {
  const int32_t log2 = walk->num_log2[1];
  const rg_lanes from = rg_twice_pair(edges, 0);
  const rg_lanes to = rg_twice_pair(edges, 1);
  const rg_lanes sums = (to - from + bends * walk->rest) * walk->line;
  return from + ((sums + (1 << log2 >> 1)) >> log2);
}

/* The signed byte on top of each lane. */
static RG_INLINE rg_lanes rg_load_bends(uint32_t a, uint32_t b, uint32_t c,
                                        uint32_t d, int32_t shift) {
  const rg_modular_lanes bytes = {a, b, c, d};
  return (rg_lanes)((rg_modular_lanes)((rg_lanes)bytes >> 24) << shift);
}

/* To the next column of vertices: where the lines cross it, and their bends
 * from the column before to it, twice, if blocks have several parts. */
static RG_INLINE rg_lanes rg_next_column(rg_block_walk* walk, rg_lanes* turns) {
  const uint8_t* const above = walk->above;
  const uint8_t* const below = above + walk->row_size;
  const uint32_t a = rg_load_u32(above), b = rg_load_u32(below);
  const rg_modular_lanes halves = {a << 16, a, b << 16, b};
  const rg_modular_lanes residuals = (rg_modular_lanes)((rg_lanes)halves >> 16)
                                     << walk->residual_shift;
  const rg_lanes ends = (rg_lanes)(walk->plane + residuals);
  const rg_lanes none = {0, 0, 0, 0};
  walk->plane += walk->column_step;
  walk->above = above + walk->vertex_size;
  *turns = none;
  if (walk->vertex_size != RG_BENT_VERTEX_SIZE) return ends;
  const uint32_t c = rg_load_u32(above + RG_LEFT_BEND);
  const uint32_t d = rg_load_u32(below + RG_LEFT_BEND);
  if (walk->num_log2[0] != 0)
    *turns = 2 * rg_cross_edges(walk,
                                rg_load_bends(c << 24, c << 16, d << 24,
                                              d << 16, walk->bend_shift[0]),
                                none);
  return rg_cross_edges(
      walk, ends, rg_load_bends(d << 8, d, d << 8, d, walk->bend_shift[1]));
}

/* To the block that begins with the next part: in place, and out of line. */
static RG_INLINE void rg_enter_block(rg_block_walk* walk) {
  const int32_t log2 = walk->num_log2[0];
  const uint32_t mark = walk->next_mark++;
  walk->is_empty = (walk->marks[mark >> 3] >> (mark & 7)) & 1;
  rg_lanes turns;
  const rg_lanes from = walk->right, to = rg_next_column(walk, &turns);
  const rg_lanes bends = turns >> 1;
  walk->sums = (rg_lanes)((rg_modular_lanes)from << log2) + (1 << log2 >> 1);
  walk->steps = to - from - bends + (rg_lanes)((rg_modular_lanes)bends << log2);
  walk->turns = turns;
}

void rg_start_block(rg_block_walk* walk);

/* Goes on as rg_next_block() does, behind the first column: the corners on the
 * line above and on that below. */
static RG_INLINE void rg_next_corners(rg_block_walk* walk, rg_lanes* upper,
                                      rg_lanes* lower) {
  const int32_t log2 = walk->num_log2[0];
  if ((walk->next_part++ & ((1u << log2) - 1)) == 0) {
    if (RG_IS_FAST)
      rg_enter_block(walk);
    else
      rg_start_block(walk);
  }
  /* Differences: the sum of k steps is k (to - from + bend (num - k)). */
  const rg_lane_pairs left = (rg_lane_pairs)walk->right;
  walk->sums += walk->steps;
  walk->steps -= walk->turns;
  walk->right = walk->sums >> log2;
  const rg_lane_pairs right = (rg_lane_pairs)walk->right;
  const rg_lane_pairs above = {left[0], right[0]};
  const rg_lane_pairs below = {left[1], right[1]};
  *upper = (rg_lanes)above;
  *lower = (rg_lanes)below;
}

/* The corners of a block, which is aligned. */
static inline void rg_load_corners(const rg_position* corners, rg_lanes* upper,
                                   rg_lanes* lower) {
  corners = (const rg_position*)__builtin_assume_aligned(corners, 16);
  memcpy(upper, corners, sizeof(*upper));
  memcpy(lower, corners + 2, sizeof(*lower));
}

static inline void rg_store_corners(rg_lanes upper, rg_lanes lower,
                                    rg_position* corners) {
  corners = (rg_position*)__builtin_assume_aligned(corners, 16);
  memcpy(corners, &upper, sizeof(upper));
  memcpy(corners + 2, &lower, sizeof(lower));
}

#endif

/* A row of a block: pixel k comes from start + k step. */
typedef struct rg_block_row {
  rg_position start, step;
} rg_block_row;

/* (value + 2^(shift - 1)) >> shift; the sum modulo 2^32. */
static RG_INLINE int32_t rg_round_shift(uint32_t value, uint32_t shift) {
  return (int32_t)(value + (UINT32_C(1) << shift >> 1)) >> shift;
}

/* from + round((to - from) r / 2^shift), modulo 2^32. */
static RG_INLINE int32_t rg_point_between(int32_t from, int32_t to, uint32_t r,
                                          uint32_t shift) {
  return rg_add(from,
                rg_round_shift(((uint32_t)to - (uint32_t)from) * r, shift));
}

/* Coordinate c of row r of a block, r less than its height. Modulo 2^32, as all
 * that a forged table may bring there. */
static RG_INLINE void rg_find_row_axis(const rg_block* block, uint32_t r, int c,
                                       rg_block_row* row) {
  const rg_position* const corners = block->corners;
  const int32_t left = rg_point_between(corners[0].q12[c], corners[2].q12[c], r,
                                        block->height_log2);
  const int32_t right = rg_point_between(corners[1].q12[c], corners[3].q12[c],
                                         r, block->height_log2);
  row->start.q12[c] = left;
  row->step.q12[c] =
      rg_round_shift((uint32_t)right - (uint32_t)left, block->width_log2);
}

/* Row r: in place, and out of line. */
static RG_INLINE void rg_find_row(const rg_block* block, uint32_t r,
                                  rg_block_row* row) {
  rg_find_row_axis(block, r, 0, row);
  rg_find_row_axis(block, r, 1, row);
}
void rg_find_block_row(const rg_block* block, uint32_t r, rg_block_row* row);

/* To the row's next pixel, which it then begins with. */
static RG_INLINE void rg_go_on_in_row(rg_block_row* row) {
  for (int c = 0; c < 2; ++c)
    row->start.q12[c] = rg_add(row->start.q12[c], row->step.q12[c]);
}

static inline rg_position rg_row_position(const rg_block_row* row, uint32_t k) {
  rg_position p;
  for (int c = 0; c < 2; ++c)
    p.q12[c] = row->start.q12[c] + (int32_t)k * row->step.q12[c];
  return p;
}

#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_REMAP_TABLE_H */
