/* The walk where stacks and programs are small. */
#include "cortex_m/grey_row_thumb2.h"
#include "frames/remap_blocks.h"
#include "kernels/grey_row.h"

#if !RG_KEEP_LINES
#include <stddef.h>

/* To the row of parts below those that were done; 0 below the last one. */
static RG_INLINE int start_parts(rg_remap_job* job) {
  rg_run* const run = &job->run;
  const uint32_t log2 = run->block.height_log2;
  const uint32_t row = job->row, part = row >> log2;
  if (row >= job->end_row) return 0;
  job->row = (uint16_t)rg_lesser((part + 1) << log2, job->end_row);
  run->first_row = (uint16_t)(row - (part << log2));
  run->num_rows = (uint16_t)(job->row - row);
  rg_start_parts(&job->walk, part);
  return 1;
}

int rg_next_part(rg_remap_job* job) {
  rg_run* const run = &job->run;
  uint32_t pixel = (uint32_t)run->out_pixel + run->num_pixels;
  if (pixel >= job->width) {
    if (!start_parts(job)) return 0;
    pixel = 0;
  } else { /* back to the part's first row */
    run->out -= (size_t)run->num_rows * run->out_stride;
  }
  run->out_pixel = (uint16_t)pixel;
  run->num_pixels =
      (uint16_t)rg_lesser(job->width - pixel, 1u << run->block.width_log2);
  rg_next_corners(&job->walk, run->block.corners);
  return 1;
}

int rg_have_sources(const rg_remap_job* job, const rg_position* positions,
                    uint32_t num, uint32_t margin) {
  const int32_t* q12 = positions->q12;
  if (job->walk.is_empty) return 0;
  num *= 2;
  do {
    const uint8_t* range = job->ranges + 4 * (num & 1);
    RG_IN_REGISTER(range);
    const uint32_t min = rg_load_u32(range);
    const uint32_t size = rg_load_u32(range + 8) - min;
    const uint32_t at = (uint32_t)*q12++ - min;
    if (at - margin > size || at + margin > size) return 0;
  } while (--num != 0);
  return 1;
}

void rg_do_pixels(rg_remap_job* job, rg_do_pixel* on_pixel) {
  rg_block_row row;
  uint32_t r = 0;
  do {
    RG_IN_REGISTER(job);
    rg_find_block_row(&job->run.block, job->run.first_row + r, &row);
    uint32_t pixel = job->run.out_pixel;
    const uint32_t end = pixel + job->run.num_pixels;
    do {
      on_pixel(job, &row.start, pixel);
      rg_go_on_in_row(&row);
    } while (++pixel != end);
    job->run.out += job->run.out_stride;
  } while (++r != job->run.num_rows);
}

static RG_INLINE rg_remap_job* job_of(const rg_grey_rows* rows) {
  return (rg_remap_job*)(void*)((uint8_t*)rows->corners -
                                offsetof(rg_remap_job, run.block.corners));
}

#if !RG_GREY_ROW_IN_ASSEMBLER

static RG_INLINE rg_blended rg_first_rounding(const rg_run* run) {
  return rg_rounding_of(run->num_pixels);
}

/* The rows, from the corners as edges, by the kernel; or finds the next one, if
 * its pixels are done one by one: then 1. */
static RG_INLINE int rg_do_grey_rows(rg_grey_rows* rows, rg_block_row* row) {
  rg_run* const run = &job_of(rows)->run;
  do {
    rg_next_row(&run->block, (uint32_t*)rows->corners->q12, row);
    if (RG_ALL_BUILT_IN || rows->rounding == 0) return 1;
    rg_blend_grey_row(run, row, rows->rounding, run->out);
    run->out += run->out_stride;
  } while (--rows->rest != 0);
  return 0;
}

#endif

/* The row that was found, pixel by pixel. */
static RG_INLINE void do_row(const rg_grey_rows* rows,
                             const rg_block_row* row) {
  rg_remap_job* const job = job_of(rows);
  rg_position position;
  uint32_t pixel = 0;
  position = row->start;
  do {
    rows->on_pixel(job, &position, pixel);
    for (int c = 0; c < 2; ++c)
      position.q12[c] = rg_add(position.q12[c], row->step.q12[c]);
  } while (++pixel != job->run.num_pixels);
  job->run.out += job->run.out_stride;
}

void rg_do_rows(rg_remap_job* job, rg_do_pixel* on_pixel) {
  rg_grey_rows rows;
  rows.corners = job->run.block.corners;
  rows.on_pixel = on_pixel;
  rows.rest = job->run.num_rows;
  rows.rounding = 0;
  if (!on_pixel) rows.rounding = rg_first_rounding(&job->run);
  rg_start_edges(&job->run, rows.corners->q12, (uint32_t*)rows.corners->q12);
  rg_block_row row;
  while (rg_do_grey_rows(&rows, &row)) {
    do_row(&rows, &row);
    if (--rows.rest == 0) break;
  }
}

#endif
