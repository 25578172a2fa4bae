#include "remap_blocks.h"

#include <stddef.h>

/* More than rounding moves the positions of a block beyond its corners, and
 * than a position is rounded by, in q12. */
#define SAFE_MARGIN 64

static inline int32_t min_of(int32_t a, int32_t b) { return a < b ? a : b; }
static inline int32_t max_of(int32_t a, int32_t b) { return a > b ? a : b; }

/* Short where stacks and programs are; elsewhere fast. */
#if RG_KEEP_LINES
#define OF_BLOCKS RG_INLINE
#else
#define OF_BLOCKS RG_SHARED
#endif

/* What coordinate c of positions between two values asks for. */
static RG_INLINE rg_care find_axis_care(const rg_remap_job* job, int c,
                                        int32_t low, int32_t high) {
  const rg_range source = rg_job_range(job, job->lattice, c);
  const int32_t first = c == 0 ? 0 : job->run.first_source_row;
  const int32_t num = c == 0 ? job->size[0] : job->num_rows;
  const int32_t end =
      min_of(source.max_q12, (first + num - 1) * 4096) - SAFE_MARGIN;
  if (high < source.min_q12 - SAFE_MARGIN || low > source.max_q12 + SAFE_MARGIN)
    return RG_CARE_NO_SOURCE;
  if (low < max_of(source.min_q12, first * 4096) + SAFE_MARGIN || high > end)
    return RG_CARE_PIXEL;
  return RG_CHOOSE_KERNELS && c == 1 && high > end - RG_SPARE_Q12
             ? RG_CARE_SPARE
             : RG_CARE_NONE;
}

/* The greater care of both coordinates. */
static OF_BLOCKS rg_care find_care(const rg_remap_job* job,
                                   const rg_position* low,
                                   const rg_position* high) {
  const rg_care x = find_axis_care(job, 0, low->q12[0], high->q12[0]);
  const rg_care y = find_axis_care(job, 1, low->q12[1], high->q12[1]);
  const rg_care care = x > y ? x : y;
  return care == RG_CARE_NO_SOURCE && job->walk.is_clamped ? RG_CARE_PIXEL
                                                           : care;
}

/* Of all pixels of the run's block. */
static OF_BLOCKS rg_care find_block_care(const rg_remap_job* job) {
  const rg_position* const p = job->run.block.corners;
  rg_position low, high;
  if (job->walk.is_empty && !job->walk.is_clamped) return RG_CARE_NO_SOURCE;
  for (int c = 0; c < 2; ++c) {
    const int32_t a = p[0].q12[c], b = p[1].q12[c];
    const int32_t d = p[2].q12[c], e = p[3].q12[c];
    low.q12[c] = min_of(min_of(a, b), min_of(d, e));
    high.q12[c] = max_of(max_of(a, b), max_of(d, e));
  }
  return find_care(job, &low, &high);
}

/* Makes the run, of one row of a part, end before the row does or where its
 * pixels begin to need another care. */
static RG_NOINLINE rg_care find_segment(rg_remap_job* job) {
  rg_run* const run = &job->run;
  rg_block_row row;
  rg_find_block_row(&run->block, run->first_row, &row);
  rg_position p = rg_row_position(&row, run->first_pixel);
  job->position = p;
  const rg_care care = find_care(job, &p, &p);
  uint32_t k = run->first_pixel;
  do {
    for (int c = 0; c < 2; ++c) p.q12[c] += row.step.q12[c];
    ++k;
  } while (k < job->part_pixels && care != RG_CARE_PIXEL &&
           find_care(job, &p, &p) == care);
  run->num_pixels = (uint8_t)(k - run->first_pixel);
  if (k >= job->part_pixels) --job->rows_left;
  return care;
}

/* On to the pixels behind the run's segment. */
static OF_BLOCKS void go_on_in_part(rg_remap_job* job) {
  rg_run* const run = &job->run;
  const uint32_t end = job->part_pixels;
  run->first_pixel = (uint8_t)(run->first_pixel + run->num_pixels);
  run->out_pixel = (uint16_t)(run->out_pixel + run->num_pixels);
  if (run->first_pixel < end) return;
  run->first_pixel = 0;
  run->out_pixel = (uint16_t)(run->out_pixel - end);
  ++run->first_row;
  run->out += run->out_stride;
}

/* To the row of parts below those that were done; 0 below the last one. */
static OF_BLOCKS int start_parts(rg_remap_job* job) {
  const uint8_t* const section = job->walk.section;
  job->run.out += (size_t)job->part_rows * job->run.out_stride;
  const uint32_t row = (uint32_t)job->row + job->part_rows, end = job->end_row;
  if (row >= end) return 0;
  const uint32_t width_log2 = rg_part_log2(section, job->lattice, 0);
  const uint32_t height_log2 = rg_part_log2(section, job->lattice, 1);
  const uint32_t rows_log2 = height_log2 - job->lattice->log2[1];
  const uint32_t part = row >> rows_log2;
  const uint32_t next = (part + 1) << rows_log2;
  rg_start_walk(section, width_log2, height_log2, part, &job->walk);
  job->row = (uint16_t)row;
  job->part_rows = (uint8_t)((next < end ? next : end) - row);
  return 1;
}

/* Pixels of the row from the next part on; 0 behind the last one. */
static inline uint32_t rest_of_row(const rg_remap_job* job) {
  const uint32_t width = rg_load_u16(job->walk.section);
  const uint32_t first = (uint32_t)job->walk.next_part
                         << job->walk.part_log2[0];
  return first < width ? (width - first) >> job->lattice->log2[0] : 0;
}

/* The run of the next part, from which on the row has so many pixels. */
static OF_BLOCKS void start_part(rg_remap_job* job, uint32_t rest) {
  rg_run* const run = &job->run;
  const rg_lattice* const lattice = job->lattice;
  const uint32_t part_width = 1u << job->walk.part_log2[0] >> lattice->log2[0];
  const uint32_t part_height = 1u << job->walk.part_log2[1] >> lattice->log2[1];
  run->out_pixel = (uint16_t)(job->walk.next_part * part_width);
  run->first_pixel = 0;
  run->num_pixels = (uint8_t)(rest < part_width ? rest : part_width);
  run->first_row = (uint8_t)(job->row & (part_height - 1));
  run->num_rows = job->rows_left = job->part_rows;
#if RG_KEEP_LINES
  if (job->walk.next_part == 0) rg_start_columns(&job->walk);
  rg_find_corners(job);
  run->block.width_log2 = (uint8_t)(job->walk.part_log2[0] - lattice->log2[0]);
  run->block.height_log2 = (uint8_t)(job->walk.part_log2[1] - lattice->log2[1]);
#else
  rg_next_block(&job->walk, &run->block);
#endif
}

#if RG_KEEP_LINES

static rg_safe_box find_safe_box(const rg_remap_job* job) {
  int32_t min[2], max[2];
  for (int c = 0; c < 2; ++c) {
    const rg_range source = job->ranges[c];
    const int32_t last_q12 = (job->size[c] - 1) * 4096;
    min[c] = max_of(source.min_q12, 0) + SAFE_MARGIN;
    max[c] = min_of(source.max_q12, last_q12) - SAFE_MARGIN;
  }
  if (RG_CHOOSE_KERNELS) max[1] -= RG_SPARE_Q12;
  if (job->ring_rows != 0) max[1] = min[1] - 1;
  const rg_safe_box box = {rg_twice(min[0], min[1]), rg_twice(max[0], max[1])};
  return box;
}

#endif

/* Of the part at hand. */
static OF_BLOCKS rg_care find_part_care(const rg_remap_job* job) {
#if RG_KEEP_LINES
  if (rg_is_part_safe(job)) return RG_CARE_NONE;
#endif
  return find_block_care(job);
}

void rg_start_rows(rg_remap_job* job, uint32_t first_row, uint32_t num_rows) {
  const uint32_t log2 = job->lattice->log2[1];
  job->row = (uint16_t)(first_row >> log2);
  job->end_row = (uint16_t)((first_row + num_rows) >> log2);
  job->part_rows = job->part_pixels = 0;
#if RG_KEEP_LINES
  for (int c = 0; c < 2; ++c)
    job->ranges[c] = rg_source_range(job->walk.section, job->lattice, c);
  const uint8_t* const section = job->walk.section;
  const uint32_t width_log2 = rg_part_log2(section, job->lattice, 0);
  job->safe = find_safe_box(job);
  job->move = rg_find_lattice_lanes(job->lattice, width_log2);
  job->whole_parts = (uint16_t)(rg_load_u16(section) >> width_log2);
#endif
}

int rg_next_part(rg_remap_job* job) {
  if (job->part_pixels != 0) /* back to the part's first row */
    job->run.out -= (size_t)(job->part_rows - 1u) * job->run.out_stride;
  job->part_pixels = 0;
  uint32_t rest = job->part_rows == 0 ? 0 : rest_of_row(job);
  if (rest == 0) {
    if (!start_parts(job)) return 0;
    rest = rest_of_row(job);
  }
  start_part(job, rest);
  return 1;
}

rg_care rg_next_run(rg_remap_job* job) {
  if (job->part_pixels != 0) {
    go_on_in_part(job);
  } else {
    const rg_care care = find_part_care(job);
    if (care != RG_CARE_PIXEL) {
      job->rows_left = 0;
      return care;
    }
    job->part_pixels = job->run.num_pixels;
    job->run.num_rows = 1;
  }
  return find_segment(job);
}
