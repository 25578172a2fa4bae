/* One lattice of a frame, block by block: a walk over runs of pixels, with
 * which the caller does what is to be done, so that a program with grey frames
 * alone has no code of the others, and the stack of the walk is free by then.
 */
#ifndef RAYGRID_REMAP_BLOCKS_H
#define RAYGRID_REMAP_BLOCKS_H

#include <stddef.h>

#include "frames/lattice_map.h"
#include "kernels/remap_dispatch.h"
#include "kernels/remap_kernels.h"

#ifdef __cplusplus
extern "C" {
#endif

/* More than rounding moves the positions of a block beyond its corners, and
 * than a position is rounded by, in q12. */
#define RG_POSITION_MARGIN 64

/* The care that the pixels of a run ask for. */
typedef enum rg_care {
  RG_CARE_NONE,     /* their neighbours lie in the source, in rows that follow
                       each other in memory, and so do the spare rows */
  RG_CARE_SPARE,    /* the spare rows may not */
  RG_CARE_PIXEL,    /* it is one pixel, which may have no source, or that may
                       lack neighbours */
  RG_CARE_NO_SOURCE /* none has */
} rg_care;

/* A function that is called for each run, with the care that it asks for. */
typedef void rg_do_run(struct rg_remap_job* job, rg_care care);

#if RG_KEEP_LINES
/* The box of positions in which a part's corners ask for no care. No position
 * lies in it if the source is a ring. */
typedef struct rg_safe_box {
  rg_lanes min, max;
} rg_safe_box;
#endif

typedef struct rg_remap_job {
  rg_block_walk walk;
  uint16_t size[2];   /* of the source lattice: width, height */
  uint16_t ring_rows; /* likewise; 0: no ring */
#if RG_KEEP_LINES
  uint16_t num_rows; /* that follow each other in memory, from the run's
                        first_source_row on */
#else
  uint16_t width;        /* of the output, in the lattice's pixels */
#endif
  uint16_t row;     /* of the output: the first one of the row of parts at
                       hand; where size matters, of the next one */
  uint16_t end_row; /* behind the last one to do */
#if RG_KEEP_LINES
  uint8_t part_rows;   /* that the parts have; 0 before the first ones */
  uint8_t part_pixels; /* of such a row, where the part at hand is done in
                          segments of rows; 0: not yet */
  uint8_t rows_left;   /* of the part; 0: the run is the last one */
#endif
  rg_run run;
  const void* how; /* for what does runs and pixels */
#if RG_CHOOSE_KERNELS
  const rg_kernels* kernels;
#endif
#if RG_KEEP_LINES
  rg_range ranges[2]; /* of the positions that have a source: x, y */
#else
  const uint8_t* ranges; /* likewise, as a table's section has them */
#endif
#if RG_KEEP_LINES
  const rg_lattice* lattice;
  rg_position position; /* of the pixel that a run of RG_CARE_PIXEL is */
  uint16_t whole_parts; /* that a row of parts has, from the left */
  rg_safe_box safe;
  rg_lattice_lanes move;
#endif
} rg_remap_job;

/* A job with its own lattice, to be taken for the job itself. */
typedef struct rg_lattice_job {
  rg_remap_job job;
  rg_lattice lattice;
#if !RG_KEEP_LINES
  uint8_t ranges[16]; /* of the lattice, as a section has those of the image */
#endif
} rg_lattice_job;

/* The lattice of a job that has one. */
static RG_INLINE const rg_lattice* rg_lattice_of(const rg_remap_job* job) {
#if RG_KEEP_LINES
  return job->lattice;
#else
  return &((const rg_lattice_job*)job)->lattice;
#endif
}

/* wanted, or the fastest, as the frame's rows allow it. */
static inline void rg_set_kernels(rg_remap_job* job, const rg_kernels* wanted,
                                  uint32_t stride) {
#if RG_CHOOSE_KERNELS
  job->kernels = rg_choose_kernels(wanted, stride);
#else
  (void)job, (void)wanted, (void)stride;
#endif
}

static inline const rg_kernels* rg_kernels_of(const rg_remap_job* job) {
#if RG_CHOOSE_KERNELS
  return job->kernels;
#else
  (void)job;
  return 0;
#endif
}

/* The size of the source, in pixels of the image. */
static RG_INLINE void rg_set_source(rg_remap_job* job, uint32_t width,
                                    uint32_t height) {
  job->size[0] = (uint16_t)(width >> rg_lattice_of(job)->log2[0]);
  job->size[1] = (uint16_t)(height >> rg_lattice_of(job)->log2[1]);
#if RG_KEEP_LINES
  job->num_rows = job->size[1];
  job->run.first_source_row = 0;
#endif
}

#if RG_KEEP_LINES
/* The work that rg_start_rows() does for speed. */
void rg_start_lanes(rg_remap_job* job);
#endif

#if !RG_KEEP_LINES

/* To those of the lattice, from those of the image: one of these may be without
 * any of the lattice's positions. */
static RG_INLINE void rg_set_ranges(rg_lattice_job* whole) {
  whole->job.walk.is_void = 0;
  for (int c = 0; c < 2; ++c) {
    const rg_range range =
        rg_source_range(whole->job.walk.section, &whole->lattice, c);
    rg_store_i32(whole->ranges + 4 * c, range.min_q12);
    rg_store_i32(whole->ranges + 8 + 4 * c, range.max_q12);
    if (range.min_q12 > range.max_q12) whole->job.walk.is_void = 1;
  }
  whole->job.ranges = whole->ranges;
}

#endif

/* Sets what the job needs of the table, for any rows. The job holds its
 * kernels, sizes, and the walk's section and is_clamped; and of the run,
 * strides and data. */
static RG_INLINE void rg_set_table(rg_remap_job* job,
                                   const rg_lattice* lattice) {
  const uint8_t* const section = job->walk.section;
  const uint8_t across_log2 = rg_part_log2(section, lattice, 0);
  const uint8_t down_log2 = rg_part_log2(section, lattice, 1);
  rg_set_parts(&job->walk, across_log2, down_log2);
#if RG_KEEP_LINES
  for (int c = 0; c < 2; ++c)
    job->ranges[c] = rg_source_range(section, lattice, c);
#else
  job->ranges = section + 12;
  if (RG_ALL_BUILT_IN)
    job->run.out_pixel = job->run.first_pixel = job->run.first_source_row = 0;
  job->run.block.width_log2 = (uint8_t)(across_log2 - lattice->log2[0]);
  job->run.block.height_log2 = (uint8_t)(down_log2 - lattice->log2[1]);
  job->width = (uint16_t)(rg_load_u16(section) >> lattice->log2[0]);
#endif
}

/* Before the first part, of so many rows of the output, counted in pixels of
 * the image; run->out is for the first row. */
static RG_INLINE void rg_start_rows(rg_remap_job* job,
                                    const rg_lattice* lattice,
                                    uint32_t first_row, uint32_t num_rows) {
  rg_set_table(job, lattice);
  job->row = (uint16_t)(first_row >> lattice->log2[1]);
  job->end_row = (uint16_t)((first_row + num_rows) >> lattice->log2[1]);
#if RG_KEEP_LINES
  job->part_rows = job->part_pixels = 0;
  rg_start_lanes(job);
#else
  job->run.num_rows = job->run.out_pixel = 0;
  job->run.num_pixels = job->width; /* behind a row's last part */
#endif
}

/* To the next part of a block; 0 if there is none. The caller then brings it to
 * the lattice, and may choose the rows of the source. */
int rg_next_part(rg_remap_job* job);

/* The corners of the run's block from the image's pixels to the lattice's. A
 * program with grey frames alone does not need it. */
static RG_INLINE void rg_bring_to_lattice(rg_remap_job* job) {
#if RG_KEEP_LINES
  (void)job; /* they are */
#else
  rg_block* const block = &job->run.block;
  rg_move_corners(rg_lattice_of(job),
                  (uint32_t)block->width_log2 + rg_lattice_of(job)->log2[0],
                  block->corners);
  if (job->walk.is_void) job->walk.is_empty = 1;
#endif
}

#if !RG_KEEP_LINES
/* Whether so many positions have a source, and what is no farther than a margin
 * from them. */
int rg_have_sources(const rg_remap_job* job, const rg_position* positions,
                    uint32_t num, uint32_t margin);
#endif

/* Whether a position has a source. */
#if RG_KEEP_LINES
static RG_INLINE int rg_has_source(const rg_remap_job* job,
                                   const rg_position* position) {
  if (job->walk.is_empty) return 0;
  for (int c = 0; c < 2; ++c)
    if (position->q12[c] < job->ranges[c].min_q12 ||
        position->q12[c] > job->ranges[c].max_q12)
      return 0;
  return 1;
}
#else
static RG_INLINE int rg_has_source(const rg_remap_job* job,
                                   const rg_position* position) {
  return rg_have_sources(job, position, 1, 0);
}
#endif

#if RG_KEEP_LINES

/* The part's next run, and what its pixels ask for; while rows_left is not 0,
 * there is another one. */
rg_care rg_next_run(rg_remap_job* job);

#else

/* A lattice may end half a pixel before the positions with a source. (The
 * nearest pixel of such a position is not beyond its last, either.) */
#define RG_LATTICE_MARGIN (RG_POSITION_MARGIN + 2048)

/* Whether all pixels of the part ask for no care, unless the source is a ring.
 */
static RG_INLINE int rg_is_part_safe(const rg_remap_job* job) {
  const rg_position* const corners = job->run.block.corners;
  if (!RG_ALL_BUILT_IN)
    return rg_have_sources(job, corners, 4, RG_LATTICE_MARGIN);
  /* Built-in kernels are fast, so that this check is to be fast as well. */
  for (int c = 0; c < 2; ++c) {
    const uint8_t* const range = job->ranges + 4 * c;
    const int32_t min = rg_load_i32(range) + RG_LATTICE_MARGIN;
    const int32_t max = rg_load_i32(range + 8) - RG_LATTICE_MARGIN;
    for (int k = 0; k < 4; ++k)
      if (corners[k].q12[c] < min || corners[k].q12[c] > max) return 0;
  }
  return !job->walk.is_empty;
}

/* Each of these leaves the run's out below the part. */

/* The part, pixel by pixel. */
void rg_do_pixels(rg_remap_job* job, rg_do_pixel* on_pixel);

/* Does a part with less code than rg_do_pixels() but more stack, and leaves
 * nothing of the corners. If on_pixel is NULL, the kernel for grey pixels does
 * it, where none is built in. The run's out begins with the part's first pixel,
 * and is counted from it. */
void rg_do_rows(rg_remap_job* job, rg_do_pixel* on_pixel);

/* By the kernel for so many channels, of a part that asks for no care; 0 if
 * there is none. */
static RG_INLINE int rg_blend_part(rg_remap_job* job, uint32_t channels) {
#if RG_ALL_BUILT_IN
  if (!rg_blend_built_in(&job->run, channels)) return 0;
  job->run.out += (size_t)job->run.num_rows * job->run.out_stride;
  return 1;
#else
  if (channels != 1) return 0;
  job->run.out += job->run.out_pixel;
  rg_do_rows(job, NULL);
  job->run.out -= job->run.out_pixel;
  return 1;
#endif
}

#endif

/* The part at hand: runs as long as they ask for the same, or, where size
 * matters, the part as one run or pixel by pixel. */
static RG_INLINE void rg_do_part(rg_remap_job* job, rg_do_run* on_run,
                                 rg_do_pixel* on_pixel) {
#if RG_KEEP_LINES
  do {
    const rg_care care = rg_next_run(job);
    if (care == RG_CARE_PIXEL)
      on_pixel(job, &job->position, job->run.out_pixel);
    else
      on_run(job, care);
  } while (job->rows_left != 0);
#else
  if (rg_is_part_safe(job))
    on_run(job, RG_CARE_NONE);
  else
    rg_do_pixels(job, on_pixel);
#endif
}

#if RG_KEEP_LINES

/* The corners of the next part, as the lattice has them. */
static RG_INLINE void rg_find_corners(rg_remap_job* job) {
  const rg_lattice* const lattice = rg_lattice_of(job);
  rg_lanes upper, lower;
  rg_next_corners(&job->walk, &upper, &lower);
  if ((lattice->log2[0] | lattice->log2[1]) != 0)
    rg_lattice_corners(&job->move, &upper, &lower);
  rg_store_corners(upper, lower, job->run.block.corners);
}

/* Goes on as rg_next_part() does if neither the part at hand, which was done in
 * one run, nor the next one is cut off by the right border; else returns 0. */
static RG_INLINE int rg_next_whole_part(rg_remap_job* job) {
  if (job->part_pixels != 0 || job->walk.next_part >= job->whole_parts)
    return 0;
  job->run.out_pixel = (uint16_t)(job->run.out_pixel + job->run.num_pixels);
  job->rows_left = job->part_rows;
  rg_find_corners(job);
  return 1;
}

/* Whether the part at hand is a run of RG_CARE_NONE. */
static RG_INLINE int rg_is_part_safe(const rg_remap_job* job) {
  const rg_safe_box* const box = &job->safe;
  rg_lanes upper, lower;
  rg_load_corners(job->run.block.corners, &upper, &lower);
  const rg_lane_pairs beyond =
      (rg_lane_pairs)((upper < box->min) | (upper > box->max) |
                      (lower < box->min) | (lower > box->max));
  return (beyond[0] | beyond[1]) == 0 && !job->walk.is_empty;
}

/* The kernel that blends the safe parts of a row; NULL if none does. */
static RG_INLINE rg_blend_parts* rg_find_blend_parts(
    const rg_remap_job* job, const rg_lattice* lattice) {
#if RG_CHOOSE_KERNELS
  const uint32_t channels = rg_interleaved(lattice);
  const rg_block* const block = &job->run.block;
  if (job->kernels && channels != 0 && block->width_log2 == 3 &&
      block->height_log2 == 3 && job->part_rows == 8)
    return job->kernels->blend_parts[channels - 1];
#else
  (void)job, (void)lattice;
#endif
  return 0;
}

/* An rg_blend_parts for parts of any size and the job's lattice. */
static RG_INLINE int rg_do_safe_parts(rg_remap_job* job,
                                      const rg_lattice* lattice,
                                      rg_sampling sampling) {
  const int is_copy = sampling == RG_SAMPLING_NEAREST;
  rg_blend_parts* const blend_parts =
      is_copy ? 0 : rg_find_blend_parts(job, lattice);
  if (blend_parts) return blend_parts(job);
  while (rg_next_whole_part(job)) {
    if (!rg_is_part_safe(job)) return 1;
    if (is_copy)
      rg_copy_lattice(&job->run, lattice);
    else
      rg_dispatch(rg_kernels_of(job), &job->run, lattice, 1);
  }
  return 0;
}

#endif

#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_REMAP_BLOCKS_H */
