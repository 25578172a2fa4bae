/* Bilinear interpolation by gathers of 8 pixels, for any step whose offsets fit
 * into 16 bits. Only the pixels' own neighbours are read: lanes after the last
 * pixel are predicated off. */
#include "kernels/kernel.h"
#include "kernels/segments.h"

#if RG_HAVE_HELIUM

#include <arm_mve.h>

#include "fixed_point.h"

#define INLINE static inline __attribute__((always_inline))

#define LANES 8

#define ROWS 4

/* The initial values of a row: the position of the minimum x and y of its first
 * segment, the steps, and the (non-positive) distances from the first lane to
 * that minimum. They are stored for ROWS rows at once, with a stride of ROWS.
 */
enum {
  X = 0 * ROWS,
  STEP_X = 1 * ROWS,
  BACK = 2 * ROWS,
  Y = 3 * ROWS,
  STEP_Y = 4 * ROWS,
  UP = 5 * ROWS,
  GROUP_SIZE = 6 * ROWS
};

/* Computes one coordinate of the rows with these numbers in the block. */
INLINE void compute_rows(const rg_span* span, int c, int32x4_t row,
                         int32_t origin, int32_t width_shift,
                         int32_t height_shift, int32_t* values) {
  const rg_position* const p = span->block.corners;
  int32x4_t down = vmulq_n_s32(row, p[2].q12[c] - p[0].q12[c]);
  const int32x4_t left =
      vaddq_n_s32(vrshlq_n_s32(down, height_shift), p[0].q12[c] - origin);
  down = vmulq_n_s32(row, p[3].q12[c] - p[1].q12[c]);
  const int32x4_t right =
      vaddq_n_s32(vrshlq_n_s32(down, height_shift), p[1].q12[c] - origin);
  const int32x4_t step = vrshlq_n_s32(vsubq_s32(right, left), width_shift);
  const int32x4_t back =
      vminq_s32(vmulq_n_s32(step, LANES - 1), vdupq_n_s32(0));
  vstrwq_s32(values + X,
             vaddq_s32(vmlaq_n_s32(left, step, span->first_pixel), back));
  vstrwq_s32(values + STEP_X, step);
  vstrwq_s32(values + BACK, back);
}

static void compute_row_group(const rg_span* span, uint32_t r,
                              int32_t* values) {
  const int32x4_t row = vreinterpretq_s32_u32(vidupq_n_u32(r, 1));
  const int32_t width_shift = -(int32_t)span->block.width_log2;
  const int32_t height_shift = -(int32_t)span->block.height_log2;
  compute_rows(span, 0, row, -16, width_shift, height_shift, values);
  compute_rows(span, 1, row, span->first_source_row << 12, width_shift,
               height_shift, values + Y);
}

/* Interpolates one row of samples horizontally, times 128. */
INLINE uint16x8_t blend_across(const uint8_t* base, uint32_t channels,
                               uint16x8_t offsets, uint16x8_t wx) {
  const uint16x8_t left = vldrbq_gather_offset_u16(base, offsets);
  const uint16x8_t right = vldrbq_gather_offset_u16(base + channels, offsets);
  return vmlaq_n_u16(vmulq_u16(vsubq_u16(right, left), wx), left, 128);
}

/* x and y in q12 relative to the base, the minimum of the segment. Masks are
 * pairs of shifts, since registers are scarce. */
INLINE void blend_segment(const uint8_t* base, uint32_t stride,
                          uint32_t channels, uint16x8_t x, uint16x8_t y,
                          uint8_t* out) {
  uint16x8_t offsets = vshrq_n_u16(x, 12);
  if (channels != 1) offsets = vmulq_n_u16(offsets, (uint16_t)channels);
  offsets = vmlaq_n_u16(offsets, vshrq_n_u16(y, 12), (uint16_t)stride);
  const uint16x8_t wx = vshrq_n_u16(vshlq_n_u16(x, 4), 9);
  const int16x8_t wy_q15 =
      vreinterpretq_s16_u16(vshrq_n_u16(vshlq_n_u16(y, 4), 1));
  for (uint32_t c = 0; c < channels; ++c) {
    const uint16x8_t h0 = blend_across(base + c, channels, offsets, wx);
    const uint16x8_t h1 =
        blend_across(base + stride + c, channels, offsets, wx);
    /* v = h0 - ((h0 - h1) wy + 2^14) >> 15, then (v + 64) >> 7 */
    const int16x8_t down =
        vqrdmulhq_s16(vreinterpretq_s16_u16(vsubq_u16(h0, h1)), wy_q15);
    const uint16x8_t v = vreinterpretq_u16_s16(
        vrshrq_n_s16(vsubq_s16(vreinterpretq_s16_u16(h0), down), 7));
    if (channels == 1)
      vstrbq_u16(out, v);
    else
      vstrbq_scatter_offset_u16(
          out + c, vmulq_n_u16(vidupq_n_u16(0, 1), (uint16_t)channels), v);
  }
}

/* pixels: the distance from the first segment to the second one, such that the
 * last segment ends at the row's end. */
INLINE void blend_row(const rg_span* span, const int32_t* row, uint32_t pixels,
                      uint32_t channels, uint8_t* out) {
  const uint8_t* const data = span->data;
  const uint32_t stride = span->stride;
  const uint32_t step_x = (uint32_t)row[STEP_X];
  const uint32_t step_y = (uint32_t)row[STEP_Y];
  uint32_t x = (uint32_t)row[X], y = (uint32_t)row[Y];
  const uint16x8_t lane = vidupq_n_u16(0, 1);
  const uint16x8_t lanes_x =
      vsubq_n_u16(vmulq_n_u16(lane, (uint16_t)step_x), (uint16_t)row[BACK]);
  const uint16x8_t lanes_y =
      vsubq_n_u16(vmulq_n_u16(lane, (uint16_t)step_y), (uint16_t)row[UP]);
  uint8_t* const last = out + (span->num_pixels - LANES) * channels;
  for (;;) {
    const uint8_t* const base =
        data + (x >> 12) * channels + (y >> 12) * stride;
    blend_segment(base, stride, channels,
                  vaddq_n_u16(lanes_x, (uint16_t)(x & 4095)),
                  vaddq_n_u16(lanes_y, (uint16_t)(y & 4095)), out);
    if (out == last) return;
    out += pixels * channels;
    x += pixels * step_x;
    y += pixels * step_y;
    pixels = LANES;
  }
}

/* Separate functions, so that each loop can use all registers. */
typedef void blend_one_row(const rg_span* span, const int32_t* row,
                           uint32_t pixels, uint8_t* out);
#define ROW_OF(channels)                                        \
  static RG_NOINLINE void blend_row_##channels##_helium(        \
      const rg_span* span, const int32_t* row, uint32_t pixels, \
      uint8_t* out) {                                           \
    blend_row(span, row, pixels, channels, out);                \
  }
ROW_OF(1)
ROW_OF(2)
ROW_OF(3)
ROW_OF(4)

INLINE void blend(const rg_span* span, uint32_t channels,
                  blend_one_row* blend_one, rg_blend* portable) {
  if (span->num_pixels < LANES || !rg_fits_offsets(span, LANES, channels)) {
    portable(span);
    return;
  }
  /* The second segment of a row may overlap the first. */
  const uint32_t pixels = (span->num_pixels - 1u) % LANES + 1;
  uint8_t* out = span->out + span->out_pixel * channels;
  uint32_t r = span->first_row, rest = span->num_rows;
  do {
    int32_t values[GROUP_SIZE];
    const int32_t* row = values;
    uint32_t num_rows = rest < ROWS ? rest : ROWS;
    compute_row_group(span, r, values);
    r += num_rows;
    rest -= num_rows;
    do {
      blend_one(span, row++, pixels, out);
      out += span->out_stride;
    } while (--num_rows != 0);
  } while (rest != 0);
}

void rg_blend_1_helium(const rg_span* span) {
  blend(span, 1, blend_row_1_helium, rg_blend_1);
}
void rg_blend_2_helium(const rg_span* span) {
  blend(span, 2, blend_row_2_helium, rg_blend_2);
}
void rg_blend_3_helium(const rg_span* span) {
  blend(span, 3, blend_row_3_helium, rg_blend_3);
}
void rg_blend_4_helium(const rg_span* span) {
  blend(span, 4, blend_row_4_helium, rg_blend_4);
}

#endif
