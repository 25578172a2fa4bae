/* The walk where stacks and programs are small. */
#include "remap_blocks.h"

#if !RG_KEEP_LINES
#include <stddef.h>

/* To the row of parts below those that were done; 0 below the last one. */
static RG_INLINE int start_parts(rg_remap_job* job) {
  rg_run* const run = &job->run;
  const uint32_t log2 = (uint32_t)job->walk.part_log2[1] - job->lattice.log2[1];
  const uint32_t row = job->row, part = row >> log2;
  uint32_t end = (part + 1) << log2;
  if (row >= job->end_row) return 0;
  if (end > job->end_row) end = job->end_row;
  job->row = (uint16_t)end;
  run->out += (size_t)run->num_rows * run->out_stride;
  run->first_row = (uint16_t)(row - (part << log2));
  run->num_rows = (uint16_t)(end - row);
  rg_start_parts(&job->walk, part);
  return 1;
}

int rg_go_to_part(rg_remap_job* job) {
  rg_run* const run = &job->run;
  rg_block_walk* const walk = &job->walk;
  const uint32_t lattice_log2 = job->lattice.log2[0];
  const uint32_t log2 = walk->part_log2[0] - lattice_log2;
  const uint32_t width = (uint32_t)rg_load_u16(walk->section) >> lattice_log2;
  if ((uint32_t)walk->next_part << log2 >= width && !start_parts(job)) return 0;
  const uint32_t first = (uint32_t)walk->next_part << log2;
  const uint32_t rest = width - first, part_width = 1u << log2;
  run->out_pixel = (uint16_t)first;
  run->num_pixels = (uint16_t)(rest < part_width ? rest : part_width);
  return 1;
}

int rg_has_source(const rg_remap_job* job, const rg_position* position,
                  int32_t margin) {
  return rg_is_in_ranges(job, position, margin);
}

/* A lattice may end half a pixel before the positions with a source. (The
 * nearest pixel of such a position is not beyond its last, either.) */
#define MARGIN (RG_POSITION_MARGIN + 2048)

int rg_is_part_safe(const rg_remap_job* job) {
  const rg_position* corner = job->run.block.corners;
  if (job->num_rows == 0) return 0;
  for (uint32_t k = 4; k != 0; --k, ++corner)
    if (!rg_has_source(job, corner, MARGIN)) return 0;
  return 1;
}

void rg_do_pixels(rg_remap_job* job, rg_do_pixel* on_pixel) {
  rg_block_row row;
  uint32_t r = 0;
  do {
    RG_IN_REGISTER(job);
    rg_find_block_row(&job->run.block, job->run.first_row + r, &row);
    uint32_t k = job->run.num_pixels;
    do {
      on_pixel(job, &row.start);
      row.start.q12[0] = rg_add(row.start.q12[0], row.step.q12[0]);
      row.start.q12[1] = rg_add(row.start.q12[1], row.step.q12[1]);
      ++job->run.out_pixel;
    } while (--k != 0);
    job->run.out_pixel = (uint16_t)(job->run.out_pixel - job->run.num_pixels);
    job->run.out += job->run.out_stride;
  } while (++r != job->run.num_rows);
  job->run.out -= (size_t)r * job->run.out_stride;
}

#endif
