/* Bilinear blending by gathers of 8 pixels, of any steps whose offsets fit into
 * 16 bits. Nothing is read but the pixels' own neighbours: lanes behind the
 * last pixel are predicated away. */
#if defined(__ARM_FEATURE_MVE)

#include <arm_mve.h>

#include "remap_kernels.h"

#define INLINE static inline __attribute__((always_inline))

#define LANES 8

/* Rows of a run, one after the other. */
typedef struct row_steps {
  int32x4_t top;  /* P00, P10 */
  int32x4_t down; /* (P01 - P00) r, (P11 - P10) r */
  int32x4_t height, minus_height_log2;
} row_steps;

INLINE row_steps first_row(const rg_run* run) {
  const rg_block* const block = &run->block;
  const int32_t origin[4] = {0, run->first_source_row << 12, 0,
                             run->first_source_row << 12};
  row_steps rows;
  rows.top = vldrwq_s32(block->corners[0].q12);
  rows.height = vsubq_s32(vldrwq_s32(block->corners[2].q12), rows.top);
  rows.down = vmulq_n_s32(rows.height, run->first_row);
  rows.top = vsubq_s32(rows.top, vldrwq_s32(origin));
  rows.minus_height_log2 = vdupq_n_s32(-(int32_t)block->height_log2);
  return rows;
}

INLINE void next_row(const rg_run* run, row_steps* rows, rg_block_row* row) {
  /* left, right = top + round((bottom - top) r, height_log2) */
  const int32x4_t edges =
      vaddq_s32(rows->top, vrshlq_s32(rows->down, rows->minus_height_log2));
  rows->down = vaddq_s32(rows->down, rows->height);
  const int32_t left[2] = {vgetq_lane_s32(edges, 0), vgetq_lane_s32(edges, 1)};
  const int32_t right[2] = {vgetq_lane_s32(edges, 2), vgetq_lane_s32(edges, 3)};
  for (int c = 0; c < 2; ++c) {
    row->step.q12[c] =
        rg_round_shift(right[c] - left[c], run->block.width_log2);
    row->start.q12[c] = left[c] + run->first_pixel * row->step.q12[c];
  }
}

/* One row of samples across, times 128. */
INLINE uint16x8_t blend_across(const uint8_t* base, uint32_t channels,
                               uint16x8_t offsets, uint16x8_t wx) {
  const uint16x8_t left = vldrbq_gather_offset_u16(base, offsets);
  const uint16x8_t right = vldrbq_gather_offset_u16(base + channels, offsets);
  return vmlaq_n_u16(vmulq_u16(vsubq_u16(right, left), wx), left, 128);
}

/* x and y in q12 from the base, which is the least of a segment. Masks are
 * pairs of shifts: registers are scarce. */
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

/* What rows have in common, in registers. */
typedef struct run_constants {
  const uint8_t* data;
  uint32_t stride, num_pixels;
} run_constants;

INLINE void blend_row(const run_constants* run, const rg_block_row* row,
                      uint32_t channels, uint8_t* out) {
  const int32_t step_x = row->step.q12[0], step_y = row->step.q12[1];
  /* To the least x and y of a segment. */
  const int32_t back = step_x < 0 ? (LANES - 1) * step_x : 0;
  const int32_t up = step_y < 0 ? (LANES - 1) * step_y : 0;
  const uint16x8_t lane = vidupq_n_u16(0, 1);
  const uint16x8_t lanes_x =
      vsubq_n_u16(vmulq_n_u16(lane, (uint16_t)step_x), (uint16_t)back);
  const uint16x8_t lanes_y =
      vsubq_n_u16(vmulq_n_u16(lane, (uint16_t)step_y), (uint16_t)up);
  uint32_t x = (uint32_t)(row->start.q12[0] + 16 + back);
  uint32_t y = (uint32_t)(row->start.q12[1] + up);
  uint8_t* const last = out + (run->num_pixels - LANES) * channels;
  /* The second segment may begin within the first. */
  uint32_t pixels = run->num_pixels % LANES;
  if (pixels == 0) pixels = LANES;
  for (;;) {
    const uint8_t* const base =
        run->data + (y >> 12) * run->stride + (x >> 12) * channels;
    blend_segment(base, run->stride, channels,
                  vaddq_n_u16(lanes_x, (uint16_t)(x & 4095)),
                  vaddq_n_u16(lanes_y, (uint16_t)(y & 4095)), out);
    if (out == last) return;
    out += pixels * channels;
    x += pixels * (uint32_t)step_x;
    y += pixels * (uint32_t)step_y;
    pixels = LANES;
  }
}

INLINE void blend(const rg_run* run, uint32_t channels, rg_blend* portable) {
  if (run->num_pixels < LANES || !rg_fits_offsets(run, LANES, channels)) {
    portable(run);
    return;
  }
  const run_constants constants = {run->data, run->stride, run->num_pixels};
  row_steps rows = first_row(run);
  uint8_t* out = run->out + run->out_pixel * channels;
  for (uint32_t r = run->num_rows; r != 0; --r, out += run->out_stride) {
    rg_block_row row;
    next_row(run, &rows, &row);
    blend_row(&constants, &row, channels, out);
  }
}

void rg_blend_1_helium(const rg_run* run) { blend(run, 1, rg_blend_1); }
void rg_blend_2_helium(const rg_run* run) { blend(run, 2, rg_blend_2); }
void rg_blend_3_helium(const rg_run* run) { blend(run, 3, rg_blend_3); }
void rg_blend_4_helium(const rg_run* run) { blend(run, 4, rg_blend_4); }

#endif
