/* Rows of a span of grey pixels in C: cortex_m/grey_rows.h. */
#ifndef RAYGRID_GREY_ROWS_C_H
#define RAYGRID_GREY_ROWS_C_H

#include <stddef.h>

#include "kernels/grey_row.h"

/* The remaining rows of a span. */
typedef struct rg_grey_rows {
  rg_position* corners; /* corners of the span's tile, converted to edges by
                           rg_start_edges() */
  uint32_t rounding;    /* rounding constant of the kernel; 0: pixels are
                           processed one by one */
  uint32_t rest;        /* number of remaining rows */
  uint8_t* out;         /* first output pixel of the next row */
} rg_grey_rows;

/* Returns the rounding constant of the kernel in C. */
static RG_INLINE uint32_t rg_first_rounding_in_c(const rg_span* span) {
  (void)span;
  return RG_ROUNDING_8;
}

/* Blends all remaining rows, advances out past them, and returns 0. If the
 * rounding is 0, computes the next row's positions instead, and returns 1. */
static RG_INLINE int rg_process_grey_rows_in_c(rg_grey_rows* rows,
                                               rg_block_row* row) {
  const rg_span* const span =
      (const rg_span*)(const void*)((const uint8_t*)rows->corners -
                                    offsetof(rg_span, block.corners));
  do {
    rg_next_row(&span->block, (uint32_t*)rows->corners->q12, row);
    if (RG_ALL_BUILT_IN || rows->rounding == 0) return 1;
    rg_blend_grey_row(span, row, rows->out);
    rows->out += span->out_stride;
  } while (--rows->rest != 0);
  return 0;
}

#endif /* RAYGRID_GREY_ROWS_C_H */
