/* The rows of a part of a grey frame in C: cortex_m/grey_rows.h. */
#ifndef RAYGRID_GREY_ROWS_C_H
#define RAYGRID_GREY_ROWS_C_H

#include <stddef.h>

#include "kernels/grey_row.h"

/* The rows of a run that are not done yet. */
typedef struct rg_grey_rows {
  rg_position* corners; /* those of a run's block, which are edges by now:
                           rg_start_edges() */
  uint32_t rounding; /* that the kernel begins with; 0: the pixels of the rows
                        are done one by one */
  uint32_t rest;     /* rows that are not done */
  uint8_t* out;      /* the first pixel of the next one */
} rg_grey_rows;

/* The rounding that the kernel begins with, in C. */
static RG_INLINE uint32_t rg_first_rounding_in_c(const rg_run* run) {
  (void)run;
  return RG_ROUNDING_8;
}

/* Does all rows that are left, and moves out below them: returns 0.
 * If the rounding is 0, finds the next row instead, and returns 1. */
static RG_INLINE int rg_do_grey_rows_in_c(rg_grey_rows* rows,
                                          rg_block_row* row) {
  const rg_run* const run =
      (const rg_run*)(const void*)((const uint8_t*)rows->corners -
                                   offsetof(rg_run, block.corners));
  do {
    rg_next_row(&run->block, (uint32_t*)rows->corners->q12, row);
    if (RG_ALL_BUILT_IN || rows->rounding == 0) return 1;
    rg_blend_grey_row(run, row, rows->out);
    rows->out += run->out_stride;
  } while (--rows->rest != 0);
  return 0;
}

#endif /* RAYGRID_GREY_ROWS_C_H */
