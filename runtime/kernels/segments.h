/* Rows of a span, and whether segments of them, neighbouring pixels that a
 * kernel processes at once, fit into its registers. */
#ifndef RAYGRID_SEGMENTS_H
#define RAYGRID_SEGMENTS_H

#include <stdint.h>

#include "kernels/block.h"
#include "kernels/kernel.h"

/* Converts a row of the span's block: position (0, 0) becomes span->data. */
static RG_INLINE void rg_move_to_span(const rg_span* span, rg_block_row* row) {
  row->start = rg_row_position(row, span->first_pixel);
  row->start.q12[1] -= (int32_t)span->first_source_row << 12;
}

/* Computes row r of a span. */
static RG_INLINE void rg_compute_span_row(const rg_span* span, uint32_t r,
                                          rg_block_row* row) {
  rg_compute_row(&span->block, span->first_row + r, row);
  rg_move_to_span(span, row);
}

/* Returns coordinate c of the step between neighbouring pixels of the block's
 * upper (k = 0) or lower (1) edge. Steps of rows are between both, up to
 * rounding of less than 2. */
static inline int32_t rg_edge_step(const rg_span* span, uint32_t k, int c) {
  const rg_position* const edge = span->block.corners + 2 * k;
  return (edge[1].q12[c] - edge[0].q12[c]) >> span->block.width_log2;
}

/* Whether any num_pixels neighbouring pixels of a span, with their bilinear
 * neighbours, are in a window of window_pixels pixels that starts at the first
 * one, on two rows. */
static inline int rg_fits_windows(const rg_span* span, uint32_t num_pixels,
                                  uint32_t window_pixels) {
  const int32_t steps = (int32_t)num_pixels - 1;
  const int32_t room = (int32_t)(window_pixels - 1) * 4096 - 4112;
  for (uint32_t k = 0; k < 2; ++k) {
    const int32_t x = rg_edge_step(span, k, 0), y = rg_edge_step(span, k, 1);
    if (x < 2 || x > 16384 || (x + 2) * steps > room || y < -8192 || y > 8192 ||
        (y + 2) * steps > 4096 || (y - 2) * steps < -4096)
      return 0;
  }
  return span->num_pixels >= num_pixels;
}

/* Whether the positions of num_pixels neighbouring pixels, in q12, and the byte
 * offsets of their samples fit into 16 bits relative to the smallest one. */
static inline int rg_fits_offsets(const rg_span* span, uint32_t num_pixels,
                                  uint32_t channels) {
  for (uint32_t k = 0; k < 2; ++k) {
    uint32_t beyond[2]; /* maximum distance of the last pixel */
    for (int c = 0; c < 2; ++c) {
      const int32_t step = rg_edge_step(span, k, c);
      const uint32_t size = (uint32_t)(step < 0 ? -step : step) + 2;
      if (size > (65535 - 4111) / (num_pixels - 1)) return 0;
      beyond[c] = ((num_pixels - 1) * size + 4111) >> 12;
    }
    if (span->stride > 65535 ||
        beyond[1] * span->stride + beyond[0] * channels > 65535)
      return 0;
  }
  return 1;
}

#endif /* RAYGRID_SEGMENTS_H */
