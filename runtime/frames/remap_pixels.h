/* Pixels without a source: for functions that know the lattice and the border,
 * or do not. */
#ifndef RAYGRID_REMAP_PIXELS_H
#define RAYGRID_REMAP_PIXELS_H

#include <stddef.h>

#include "frames/planes.h"
#include "frames/remap_blocks.h"

static RG_INLINE void rg_put(const rg_lattice* lattice, uint8_t* row,
                             uint32_t index, uint32_t value) {
  if (lattice->kind == RG_SAMPLE_8)
    row[index] = (uint8_t)value;
  else
    rg_put_sample(lattice->kind, row, index, value);
}

/* Fills pixels whose channels of 8 bits fill the plane: 8 bytes at once, which
 * begin with the first channel again after three such steps at most. */
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

#endif /* RAYGRID_REMAP_PIXELS_H */
