/* Pixels that need edge handling, outside the source image or without a source,
 * processed per pixel: code shared by both traversals. */
#ifndef RAYGRID_EDGE_PIXELS_H
#define RAYGRID_EDGE_PIXELS_H

#include <stddef.h>

#include "frames/component_map.h"
#include "frames/planes.h"
#include "kernels/blend.h"
#include "kernels/kernel.h"
#include "raygrid.h"

/* Maximum distance of rounded positions from the quadrilateral of the tile's
 * corners, with a margin, in q12 pixels. */
#define RG_POSITION_MARGIN 64

/* Size of a component's source, in component pixels. */
typedef struct rg_source {
  uint16_t size[2];   /* width, height */
  uint16_t ring_rows; /* rows of the ring buffer; 0: whole frame */
} rg_source;

/* Sets the size for an image of the given size in pixels. */
static RG_INLINE void rg_set_source_size(const rg_camera* camera,
                                         const rg_component* component,
                                         rg_source* source) {
  source->size[0] = (uint16_t)(camera->frame_width >> component->log2[0]);
  source->size[1] = (uint16_t)(camera->frame_height >> component->log2[1]);
}

/* Sets the component's addresses in the planes of image and target: data, out
 * and strides of the span, and the rows of the ring buffer. */
static RG_INLINE void rg_set_planes(const rg_component* component,
                                    const rg_image* image,
                                    const rg_target* target, rg_source* source,
                                    rg_span* span) {
  const uint32_t plane = component->plane;
  const uint32_t stride = image->planes[plane].stride;
  const uint32_t out_stride = target->planes[plane].stride;
  source->ring_rows = (uint16_t)(image->ring_rows >> component->log2[1]);
  span->data =
      image->planes[plane].data + component->first_row * (size_t)stride;
  span->stride = stride * component->row_step;
  span->out =
      target->planes[plane].data + component->first_row * (size_t)out_stride;
  span->out_stride = out_stride * component->row_step;
}

/* Rows [k n, (k + 1) n) of a ring buffer of n rows are contiguous in memory.
 * Returns the number and the first one of the rows contiguous with the row of a
 * position. */
static RG_INLINE uint32_t rg_find_ring_rows(const rg_source* source,
                                            int32_t y_q12, uint32_t* first) {
  const uint32_t row = y_q12 < 0 ? 0 : (uint32_t)y_q12 >> 12;
  *first = row - (uint32_t)rg_remainder(row, source->ring_rows);
  const uint32_t rest = source->size[1] - *first;
  return rest < source->ring_rows ? rest : source->ring_rows;
}

/* Returns the address of a source row; span->data is the address of row 0. */
static RG_INLINE const uint8_t* rg_source_row(const rg_source* source,
                                              const rg_span* span,
                                              uint32_t row) {
  if (source->ring_rows != 0)
    row = (uint32_t)rg_remainder(row, source->ring_rows);
  return span->data + (size_t)row * span->stride;
}

/* Coordinate c of a position, rounded to the precision of the interpolation. */
static RG_INLINE int32_t rg_round_position(rg_sampling sampling,
                                           const rg_component* component,
                                           int32_t q12, int c) {
  if (sampling != RG_SAMPLING_NEAREST)
    return q12 + (int32_t)rg_rounding(component->kind, c);
  uint32_t pixel = ((uint32_t)q12 + 2048) >> 12;
  RG_FORGET(pixel); /* otherwise a register holds a mask */
  return (int32_t)(pixel << 12);
}

/* Coordinate c of the nearest position with a source pixel. */
static RG_INLINE int32_t rg_nearest_source(const rg_source* source,
                                           rg_range range, int32_t q12, int c) {
  return rg_clamp(rg_clamp(q12, range.min_q12, range.max_q12), 0,
                  (source->size[c] - 1) << 12);
}

/* Finds the rows of at->position, which is rounded, and the distance of its
 * right neighbours. Neighbours beyond the last pixel have weight zero. */
static RG_INLINE void rg_find_neighbors(const rg_source* source,
                                        const rg_span* span,
                                        const rg_component* component,
                                        rg_neighbors* at) {
  const uint32_t row = rg_get_q12(at, 1) >> 12;
  at->upper = rg_source_row(source, span, row);
  at->lower = rg_source_row(source, span, row + (row + 1 < source->size[1]));
  at->right = (rg_get_q12(at, 0) >> 12) + 1 < source->size[0]
                  ? component->sample_step
                  : 0;
}

/* Sets a pixel of the output row at->out to the border values, unless the
 * border keeps the contents. */
static RG_INLINE void rg_put_border(const rg_target* target,
                                    const rg_component* component,
                                    const rg_neighbors* at,
                                    uint32_t out_pixel) {
  if (target->border == RG_BORDER_KEEP) return;
  const uint16_t* const values = target->border_values + component->index;
  const uint32_t index = rg_first_sample(component, out_pixel);
  for (uint32_t c = 0; c < component->num_channels; ++c)
    rg_put_sample(component->kind, at->out, index + c, values[c]);
}

/* Interpolates a grey pixel at a position with a source, thus within the frame.
 * In the last column, the right neighbour's weight is zero, or one if the pair
 * starts at the previous column; likewise in the last row. */
static RG_INLINE uint32_t rg_blend_edge_grey(const rg_source* source,
                                             const rg_span* span,
                                             const rg_position* position) {
  const uint32_t x = (uint32_t)position->q12[0] + rg_rounding(RG_SAMPLE_8, 0);
  const uint32_t y = (uint32_t)position->q12[1];
  const uint32_t column = rg_lesser(x >> 12, source->size[0] - 2u);
  const uint32_t row = rg_lesser(y >> 12, source->size[1] - 2u);
  const uint8_t* const upper = span->data + (size_t)row * span->stride + column;
  const uint32_t pixels =
      rg_load_pair(upper) | rg_load_pair(upper + span->stride) << 16;
  return rg_blend_8(rg_even_bytes(pixels), rg_odd_bytes(pixels),
                    (x >> 5) - (column << 7), y - (row << 12));
}

#endif /* RAYGRID_EDGE_PIXELS_H */
