/* The walk where speed matters more than size. */
#include "frames/remap_blocks.h"

#if RG_KEEP_LINES
#include <stddef.h>

static inline int32_t min_of(int32_t a, int32_t b) { return a < b ? a : b; }
static inline int32_t max_of(int32_t a, int32_t b) { return a > b ? a : b; }

/* The care that positions ask for, coordinate c of which lies between two
 * values. */
static RG_INLINE rg_care find_axis_care(const rg_remap_job* job, int c,
                                        int32_t low, int32_t high) {
  const rg_range source = job->ranges[c];
  const int32_t first = c == 0 ? 0 : job->run.first_source_row;
  const int32_t num = c == 0 ? job->size[0] : job->num_rows;
  const int32_t end = min_of(source.max_q12, (first + num - 1) * 4096);
  low -= RG_POSITION_MARGIN;
  high += RG_POSITION_MARGIN;
  if (high < source.min_q12 || low > source.max_q12) return RG_CARE_NO_SOURCE;
  if (low < max_of(source.min_q12, first * 4096) || high > end)
    return RG_CARE_PIXEL;
  return RG_CHOOSE_KERNELS && c == 1 && high > end - RG_SPARE_Q12
             ? RG_CARE_SPARE
             : RG_CARE_NONE;
}

/* The care that positions between some others ask for: the greater care of both
 * coordinates. */
static RG_INLINE rg_care find_care(const rg_remap_job* job,
                                   const rg_position* p, uint32_t num) {
  rg_care care = RG_CARE_NONE;
  for (int c = 0; c < 2; ++c) {
    int32_t low = p[0].q12[c], high = low;
    for (uint32_t k = num; --k != 0;) {
      low = min_of(low, p[k].q12[c]);
      high = max_of(high, p[k].q12[c]);
    }
    const rg_care axis_care = find_axis_care(job, c, low, high);
    if (axis_care > care) care = axis_care;
  }
  return care == RG_CARE_NO_SOURCE && job->walk.is_clamped ? RG_CARE_PIXEL
                                                           : care;
}

/* On to the pixels behind the run's, which lie in one row of a part. */
static RG_INLINE void go_on_in_part(rg_remap_job* job) {
  rg_run* const run = &job->run;
  const uint32_t end = job->part_pixels;
  run->first_pixel = (uint16_t)(run->first_pixel + run->num_pixels);
  run->out_pixel = (uint16_t)(run->out_pixel + run->num_pixels);
  if (run->first_pixel < end) return;
  run->first_pixel = 0;
  run->out_pixel = (uint16_t)(run->out_pixel - end);
  ++run->first_row;
  run->out += run->out_stride;
}

/* The run of a row's next pixels that ask for the same: all that are left, half
 * of them, and so on, or one. */
static RG_INLINE rg_care find_segment(rg_remap_job* job) {
  rg_run* const run = &job->run;
  go_on_in_part(job);
  uint32_t num = (uint32_t)job->part_pixels - run->first_pixel;
  rg_block_row row;
  rg_position ends[2];
  rg_care care;
  rg_find_block_row(&run->block, run->first_row, &row);
  job->position = ends[0] = rg_row_position(&row, run->first_pixel);
  for (;; num >>= 1) {
    for (int c = 0; c < 2; ++c)
      ends[1].q12[c] =
          ends[0].q12[c] + (int32_t)(num - 1) * rg_read_late(&row.step.q12[c]);
    care = find_care(job, ends, 2);
    if (care != RG_CARE_PIXEL || num == 1) break;
  }
  run->num_pixels = (uint16_t)num;
  if (run->first_pixel + num == job->part_pixels) --job->rows_left;
  return care;
}

/* To the row of parts below those that were done; 0 below the last one. */
static RG_INLINE int start_parts(rg_remap_job* job) {
  rg_run* const run = &job->run;
  run->out += (size_t)job->part_rows * run->out_stride;
  const uint32_t row = (uint32_t)job->row + job->part_rows, end = job->end_row;
  if (row >= end) return 0;
  const uint32_t log2 =
      (uint32_t)job->walk.part_log2[1] - job->lattice->log2[1];
  const uint32_t part = row >> log2;
  const uint32_t next = (part + 1) << log2;
  rg_start_parts(&job->walk, part);
  run->first_row = (uint16_t)(row - (part << log2));
  job->row = (uint16_t)row;
  job->part_rows = (uint8_t)((next < end ? next : end) - row);
  return 1;
}

/* The block of the next part. */
static RG_INLINE void find_block(rg_remap_job* job) {
  const rg_lattice* const lattice = job->lattice;
  rg_block* const block = &job->run.block;
  if (job->walk.next_part == 0) rg_start_columns(&job->walk);
  rg_find_corners(job);
  block->width_log2 = (uint8_t)(job->walk.part_log2[0] - lattice->log2[0]);
  block->height_log2 = (uint8_t)(job->walk.part_log2[1] - lattice->log2[1]);
}

static rg_safe_box find_safe_box(const rg_remap_job* job) {
  int32_t min[2], max[2];
  for (int c = 0; c < 2; ++c) {
    const rg_range source = job->ranges[c];
    const int32_t last_q12 = (job->size[c] - 1) * 4096;
    min[c] = max_of(source.min_q12, 0) + RG_POSITION_MARGIN;
    max[c] = min_of(source.max_q12, last_q12) - RG_POSITION_MARGIN;
  }
  if (RG_CHOOSE_KERNELS) max[1] -= RG_SPARE_Q12;
  if (job->ring_rows != 0) max[1] = min[1] - 1;
  const rg_safe_box box = {rg_twice(min[0], min[1]), rg_twice(max[0], max[1])};
  return box;
}

/* The care that the part at hand asks for. */
static RG_INLINE rg_care find_part_care(const rg_remap_job* job) {
  if (job->walk.is_empty && !job->walk.is_clamped) return RG_CARE_NO_SOURCE;
  if (rg_is_part_safe(job)) return RG_CARE_NONE;
  return find_care(job, job->run.block.corners, 4);
}

void rg_start_lanes(rg_remap_job* job) {
  const rg_block_walk* const walk = &job->walk;
  job->safe = find_safe_box(job);
  job->move = rg_find_lattice_lanes(job->lattice, walk->part_log2[0]);
  job->whole_parts =
      (uint16_t)(rg_load_u16(walk->section) >> walk->part_log2[0]);
}

/* To the next part, but for its block; 0 if there is none. */
static RG_INLINE int go_to_part(rg_remap_job* job) {
  rg_run* const run = &job->run;
  const rg_block_walk* const walk = &job->walk;
  if (job->part_pixels != 0) { /* back to the part's first row */
    const uint32_t rows = job->part_rows - 1u;
    run->out -= (size_t)rows * run->out_stride;
    run->first_row = (uint16_t)(run->first_row - rows);
  }
  const uint32_t log2 = job->lattice->log2[0];
  const uint32_t width = (uint32_t)rg_load_u16(walk->section) >> log2;
  const uint32_t part_width = 1u << walk->part_log2[0] >> log2;
  uint32_t first = walk->next_part * part_width;
  if (job->part_rows == 0 || first >= width) {
    if (!start_parts(job)) return 0;
    first = 0;
  }
  const uint32_t rest = width - first;
  run->out_pixel = (uint16_t)first;
  run->first_pixel = job->part_pixels = 0;
  run->num_pixels = (uint16_t)(rest < part_width ? rest : part_width);
  run->num_rows = job->rows_left = job->part_rows;
  return 1;
}

int rg_next_part(rg_remap_job* job) {
  if (!go_to_part(job)) return 0;
  find_block(job);
  return 1;
}

rg_care rg_next_run(rg_remap_job* job) {
  rg_run* const run = &job->run;
  if (job->part_pixels == 0) {
    const rg_care care = find_part_care(job);
    if (care != RG_CARE_PIXEL) {
      job->rows_left = 0;
      return care;
    }
    job->part_pixels = (uint8_t)run->num_pixels;
    run->num_pixels = 0; /* none of them is done */
    run->num_rows = 1;
  }
  return find_segment(job);
}

#endif
