/* Pixels with every check, and without a source: for functions that know the
 * lattice and the border, or do not. */
#ifndef RAYGRID_REMAP_PIXELS_H
#define RAYGRID_REMAP_PIXELS_H

#include <stddef.h>
#include <string.h>

#include "planes.h"
#include "remap_blocks.h"

static RG_INLINE void rg_put(const rg_lattice* lattice, uint8_t* row,
                             uint32_t index, uint32_t value) {
  if (lattice->kind == RG_SAMPLE_8)
    row[index] = (uint8_t)value;
  else
    rg_put_sample(lattice->kind, row, index, value);
}

/* Of channels of 8 bits that fill the plane: 8 bytes at once, which begin with
 * the first channel again after three such steps at most. */
static inline void rg_fill_bytes(const rg_run* run, uint32_t channels,
                                 const uint16_t* values) {
  uint8_t pattern[24];
  const uint32_t num_bytes = run->num_pixels * channels;
  uint8_t* out = run->out + run->out_pixel * channels;
  for (uint32_t k = 0, c = 0; k < 24 && k < num_bytes; ++k) {
    pattern[k] = (uint8_t)values[c];
    c = c + 1 == channels ? 0 : c + 1;
    RG_IN_REGISTER(c); /* else the compiler calls memset() */
  }
  for (uint32_t r = run->num_rows; r != 0; --r, out += run->out_stride) {
    uint32_t k = 0, phase = 0;
    for (; k + 8 <= num_bytes; k += 8) {
      memcpy(out + k, pattern + phase, 8);
      phase = phase == 16 ? 0 : phase + 8;
    }
    for (; k < num_bytes; ++k) out[k] = pattern[phase + (k & 7)];
  }
}

/* The border's values, of the lattice's channels. */
static RG_INLINE void rg_fill_run(const rg_run* run, const rg_lattice* lattice,
                                  const uint16_t* values) {
  if (RG_KEEP_LINES && RG_IS_FAST && rg_interleaved(lattice) != 0) {
    rg_fill_bytes(run, lattice->num_channels, values);
    return;
  }
  uint8_t* out = run->out;
  for (uint32_t r = run->num_rows; r != 0; --r, out += run->out_stride) {
    uint32_t index =
        (uint32_t)lattice->first_sample + run->out_pixel * lattice->sample_step;
    for (uint32_t k = run->num_pixels; k != 0; --k) {
      for (uint32_t c = 0; c < lattice->num_channels; ++c)
        rg_put(lattice, out, index + c, values[c]);
      index += lattice->sample_step;
      RG_IN_REGISTER(index); /* else the compiler calls memset() */
    }
  }
}

static RG_INLINE const uint8_t* rg_source_row(const rg_remap_job* job,
                                              int is_grey, uint32_t row) {
  if (!is_grey && job->ring_rows != 0)
    row = (uint32_t)rg_remainder(row, job->ring_rows);
  return job->run.data + (size_t)row * job->run.stride;
}

/* The run's pixel, at its position moved into the lattice; 0 if it has no
 * source. is_grey: the lattice is that of grey frames, for which nothing else
 * than bilinear blending is needed. */
static RG_INLINE int rg_remap_pixel(const rg_remap_job* job,
                                    const rg_lattice* lattice, int is_grey,
                                    rg_sampling sampling) {
  const uint32_t kind = lattice->kind, step = lattice->sample_step;
  uint32_t q12[2], neighbor[2]; /* one beyond the last has weight zero */
  for (int c = 0; c < 2; ++c) {
    const rg_range range = rg_job_range(job, lattice, c);
    const int32_t last = job->size[c] - 1, position = job->position.q12[c];
    int32_t moved = rg_clamp(position, range.min_q12, range.max_q12);
    if (moved != position && (is_grey || !job->walk.is_clamped)) return 0;
    moved = rg_clamp(moved, 0, last << 12);
    q12[c] = sampling == RG_SAMPLING_NEAREST
                 ? ((uint32_t)moved + 2048) & ~UINT32_C(4095)
                 : (uint32_t)moved + rg_rounding(kind, c);
    neighbor[c] = q12[c] >> 12 < (uint32_t)last;
  }
  const uint32_t row = q12[1] >> 12;
  const rg_neighbors at = {q12[0], q12[1], rg_source_row(job, is_grey, row),
                           rg_source_row(job, is_grey, row + neighbor[1]),
                           neighbor[0] ? step : 0};
  const uint32_t index = lattice->first_sample + (q12[0] >> 12) * step;
  const uint32_t target = lattice->first_sample + job->run.out_pixel * step;
  for (uint32_t c = 0; c < lattice->num_channels; ++c)
    rg_put(lattice, job->run.out, target + c,
           rg_blend_samples(kind, &at, index + c));
  return 1;
}

#endif /* RAYGRID_REMAP_PIXELS_H */
