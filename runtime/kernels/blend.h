/* Bilinear interpolation of neighbours: formats/SPEC.md, "Remap arithmetic". */
#ifndef RAYGRID_BLEND_H
#define RAYGRID_BLEND_H

#include <stdint.h>

#include "config.h"
#if RG_HAVE_SIMD32
#include <arm_acle.h>
#endif

#include "fixed_point.h"
#include "kernels/block.h"
#include "kernels/samples.h"

/* Loads two neighbouring samples, the left one into the low byte. */
static inline uint32_t rg_load_pair(const uint8_t* p) {
  return p[0] | (uint32_t)p[1] << 8;
}

/* Extracts bytes 0 and 2 into halves; the next function bytes 1 and 3. */
static inline uint32_t rg_even_bytes(uint32_t bytes) {
#if RG_HAVE_SIMD32
  return (uint32_t)__uxtb16(bytes);
#else
  return bytes & 0x00ff00ff;
#endif
}

static inline uint32_t rg_odd_bytes(uint32_t bytes) {
#if RG_HAVE_SIMD32
  return (uint32_t)__uxtb16(bytes >> 8);
#else
  return (bytes >> 8) & 0x00ff00ff;
#endif
}

/* Sum of the rounding constants of both interpolations of 8-bit pixels. */
#define RG_ROUNDING_8 UINT32_C(0x407ff)

/* Interpolates with weights across (q7) and down (q12), with one rounding.
 * Low halves are samples of the upper row, high halves of the lower row. */
static RG_INLINE uint32_t rg_blend_8(uint32_t left, uint32_t right,
                                     uint32_t wx_q7, uint32_t wy_q12) {
  /* h0 below and h1 above 16 bits */
  const uint32_t h_q7 = (right - left) * wx_q7 + (left << 7);
#if RG_HAVE_SIMD32
  /* h0 (4096 - wy) + h1 wy: one instruction */
  const uint32_t weights = (wy_q12 << 16) - wy_q12 + 4096;
  return (uint32_t)__smlad((int16x2_t)h_q7, (int16x2_t)weights,
                           (int32_t)RG_ROUNDING_8) >>
         19;
#else
  const uint32_t upper_q7 = h_q7 & 0xffff;
  const uint32_t down_q7 = (h_q7 >> 16) - upper_q7;
  return (down_q7 * wy_q12 + ((upper_q7 << 12) + RG_ROUNDING_8)) >> 19;
#endif
}

/* Half the last bit of the weights across (c = 0) and down, which is added to a
 * position before it is split into pixel and weight. */
static inline uint32_t rg_rounding(uint32_t kind, int c) {
  return kind != RG_SAMPLE_8 ? 8 : c == 0 ? 16 : 0;
}

/* Rounds the positions of a row: to the last bit of the weights, or, to copy
 * the nearest pixel, to whole pixels. */
static RG_INLINE void rg_round_row(uint32_t kind, int is_copy,
                                   rg_block_row* row) {
  for (int c = 0; c < 2; ++c)
    row->start.q12[c] = rg_add(row->start.q12[c],
                               is_copy ? 2048 : (int32_t)rg_rounding(kind, c));
}

/* Interpolates the bytes around a position that includes the rounding. The
 * right samples are `right` bytes after the left ones. */
static RG_INLINE uint32_t rg_interpolate_bytes(const uint8_t* upper,
                                               const uint8_t* lower,
                                               uint32_t right, uint32_t x_q12,
                                               uint32_t y_q12) {
  return rg_blend_8(upper[0] | (uint32_t)lower[0] << 16,
                    upper[right] | (uint32_t)lower[right] << 16,
                    (x_q12 >> 5) & 127, y_q12 & 4095);
}

/* The neighbours of a position that includes the rounding, and the output row
 * of the pixel. */
typedef struct rg_neighbors {
  rg_position position;
  const uint8_t *upper, *lower; /* rows of the source */
  uint32_t right;               /* samples to the right neighbours */
  uint8_t* out;
} rg_neighbors;

/* Coordinate c of the position, which must not be negative. */
static inline uint32_t rg_get_q12(const rg_neighbors* at, int c) {
  return (uint32_t)at->position.q12[c];
}

/* Interpolates two samples of a row, of up to 16 bits, with 8-bit weights. */
static inline uint32_t rg_blend_pair(const rg_neighbors* at, uint32_t left,
                                     uint32_t right) {
  const uint32_t wx_q8 = (rg_get_q12(at, 0) >> 4) & 255;
  return left * (256 - wx_q8) + right * wx_q8;
}

/* Interpolates samples of more than 8 bits: sample `index` of the upper row,
 * and its neighbours. Sums for 16-bit samples are below 2^32 - 2^15. */
static RG_INLINE uint32_t rg_blend_wide(uint32_t kind, const rg_neighbors* at,
                                        uint32_t index) {
  uint32_t left = rg_load_sample(kind, at->upper, index);
  RG_FORGET(at); /* loads fields only when needed */
  uint32_t right = rg_load_sample(kind, at->upper, index + at->right);
  const uint32_t upper_q8 = rg_blend_pair(at, left, right);
  left = rg_load_sample(kind, at->lower, index);
  RG_FORGET(at);
  right = rg_load_sample(kind, at->lower, index + at->right);
  const uint32_t lower_q8 = rg_blend_pair(at, left, right);
  const uint32_t wy_q8 = (rg_get_q12(at, 1) >> 4) & 255;
  return (upper_q8 * (256 - wy_q8) + lower_q8 * wy_q8 + 0x8000) >> 16;
}

/* Interpolates samples of any kind. */
static RG_INLINE uint32_t rg_blend_samples(uint32_t kind,
                                           const rg_neighbors* at,
                                           uint32_t index) {
  return kind == RG_SAMPLE_8
             ? rg_interpolate_bytes(at->upper + index, at->lower + index,
                                    at->right, rg_get_q12(at, 0),
                                    rg_get_q12(at, 1))
             : rg_blend_wide(kind, at, index);
}

/* rg_store_sample(), not inlined. */
void rg_put_sample(uint32_t kind, uint8_t* row, uint32_t index, uint32_t value);

/* rg_mix_samples() interpolates one sample of more than 8 bits,
 * rg_interleave_bytes() num_channels consecutive samples of 8 bits. */
uint32_t rg_mix_samples(uint32_t kind, const rg_neighbors* at, uint32_t index);
void rg_interleave_bytes(const rg_neighbors* at, uint32_t index, uint8_t* out,
                         uint32_t num_channels);

/* Interpolates a pixel of any component and stores it in the row at->out. */
static RG_INLINE void rg_blend_pixel(const rg_component* component,
                                     const rg_neighbors* at,
                                     uint32_t out_pixel) {
  const uint32_t index = rg_first_sample(component, rg_get_q12(at, 0) >> 12);
  if (component->kind == RG_SAMPLE_8) {
    rg_interleave_bytes(at, index,
                        at->out + rg_first_sample(component, out_pixel),
                        component->num_channels);
  } else {
    const uint32_t value = rg_mix_samples(component->kind, at, index);
    rg_put_sample(component->kind, at->out,
                  rg_first_sample(component, out_pixel), value);
  }
}

#endif /* RAYGRID_BLEND_H */
