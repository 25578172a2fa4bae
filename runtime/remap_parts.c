/* The walk where stacks and programs are small. */
#include "grey_row.h"
#include "grey_row_thumb2.h"
#include "remap_blocks.h"

#if !RG_KEEP_LINES
#include <stddef.h>

int rg_have_sources(const rg_remap_job* job, const rg_position* positions,
                    uint32_t num, uint32_t margin) {
  const int32_t* q12 = positions->q12;
  if (job->walk.is_empty) return 0;
  for (num *= 2; num != 0; --num) {
    const rg_range* const range = &job->ranges[num & 1];
    const uint32_t size = (uint32_t)(range->max_q12 - range->min_q12);
    const uint32_t at = (uint32_t)*q12++ - (uint32_t)range->min_q12;
    if (at - margin > size || at + margin > size) return 0;
  }
  return 1;
}

/* The pixels of a row, one by one. */
static RG_INLINE void do_row(rg_remap_job* job, const rg_block_row* row,
                             rg_do_pixel* on_pixel) {
  uint32_t pixel = job->run.out_pixel, num = job->run.num_pixels;
  rg_position position = row->start;
  do {
    on_pixel(job, &position, pixel);
    position.q12[0] = rg_add(position.q12[0], row->step.q12[0]);
    position.q12[1] = rg_add(position.q12[1], row->step.q12[1]);
    ++pixel;
  } while (--num != 0);
}

#if !RG_GREY_ROW_IN_ASSEMBLER
/* The next row is blended, or found, if its pixels are done one by one: then 1.
 */
static RG_INLINE int rg_next_grey_row(const rg_remap_job* job,
                                       rg_grey_rows* rows, rg_block_row* row) {
  const rg_run* const run = &job->run;
  rg_next_row(run, &rows->edges, row);
  if (RG_ALL_BUILT_IN || rows->on_pixel) return 1;
  rg_blend_grey_row(run, row, rows->rounding, run->out + run->out_pixel);
  return 0;
}
#endif

void rg_do_rows(rg_remap_job* job, rg_do_pixel* on_pixel) {
  rg_grey_rows walk;
  rg_start_grey_rows(&job->run, on_pixel, &walk);
  uint32_t rows = job->run.num_rows;
  do {
    rg_block_row row;
    RG_IN_MEMORY(rows);
    if (rg_next_grey_row(job, &walk, &row)) do_row(job, &row, walk.on_pixel);
    RG_IN_MEMORY(job);
    job->run.out += job->run.out_stride;
  } while (--rows != 0);
}

#endif
