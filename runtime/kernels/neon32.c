/* Bilinear interpolation by table lookup on 32-bit Arm: 8 lanes of a row, whose
 * pixels read at most 16 contiguous bytes of each of three rows. Spans with
 * larger steps are processed by the portable kernels. */
#include "kernels/kernel.h"
#include "kernels/segments.h"

#if defined(__arm__) && defined(__ARM_NEON)

#include <arm_neon.h>
#include <stddef.h>

#define INLINE static inline __attribute__((always_inline))

/* The pixels of a segment: 2, 4 or 8. */
typedef struct layout {
  uint32_t channels, pixels;
} layout;

/* By channels - 1: the pixel of each lane, relative to its window. */
static const uint16_t kLanePixels[4][8] = {{0, 1, 2, 3, 4, 5, 6, 7},
                                           {0, 0, 1, 1, 2, 2, 3, 3},
                                           {0, 0, 0, 1, 1, 1, 1, 1},
                                           {0, 0, 0, 0, 1, 1, 1, 1}};

/* By channels - 1: the byte offset in the window of the first pixel's left
 * sample, for each lane. */
static const uint8_t kLaneOffsets[4][8] = {{0, 0, 0, 0, 0, 0, 0, 0},
                                           {0, 1, 0, 1, 0, 1, 0, 1},
                                           {0, 1, 2, 0, 1, 2, 2, 2},
                                           {0, 1, 2, 3, 0, 1, 2, 3}};

/* Weighted samples of two consecutive rows. */
INLINE uint16x8_t blend_across(uint8x16_t upper, uint8x16_t lower,
                               uint8x8_t left, uint8x8_t right, uint8x8_t wx) {
  const uint8x8x4_t rows = {{vget_low_u8(upper), vget_high_u8(upper),
                             vget_low_u8(lower), vget_high_u8(lower)}};
  return vmlal_u8(vmull_u8(vtbl4_u8(rows, left), vsub_u8(vdup_n_u8(128), wx)),
                  vtbl4_u8(rows, right), wx);
}

/* x in q12 and y in q15, relative to the window's start. */
INLINE uint8x8_t blend_segment(const uint8_t* window, size_t stride,
                               uint16x8_t x_q12, uint16x8_t y_q15,
                               uint8x8_t offsets, layout l) {
  /* The pixel in the window, plus 16 in the second of its rows. */
  const uint8x8_t pixel =
      vshr_n_u8(vshrn_n_u16(vsriq_n_u16(y_q15, x_q12, 1), 8), 3);
  uint8x8_t left = vadd_u8(pixel, offsets);
  if (l.channels != 1) /* multiplies the pixel by channels, not the 16 */
    left = vmla_u8(left, vand_u8(pixel, vdup_n_u8(15)),
                   vdup_n_u8((uint8_t)(l.channels - 1)));
  const uint8x8_t right = vadd_u8(left, vdup_n_u8((uint8_t)l.channels));
  const uint8x8_t wx = vand_u8(vshrn_n_u16(x_q12, 5), vdup_n_u8(127));
  const int16x8_t wy =
      vreinterpretq_s16_u16(vandq_u16(y_q15, vdupq_n_u16(0x7fff)));
  const uint8x16_t row0 = vld1q_u8(window);
  const uint8x16_t row1 = vld1q_u8(window + stride);
  const uint8x16_t row2 = vld1q_u8(window + 2 * stride);
  const uint16x8_t h0 = blend_across(row0, row1, left, right, wx);
  const uint16x8_t h1 = blend_across(row1, row2, left, right, wx);
  /* (v + 64) >> 7, v = h0 - ((h0 - h1) wy + 2^14) >> 15 */
  const int16x8_t difference = vreinterpretq_s16_u16(vsubq_u16(h0, h1));
  const int16x8_t v =
      vsubq_s16(vreinterpretq_s16_u16(h0), vqrdmulhq_s16(difference, wy));
  return vqrshrun_n_s16(v, 7);
}

/* With three channels, two of the eight bytes are unused; the next segment
 * overwrites them. */
INLINE void store(uint8_t* out, uint8x8_t bytes, int is_last, layout l) {
  if (l.channels == 3 && is_last) {
    uint8_t all[8];
    vst1_u8(all, bytes);
    __builtin_memcpy(out, all, 6);
  } else {
    vst1_u8(out, bytes);
  }
}

INLINE void blend_row(const rg_span* span, const rg_block_row* row,
                      uint8_t* out, layout l) {
  const int32_t pixels = (int32_t)l.pixels, n = span->num_pixels;
  const int32_t step_x = row->step.q12[0], step_y = row->step.q12[1];
  /* The window starts at the first x + 16 and the minimum y. */
  const int32_t up = step_y < 0 ? (pixels - 1) * step_y : 0;
  const uint16x8_t lanes = vld1q_u16(kLanePixels[l.channels - 1]);
  const uint8x8_t offsets = vld1_u8(kLaneOffsets[l.channels - 1]);
  const uint16x8_t lanes_x = vmulq_n_u16(lanes, (uint16_t)step_x);
  const uint16x8_t lanes_y =
      vsubq_u16(vmulq_n_u16(lanes, (uint16_t)(8 * step_y)),
                vdupq_n_u16((uint16_t)(8 * up)));
  int32_t x = row->start.q12[0] + 16, y = row->start.q12[1] + up;
  for (int32_t k = 0; k < n; k += pixels) {
    if (k + pixels > n) { /* the last segment overlaps the previous one */
      const int32_t back = k + pixels - n;
      x -= back * step_x;
      y -= back * step_y;
      k = n - pixels;
    }
    const uint8_t* const window = span->data +
                                  (size_t)((uint32_t)y >> 12) * span->stride +
                                  ((uint32_t)x >> 12) * l.channels;
    const uint16x8_t x_q12 =
        vaddq_u16(lanes_x, vdupq_n_u16((uint16_t)(x & 4095)));
    const uint16x8_t y_q15 =
        vaddq_u16(lanes_y, vdupq_n_u16((uint16_t)((y & 4095) << 3)));
    store(out + (uint32_t)k * l.channels,
          blend_segment(window, span->stride, x_q12, y_q15, offsets, l),
          k + pixels == n, l);
    x += pixels * step_x;
    y += pixels * step_y;
  }
}

INLINE void blend(const rg_span* span, layout l, rg_blend* portable) {
  if (!rg_fits_windows(span, l.pixels, 16 / l.channels)) {
    portable(span);
    return;
  }
  uint8_t* out = span->out + span->out_pixel * l.channels;
  for (uint32_t r = 0; r < span->num_rows; ++r, out += span->out_stride) {
    rg_block_row row;
    rg_compute_span_row(span, r, &row);
    blend_row(span, &row, out, l);
  }
}

#define BLEND(channels, pixels)                          \
  void rg_blend_##channels##_neon(const rg_span* span) { \
    const layout l = {channels, pixels};                 \
    blend(span, l, rg_blend_##channels);                 \
  }
BLEND(1, 8)
BLEND(2, 4)
BLEND(3, 2)
BLEND(4, 2)

#endif
