/* Block by block, what is done with one lattice of a frame. The runs of pixels
 * go to functions of the caller's, so that a program with grey frames alone has
 * no code of the others. */
#ifndef RAYGRID_REMAP_BLOCKS_H
#define RAYGRID_REMAP_BLOCKS_H

#include "lattice_map.h"
#include "remap_dispatch.h"
#include "remap_kernels.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What the pixels of a run ask for. */
typedef enum rg_care {
  RG_CARE_NONE,     /* their neighbours lie in the source, in rows that follow
                       each other in memory, and so do the spare rows */
  RG_CARE_SPARE,    /* the spare rows may not */
  RG_CARE_PIXEL,    /* it is one pixel, which may have no source, or that may
                       lack neighbours */
  RG_CARE_NO_SOURCE /* none has */
} rg_care;

typedef struct rg_remap_job rg_remap_job;

/* The run of the job. */
typedef void rg_remap_run(rg_remap_job* job, rg_care care);

/* Brings the corners of the run's block, which are in the image's pixels, to
 * the lattice's, and chooses the rows of the source. */
typedef void rg_prepare_block(rg_remap_job* job);

struct rg_remap_job {
  const rg_lattice* lattice;
  rg_remap_run* remap_run;
  rg_prepare_block* prepare_block; /* may be 0 */
  const void* context;             /* of these functions */
#if RG_CHOOSE_KERNELS
  const rg_kernels* kernels;
#endif
  uint16_t size[2];   /* of the source lattice: width, height */
  uint16_t ring_rows; /* likewise; 0: no ring */
  uint16_t num_rows;  /* that follow each other in memory, from the run's
                         first_source_row on */
  rg_block_walk walk;
  rg_run run;
#if RG_KEEP_LINES
  rg_range ranges[2]; /* as rg_job_range() has them */
#endif
};

/* Coordinate c of the positions that have a source, for the job's lattice. */
static RG_INLINE rg_range rg_job_range(const rg_remap_job* job,
                                       const rg_lattice* lattice, int c) {
#if RG_KEEP_LINES
  (void)lattice;
  return job->ranges[c];
#else
  return rg_source_range(job->walk.section, lattice, c);
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

/* Rows [row, end) of the lattice's output. The job holds all but the walk's
 * place and the run's pixels; run.out is for the first row. Always
 * RG_OK, so that callers have no status to keep. */
rg_status rg_remap_rows(rg_remap_job* job, uint32_t row, uint32_t end);

#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_REMAP_BLOCKS_H */
