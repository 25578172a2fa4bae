/* The inner loops of remapping, for runs of pixels that need no care: equal
 * steps, all sources inside. Faster versions for a core give the same bits:
 * formats/SPEC.md, "Remap arithmetic". */
#ifndef RAYGRID_REMAP_ROWS_H
#define RAYGRID_REMAP_ROWS_H

#include <stdint.h>

#include "pixel_formats.h"
#include "remap_table.h"

/* Pixels start, start + step, ... of an image. Position (0, 0) is data; every
 * source pixel and its right, lower and diagonal neighbours are in the image.
 * Positions are not negative. */
typedef struct rg_run {
  const uint8_t* data;
  uint32_t stride;
  rg_position start, step;
  uint32_t num_pixels; /* not 0 */
} rg_run;

/* One sample of 8 bits a pixel, one after the other. */
void rg_blend_grey8(const rg_run* run, uint8_t* out);

/* Any lattice; its first sample and step apply to out too. */
void rg_blend_lattice(const rg_run* run, const rg_lattice* lattice,
                      uint8_t* out, uint32_t first_pixel);

/* Bilinear: 7-bit weights across in 16 bits, then down with a rounding
 * multiply-high of 15 bits (wy_q12 in 12, which is the same). */
static inline uint32_t rg_blend_8(uint32_t p00, uint32_t p01, uint32_t p10,
                                  uint32_t p11, int32_t wx_q7, int32_t wy_q12) {
  /* Half an LSB of the result is added early: it does not change the
   * difference. */
  const int32_t left_q7 = 128 - wx_q7;
  const int32_t upper_q7 = 64 + (int32_t)p00 * left_q7 + (int32_t)p01 * wx_q7;
  const int32_t lower_q7 = 64 + (int32_t)p10 * left_q7 + (int32_t)p11 * wx_q7;
  const int32_t down_q7 = ((lower_q7 - upper_q7) * wy_q12 + 0x800) >> 12;
  return (uint32_t)(upper_q7 + down_q7) >> 7;
}

/* Samples of up to 16 bits, 8-bit weights both ways: below 2^32 - 2^15. */
static inline uint32_t rg_blend_16(uint32_t p00, uint32_t p01, uint32_t p10,
                                   uint32_t p11, uint32_t wx_q8,
                                   uint32_t wy_q8) {
  const uint32_t upper_q8 = p00 * (256 - wx_q8) + p01 * wx_q8;
  const uint32_t lower_q8 = p10 * (256 - wx_q8) + p11 * wx_q8;
  return (upper_q8 * (256 - wy_q8) + lower_q8 * wy_q8 + 0x8000) >> 16;
}

/* A source position cut into pixel and weights, as the kind wants them. */
typedef struct rg_cut_position {
  uint32_t column, row;
  int32_t wx, wy;
} rg_cut_position;

static inline rg_cut_position rg_cut(uint32_t kind, rg_position p) {
  rg_cut_position cut;
  if (kind == RG_SAMPLE_8) {
    const uint32_t x_q12 = (uint32_t)p.q12[0] + 16; /* rounds to 7 bits */
    const uint32_t y_q12 = (uint32_t)p.q12[1];
    cut.column = x_q12 >> 12;
    cut.row = y_q12 >> 12;
    cut.wx = (int32_t)(x_q12 >> 5) & 127;
    cut.wy = (int32_t)y_q12 & 4095;
  } else {
    const uint32_t x_q8 = ((uint32_t)p.q12[0] + 8) >> 4;
    const uint32_t y_q8 = ((uint32_t)p.q12[1] + 8) >> 4;
    cut.column = x_q8 >> 8;
    cut.row = y_q8 >> 8;
    cut.wx = (int32_t)x_q8 & 255;
    cut.wy = (int32_t)y_q8 & 255;
  }
  return cut;
}

/* The four samples around a cut position, two rows, the right ones step
 * samples on. */
static inline uint32_t rg_blend(uint32_t kind, const uint8_t* upper,
                                const uint8_t* lower, uint32_t index,
                                uint32_t right, rg_cut_position cut) {
  const uint32_t p00 = rg_load_sample(kind, upper, index);
  const uint32_t p01 = rg_load_sample(kind, upper, index + right);
  const uint32_t p10 = rg_load_sample(kind, lower, index);
  const uint32_t p11 = rg_load_sample(kind, lower, index + right);
  return kind == RG_SAMPLE_8 ? rg_blend_8(p00, p01, p10, p11, cut.wx, cut.wy)
                             : rg_blend_16(p00, p01, p10, p11, (uint32_t)cut.wx,
                                           (uint32_t)cut.wy);
}

#endif /* RAYGRID_REMAP_ROWS_H */
