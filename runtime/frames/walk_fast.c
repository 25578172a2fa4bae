/* The traversal optimized for speed: a tile is one span, or is divided into the
 * longest spans with uniform edge handling. */
#include "config.h"
#include "frames/walk.h"

#if RG_FAST_WALK

#include <stddef.h>

#include "blob_layout.h"
#include "bytes.h"
#include "frames/careful_pixels.h"
#include "frames/fast_corners.h"
#include "frames/lattice_map.h"
#include "frames/pixel_formats.h"
#include "kernels/kernel.h"

/* The edge handling that the pixels of a span require. */
typedef enum run_care {
  CARE_NONE,     /* their neighbours are in the source, in rows that follow each
                    other in memory, and so do the spare rows */
  CARE_SPARE,    /* their neighbours are, but perhaps not the spare rows */
  CARE_PIXEL,    /* a single pixel, which may have no source, or a source that
                    lacks neighbours */
  CARE_NO_SOURCE /* no pixel has a source */
} run_care;

/* The box of tile corners without edge handling. It contains no position if the
 * source is a ring buffer. */
typedef struct safe_box {
  rg_lanes min, max;
} safe_box;

/* The traversal of a component's tiles, and the current span. */
typedef struct fast_walk {
  rg_corner_lines lines;
  const rg_lattice* lattice;
  rg_source source;
  uint16_t num_rows;    /* of the source that follow each other in memory, from
                           the run's first_source_row on */
  uint16_t row;         /* first output row of the row of tiles */
  uint16_t end_row;     /* after the last one to process */
  uint8_t part_rows;    /* of the tiles; 0 before the first ones */
  uint8_t part_pixels;  /* of such a row, where the part at hand is done in
                           segments of rows; 0: not yet */
  uint8_t rows_left;    /* of the part; 0: the run is the last one */
  uint8_t is_clamped;   /* use the nearest source if there is none */
  uint16_t whole_parts; /* number in a row of tiles, from the left */
  rg_run run __attribute__((aligned(16)));
  const rg_kernels* kernels;
  rg_range ranges[2];   /* of positions with a source: x, y */
  rg_position position; /* of the pixel of a CARE_PIXEL span */
  safe_box safe;
  rg_lattice_lanes move;
} fast_walk;

static inline int32_t min_of(int32_t a, int32_t b) { return a < b ? a : b; }
static inline int32_t max_of(int32_t a, int32_t b) { return a > b ? a : b; }

/* ---- Tiles --------------------------------------------------------------- */

static RG_INLINE void load_corners(const rg_position* corners, rg_lanes* upper,
                                   rg_lanes* lower) {
  memcpy(upper, corners, sizeof(*upper));
  memcpy(lower, corners + 2, sizeof(*lower));
}

/* Computes the corners of the next tile in component pixels. */
static RG_INLINE void find_corners(fast_walk* walk, rg_position* corners) {
  const rg_lattice* const lattice = walk->lattice;
  rg_lanes upper, lower;
  rg_follow_lines(&walk->lines, &upper, &lower);
  if ((lattice->log2[0] | lattice->log2[1]) != 0)
    rg_lattice_corners(&walk->move, &upper, &lower);
  memcpy(corners, &upper, sizeof(upper));
  memcpy(corners + 2, &lower, sizeof(lower));
}

/* Whether a tile with these corners is a CARE_NONE span. */
static RG_INLINE int are_corners_safe(const fast_walk* walk,
                                      const rg_position* corners) {
  const safe_box* const box = &walk->safe;
  rg_lanes upper, lower;
  load_corners(corners, &upper, &lower);
  const rg_lane_pairs beyond =
      (rg_lane_pairs)((upper < box->min) | (upper > box->max) |
                      (lower < box->min) | (lower > box->max));
  return (beyond[0] | beyond[1]) == 0 && !walk->lines.is_empty;
}

static safe_box find_safe_box(const fast_walk* walk) {
  int32_t min[2], max[2];
  for (int c = 0; c < 2; ++c) {
    const rg_range source = walk->ranges[c];
    const int32_t last_q12 = (walk->source.size[c] - 1) * 4096;
    min[c] = max_of(source.min_q12, 0) + RG_POSITION_MARGIN;
    max[c] = min_of(source.max_q12, last_q12) - RG_POSITION_MARGIN;
  }
  if (RG_CHOOSE_KERNELS) max[1] -= RG_SPARE_Q12;
  if (walk->source.ring_rows != 0) max[1] = min[1] - 1;
  const safe_box box = {rg_twice(min[0], min[1]), rg_twice(max[0], max[1])};
  return box;
}

/* Starts a component's rows, which are counted in image pixels of the output;
 * run->out is for the first row. The component, ring_rows, is_clamped and
 * kernels must be set. */
static void start_rows(fast_walk* walk, const rg_camera* camera,
                       rg_row_range rows) {
  const uint8_t* const section = camera->remap;
  const rg_lattice* const lattice = walk->lattice;
  walk->lines.section = section;
  walk->lines.vertices = rg_find_vertices(section) + camera->knot_shift;
  walk->lines.knot_size = camera->knot_size;
  walk->lines.weight = camera->weight_q14;
  rg_set_source_size(camera, lattice, &walk->source);
  walk->num_rows = walk->source.size[1];
  walk->run.first_source_row = 0;
  for (int c = 0; c < 2; ++c) {
    walk->lines.part_log2[c] = rg_part_log2(section, lattice, c);
    walk->ranges[c] = rg_source_range(section, lattice, c);
  }
  walk->row = (uint16_t)(rows.first >> lattice->log2[1]);
  walk->end_row = (uint16_t)(rows.end >> lattice->log2[1]);
  /* A component has no pixels if the table is too narrow for it. */
  if (rg_load_u16(section + RG_REMAP_WIDTH) >> lattice->log2[0] == 0)
    walk->end_row = walk->row;
  walk->part_rows = walk->part_pixels = 0;
  walk->safe = find_safe_box(walk);
  walk->move = rg_find_lattice_lanes(lattice, walk->lines.part_log2[0]);
  walk->whole_parts = (uint16_t)(rg_load_u16(section + RG_REMAP_WIDTH) >>
                                 walk->lines.part_log2[0]);
}

/* Advances to the next row of tiles; 0 after the last one. */
static RG_INLINE int start_parts(fast_walk* walk) {
  rg_run* const run = &walk->run;
  run->out += (size_t)walk->part_rows * run->out_stride;
  const uint32_t row = (uint32_t)walk->row + walk->part_rows,
                 end = walk->end_row;
  if (row >= end) return 0;
  const uint32_t log2 =
      (uint32_t)walk->lines.part_log2[1] - walk->lattice->log2[1];
  const uint32_t part = row >> log2;
  const uint32_t next = (part + 1) << log2;
  walk->lines.row = (uint16_t)part;
  walk->lines.next_part = 0;
  run->first_row = (uint16_t)(row - (part << log2));
  walk->row = (uint16_t)row;
  walk->part_rows = (uint8_t)((next < end ? next : end) - row);
  return 1;
}

/* Computes the block of the next tile. */
static RG_INLINE void find_block(fast_walk* walk) {
  const rg_lattice* const lattice = walk->lattice;
  rg_block* const block = &walk->run.block;
  if (walk->lines.next_part == 0) rg_start_columns(&walk->lines);
  find_corners(walk, block->corners);
  block->width_log2 = (uint8_t)(walk->lines.part_log2[0] - lattice->log2[0]);
  block->height_log2 = (uint8_t)(walk->lines.part_log2[1] - lattice->log2[1]);
}

/* Advances to the next tile, without its block; 0 if there is none. */
static RG_INLINE int go_to_part(fast_walk* walk) {
  rg_run* const run = &walk->run;
  const rg_corner_lines* const lines = &walk->lines;
  if (walk->part_pixels != 0) { /* back to the tile's first row */
    const uint32_t rows = walk->part_rows - 1u;
    run->out -= (size_t)rows * run->out_stride;
    run->first_row = (uint16_t)(run->first_row - rows);
  }
  const uint32_t log2 = walk->lattice->log2[0];
  const uint32_t width =
      (uint32_t)rg_load_u16(lines->section + RG_REMAP_WIDTH) >> log2;
  const uint32_t part_width = 1u << lines->part_log2[0] >> log2;
  uint32_t first = lines->next_part * part_width;
  if (walk->part_rows == 0 || first >= width) {
    if (!start_parts(walk)) return 0;
    first = 0;
  }
  const uint32_t rest = width - first;
  run->out_pixel = (uint16_t)first;
  run->first_pixel = walk->part_pixels = 0;
  run->num_pixels = (uint16_t)(rest < part_width ? rest : part_width);
  run->num_rows = walk->rows_left = walk->part_rows;
  return 1;
}

/* Advances to the next tile; 0 if there is none. */
static int next_part(fast_walk* walk) {
  if (!go_to_part(walk)) return 0;
  find_block(walk);
  return 1;
}

/* Like next_part() if neither the current tile, which was processed in one
 * span, nor the next one is clipped by the right border; otherwise returns 0.
 * The corners of the block are kept. */
static RG_INLINE int next_whole_part(fast_walk* walk, rg_position* corners) {
  if (walk->part_pixels != 0 || walk->lines.next_part >= walk->whole_parts)
    return 0;
  walk->run.out_pixel = (uint16_t)(walk->run.out_pixel + walk->run.num_pixels);
  walk->rows_left = walk->part_rows;
  find_corners(walk, corners);
  return 1;
}

/* ---- Spans --------------------------------------------------------------- */

/* Whether a position has a source. */
static RG_INLINE int has_source(const fast_walk* walk,
                                const rg_position* position) {
  if (walk->lines.is_empty) return 0;
  for (int c = 0; c < 2; ++c)
    if (position->q12[c] < walk->ranges[c].min_q12 ||
        position->q12[c] > walk->ranges[c].max_q12)
      return 0;
  return 1;
}

/* The edge handling for positions whose coordinate c is between two values. */
static RG_INLINE run_care find_axis_care(const fast_walk* walk, int c,
                                         int32_t low, int32_t high) {
  const rg_range source = walk->ranges[c];
  const int32_t first = c == 0 ? 0 : walk->run.first_source_row;
  const int32_t num = c == 0 ? walk->source.size[0] : walk->num_rows;
  const int32_t end = min_of(source.max_q12, (first + num - 1) * 4096);
  low -= RG_POSITION_MARGIN;
  high += RG_POSITION_MARGIN;
  if (high < source.min_q12 || low > source.max_q12) return CARE_NO_SOURCE;
  if (low < max_of(source.min_q12, first * 4096) || high > end)
    return CARE_PIXEL;
  return RG_CHOOSE_KERNELS && c == 1 && high > end - RG_SPARE_Q12 ? CARE_SPARE
                                                                  : CARE_NONE;
}

/* The edge handling for positions between corners: the maximum over both
 * coordinates. */
static RG_INLINE run_care find_care(const fast_walk* walk, const rg_position* p,
                                    uint32_t num) {
  run_care care = CARE_NONE;
  for (int c = 0; c < 2; ++c) {
    int32_t low = p[0].q12[c], high = low;
    for (uint32_t k = num; --k != 0;) {
      low = min_of(low, p[k].q12[c]);
      high = max_of(high, p[k].q12[c]);
    }
    const run_care axis_care = find_axis_care(walk, c, low, high);
    if (axis_care > care) care = axis_care;
  }
  return care == CARE_NO_SOURCE && walk->is_clamped ? CARE_PIXEL : care;
}

/* The edge handling of the current tile. */
static RG_INLINE run_care find_part_care(const fast_walk* walk) {
  if (walk->lines.is_empty && !walk->is_clamped) return CARE_NO_SOURCE;
  if (are_corners_safe(walk, walk->run.block.corners)) return CARE_NONE;
  return find_care(walk, walk->run.block.corners, 4);
}

/* Advances to the pixels after the span, which are in one row of a tile. */
static RG_INLINE void go_on_in_part(fast_walk* walk) {
  rg_run* const run = &walk->run;
  const uint32_t end = walk->part_pixels;
  run->first_pixel = (uint16_t)(run->first_pixel + run->num_pixels);
  run->out_pixel = (uint16_t)(run->out_pixel + run->num_pixels);
  if (run->first_pixel < end) return;
  run->first_pixel = 0;
  run->out_pixel = (uint16_t)(run->out_pixel - end);
  ++run->first_row;
  run->out += run->out_stride;
}

/* Finds the span of a row's next pixels with uniform edge handling: all
 * remaining ones, half of them, and so on, or one. */
static RG_INLINE run_care find_segment(fast_walk* walk) {
  rg_run* const run = &walk->run;
  go_on_in_part(walk);
  uint32_t num = (uint32_t)walk->part_pixels - run->first_pixel;
  rg_block_row row;
  rg_position ends[2];
  run_care care;
  rg_find_block_row(&run->block, run->first_row, &row);
  walk->position = ends[0] = rg_row_position(&row, run->first_pixel);
  for (;; num >>= 1) {
    for (int c = 0; c < 2; ++c)
      ends[1].q12[c] = ends[0].q12[c] + (int32_t)(num - 1) * row.step.q12[c];
    care = find_care(walk, ends, 2);
    if (care != CARE_PIXEL || num == 1) break;
  }
  run->num_pixels = (uint16_t)num;
  if (run->first_pixel + num == walk->part_pixels) --walk->rows_left;
  return care;
}

/* Finds the tile's next span and its edge handling; while rows_left is not 0,
 * there is another one. */
static run_care next_run(fast_walk* walk) {
  rg_run* const run = &walk->run;
  if (walk->part_pixels == 0) {
    const run_care care = find_part_care(walk);
    if (care != CARE_PIXEL) {
      walk->rows_left = 0;
      return care;
    }
    walk->part_pixels = (uint8_t)run->num_pixels;
    run->num_pixels = 0; /* none is processed yet */
    run->num_rows = 1;
  }
  return find_segment(walk);
}

/* ---- Consecutive safe tiles ---------------------------------------------- */

/* The kernel that interpolates several adjacent tiles; NULL if there is none
 * for the current tiles. */
static RG_INLINE rg_blend_parts* find_blend_parts(const fast_walk* walk) {
  const uint32_t channels = rg_interleaved(walk->lattice);
  const rg_block* const block = &walk->run.block;
  return walk->kernels && channels != 0 && block->width_log2 == 3 &&
                 block->height_log2 == 3 && walk->part_rows == 8
             ? walk->kernels->blend_parts[channels - 1]
             : NULL;
}

/* Interpolates the tiles to the right of the current one, several at once, as
 * long as they are whole and safe. Returns whether the tile reached is to be
 * processed with edge handling. */
static int blend_safe_parts(fast_walk* walk, rg_blend_parts* blend_parts) {
  rg_position corners[4 * RG_PARTS_AT_ONCE];
  for (;;) {
    rg_run* const run = &walk->run;
    const uint32_t first = (uint32_t)run->out_pixel + run->num_pixels;
    uint32_t num = 0;
    int is_next = 0, is_safe = 1;
    while (num < RG_PARTS_AT_ONCE &&
           (is_next = next_whole_part(walk, &corners[4 * num])) &&
           (is_safe = are_corners_safe(walk, &corners[4 * num])))
      ++num;
    if (num != 0) {
      const uint16_t last = run->out_pixel;
      run->out_pixel = (uint16_t)first;
      blend_parts(run, corners, num);
      run->out_pixel = last;
    }
    if (!is_safe)
      memcpy(run->block.corners, &corners[4 * num], sizeof(run->block.corners));
    if (!is_next || !is_safe) return is_next;
  }
}

/* Processes the tiles to the right of the current one while they are whole and
 * safe. Returns whether the tile reached requires edge handling. */
static RG_INLINE int do_safe_parts(fast_walk* walk, rg_sampling sampling) {
  const int is_copy = sampling == RG_SAMPLING_NEAREST;
  if (RG_HAS_PART_KERNELS && !is_copy) {
    rg_blend_parts* const blend_parts = find_blend_parts(walk);
    if (blend_parts) return blend_safe_parts(walk, blend_parts);
  }
  while (next_whole_part(walk, walk->run.block.corners)) {
    if (!are_corners_safe(walk, walk->run.block.corners)) return 1;
    if (is_copy)
      rg_copy_lattice(&walk->run, walk->lattice);
    else
      rg_dispatch(walk->kernels, &walk->run, walk->lattice, 1);
  }
  return 0;
}

/* ---- The border ---------------------------------------------------------- */

/* Fills pixels whose 8-bit channels fill the plane: 8 bytes at once; after at
 * most three such steps, the first channel is aligned again. */
static RG_INLINE void fill_bytes(const rg_run* run, uint32_t channels,
                                 const uint16_t* values) {
  uint8_t pattern[24];
  const uint32_t num_bytes = run->num_pixels * channels;
  uint8_t* out = run->out + run->out_pixel * channels;
  for (uint32_t k = 0, c = 0; k < 24 && k < num_bytes; ++k) {
    pattern[k] = (uint8_t)values[c];
    c = c + 1 == channels ? 0 : c + 1;
    RG_IN_REGISTER(c); /* otherwise compilers call memset() */
  }
  for (uint32_t r = run->num_rows; r != 0; --r, out += run->out_stride) {
    uint32_t k = 0, phase = 0;
    for (; k + 8 <= num_bytes; k += 8) {
      memcpy(out + k, pattern + phase, 8);
      phase = phase == 16 ? 0 : phase + 8;
    }
    for (; k < num_bytes; ++k) out[k] = pattern[phase + (k & 7)];
  }
}

static RG_INLINE void put_value(const rg_lattice* lattice, uint8_t* row,
                                uint32_t index, uint32_t value) {
  if (lattice->kind == RG_SAMPLE_8)
    row[index] = (uint8_t)value;
  else
    rg_put_sample(lattice->kind, row, index, value);
}

/* Fills the pixels of a span with the border of the component's channels. */
static RG_INLINE void fill_run(const rg_run* run, const rg_lattice* lattice,
                               const uint16_t* values) {
  if (RG_IS_FAST && rg_interleaved(lattice) != 0) {
    fill_bytes(run, lattice->num_channels, values);
    return;
  }
  uint8_t* out = run->out;
  for (uint32_t r = run->num_rows; r != 0; --r, out += run->out_stride) {
    uint32_t index = rg_first_sample(lattice, run->out_pixel);
    for (uint32_t k = run->num_pixels; k != 0; --k) {
      for (uint32_t c = 0; c < lattice->num_channels; ++c)
        put_value(lattice, out, index + c, values[c]);
      index += lattice->sample_step;
      RG_IN_REGISTER(index); /* otherwise compilers call memset() */
    }
  }
}

/* ---- Grey frames --------------------------------------------------------- */

static const rg_lattice kGrey = {RG_SAMPLE_8, 0,      0, 1, 1,
                                 {0, 0},      {0, 0}, 0, 1, 0};

static RG_INLINE void do_grey_pixel(const fast_walk* walk, uint8_t border) {
  const rg_run* const run = &walk->run;
  uint32_t value = border;
  if (has_source(walk, &walk->position))
    value = rg_blend_careful_grey(&walk->source, run, &walk->position);
  run->out[run->out_pixel] = (uint8_t)value;
}

static RG_INLINE void do_grey_part(fast_walk* walk, uint16_t border) {
  do {
    const run_care care = next_run(walk);
    if (care == CARE_PIXEL)
      do_grey_pixel(walk, (uint8_t)border);
    else if (care == CARE_NO_SOURCE)
      fill_run(&walk->run, &kGrey, &border);
    else
      rg_dispatch_grey(walk->kernels, &walk->run, care == CARE_NONE);
  } while (walk->rows_left != 0);
}

rg_status rg_walk_grey(const rg_camera* camera, const rg_frame* frame,
                       const rg_band* band) {
  fast_walk walk;
  walk.lattice = &kGrey;
  walk.kernels = rg_choose_kernels(0, frame->stride);
  walk.is_clamped = 0;
  walk.source.ring_rows = 0;
  walk.run.data = frame->data;
  walk.run.stride = frame->stride;
  walk.run.out = band->data;
  walk.run.out_stride = band->stride;
  const rg_row_range rows = {band->first_row,
                             (uint16_t)(band->first_row + band->num_rows)};
  start_rows(&walk, camera, rows);
  while (next_part(&walk)) {
    do {
      do_grey_part(&walk, band->border);
    } while (do_safe_parts(&walk, RG_SAMPLING_BILINEAR));
  }
  return RG_OK;
}

/* ---- Images -------------------------------------------------------------- */

/* Selects the rows of the ring buffer around the top of the tile: pixels that
 * need other rows are processed individually. */
static RG_NOINLINE void choose_ring_rows(fast_walk* walk) {
  const rg_position* const corners = walk->run.block.corners;
  int32_t top = (walk->source.size[1] - 1) << 12;
  for (int k = 0; k < 4; ++k)
    if (corners[k].q12[1] < top) top = corners[k].q12[1];
  uint32_t first;
  walk->num_rows = (uint16_t)rg_find_ring_rows(&walk->source, top, &first);
  walk->run.first_source_row = (uint16_t)first;
}

static RG_INLINE int32_t nearest_position(const fast_walk* walk,
                                          rg_sampling sampling, int c) {
  const int32_t q12 = rg_nearest_source(&walk->source, walk->ranges[c],
                                        walk->position.q12[c], c);
  return rg_round_position(sampling, walk->lattice, q12, c);
}

/* Processes the pixel of a CARE_PIXEL span, with every check. */
static RG_NOINLINE void remap_pixel(const fast_walk* walk,
                                    const rg_target* target) {
  const rg_run* const run = &walk->run;
  rg_neighbors at;
  at.out = run->out;
  if (!walk->is_clamped && !has_source(walk, &walk->position)) {
    rg_put_border(target, walk->lattice, &at, run->out_pixel);
    return;
  }
  for (int c = 0; c < 2; ++c)
    at.position.q12[c] = nearest_position(walk, target->sampling, c);
  rg_find_neighbors(&walk->source, run, walk->lattice, &at);
  rg_blend_pixel(walk->lattice, &at, run->out_pixel);
}

static RG_NOINLINE void fill_border(const fast_walk* walk,
                                    const rg_target* target) {
  if (target->border != RG_BORDER_KEEP)
    fill_run(&walk->run, walk->lattice,
             target->border_values + walk->lattice->index);
}

static RG_INLINE void remap_part(fast_walk* walk, const rg_target* target) {
  if (walk->source.ring_rows != 0) choose_ring_rows(walk);
  do {
    const run_care care = next_run(walk);
    if (care == CARE_PIXEL)
      remap_pixel(walk, target);
    else if (care == CARE_NO_SOURCE)
      fill_border(walk, target);
    else if (target->sampling == RG_SAMPLING_NEAREST)
      rg_copy_lattice(&walk->run, walk->lattice);
    else
      rg_dispatch(walk->kernels, &walk->run, walk->lattice, care == CARE_NONE);
  } while (walk->rows_left != 0);
}

/* Initialization before the first tile of a component. */
static RG_NOINLINE void start_lattice(fast_walk* walk, const rg_camera* camera,
                                      const rg_image* image,
                                      const rg_target* target) {
  const uint32_t plane = walk->lattice->plane;
  walk->kernels =
      rg_choose_kernels(target->kernels, image->planes[plane].stride);
  walk->is_clamped = target->border == RG_BORDER_CLAMP;
  rg_set_planes(walk->lattice, image, target, &walk->source, &walk->run);
  const rg_row_range rows = {target->first_row,
                             (uint16_t)(target->first_row + target->num_rows)};
  start_rows(walk, camera, rows);
}

rg_status rg_walk_image(const rg_camera* camera, const rg_image* image,
                        const rg_target* target) {
  fast_walk walk;
  rg_lattice lattice;
  walk.lattice = &lattice;
  for (uint32_t k = 0; rg_find_lattice(image->format, k, &lattice); ++k) {
    start_lattice(&walk, camera, image, target);
    while (next_part(&walk)) {
      do {
        remap_part(&walk, target);
      } while (do_safe_parts(&walk, target->sampling));
    }
  }
  return RG_OK;
}

/* ---- Rows of the source -------------------------------------------------- */

/* Adds the rows that a span requires. Positions are bilinear in a block: if all
 * have a source, the span's corners suffice. */
static RG_NOINLINE void add_run(const fast_walk* walk, rg_row_range* found) {
  const rg_run* const run = &walk->run;
  const int32_t num_rows = walk->source.size[1];
  const uint32_t log2 = walk->lattice->log2[1];
  uint32_t r = run->first_row;
  for (uint32_t k = 0; k < 2; ++k, r += run->num_rows - 1u) {
    rg_block_row row;
    rg_find_block_row(&run->block, r, &row);
    const int32_t step = row.step.q12[1];
    const int32_t y_q12 = row.start.q12[1] + step * run->first_pixel;
    rg_add_rows(found, y_q12, num_rows, log2);
    rg_add_rows(found, y_q12 + step * (run->num_pixels - 1), num_rows, log2);
  }
}

static RG_INLINE void add_part(fast_walk* walk, rg_row_range* found) {
  do {
    const run_care care = next_run(walk);
    if (care == CARE_PIXEL ? has_source(walk, &walk->position)
                           : care != CARE_NO_SOURCE)
      add_run(walk, found);
  } while (walk->rows_left != 0);
}

void rg_walk_source_rows(const rg_camera* camera, rg_format format,
                         rg_row_search* search) {
  fast_walk walk;
  rg_lattice lattice;
  walk.lattice = &lattice;
  walk.kernels = 0;
  walk.is_clamped = 0;
  walk.source.ring_rows = 0;
  walk.run.out = (uint8_t*)search; /* no byte of it is written */
  walk.run.out_stride = 0;
  for (uint32_t k = 0; rg_find_lattice(format, k, &lattice); ++k) {
    start_rows(&walk, camera, search->output);
    while (next_part(&walk)) add_part(&walk, &search->source);
  }
}

#endif
