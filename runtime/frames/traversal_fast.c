/* The traversal optimized for speed: a tile is one span, or is divided into the
 * longest spans with uniform edge handling. */
#include "config.h"
#include "frames/traversal.h"

#if RG_FAST_TRAVERSAL

#include <stddef.h>

#include "blob_layout.h"
#include "bytes.h"
#include "frames/component_map.h"
#include "frames/edge_pixels.h"
#include "frames/fast_corners.h"
#include "frames/pixel_formats.h"
#include "kernels/kernel.h"

/* The edge handling that the pixels of a span require. */
typedef enum edge_handling {
  EDGE_NONE,    /* their neighbours are in the source, in contiguous rows, which
                   the spare rows follow */
  EDGE_GUARDED, /* their neighbours are, but perhaps not the spare rows */
  EDGE_PER_PIXEL, /* a single pixel, which may have no source, or a source that
                 lacks neighbours */
  EDGE_NO_SOURCE  /* no pixel has a source */
} edge_handling;

/* The box of tile corners without edge handling. It contains no position if the
 * source is a ring buffer. */
typedef struct interior_box {
  rg_lanes min, max;
} interior_box;

/* The traversal of a component's tiles, and the current span. */
typedef struct fast_traversal {
  rg_corner_lines lines;
  const rg_component* component;
  rg_source source;
  uint16_t num_rows;   /* number of source rows that are contiguous in memory,
                          from the span's first_source_row on */
  uint16_t row;        /* first output row of the row of tiles */
  uint16_t end_row;    /* after the last one to process */
  uint8_t tile_rows;   /* rows of the current tiles; 0 before the first tiles */
  uint8_t tile_pixels; /* pixels per row, if the current tile is processed in
                          segments of rows; otherwise 0 */
  uint8_t rows_left;   /* rows left in the tile; 0: the span is the last one */
  uint8_t is_clamped;  /* use the nearest source if there is none */
  uint16_t num_whole_tiles; /* number in a row of tiles, from the left */
  rg_span span __attribute__((aligned(16)));
  const rg_kernels* kernels;
  rg_range ranges[2];   /* ranges of positions with a source: x, y */
  rg_position position; /* position of the pixel of an EDGE_PER_PIXEL span */
  interior_box interior;
  rg_component_lanes move;
} fast_traversal;

static inline int32_t min_int32(int32_t a, int32_t b) { return a < b ? a : b; }
static inline int32_t max_int32(int32_t a, int32_t b) { return a > b ? a : b; }

/* ---- Tiles --------------------------------------------------------------- */

static RG_INLINE void load_corners(const rg_position* corners, rg_lanes* upper,
                                   rg_lanes* lower) {
  memcpy(upper, corners, sizeof(*upper));
  memcpy(lower, corners + 2, sizeof(*lower));
}

/* Computes the corners of the next tile in component pixels. */
static RG_INLINE void compute_corners(fast_traversal* traversal,
                                      rg_position* corners) {
  const rg_component* const component = traversal->component;
  rg_lanes upper, lower;
  rg_follow_lines(&traversal->lines, &upper, &lower);
  if ((component->log2[0] | component->log2[1]) != 0)
    rg_transform_corner_lanes(&traversal->move, &upper, &lower);
  memcpy(corners, &upper, sizeof(upper));
  memcpy(corners + 2, &lower, sizeof(lower));
}

/* Whether a tile with these corners is a EDGE_NONE span. */
static RG_INLINE int are_corners_interior(const fast_traversal* traversal,
                                          const rg_position* corners) {
  const interior_box* const box = &traversal->interior;
  rg_lanes upper, lower;
  load_corners(corners, &upper, &lower);
  const rg_lane_pairs beyond =
      (rg_lane_pairs)((upper < box->min) | (upper > box->max) |
                      (lower < box->min) | (lower > box->max));
  return (beyond[0] | beyond[1]) == 0 && !traversal->lines.is_block_empty;
}

static interior_box compute_interior_box(const fast_traversal* traversal) {
  int32_t min[2], max[2];
  for (int c = 0; c < 2; ++c) {
    const rg_range source = traversal->ranges[c];
    const int32_t last_q12 = (traversal->source.size[c] - 1) * 4096;
    min[c] = max_int32(source.min_q12, 0) + RG_POSITION_MARGIN;
    max[c] = min_int32(source.max_q12, last_q12) - RG_POSITION_MARGIN;
  }
  if (RG_SELECT_KERNELS) max[1] -= RG_SPARE_Q12;
  if (traversal->source.ring_rows != 0) max[1] = min[1] - 1;
  const interior_box box = {rg_twice(min[0], min[1]), rg_twice(max[0], max[1])};
  return box;
}

/* Starts a component's rows, which are counted in image pixels of the output;
 * span->out is for the first row. The component, ring_rows, is_clamped and
 * kernels must be set. */
static void start_rows(fast_traversal* traversal, const rg_camera* camera,
                       rg_row_range rows) {
  const uint8_t* const section = camera->remap;
  const rg_component* const component = traversal->component;
  traversal->lines.section = section;
  traversal->lines.vertices = rg_find_vertices(section) + camera->sample_shift;
  traversal->lines.sample_size = camera->sample_size;
  traversal->lines.weight = camera->weight_q14;
  rg_set_source_size(camera, component, &traversal->source);
  traversal->num_rows = traversal->source.size[1];
  traversal->span.first_source_row = 0;
  for (int c = 0; c < 2; ++c) {
    traversal->lines.tile_log2[c] = rg_tile_log2(section, component, c);
    traversal->ranges[c] = rg_source_range(section, component, c);
  }
  traversal->row = (uint16_t)(rows.first >> component->log2[1]);
  traversal->end_row = (uint16_t)(rows.end >> component->log2[1]);
  /* A component has no pixels if the table is too narrow for it. */
  if (rg_load_u16(section + RG_REMAP_WIDTH) >> component->log2[0] == 0)
    traversal->end_row = traversal->row;
  traversal->tile_rows = traversal->tile_pixels = 0;
  traversal->interior = compute_interior_box(traversal);
  traversal->move =
      rg_get_component_lanes(component, traversal->lines.tile_log2[0]);
  traversal->num_whole_tiles =
      (uint16_t)(rg_load_u16(section + RG_REMAP_WIDTH) >>
                 traversal->lines.tile_log2[0]);
}

/* Advances to the next row of tiles; 0 after the last one. */
static RG_INLINE int start_tile_row(fast_traversal* traversal) {
  rg_span* const span = &traversal->span;
  span->out += (size_t)traversal->tile_rows * span->out_stride;
  const uint32_t row = (uint32_t)traversal->row + traversal->tile_rows,
                 end = traversal->end_row;
  if (row >= end) return 0;
  const uint32_t log2 =
      (uint32_t)traversal->lines.tile_log2[1] - traversal->component->log2[1];
  const uint32_t tile = row >> log2;
  const uint32_t next = (tile + 1) << log2;
  traversal->lines.row = (uint16_t)tile;
  traversal->lines.next_tile = 0;
  span->first_row = (uint16_t)(row - (tile << log2));
  traversal->row = (uint16_t)row;
  traversal->tile_rows = (uint8_t)((next < end ? next : end) - row);
  return 1;
}

/* Computes the block of the next tile. */
static RG_INLINE void find_block(fast_traversal* traversal) {
  const rg_component* const component = traversal->component;
  rg_block* const block = &traversal->span.block;
  if (traversal->lines.next_tile == 0) rg_start_columns(&traversal->lines);
  compute_corners(traversal, block->corners);
  block->width_log2 =
      (uint8_t)(traversal->lines.tile_log2[0] - component->log2[0]);
  block->height_log2 =
      (uint8_t)(traversal->lines.tile_log2[1] - component->log2[1]);
}

/* Advances to the next tile, without its block; 0 if there is none. */
static RG_INLINE int go_to_tile(fast_traversal* traversal) {
  rg_span* const span = &traversal->span;
  const rg_corner_lines* const lines = &traversal->lines;
  if (traversal->tile_pixels != 0) { /* back to the tile's first row */
    const uint32_t rows = traversal->tile_rows - 1u;
    span->out -= (size_t)rows * span->out_stride;
    span->first_row = (uint16_t)(span->first_row - rows);
  }
  const uint32_t log2 = traversal->component->log2[0];
  const uint32_t width =
      (uint32_t)rg_load_u16(lines->section + RG_REMAP_WIDTH) >> log2;
  const uint32_t tile_width = 1u << lines->tile_log2[0] >> log2;
  uint32_t first = lines->next_tile * tile_width;
  if (traversal->tile_rows == 0 || first >= width) {
    if (!start_tile_row(traversal)) return 0;
    first = 0;
  }
  const uint32_t rest = width - first;
  span->out_pixel = (uint16_t)first;
  span->first_pixel = traversal->tile_pixels = 0;
  span->num_pixels = (uint16_t)(rest < tile_width ? rest : tile_width);
  span->num_rows = traversal->rows_left = traversal->tile_rows;
  return 1;
}

/* Advances to the next tile; 0 if there is none. */
static int next_tile(fast_traversal* traversal) {
  if (!go_to_tile(traversal)) return 0;
  find_block(traversal);
  return 1;
}

/* Like next_tile() if neither the current tile, which was processed in one
 * span, nor the next one is clipped by the right border; otherwise returns 0.
 * The corners of the block are kept. */
static RG_INLINE int next_whole_tile(fast_traversal* traversal,
                                     rg_position* corners) {
  if (traversal->tile_pixels != 0 ||
      traversal->lines.next_tile >= traversal->num_whole_tiles)
    return 0;
  traversal->span.out_pixel =
      (uint16_t)(traversal->span.out_pixel + traversal->span.num_pixels);
  traversal->rows_left = traversal->tile_rows;
  compute_corners(traversal, corners);
  return 1;
}

/* ---- Spans --------------------------------------------------------------- */

/* Whether a position has a source. */
static RG_INLINE int has_source(const fast_traversal* traversal,
                                const rg_position* position) {
  if (traversal->lines.is_block_empty) return 0;
  for (int c = 0; c < 2; ++c)
    if (position->q12[c] < traversal->ranges[c].min_q12 ||
        position->q12[c] > traversal->ranges[c].max_q12)
      return 0;
  return 1;
}

/* The edge handling for positions whose coordinate c is between two values. */
static RG_INLINE edge_handling select_axis_handling(
    const fast_traversal* traversal, int c, int32_t low, int32_t high) {
  const rg_range source = traversal->ranges[c];
  const int32_t first = c == 0 ? 0 : traversal->span.first_source_row;
  const int32_t num = c == 0 ? traversal->source.size[0] : traversal->num_rows;
  const int32_t end = min_int32(source.max_q12, (first + num - 1) * 4096);
  low -= RG_POSITION_MARGIN;
  high += RG_POSITION_MARGIN;
  if (high < source.min_q12 || low > source.max_q12) return EDGE_NO_SOURCE;
  if (low < max_int32(source.min_q12, first * 4096) || high > end)
    return EDGE_PER_PIXEL;
  return RG_SELECT_KERNELS && c == 1 && high > end - RG_SPARE_Q12 ? EDGE_GUARDED
                                                                  : EDGE_NONE;
}

/* The edge handling for positions between corners: the maximum over both
 * coordinates. */
static RG_INLINE edge_handling select_edge_handling(
    const fast_traversal* traversal, const rg_position* p, uint32_t num) {
  edge_handling handling = EDGE_NONE;
  for (int c = 0; c < 2; ++c) {
    int32_t low = p[0].q12[c], high = low;
    for (uint32_t k = num; --k != 0;) {
      low = min_int32(low, p[k].q12[c]);
      high = max_int32(high, p[k].q12[c]);
    }
    const edge_handling axis_handling =
        select_axis_handling(traversal, c, low, high);
    if (axis_handling > handling) handling = axis_handling;
  }
  return handling == EDGE_NO_SOURCE && traversal->is_clamped ? EDGE_PER_PIXEL
                                                             : handling;
}

/* The edge handling of the current tile. */
static RG_INLINE edge_handling
find_tile_handling(const fast_traversal* traversal) {
  if (traversal->lines.is_block_empty && !traversal->is_clamped)
    return EDGE_NO_SOURCE;
  if (are_corners_interior(traversal, traversal->span.block.corners))
    return EDGE_NONE;
  return select_edge_handling(traversal, traversal->span.block.corners, 4);
}

/* Advances to the pixels after the span, which are in one row of a tile. */
static RG_INLINE void advance_in_tile(fast_traversal* traversal) {
  rg_span* const span = &traversal->span;
  const uint32_t end = traversal->tile_pixels;
  span->first_pixel = (uint16_t)(span->first_pixel + span->num_pixels);
  span->out_pixel = (uint16_t)(span->out_pixel + span->num_pixels);
  if (span->first_pixel < end) return;
  span->first_pixel = 0;
  span->out_pixel = (uint16_t)(span->out_pixel - end);
  ++span->first_row;
  span->out += span->out_stride;
}

/* Finds the span of a row's next pixels with uniform edge handling: all
 * remaining ones, half of them, and so on, or one. */
static RG_INLINE edge_handling find_segment(fast_traversal* traversal) {
  rg_span* const span = &traversal->span;
  advance_in_tile(traversal);
  uint32_t num = (uint32_t)traversal->tile_pixels - span->first_pixel;
  rg_block_row row;
  rg_position ends[2];
  edge_handling handling;
  rg_compute_block_row(&span->block, span->first_row, &row);
  traversal->position = ends[0] = rg_row_position(&row, span->first_pixel);
  for (;; num >>= 1) {
    for (int c = 0; c < 2; ++c)
      ends[1].q12[c] = ends[0].q12[c] + (int32_t)(num - 1) * row.step.q12[c];
    handling = select_edge_handling(traversal, ends, 2);
    if (handling != EDGE_PER_PIXEL || num == 1) break;
  }
  span->num_pixels = (uint16_t)num;
  if (span->first_pixel + num == traversal->tile_pixels) --traversal->rows_left;
  return handling;
}

/* Finds the tile's next span and its edge handling; while rows_left is not 0,
 * there is another one. */
static edge_handling next_span(fast_traversal* traversal) {
  rg_span* const span = &traversal->span;
  if (traversal->tile_pixels == 0) {
    const edge_handling handling = find_tile_handling(traversal);
    if (handling != EDGE_PER_PIXEL) {
      traversal->rows_left = 0;
      return handling;
    }
    traversal->tile_pixels = (uint8_t)span->num_pixels;
    span->num_pixels = 0; /* none is processed yet */
    span->num_rows = 1;
  }
  return find_segment(traversal);
}

/* ---- Consecutive interior tiles ------------------------------------------ */

/* The kernel that interpolates several adjacent tiles; NULL if there is none
 * for the current tiles. */
static RG_INLINE rg_blend_tile_row* select_tile_kernel(
    const fast_traversal* traversal) {
  const uint32_t channels = rg_interleaved(traversal->component);
  const rg_block* const block = &traversal->span.block;
  return traversal->kernels && channels != 0 && block->width_log2 == 3 &&
                 block->height_log2 == 3 && traversal->tile_rows == 8
             ? traversal->kernels->blend_tile_row[channels - 1]
             : NULL;
}

/* Interpolates the tiles to the right of the current one, several at once, as
 * long as they are complete and interior. Returns whether the tile reached is
 * to be processed with edge handling. */
static int blend_interior_tiles(fast_traversal* traversal,
                                rg_blend_tile_row* blend_tile_row) {
  rg_position corners[4 * RG_TILES_AT_ONCE];
  for (;;) {
    rg_span* const span = &traversal->span;
    const uint32_t first = (uint32_t)span->out_pixel + span->num_pixels;
    uint32_t num = 0;
    int is_next = 0, is_interior = 1;
    while (num < RG_TILES_AT_ONCE &&
           (is_next = next_whole_tile(traversal, &corners[4 * num])) &&
           (is_interior = are_corners_interior(traversal, &corners[4 * num])))
      ++num;
    if (num != 0) {
      const uint16_t last = span->out_pixel;
      span->out_pixel = (uint16_t)first;
      blend_tile_row(span, corners, num);
      span->out_pixel = last;
    }
    if (!is_interior)
      memcpy(span->block.corners, &corners[4 * num],
             sizeof(span->block.corners));
    if (!is_next || !is_interior) return is_next;
  }
}

/* Processes the tiles to the right of the current one while they are complete
 * and interior. Returns whether the tile reached requires edge handling. */
static RG_INLINE int process_interior_tiles(fast_traversal* traversal,
                                            rg_sampling sampling) {
  const int is_copy = sampling == RG_SAMPLING_NEAREST;
  if (RG_HAS_TILE_KERNELS && !is_copy) {
    rg_blend_tile_row* const blend_tile_row = select_tile_kernel(traversal);
    if (blend_tile_row) return blend_interior_tiles(traversal, blend_tile_row);
  }
  while (next_whole_tile(traversal, traversal->span.block.corners)) {
    if (!are_corners_interior(traversal, traversal->span.block.corners))
      return 1;
    if (is_copy)
      rg_copy_component(&traversal->span, traversal->component);
    else
      rg_dispatch(traversal->kernels, &traversal->span, traversal->component,
                  1);
  }
  return 0;
}

/* ---- The border ---------------------------------------------------------- */

/* Fills pixels whose 8-bit channels fill the plane: 8 bytes at once; after at
 * most three such steps, the first channel is aligned again. */
static RG_INLINE void fill_bytes(const rg_span* span, uint32_t channels,
                                 const uint16_t* values) {
  uint8_t pattern[24];
  const uint32_t num_bytes = span->num_pixels * channels;
  uint8_t* out = span->out + span->out_pixel * channels;
  for (uint32_t k = 0, c = 0; k < 24 && k < num_bytes; ++k) {
    pattern[k] = (uint8_t)values[c];
    c = c + 1 == channels ? 0 : c + 1;
    RG_IN_REGISTER(c); /* otherwise compilers call memset() */
  }
  for (uint32_t r = span->num_rows; r != 0; --r, out += span->out_stride) {
    uint32_t k = 0, phase = 0;
    for (; k + 8 <= num_bytes; k += 8) {
      memcpy(out + k, pattern + phase, 8);
      phase = phase == 16 ? 0 : phase + 8;
    }
    for (; k < num_bytes; ++k) out[k] = pattern[phase + (k & 7)];
  }
}

static RG_INLINE void put_value(const rg_component* component, uint8_t* row,
                                uint32_t index, uint32_t value) {
  if (component->kind == RG_SAMPLE_8)
    row[index] = (uint8_t)value;
  else
    rg_put_sample(component->kind, row, index, value);
}

/* Fills the pixels of a span with the border of the component's channels. */
static RG_INLINE void fill_span(const rg_span* span,
                                const rg_component* component,
                                const uint16_t* values) {
  if (RG_IS_FAST && rg_interleaved(component) != 0) {
    fill_bytes(span, component->num_channels, values);
    return;
  }
  uint8_t* out = span->out;
  for (uint32_t r = span->num_rows; r != 0; --r, out += span->out_stride) {
    uint32_t index = rg_first_sample(component, span->out_pixel);
    for (uint32_t k = span->num_pixels; k != 0; --k) {
      for (uint32_t c = 0; c < component->num_channels; ++c)
        put_value(component, out, index + c, values[c]);
      index += component->sample_step;
      RG_IN_REGISTER(index); /* otherwise compilers call memset() */
    }
  }
}

/* ---- Grey frames --------------------------------------------------------- */

static const rg_component kGrey = {RG_SAMPLE_8, 0,      0, 1, 1,
                                   {0, 0},      {0, 0}, 0, 1, 0};

static RG_INLINE void process_grey_pixel(const fast_traversal* traversal,
                                         uint8_t border) {
  const rg_span* const span = &traversal->span;
  uint32_t value = border;
  if (has_source(traversal, &traversal->position))
    value = rg_blend_edge_grey(&traversal->source, span, &traversal->position);
  span->out[span->out_pixel] = (uint8_t)value;
}

static RG_INLINE void process_grey_tile(fast_traversal* traversal,
                                        uint16_t border) {
  do {
    const edge_handling handling = next_span(traversal);
    if (handling == EDGE_PER_PIXEL)
      process_grey_pixel(traversal, (uint8_t)border);
    else if (handling == EDGE_NO_SOURCE)
      fill_span(&traversal->span, &kGrey, &border);
    else
      rg_dispatch_grey(traversal->kernels, &traversal->span,
                       handling == EDGE_NONE);
  } while (traversal->rows_left != 0);
}

rg_status rg_traverse_grey(const rg_camera* camera, const rg_grey_image* frame,
                           const rg_grey_target* band) {
  fast_traversal traversal;
  traversal.component = &kGrey;
  traversal.kernels = rg_select_kernels(0, frame->stride);
  traversal.is_clamped = 0;
  traversal.source.ring_rows = 0;
  traversal.span.data = frame->data;
  traversal.span.stride = frame->stride;
  traversal.span.out = band->data;
  traversal.span.out_stride = band->stride;
  const rg_row_range rows = {band->first_row,
                             (uint16_t)(band->first_row + band->num_rows)};
  start_rows(&traversal, camera, rows);
  while (next_tile(&traversal)) {
    do {
      process_grey_tile(&traversal, band->border);
    } while (process_interior_tiles(&traversal, RG_SAMPLING_BILINEAR));
  }
  return RG_OK;
}

/* ---- Images -------------------------------------------------------------- */

/* Selects the rows of the ring buffer around the top of the tile: pixels that
 * need other rows are processed individually. */
static RG_NOINLINE void choose_ring_rows(fast_traversal* traversal) {
  const rg_position* const corners = traversal->span.block.corners;
  int32_t top = (traversal->source.size[1] - 1) << 12;
  for (int k = 0; k < 4; ++k)
    if (corners[k].q12[1] < top) top = corners[k].q12[1];
  uint32_t first;
  traversal->num_rows =
      (uint16_t)rg_find_ring_rows(&traversal->source, top, &first);
  traversal->span.first_source_row = (uint16_t)first;
}

static RG_INLINE int32_t nearest_position(const fast_traversal* traversal,
                                          rg_sampling sampling, int c) {
  const int32_t q12 = rg_nearest_source(
      &traversal->source, traversal->ranges[c], traversal->position.q12[c], c);
  return rg_round_position(sampling, traversal->component, q12, c);
}

/* Processes the pixel of a EDGE_PER_PIXEL span, with every check. */
static RG_NOINLINE void remap_pixel(const fast_traversal* traversal,
                                    const rg_target* target) {
  const rg_span* const span = &traversal->span;
  rg_neighbors at;
  at.out = span->out;
  if (!traversal->is_clamped && !has_source(traversal, &traversal->position)) {
    rg_put_border(target, traversal->component, &at, span->out_pixel);
    return;
  }
  for (int c = 0; c < 2; ++c)
    at.position.q12[c] = nearest_position(traversal, target->sampling, c);
  rg_find_neighbors(&traversal->source, span, traversal->component, &at);
  rg_blend_pixel(traversal->component, &at, span->out_pixel);
}

static RG_NOINLINE void fill_border(const fast_traversal* traversal,
                                    const rg_target* target) {
  if (target->border != RG_BORDER_KEEP)
    fill_span(&traversal->span, traversal->component,
              target->border_values + traversal->component->index);
}

static RG_INLINE void remap_tile(fast_traversal* traversal,
                                 const rg_target* target) {
  if (traversal->source.ring_rows != 0) choose_ring_rows(traversal);
  do {
    const edge_handling handling = next_span(traversal);
    if (handling == EDGE_PER_PIXEL)
      remap_pixel(traversal, target);
    else if (handling == EDGE_NO_SOURCE)
      fill_border(traversal, target);
    else if (target->sampling == RG_SAMPLING_NEAREST)
      rg_copy_component(&traversal->span, traversal->component);
    else
      rg_dispatch(traversal->kernels, &traversal->span, traversal->component,
                  handling == EDGE_NONE);
  } while (traversal->rows_left != 0);
}

/* Initialization before the first tile of a component. */
static RG_NOINLINE void start_component(fast_traversal* traversal,
                                        const rg_camera* camera,
                                        const rg_image* image,
                                        const rg_target* target) {
  const uint32_t plane = traversal->component->plane;
  traversal->kernels =
      rg_select_kernels(target->kernels, image->planes[plane].stride);
  traversal->is_clamped = target->border == RG_BORDER_CLAMP;
  rg_set_planes(traversal->component, image, target, &traversal->source,
                &traversal->span);
  const rg_row_range rows = {target->first_row,
                             (uint16_t)(target->first_row + target->num_rows)};
  start_rows(traversal, camera, rows);
}

rg_status rg_traverse_image(const rg_camera* camera, const rg_image* image,
                            const rg_target* target) {
  fast_traversal traversal;
  rg_component component;
  traversal.component = &component;
  for (uint32_t k = 0; rg_get_component(image->format, k, &component); ++k) {
    start_component(&traversal, camera, image, target);
    while (next_tile(&traversal)) {
      do {
        remap_tile(&traversal, target);
      } while (process_interior_tiles(&traversal, target->sampling));
    }
  }
  return RG_OK;
}

/* ---- Rows of the source -------------------------------------------------- */

/* Adds the rows that a span requires. Positions are bilinear in a block: if all
 * have a source, the span's corners suffice. */
static RG_NOINLINE void add_span(const fast_traversal* traversal,
                                 rg_row_range* found) {
  const rg_span* const span = &traversal->span;
  const int32_t num_rows = traversal->source.size[1];
  const uint32_t log2 = traversal->component->log2[1];
  uint32_t r = span->first_row;
  for (uint32_t k = 0; k < 2; ++k, r += span->num_rows - 1u) {
    rg_block_row row;
    rg_compute_block_row(&span->block, r, &row);
    const int32_t step = row.step.q12[1];
    const int32_t y_q12 = row.start.q12[1] + step * span->first_pixel;
    rg_add_rows(found, y_q12, num_rows, log2);
    rg_add_rows(found, y_q12 + step * (span->num_pixels - 1), num_rows, log2);
  }
}

static RG_INLINE void add_tile(fast_traversal* traversal, rg_row_range* found) {
  do {
    const edge_handling handling = next_span(traversal);
    if (handling == EDGE_PER_PIXEL ? has_source(traversal, &traversal->position)
                                   : handling != EDGE_NO_SOURCE)
      add_span(traversal, found);
  } while (traversal->rows_left != 0);
}

void rg_traverse_source_rows(const rg_camera* camera, rg_format format,
                             rg_row_search* search) {
  fast_traversal traversal;
  rg_component component;
  traversal.component = &component;
  traversal.kernels = 0;
  traversal.is_clamped = 0;
  traversal.source.ring_rows = 0;
  traversal.span.out = (uint8_t*)search; /* no byte of it is written */
  traversal.span.out_stride = 0;
  for (uint32_t k = 0; rg_get_component(format, k, &component); ++k) {
    start_rows(&traversal, camera, search->output);
    while (next_tile(&traversal)) add_tile(&traversal, &search->source);
  }
}

#endif
