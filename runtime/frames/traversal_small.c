/* The traversal optimized for stack and code size: tile by tile, and pixel by
 * pixel without a built-in kernel or where edge handling is required. */
#include "config.h"
#include "frames/traversal.h"

#if !RG_FAST_TRAVERSAL

#include <stddef.h>

#include "blob_layout.h"
#include "bytes.h"
#include "cortex_m/grey_rows.h"
#include "cortex_m/tile_corners.h"
#include "frames/component_map.h"
#include "frames/edge_pixels.h"
#include "frames/pixel_formats.h"
#include "kernels/kernel.h"
#include "operating_point_ops.h"

/* The traversal of a component's tiles, with the current tile as a span. */
typedef struct small_traversal {
  rg_tile_row tiles;
  rg_source source;
  uint16_t width;        /* output width in component pixels */
  uint16_t row, end_row; /* output rows: first after the current row of tiles,
                            and end of the rows to process */
  rg_span span;
  const uint8_t* ranges; /* ranges of positions with a source, in the format
                            of a table's section: |q12| below 2^27 */
} small_traversal;

/* A function that interpolates a grey output pixel at a position. */
typedef uint8_t edge_pixel(const small_traversal* traversal,
                           const rg_position* position);

/* ---- Tiles --------------------------------------------------------------- */

/* Sets the table's data for any rows. The section must be set. */
static RG_INLINE void set_table(small_traversal* traversal,
                                const rg_component* component) {
  const uint8_t* const section = traversal->tiles.section;
  const uint8_t across_log2 = rg_tile_log2(section, component, 0);
  const uint8_t down_log2 = rg_tile_log2(section, component, 1);
  rg_set_tile_size(&traversal->tiles, across_log2, down_log2);
  traversal->span.first_pixel = traversal->span.first_source_row = 0;
  traversal->span.block.width_log2 =
      (uint8_t)(across_log2 - component->log2[0]);
  traversal->span.block.height_log2 = (uint8_t)(down_log2 - component->log2[1]);
  traversal->width =
      (uint16_t)(rg_load_u16(section + RG_REMAP_WIDTH) >> component->log2[0]);
}

/* Advances to the next row of tiles; 0 after the last one. */
static RG_INLINE int start_tile_row(small_traversal* traversal) {
  rg_span* const span = &traversal->span;
  span->out += (size_t)span->num_rows * span->out_stride;
  const uint32_t log2 = span->block.height_log2;
  const uint32_t row = traversal->row, tile = row >> log2;
  if (row >= traversal->end_row) return 0;
  traversal->row = (uint16_t)rg_lesser((tile + 1) << log2, traversal->end_row);
  span->first_row = (uint16_t)(row - (tile << log2));
  span->num_rows = (uint16_t)(traversal->row - row);
  rg_start_tile_row(&traversal->tiles, tile);
  return 1;
}

/* Advances to the next tile, with its block's corners in the image; 0 if there
 * is none. */
static int next_tile(small_traversal* traversal, const rg_camera* camera) {
  rg_span* const span = &traversal->span;
  uint32_t pixel = (uint32_t)span->out_pixel + span->num_pixels;
  if (pixel >= traversal->width) {
    if (!start_tile_row(traversal)) return 0;
    pixel = 0;
  }
  span->out_pixel = (uint16_t)pixel;
  span->num_pixels = (uint16_t)rg_lesser(traversal->width - pixel,
                                         1u << span->block.width_log2);
  rg_find_tile_block(&traversal->tiles, camera->sample_shift);
  if (camera->weight_q14 != 0)
    camera->stack->next_tile(&traversal->tiles, span->block.corners, camera);
  else
    rg_next_tile(&traversal->tiles, span->block.corners);
  return 1;
}

/* Whether all positions, including a margin around them, have a source. */
static int have_sources(const small_traversal* traversal,
                        const rg_position* positions, uint32_t num,
                        int32_t margin) {
  const int32_t* q12 = positions->q12;
  if (traversal->tiles.is_block_empty) return 0;
  num *= 2;
  do {
    const uint8_t* const range = traversal->ranges + 4 * (num & 1);
    if (*q12 < rg_load_i32(range) + margin ||
        *q12 > rg_load_i32(range + RG_REMAP_MIN_TO_MAX) - margin)
      return 0;
    ++q12;
  } while (--num != 0);
  return 1;
}

static RG_INLINE int has_source(const small_traversal* traversal,
                                const rg_position* position) {
  return have_sources(traversal, position, 1, 0);
}

/* The margin exceeds the rounding of a position. A component may end half a
 * pixel before the positions with a source do. (Even then, the nearest pixel of
 * such a position is not after the last one.) */
#define COMPONENT_MARGIN (RG_POSITION_MARGIN + 2048)

/* Whether no pixel of the tile needs edge handling, except for ring buffers.
 */
static RG_INLINE int is_interior_tile(const small_traversal* traversal) {
  const rg_position* const corners = traversal->span.block.corners;
  if (!RG_ALL_BUILT_IN)
    return have_sources(traversal, corners, 4, COMPONENT_MARGIN);
  /* Built-in kernels are fast, so this check must be fast as well. */
  if (traversal->tiles.is_block_empty) return 0;
  for (int c = 0; c < 2; ++c) {
    const uint8_t* const range = traversal->ranges + 4 * c;
    const int32_t min = rg_load_i32(range) + COMPONENT_MARGIN;
    const int32_t max =
        rg_load_i32(range + RG_REMAP_MIN_TO_MAX) - COMPONENT_MARGIN;
    for (int k = 0; k < 4; ++k)
      if (corners[k].q12[c] < min || corners[k].q12[c] > max) return 0;
  }
  return 1;
}

/* ---- Rows of grey pixels ------------------------------------------------- */

/* Processes the current row pixel by pixel. */
static RG_INLINE void process_row(const small_traversal* traversal,
                                  edge_pixel* on_pixel, const rg_block_row* row,
                                  uint8_t* out) {
  rg_position position;
  uint32_t pixel = 0;
  do {
    position = rg_row_position(row, pixel);
    out[pixel] = on_pixel(traversal, &position);
  } while (++pixel != traversal->span.num_pixels);
}

/* Processes a tile row by row, with less code than process_pixels() but more
 * stack; the corners are overwritten. If on_pixel is NULL, uses the kernel for
 * grey pixels where none is built in. */
static void process_tile_by_rows(small_traversal* traversal,
                                 edge_pixel* on_pixel) {
  rg_grey_rows rows;
  rows.out = traversal->span.out + traversal->span.out_pixel;
  rows.corners = traversal->span.block.corners;
  rows.rest = traversal->span.num_rows;
  rows.rounding = on_pixel ? 0 : RG_FIRST_ROUNDING(&traversal->span);
  rg_start_edges(&traversal->span, rows.corners->q12,
                 (uint32_t*)rows.corners->q12);
  rg_block_row row;
  while (RG_PROCESS_GREY_ROWS(&rows, &row)) {
    process_row(traversal, on_pixel, &row, rows.out);
    rows.out += traversal->span.out_stride;
    if (--rows.rest == 0) break;
  }
}

/* ---- Grey frames --------------------------------------------------------- */

static const rg_component kGrey = {RG_SAMPLE_8, 0,      0, 1, 1,
                                   {0, 0},      {0, 0}, 0, 1, 0};

/* The traversal of a grey frame. */
typedef struct grey_traversal {
  small_traversal traversal;
  uint8_t border;
} grey_traversal;

static uint8_t compute_grey_pixel(const small_traversal* traversal,
                                  const rg_position* position) {
  if (!has_source(traversal, position))
    return ((const grey_traversal*)traversal)->border;
  return (uint8_t)rg_blend_edge_grey(&traversal->source, &traversal->span,
                                     position);
}

static RG_INLINE void process_grey_tile(small_traversal* traversal) {
  const int is_interior = is_interior_tile(traversal);
  if (RG_ALL_BUILT_IN && is_interior)
    RG_BUILT_IN(1)(&traversal->span);
  else
    process_tile_by_rows(traversal, is_interior ? NULL : compute_grey_pixel);
}

rg_status rg_traverse_grey(const rg_camera* camera, const rg_grey_image* frame,
                           const rg_grey_target* band) {
  grey_traversal whole;
  small_traversal* const traversal = &whole.traversal;
  rg_span* const span = &traversal->span;
  whole.border = band->border;
  traversal->tiles.section = camera->remap;
  traversal->source.size[0] = frame->width;
  traversal->source.size[1] = frame->height;
  span->data = frame->data;
  span->stride = frame->stride;
  span->out_stride = band->stride;
  traversal->ranges = camera->remap + RG_REMAP_MIN_X;
  set_table(traversal, &kGrey);
  traversal->row = band->first_row;
  traversal->end_row = (uint16_t)(band->first_row + band->num_rows);
  span->out = band->data;
  span->num_rows = span->out_pixel = 0;
  span->num_pixels = traversal->width; /* after a row's last tile */
  while (next_tile(traversal, camera)) process_grey_tile(traversal);
  return RG_OK;
}

/* ---- Components ---------------------------------------------------------- */

/* The traversal of a component of any format. */
typedef struct component_traversal {
  small_traversal traversal;
  rg_component component;
  uint32_t ranges[4]; /* the component's ranges, in the format of a section */
} component_traversal;

/* Sets the component's ranges from the image's. A range may contain none of the
 * component's positions: its end is before its begin. */
static RG_INLINE void set_ranges(component_traversal* whole) {
  uint8_t* const ranges = (uint8_t*)whole->ranges;
  whole->traversal.ranges = ranges;
  for (int c = 0; c < 2; ++c) {
    const rg_range range =
        rg_source_range(whole->traversal.tiles.section, &whole->component, c);
    rg_store_i32(ranges + 4 * c, range.min_q12);
    rg_store_i32(ranges + RG_REMAP_MIN_TO_MAX + 4 * c, range.max_q12);
  }
}

/* Starts a component's rows, which are counted in image pixels of the output;
 * span->out is for the first row. */
static void start_rows(component_traversal* whole, const rg_camera* camera,
                       uint32_t first_row, uint32_t end_row) {
  small_traversal* const traversal = &whole->traversal;
  const rg_component* const component = &whole->component;
  traversal->tiles.section = camera->remap;
  rg_set_source_size(camera, component, &traversal->source);
  set_table(traversal, component);
  traversal->row = (uint16_t)(first_row >> component->log2[1]);
  traversal->end_row = (uint16_t)(end_row >> component->log2[1]);
  /* A component has no pixels if the table is too narrow for it. */
  if (traversal->width == 0) traversal->end_row = 0;
  traversal->span.num_rows = traversal->span.out_pixel = 0;
  traversal->span.num_pixels = traversal->width; /* after a row's last tile */
  set_ranges(whole);
}

/* Transforms the corners of the tile from image to component pixels. */
static RG_INLINE void transform_to_component(component_traversal* whole) {
  rg_block* const block = &whole->traversal.span.block;
  rg_transform_corners(&whole->component,
                       (uint32_t)block->width_log2 + whole->component.log2[0],
                       block->corners);
}

/* ---- Images -------------------------------------------------------------- */

/* The traversal for undistorting an image component by component. */
typedef struct image_traversal {
  component_traversal whole;
  const rg_target* target;
} image_traversal;

/* Returns whether all rows that an interior tile requires are contiguous: its
 * corners are then relative to the first one in memory. */
static RG_NOINLINE int move_to_ring(small_traversal* traversal) {
  rg_position* const corners = traversal->span.block.corners;
  uint32_t first;
  const uint32_t num =
      rg_find_ring_rows(&traversal->source, corners[0].q12[1], &first);
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
static RG_INLINE void get_interior_neighbors(const rg_span* span,
                                             rg_neighbors* at) {
  at->upper = span->data + (size_t)(rg_get_q12(at, 1) >> 12) * span->stride;
  at->lower = at->upper;
  if (at->right != 0) at->lower += span->stride;
}

/* Finds the neighbours of a pixel with edge handling: moves at->position to
 * the nearest position with a source, and rounds it. */
static RG_NOINLINE void get_edge_neighbors(const image_traversal* image,
                                           rg_neighbors* at) {
  const component_traversal* const whole = &image->whole;
  for (int c = 0; c < 2; ++c) {
    const uint8_t* const min = whole->traversal.ranges + 4 * c;
    const rg_range range = {rg_load_i32(min),
                            rg_load_i32(min + RG_REMAP_MIN_TO_MAX)};
    const int32_t nearest = rg_nearest_source(&whole->traversal.source, range,
                                              at->position.q12[c], c);
    at->position.q12[c] = rg_round_position(image->target->sampling,
                                            &whole->component, nearest, c);
  }
  rg_find_neighbors(&whole->traversal.source, &whole->traversal.span,
                    &whole->component, at);
}

/* Processes a pixel of a tile. at has its position. */
static RG_INLINE void process_image_pixel(const image_traversal* image,
                                          int is_interior, rg_neighbors* at,
                                          uint32_t pixel) {
  const rg_component* const component = &image->whole.component;
  const small_traversal* const traversal = &image->whole.traversal;
  if (is_interior) {
    get_interior_neighbors(&traversal->span, at);
  } else if (image->target->border == RG_BORDER_CLAMP ||
             has_source(traversal, &at->position)) {
    get_edge_neighbors(image, at);
  } else {
    rg_put_border(image->target, component, at, pixel);
    return;
  }
  rg_blend_pixel(component, at, pixel);
}

/* Processes a tile pixel by pixel. is_interior: without edge handling. */
static RG_NOINLINE void process_pixels(image_traversal* image,
                                       int is_interior) {
  const int is_copy = image->target->sampling == RG_SAMPLING_NEAREST;
  rg_neighbors at;
  at.right = is_copy ? 0 : image->whole.component.sample_step;
  at.out = image->whole.traversal.span.out;
  uint32_t r = 0;
  rg_span* span;
  do {
    rg_block_row row;
    RG_FORGET(image); /* otherwise its address uses a register */
    span = &image->whole.traversal.span;
    rg_compute_block_row(&span->block, span->first_row + r, &row);
    if (is_interior)
      rg_round_row(image->whole.component.kind, at.right == 0, &row);
    uint32_t k = 0;
    do {
      at.position = rg_row_position(&row, k);
      process_image_pixel(image, is_interior, &at, span->out_pixel + k);
    } while (++k != span->num_pixels);
    at.out += span->out_stride;
  } while (++r != span->num_rows);
}

/* Processes a tile without edge handling, by a kernel if there is one. */
static RG_INLINE void process_interior_tile(image_traversal* image) {
  const rg_component* const component = &image->whole.component;
  small_traversal* const traversal = &image->whole.traversal;
  const int is_copy = image->target->sampling == RG_SAMPLING_NEAREST;
  if (!RG_ALL_BUILT_IN && !is_copy && rg_is_grey(component)) {
    process_tile_by_rows(traversal, NULL);
    return;
  }
  if (!RG_ALL_BUILT_IN || is_copy ||
      !rg_blend_built_in(&traversal->span, rg_interleaved(component)))
    process_pixels(image, 1);
}

static RG_INLINE void remap_tile(image_traversal* image) {
  small_traversal* const traversal = &image->whole.traversal;
  transform_to_component(&image->whole);
  if (is_interior_tile(traversal) &&
      (traversal->source.ring_rows == 0 || move_to_ring(traversal)))
    process_interior_tile(image);
  else
    process_pixels(image, 0);
}

/* Initialization before the first tile of the component. */
static RG_NOINLINE void start_component(image_traversal* traversal,
                                        const rg_camera* camera,
                                        const rg_image* image) {
  const rg_target* const target = traversal->target;
  small_traversal* const tiles = &traversal->whole.traversal;
  rg_set_planes(&traversal->whole.component, image, target, &tiles->source,
                &tiles->span);
  start_rows(&traversal->whole, camera, target->first_row,
             (uint32_t)target->first_row + target->num_rows);
}

rg_status rg_traverse_image(const rg_camera* camera, const rg_image* image,
                            const rg_target* target) {
  image_traversal traversal;
  component_traversal* const whole = &traversal.whole;
  traversal.target = target;
  for (uint32_t k = 0; rg_get_component(image->format, k, &whole->component);
       k = whole->component.index + 1u) {
    start_component(&traversal, camera, image);
    while (next_tile(&whole->traversal, camera)) remap_tile(&traversal);
  }
  return RG_OK;
}

/* ---- Rows of the source -------------------------------------------------- */

/* The traversal that determines source rows. */
typedef struct row_traversal {
  component_traversal whole;
  rg_row_search* search;
} row_traversal;

/* The distance to the next relevant row or pixel of num_left: all are relevant,
 * or only the first and the last. */
static RG_INLINE uint32_t get_step(uint32_t num_left, int are_ends) {
  return are_ends && num_left > 1 ? num_left - 1 : 1;
}

/* Adds the rows that a tile requires: without edge handling, those of its
 * corners, which suffice, since positions are bilinear in a block; otherwise of
 * each pixel with a source. */
static RG_NOINLINE void add_tile(const row_traversal* traversal,
                                 int is_interior) {
  uint32_t r = 0;
  const small_traversal* tiles;
  do {
    rg_block_row row;
    RG_FORGET(traversal); /* otherwise its address uses a register */
    tiles = &traversal->whole.traversal;
    rg_compute_block_row(&tiles->span.block, tiles->span.first_row + r, &row);
    uint32_t num_left = tiles->span.num_pixels;
    do {
      if (is_interior || has_source(tiles, &row.start))
        rg_add_rows(&traversal->search->source, row.start.q12[1],
                    tiles->source.size[1], traversal->whole.component.log2[1]);
      const uint32_t step = get_step(num_left, is_interior);
      row.start = rg_row_position(&row, step);
      num_left -= step;
    } while (num_left != 0);
    r += get_step(tiles->span.num_rows - r, is_interior);
  } while (r != tiles->span.num_rows);
}

void rg_traverse_source_rows(const rg_camera* camera, rg_format format,
                             rg_row_search* search) {
  row_traversal traversal;
  component_traversal* const whole = &traversal.whole;
  traversal.search = search;
  whole->traversal.span.out =
      (uint8_t*)whole->ranges; /* no byte of it is written */
  whole->traversal.span.out_stride = 0;
  for (uint32_t k = 0; rg_get_component(format, k, &whole->component);
       k = whole->component.index + 1u) {
    start_rows(whole, camera, traversal.search->output.first,
               traversal.search->output.end);
    while (next_tile(&whole->traversal, camera)) {
      transform_to_component(whole);
      add_tile(&traversal, is_interior_tile(&whole->traversal));
    }
  }
}

#endif
