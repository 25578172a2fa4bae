/* Block by block, what remapping does with one lattice. Included by remap.c for
 * any lattice, and by remap_grey.c, which defines RG_GREY_ONLY so that a
 * program with grey frames alone has no code of the others. */
#ifndef RAYGRID_REMAP_BLOCKS_H
#define RAYGRID_REMAP_BLOCKS_H

#include <stddef.h>

#include "fixed_point.h"
#include "lattice_map.h"
#include "raygrid.h"
#include "remap_dispatch.h"
#include "remap_kernels.h"

/* More than rounding moves the positions of a block beyond its corners, and
 * than a position is rounded by, in q12. */
#define SAFE_MARGIN 64

/* Positions that need no care: their neighbours lie in the source, in rows that
 * follow each other in memory. */
typedef struct safe_region {
  rg_position min, max;
} safe_region;

/* What every block of a lattice needs. Positions are in its own pixels. */
typedef struct remap_job {
  rg_lattice_map map;
  safe_region safe;
  uint16_t ring_start, ring_rows; /* rows from ring_start + ring_rows on wrap */
  uint8_t border, sampling;       /* rg_border, rg_sampling */
  uint8_t is_ring;
  const uint16_t* border_values; /* of the lattice's channels */
  const rg_kernels* kernels;
  rg_run run;
} remap_job;

#ifdef RG_GREY_ONLY
#define LATTICE_OF(job) ((void)(job), &kGreyLattice)
#define BORDER_OF(job) RG_BORDER_VALUE
#define SAMPLING_OF(job) RG_SAMPLING_BILINEAR
#define IS_RING(job) 0
static const rg_lattice kGreyLattice = {0, RG_SAMPLE_8, 0, 1, 1, 0,
                                        0, 0,           0, 0, 1, 0};
#else
#define LATTICE_OF(job) ((job)->map.lattice)
#define BORDER_OF(job) ((job)->border)
#define SAMPLING_OF(job) ((job)->sampling)
#define IS_RING(job) ((job)->is_ring)
#endif

static inline int32_t min_of(int32_t a, int32_t b) { return a < b ? a : b; }
static inline int32_t max_of(int32_t a, int32_t b) { return a > b ? a : b; }

/* ---- Single pixels, with every check ------------------------------------- */

static inline const uint8_t* source_row(const remap_job* job, uint32_t row) {
  uint32_t slot = row;
  if (IS_RING(job)) {
    slot -= job->ring_start;
    if (slot >= job->ring_rows) slot -= job->ring_rows;
  }
  return job->run.data + (size_t)slot * job->run.stride;
}

static inline void store_border(const remap_job* job, uint8_t* out,
                                uint32_t index) {
  const rg_lattice* const lattice = LATTICE_OF(job);
  for (uint32_t c = 0; c < lattice->num_channels; ++c)
    rg_store_sample(lattice->kind, out, index + c, job->border_values[c]);
}

/* Bilinear or nearest, at a position that is moved into the lattice. */
static void store_source(const remap_job* job, const rg_position* p,
                         uint8_t* out, uint32_t index) {
  const rg_lattice* const lattice = LATTICE_OF(job);
  uint32_t q12[2];
  uint32_t neighbor[2]; /* one beyond the last has weight zero */
  for (int c = 0; c < 2; ++c) {
    const uint32_t last = c == 0 ? job->map.width - 1u : job->map.height - 1u;
    const int32_t moved = max_of(min_of(p->q12[c], (int32_t)(last << 12)), 0);
    q12[c] = SAMPLING_OF(job) == RG_SAMPLING_NEAREST
                 ? (uint32_t)(moved + 2048) & ~4095u
                 : (uint32_t)moved + rg_rounding(lattice->kind, c);
    neighbor[c] = q12[c] >> 12 < last;
  }
  const uint32_t row = q12[1] >> 12;
  const uint8_t* const upper = source_row(job, row);
  const uint8_t* const lower = source_row(job, row + neighbor[1]);
  const uint32_t first =
      lattice->first_sample + (q12[0] >> 12) * lattice->sample_step;
  for (uint32_t c = 0; c < lattice->num_channels; ++c)
    rg_store_sample(lattice->kind, out, index + c,
                    rg_blend_samples(lattice->kind, upper, lower, first + c,
                                     neighbor[0] ? lattice->sample_step : 0,
                                     q12[0], q12[1]));
}

/* Pixel k of the row; out is the output's row. */
static inline void remap_pixel(const remap_job* job, const rg_position* p,
                               uint8_t* out, uint32_t k) {
  const rg_lattice* const lattice = LATTICE_OF(job);
  const uint32_t index =
      lattice->first_sample + (job->run.out_pixel + k) * lattice->sample_step;
  if (!rg_is_between(&job->map.min, &job->map.max, p)) {
    if (BORDER_OF(job) == RG_BORDER_KEEP) return;
    if (BORDER_OF(job) == RG_BORDER_VALUE) {
      store_border(job, out, index);
      return;
    }
    rg_position nearest;
    for (int c = 0; c < 2; ++c)
      nearest.q12[c] =
          max_of(min_of(p->q12[c], job->map.max.q12[c]), job->map.min.q12[c]);
    store_source(job, &nearest, out, index);
  } else {
    store_source(job, p, out, index);
  }
}

/* ---- Runs ---------------------------------------------------------------- */

/* By the kernel for the lattice; lowest is the largest row of a position. */
static inline void do_run(const remap_job* job, const rg_run* run,
                          int32_t lowest_q12) {
#ifdef RG_GREY_ONLY
  rg_dispatch_grey(job->kernels, run,
                   lowest_q12 <= job->safe.max.q12[1] - RG_SPARE_Q12);
#else
  const rg_lattice* const lattice = LATTICE_OF(job);
  if (job->sampling == RG_SAMPLING_NEAREST)
    rg_copy_lattice(run, lattice);
  else
    rg_dispatch(job->kernels, run, lattice,
                lowest_q12 <= job->safe.max.q12[1] - RG_SPARE_Q12);
#endif
}

static inline int is_safe(const remap_job* job, const rg_position* p) {
  return rg_is_between(&job->safe.min, &job->safe.max, p);
}

/* ---- Blocks -------------------------------------------------------------- */

/* Pixels that need care one by one, the others, which lie together because
 * positions are linear, by a kernel. */
static RG_NOINLINE void remap_row(remap_job* job, uint32_t first_row,
                                  uint32_t num_pixels, uint8_t* out) {
  rg_run* const run = &job->run;
  rg_block_row row;
  rg_find_block_row(&run->block, first_row, &row);
  rg_position p = rg_row_position(&row, 0);
  uint32_t k = 0;
  while (k < num_pixels) {
    uint32_t end = k;
    for (; end < num_pixels && is_safe(job, &p); ++end)
      for (int c = 0; c < 2; ++c) p.q12[c] += row.step.q12[c];
    if (end != k) {
      const rg_position first = rg_row_position(&row, k);
      run->first_pixel = (uint8_t)k;
      run->num_pixels = (uint8_t)(end - k);
      run->first_row = (uint8_t)first_row;
      run->num_rows = 1;
      run->out_pixel += k;
      run->out = out;
      do_run(job, run, max_of(first.q12[1], p.q12[1] - row.step.q12[1]));
      run->out_pixel -= k;
      k = end;
    } else {
      remap_pixel(job, &p, out, k);
      for (int c = 0; c < 2; ++c) p.q12[c] += row.step.q12[c];
      ++k;
    }
  }
}

static void fill_row(const remap_job* job, uint32_t num_pixels, uint8_t* out) {
  const rg_lattice* const lattice = LATTICE_OF(job);
  uint32_t index =
      lattice->first_sample + job->run.out_pixel * lattice->sample_step;
  for (; num_pixels != 0; --num_pixels, index += lattice->sample_step)
    store_border(job, out, index);
}

/* Where the corners of the run's block let no pixel need care, the largest row
 * of them; RG_OUTSIDE where they let none have a source; otherwise
 * RG_NOT_INSIDE. */
#define RG_NOT_INSIDE INT32_MIN
#define RG_OUTSIDE (INT32_MIN + 1)
static inline int32_t inside_rows(const remap_job* job) {
  const rg_position* const p = job->run.block.corners;
  int32_t lowest = 0;
  for (int c = 0; c < 2; ++c) {
    const int32_t a = p[0].q12[c], b = p[1].q12[c];
    const int32_t d = p[2].q12[c], e = p[3].q12[c];
    const int32_t low = min_of(min_of(a, b), min_of(d, e));
    const int32_t high = max_of(max_of(a, b), max_of(d, e));
    if (high < job->map.min.q12[c] - SAFE_MARGIN ||
        low > job->map.max.q12[c] + SAFE_MARGIN)
      return RG_OUTSIDE;
    lowest = low < job->safe.min.q12[c] || high > job->safe.max.q12[c] ||
                     lowest == RG_NOT_INSIDE
                 ? RG_NOT_INSIDE
                 : high;
  }
  return lowest;
}

#ifndef RG_GREY_ONLY
/* The part of the ring, before its rows wrap or after, that the block lies in.
 * Pixels of the other part are taken one by one. */
static void choose_ring_part(remap_job* job) {
  const int32_t wrap = job->ring_start + job->ring_rows;
  int32_t top = INT32_MAX;
  for (int k = 0; k < 4; ++k)
    top = min_of(top, job->run.block.corners[k].q12[1]);
  const int is_after = top >> 12 >= wrap;
  const int32_t first = is_after ? wrap : job->ring_start;
  const int32_t last = first + job->ring_rows - 1;
  job->run.first_source_row = (uint16_t)first;
  job->safe.min.q12[1] = max_of(job->map.min.q12[1], first << 12) + SAFE_MARGIN;
  job->safe.max.q12[1] =
      min_of(job->map.max.q12[1], min_of(last, job->map.height - 1) << 12) -
      SAFE_MARGIN;
}
#endif

static void fill_block(const remap_job* job, uint32_t num_rows,
                       uint32_t num_pixels, uint8_t* out) {
  if (BORDER_OF(job) == RG_BORDER_KEEP) return;
  for (; num_rows != 0; --num_rows, out += job->run.out_stride)
    fill_row(job, num_pixels, out);
}

/* Rows [row, row + num_rows) of the run's block, num_pixels of each. */
static inline void remap_block(remap_job* job, uint32_t row, uint32_t num_rows,
                               uint32_t num_pixels, uint8_t* out) {
  rg_run* const run = &job->run;
#ifndef RG_GREY_ONLY
  if (job->map.lattice->log2_x != 0)
    rg_lattice_block(job->map.lattice, &run->block);
  if (job->is_ring) choose_ring_part(job);
#endif
  const int32_t lowest = inside_rows(job);
  if (lowest > RG_OUTSIDE) {
    run->first_pixel = 0;
    run->num_pixels = (uint8_t)num_pixels;
    run->first_row = (uint8_t)row;
    run->num_rows = (uint8_t)num_rows;
    run->out = out;
    do_run(job, run, lowest);
  } else if (lowest == RG_OUTSIDE && BORDER_OF(job) != RG_BORDER_CLAMP) {
    fill_block(job, num_rows, num_pixels, out);
  } else {
    for (; num_rows != 0; --num_rows, ++row, out += run->out_stride)
      remap_row(job, row, num_pixels, out);
  }
}

/* Rows [row, end) of the lattice's output to out. */
static void remap_rows(remap_job* job, uint32_t row, uint32_t end,
                       uint8_t* out) {
  const rg_lattice* const lattice = LATTICE_OF(job);
  const uint8_t* const section = job->map.section;
  const uint32_t width = (uint32_t)rg_load_u16(section) >> lattice->log2_x;
  const uint32_t width_log2 = rg_part_log2(section, lattice, 0);
  const uint32_t height_log2 = rg_part_log2(section, lattice, 1);
  const uint32_t part_width = 1u << width_log2 >> lattice->log2_x;
  const uint32_t part_height = 1u << height_log2 >> lattice->log2_y;
  while (row < end) {
    const uint32_t first = row & (part_height - 1);
    const uint32_t num_rows =
        (uint32_t)min_of((int32_t)(end - row), (int32_t)(part_height - first));
    rg_block_walk walk;
    rg_start_walk(section, width_log2, height_log2,
                  row << lattice->log2_y >> height_log2, &walk);
    for (uint32_t pixel = 0; pixel < width; pixel += part_width) {
      const uint32_t num_pixels =
          (uint32_t)min_of((int32_t)(width - pixel), (int32_t)part_width);
      job->run.out_pixel = pixel;
      rg_next_block(&walk, &job->run.block);
      if (BORDER_OF(job) != RG_BORDER_CLAMP && walk.is_empty)
        fill_block(job, num_rows, num_pixels, out);
      else
        remap_block(job, first, num_rows, num_pixels, out);
    }
    out += (size_t)num_rows * job->run.out_stride;
    row += num_rows;
  }
}

/* The rectangle of positions that need no care, of a whole frame. */
static inline void find_safe_region(remap_job* job) {
  for (int c = 0; c < 2; ++c) {
    const int32_t last = (c == 0 ? job->map.width : job->map.height) - 1;
    job->safe.min.q12[c] = max_of(job->map.min.q12[c], 0) + SAFE_MARGIN;
    job->safe.max.q12[c] =
        min_of(job->map.max.q12[c], last << 12) - SAFE_MARGIN;
  }
}

#endif /* RAYGRID_REMAP_BLOCKS_H */
