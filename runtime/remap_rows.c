#include "remap_rows.h"

#include <stddef.h>

void rg_blend_grey8(const rg_run* run, uint8_t* out) {
  const uint8_t* const data = run->data;
  const uint32_t stride = run->stride;
  uint32_t x_q12 = (uint32_t)run->start.q12[0] + 16; /* rounds to 7 bits */
  uint32_t y_q12 = (uint32_t)run->start.q12[1];
  const uint32_t step_x = (uint32_t)run->step.q12[0];
  const uint32_t step_y = (uint32_t)run->step.q12[1];
  uint8_t* const end = out + run->num_pixels;
  do {
    const uint8_t* const upper =
        data + (size_t)(y_q12 >> 12) * stride + (x_q12 >> 12);
    const uint8_t* const lower = upper + stride;
    *out++ =
        (uint8_t)rg_blend_8(upper[0], upper[1], lower[0], lower[1],
                            (int32_t)(x_q12 >> 5) & 127, (int32_t)y_q12 & 4095);
    x_q12 += step_x;
    y_q12 += step_y;
  } while (out != end);
}

/* With the kind known to the compiler. */
static inline void blend_kind(uint32_t kind, const rg_run* run,
                              const rg_lattice* lattice, uint8_t* out,
                              uint32_t first_pixel) {
  const uint32_t step = lattice->sample_step;
  uint32_t target = lattice->first_sample + first_pixel * step;
  rg_position p = run->start;
  for (uint32_t k = 0; k < run->num_pixels; ++k, target += step) {
    const rg_cut_position cut = rg_cut(kind, p);
    const uint8_t* const upper = run->data + (size_t)cut.row * run->stride;
    const uint32_t index = lattice->first_sample + cut.column * step;
    for (uint32_t c = 0; c < lattice->num_channels; ++c)
      rg_store_sample(
          kind, out, target + c,
          rg_blend(kind, upper, upper + run->stride, index + c, step, cut));
    p.q12[0] += run->step.q12[0];
    p.q12[1] += run->step.q12[1];
  }
}

void rg_blend_lattice(const rg_run* run, const rg_lattice* lattice,
                      uint8_t* out, uint32_t first_pixel) {
  if (lattice->kind == RG_SAMPLE_8)
    blend_kind(RG_SAMPLE_8, run, lattice, out, first_pixel);
  else
    blend_kind(lattice->kind, run, lattice, out, first_pixel);
}
