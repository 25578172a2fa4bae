/* The traversal optimized for stack and code size: tile by tile, and pixel by
 * pixel without a built-in kernel or where edge handling is required. */
#include "config.h"
#include "frames/walk.h"

#if !RG_FAST_WALK

#include <stddef.h>

#include "blob_layout.h"
#include "bytes.h"
#include "cortex_m/grey_rows.h"
#include "cortex_m/part_corners.h"
#include "frames/careful_pixels.h"
#include "frames/lattice_map.h"
#include "frames/pixel_formats.h"
#include "kernels/kernel.h"
#include "stack_code.h"

/* The traversal of a component's tiles, with the current tile as a span. */
typedef struct small_walk {
  rg_part_row parts;
  rg_source source;
  uint16_t width;        /* of the output, in component pixels */
  uint16_t row, end_row; /* of the output: behind the row of parts at hand, and
                            behind the last one to do */
  rg_run run;
  const uint8_t* ranges; /* of the positions that have a source, as a table's
                            section has them: |q12| below 2^27 */
} small_walk;

/* A function that interpolates a grey output pixel at a position. */
typedef uint8_t careful_pixel(const small_walk* walk,
                              const rg_position* position);

/* ---- Tiles --------------------------------------------------------------- */

/* Sets the table's data for any rows. The section must be set. */
static RG_INLINE void set_table(small_walk* walk, const rg_lattice* lattice) {
  const uint8_t* const section = walk->parts.section;
  const uint8_t across_log2 = rg_part_log2(section, lattice, 0);
  const uint8_t down_log2 = rg_part_log2(section, lattice, 1);
  rg_set_parts(&walk->parts, across_log2, down_log2);
  walk->run.first_pixel = walk->run.first_source_row = 0;
  walk->run.block.width_log2 = (uint8_t)(across_log2 - lattice->log2[0]);
  walk->run.block.height_log2 = (uint8_t)(down_log2 - lattice->log2[1]);
  walk->width =
      (uint16_t)(rg_load_u16(section + RG_REMAP_WIDTH) >> lattice->log2[0]);
}

/* Advances to the next row of tiles; 0 after the last one. */
static RG_INLINE int start_parts(small_walk* walk) {
  rg_run* const run = &walk->run;
  run->out += (size_t)run->num_rows * run->out_stride;
  const uint32_t log2 = run->block.height_log2;
  const uint32_t row = walk->row, part = row >> log2;
  if (row >= walk->end_row) return 0;
  walk->row = (uint16_t)rg_lesser((part + 1) << log2, walk->end_row);
  run->first_row = (uint16_t)(row - (part << log2));
  run->num_rows = (uint16_t)(walk->row - row);
  rg_start_parts(&walk->parts, part);
  return 1;
}

/* Advances to the next tile, with its block's corners in the image; 0 if there
 * is none. */
static int next_part(small_walk* walk, const rg_camera* camera) {
  rg_run* const run = &walk->run;
  uint32_t pixel = (uint32_t)run->out_pixel + run->num_pixels;
  if (pixel >= walk->width) {
    if (!start_parts(walk)) return 0;
    pixel = 0;
  }
  run->out_pixel = (uint16_t)pixel;
  run->num_pixels =
      (uint16_t)rg_lesser(walk->width - pixel, 1u << run->block.width_log2);
  rg_find_block_of_part(&walk->parts, camera->knot_shift);
  if (camera->weight_q14 != 0)
    camera->stack->pass_part(&walk->parts, run->block.corners, camera);
  else
    rg_pass_part(&walk->parts, run->block.corners);
  return 1;
}

/* Whether all positions have a source, and so has everything within a margin
 * around them. */
static int have_sources(const small_walk* walk, const rg_position* positions,
                        uint32_t num, int32_t margin) {
  const int32_t* q12 = positions->q12;
  if (walk->parts.is_empty) return 0;
  num *= 2;
  do {
    const uint8_t* const range = walk->ranges + 4 * (num & 1);
    if (*q12 < rg_load_i32(range) + margin ||
        *q12 > rg_load_i32(range + RG_REMAP_MIN_TO_MAX) - margin)
      return 0;
    ++q12;
  } while (--num != 0);
  return 1;
}

static RG_INLINE int has_source(const small_walk* walk,
                                const rg_position* position) {
  return have_sources(walk, position, 1, 0);
}

/* More than the rounding of a position; a component may end half a pixel before
 * the positions with a source. (The nearest pixel of such a position is not
 * after its last one, either.) */
#define LATTICE_MARGIN (RG_POSITION_MARGIN + 2048)

/* Whether no pixel of the tile needs edge handling, except for ring buffers.
 */
static RG_INLINE int is_part_safe(const small_walk* walk) {
  const rg_position* const corners = walk->run.block.corners;
  if (!RG_ALL_BUILT_IN) return have_sources(walk, corners, 4, LATTICE_MARGIN);
  /* Built-in kernels are fast, so this check should be, too. */
  if (walk->parts.is_empty) return 0;
  for (int c = 0; c < 2; ++c) {
    const uint8_t* const range = walk->ranges + 4 * c;
    const int32_t min = rg_load_i32(range) + LATTICE_MARGIN;
    const int32_t max =
        rg_load_i32(range + RG_REMAP_MIN_TO_MAX) - LATTICE_MARGIN;
    for (int k = 0; k < 4; ++k)
      if (corners[k].q12[c] < min || corners[k].q12[c] > max) return 0;
  }
  return 1;
}

/* ---- Rows of grey pixels ------------------------------------------------- */

/* Processes the current row pixel by pixel. */
static RG_INLINE void do_row(const small_walk* walk, careful_pixel* on_pixel,
                             const rg_block_row* row, uint8_t* out) {
  rg_position position;
  uint32_t pixel = 0;
  do {
    position = rg_row_position(row, pixel);
    out[pixel] = on_pixel(walk, &position);
  } while (++pixel != walk->run.num_pixels);
}

/* Processes a tile row by row, with less code than do_pixels() but more stack;
 * the corners are overwritten. If on_pixel is NULL, uses the kernel for grey
 * pixels where none is built in. */
static void do_part_by_rows(small_walk* walk, careful_pixel* on_pixel) {
  rg_grey_rows rows;
  rows.out = walk->run.out + walk->run.out_pixel;
  rows.corners = walk->run.block.corners;
  rows.rest = walk->run.num_rows;
  rows.rounding = on_pixel ? 0 : RG_FIRST_ROUNDING(&walk->run);
  rg_start_edges(&walk->run, rows.corners->q12, (uint32_t*)rows.corners->q12);
  rg_block_row row;
  while (RG_DO_GREY_ROWS(&rows, &row)) {
    do_row(walk, on_pixel, &row, rows.out);
    rows.out += walk->run.out_stride;
    if (--rows.rest == 0) break;
  }
}

/* ---- Grey frames --------------------------------------------------------- */

static const rg_lattice kGrey = {RG_SAMPLE_8, 0,      0, 1, 1,
                                 {0, 0},      {0, 0}, 0, 1, 0};

/* The traversal of a grey frame. */
typedef struct grey_walk {
  small_walk walk;
  uint8_t border;
} grey_walk;

static uint8_t find_grey_pixel(const small_walk* walk,
                               const rg_position* position) {
  if (!has_source(walk, position)) return ((const grey_walk*)walk)->border;
  return (uint8_t)rg_blend_careful_grey(&walk->source, &walk->run, position);
}

static RG_INLINE void do_grey_part(small_walk* walk) {
  const int is_safe = is_part_safe(walk);
  if (RG_ALL_BUILT_IN && is_safe)
    RG_BUILT_IN(1)(&walk->run);
  else
    do_part_by_rows(walk, is_safe ? NULL : find_grey_pixel);
}

rg_status rg_walk_grey(const rg_camera* camera, const rg_frame* frame,
                       const rg_band* band) {
  grey_walk whole;
  small_walk* const walk = &whole.walk;
  rg_run* const run = &walk->run;
  whole.border = band->border;
  walk->parts.section = camera->remap;
  walk->source.size[0] = frame->width;
  walk->source.size[1] = frame->height;
  run->data = frame->data;
  run->stride = frame->stride;
  run->out_stride = band->stride;
  walk->ranges = camera->remap + RG_REMAP_MIN_X;
  set_table(walk, &kGrey);
  walk->row = band->first_row;
  walk->end_row = (uint16_t)(band->first_row + band->num_rows);
  run->out = band->data;
  run->num_rows = run->out_pixel = 0;
  run->num_pixels = walk->width; /* after a row's last tile */
  while (next_part(walk, camera)) do_grey_part(walk);
  return RG_OK;
}

/* ---- Components ---------------------------------------------------------- */

/* The traversal of a component of any format. */
typedef struct lattice_walk {
  small_walk walk;
  rg_lattice lattice;
  uint32_t ranges[4]; /* of the lattice, as a section has those of the image */
} lattice_walk;

/* Sets the component's ranges from the image's. A range may contain none of the
 * component's positions: its end is before its begin. */
static RG_INLINE void set_ranges(lattice_walk* whole) {
  uint8_t* const ranges = (uint8_t*)whole->ranges;
  whole->walk.ranges = ranges;
  for (int c = 0; c < 2; ++c) {
    const rg_range range =
        rg_source_range(whole->walk.parts.section, &whole->lattice, c);
    rg_store_i32(ranges + 4 * c, range.min_q12);
    rg_store_i32(ranges + RG_REMAP_MIN_TO_MAX + 4 * c, range.max_q12);
  }
}

/* Starts a component's rows, which are counted in image pixels of the output;
 * run->out is for the first row. */
static void start_rows(lattice_walk* whole, const rg_camera* camera,
                       uint32_t first_row, uint32_t end_row) {
  small_walk* const walk = &whole->walk;
  const rg_lattice* const lattice = &whole->lattice;
  walk->parts.section = camera->remap;
  rg_set_source_size(camera, lattice, &walk->source);
  set_table(walk, lattice);
  walk->row = (uint16_t)(first_row >> lattice->log2[1]);
  walk->end_row = (uint16_t)(end_row >> lattice->log2[1]);
  /* A component has no pixels if the table is too narrow for it. */
  if (walk->width == 0) walk->end_row = 0;
  walk->run.num_rows = walk->run.out_pixel = 0;
  walk->run.num_pixels = walk->width; /* after a row's last tile */
  set_ranges(whole);
}

/* Transforms the corners of the tile from image to component pixels. */
static RG_INLINE void bring_to_lattice(lattice_walk* whole) {
  rg_block* const block = &whole->walk.run.block;
  rg_move_corners(&whole->lattice,
                  (uint32_t)block->width_log2 + whole->lattice.log2[0],
                  block->corners);
}

/* ---- Images -------------------------------------------------------------- */

/* The traversal for undistorting an image component by component. */
typedef struct image_walk {
  lattice_walk whole;
  const rg_target* target;
} image_walk;

/* Whether all rows that a safe tile requires are contiguous: its corners are
 * then relative to the first one in memory. */
static RG_NOINLINE int move_to_ring(small_walk* walk) {
  rg_position* const corners = walk->run.block.corners;
  uint32_t first;
  const uint32_t num =
      rg_find_ring_rows(&walk->source, corners[0].q12[1], &first);
  const int32_t first_q12 = (int32_t)(first << 12);
  const int32_t last_q12 = (int32_t)((first + num - 1) << 12);
  for (int k = 0; k < 4; ++k)
    if (corners[k].q12[1] < first_q12 + RG_POSITION_MARGIN ||
        corners[k].q12[1] > last_q12 - RG_POSITION_MARGIN)
      return 0;
  for (int k = 0; k < 4; ++k) corners[k].q12[1] -= first_q12;
  return 1;
}

/* Finds the neighbours of a pixel without edge handling. at has its position;
 * right neighbours are not set if pixels are copied. */
static RG_INLINE void find_safe_neighbors(const rg_run* run, rg_neighbors* at) {
  at->upper = run->data + (size_t)(rg_q12_of(at, 1) >> 12) * run->stride;
  at->lower = at->upper;
  if (at->right != 0) at->lower += run->stride;
}

/* Finds the neighbours of a pixel with edge handling: moves the position in at
 * to the nearest one with a source, and rounds it. */
static RG_NOINLINE void find_careful_neighbors(const image_walk* image,
                                               rg_neighbors* at) {
  const lattice_walk* const whole = &image->whole;
  for (int c = 0; c < 2; ++c) {
    const uint8_t* const min = whole->walk.ranges + 4 * c;
    const rg_range range = {rg_load_i32(min),
                            rg_load_i32(min + RG_REMAP_MIN_TO_MAX)};
    const int32_t nearest =
        rg_nearest_source(&whole->walk.source, range, at->position.q12[c], c);
    at->position.q12[c] =
        rg_round_position(image->target->sampling, &whole->lattice, nearest, c);
  }
  rg_find_neighbors(&whole->walk.source, &whole->walk.run, &whole->lattice, at);
}

/* Processes a pixel of a tile. at has its position. */
static RG_INLINE void do_image_pixel(const image_walk* image, int is_safe,
                                     rg_neighbors* at, uint32_t pixel) {
  const rg_lattice* const lattice = &image->whole.lattice;
  const small_walk* const walk = &image->whole.walk;
  if (is_safe) {
    find_safe_neighbors(&walk->run, at);
  } else if (image->target->border == RG_BORDER_CLAMP ||
             has_source(walk, &at->position)) {
    find_careful_neighbors(image, at);
  } else {
    rg_put_border(image->target, lattice, at, pixel);
    return;
  }
  rg_blend_pixel(lattice, at, pixel);
}

/* Processes a tile pixel by pixel. is_safe: without edge handling. */
static RG_NOINLINE void do_pixels(image_walk* image, int is_safe) {
  const int is_copy = image->target->sampling == RG_SAMPLING_NEAREST;
  rg_neighbors at;
  at.right = is_copy ? 0 : image->whole.lattice.sample_step;
  at.out = image->whole.walk.run.out;
  uint32_t r = 0;
  rg_run* run;
  do {
    rg_block_row row;
    RG_FORGET(image); /* otherwise its address uses a register */
    run = &image->whole.walk.run;
    rg_find_block_row(&run->block, run->first_row + r, &row);
    if (is_safe) rg_round_row(image->whole.lattice.kind, at.right == 0, &row);
    uint32_t k = 0;
    do {
      at.position = rg_row_position(&row, k);
      do_image_pixel(image, is_safe, &at, run->out_pixel + k);
    } while (++k != run->num_pixels);
    at.out += run->out_stride;
  } while (++r != run->num_rows);
}

/* Processes a tile without edge handling, by a kernel if there is one. */
static RG_INLINE void do_safe_part(image_walk* image) {
  const rg_lattice* const lattice = &image->whole.lattice;
  small_walk* const walk = &image->whole.walk;
  const int is_copy = image->target->sampling == RG_SAMPLING_NEAREST;
  if (!RG_ALL_BUILT_IN && !is_copy && rg_is_grey(lattice)) {
    do_part_by_rows(walk, NULL);
    return;
  }
  if (!RG_ALL_BUILT_IN || is_copy ||
      !rg_blend_built_in(&walk->run, rg_interleaved(lattice)))
    do_pixels(image, 1);
}

static RG_INLINE void remap_part(image_walk* image) {
  small_walk* const walk = &image->whole.walk;
  bring_to_lattice(&image->whole);
  if (is_part_safe(walk) && (walk->source.ring_rows == 0 || move_to_ring(walk)))
    do_safe_part(image);
  else
    do_pixels(image, 0);
}

/* Initialization before the first tile of the component. */
static RG_NOINLINE void start_lattice(image_walk* walk, const rg_camera* camera,
                                      const rg_image* image) {
  const rg_target* const target = walk->target;
  small_walk* const parts = &walk->whole.walk;
  rg_set_planes(&walk->whole.lattice, image, target, &parts->source,
                &parts->run);
  start_rows(&walk->whole, camera, target->first_row,
             (uint32_t)target->first_row + target->num_rows);
}

rg_status rg_walk_image(const rg_camera* camera, const rg_image* image,
                        const rg_target* target) {
  image_walk walk;
  lattice_walk* const whole = &walk.whole;
  walk.target = target;
  for (uint32_t k = 0; rg_find_lattice(image->format, k, &whole->lattice);
       k = whole->lattice.index + 1u) {
    start_lattice(&walk, camera, image);
    while (next_part(&whole->walk, camera)) remap_part(&walk);
  }
  return RG_OK;
}

/* ---- Rows of the source -------------------------------------------------- */

/* The traversal that determines source rows. */
typedef struct row_walk {
  lattice_walk whole;
  rg_row_search* search;
} row_walk;

/* The distance to the next relevant row or pixel of num_left: all are relevant,
 * or only the first and the last. */
static RG_INLINE uint32_t step_of(uint32_t num_left, int are_ends) {
  return are_ends && num_left > 1 ? num_left - 1 : 1;
}

/* Adds the rows that a tile requires: without edge handling, those of its
 * corners, which suffice, since positions are bilinear in a block; otherwise of
 * each pixel with a source. */
static RG_NOINLINE void add_part(const row_walk* walk, int is_safe) {
  uint32_t r = 0;
  const small_walk* parts;
  do {
    rg_block_row row;
    RG_FORGET(walk); /* otherwise its address uses a register */
    parts = &walk->whole.walk;
    rg_find_block_row(&parts->run.block, parts->run.first_row + r, &row);
    uint32_t num_left = parts->run.num_pixels;
    do {
      if (is_safe || has_source(parts, &row.start))
        rg_add_rows(&walk->search->source, row.start.q12[1],
                    parts->source.size[1], walk->whole.lattice.log2[1]);
      const uint32_t step = step_of(num_left, is_safe);
      row.start = rg_row_position(&row, step);
      num_left -= step;
    } while (num_left != 0);
    r += step_of(parts->run.num_rows - r, is_safe);
  } while (r != parts->run.num_rows);
}

void rg_walk_source_rows(const rg_camera* camera, rg_format format,
                         rg_row_search* search) {
  row_walk walk;
  lattice_walk* const whole = &walk.whole;
  walk.search = search;
  whole->walk.run.out = (uint8_t*)whole->ranges; /* no byte of it is written */
  whole->walk.run.out_stride = 0;
  for (uint32_t k = 0; rg_find_lattice(format, k, &whole->lattice);
       k = whole->lattice.index + 1u) {
    start_rows(whole, camera, walk.search->output.first,
               walk.search->output.end);
    while (next_part(&whole->walk, camera)) {
      bring_to_lattice(whole);
      add_part(&walk, is_part_safe(&whole->walk));
    }
  }
}

#endif
