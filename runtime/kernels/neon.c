/* Bilinear blending by table lookup: 8 lanes read at most 16 contiguous bytes
 * of each of three rows (32 for three channels), so that table lookups take the
 * place of a gather. Runs with larger steps go to the portable kernels. */
#if defined(__aarch64__)

#include <arm_neon.h>
#include <stddef.h>

#include "remap_kernels.h"

#define INLINE static inline __attribute__((always_inline))

/* Pixels of a segment, and bytes of its window. */
typedef struct layout {
  uint32_t channels, pixels, window;
} layout;

static const uint16_t kLanePixels[3][8] = {{0, 1, 2, 3, 4, 5, 6, 7},
                                           {0, 0, 1, 1, 2, 2, 3, 3},
                                           {0, 0, 0, 0, 1, 1, 1, 1}};

/* Where the window has the left samples of a segment's first pixel, and the
 * right ones. */
static const uint8_t kLaneOffsets[3][16] = {
    {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1},
    {0, 1, 0, 1, 0, 1, 0, 1, 2, 3, 2, 3, 2, 3, 2, 3},
    {0, 1, 2, 3, 0, 1, 2, 3, 4, 5, 6, 7, 4, 5, 6, 7}};

/* 128 - wx in the low half, wx in the high one: |wx - these|. */
static const uint8_t kWeights[16] = {128, 128, 128, 128, 128, 128, 128, 128};

/* Rows of a run, one after the other. */
typedef struct row_steps {
  int32x4_t top;  /* P00, P10 */
  int32x4_t down; /* (P01 - P00) r, (P11 - P10) r */
  int32x4_t height;
  int32x4_t minus_height_log2;
  int32x2_t minus_width_log2, first_pixel;
} row_steps;

INLINE row_steps first_row(const rg_run* run) {
  const rg_block* const block = &run->block;
  const int32_t origin[4] = {0, run->first_source_row << 12, 0,
                             run->first_source_row << 12};
  row_steps rows;
  rows.top = vld1q_s32(block->corners[0].q12);
  rows.height = vsubq_s32(vld1q_s32(block->corners[2].q12), rows.top);
  rows.top = vsubq_s32(rows.top, vld1q_s32(origin));
  rows.down = vmulq_n_s32(rows.height, run->first_row);
  rows.minus_height_log2 = vdupq_n_s32(-(int32_t)block->height_log2);
  rows.minus_width_log2 = vdup_n_s32(-(int32_t)block->width_log2);
  rows.first_pixel = vdup_n_s32(run->first_pixel);
  return rows;
}

/* x, y, step x, step y. */
INLINE int32x4_t next_row(row_steps* rows) {
  /* left, right = top + round((bottom - top) r, height_log2) */
  const int32x4_t edges =
      vaddq_s32(rows->top, vrshlq_s32(rows->down, rows->minus_height_log2));
  rows->down = vaddq_s32(rows->down, rows->height);
  const int32x2_t left = vget_low_s32(edges);
  const int32x2_t step = vrshl_s32(vsub_s32(vget_high_s32(edges), left),
                                   rows->minus_width_log2);
  return vcombine_s32(vmla_s32(left, step, rows->first_pixel), step);
}

/* (v + 64) >> 7, v = h0 - ((h0 - h1) wy + 2^14) >> 15 */
INLINE uint8x8_t blend_down(uint16x8_t h0, uint16x8_t h1, int16x8_t wy) {
  const int16x8_t difference = vreinterpretq_s16_u16(vsubq_u16(h0, h1));
  const int16x8_t v = vsubq_s16(vreinterpretq_s16_u16(h0),
                                vqrdmulhq_s16(difference, wy));
  return vqrshrun_n_s16(v, 7);
}

/* h: left samples and weights in the low halves, right ones in the high. */
INLINE uint16x8_t blend_across(uint8x16_t samples, uint8x16_t weights) {
  return vmlal_high_u8(vmull_u8(vget_low_u8(samples), vget_low_u8(weights)),
                       samples, weights);
}

/* x in q12 and y in q15 of 8 lanes, from where the window starts. */
typedef struct lanes {
  uint8x16_t pixel; /* of the window, 16 more in the second row; twice */
  uint8x16_t weights;
  int16x8_t wy;
} lanes;

INLINE lanes cut(uint16x8_t x_q12, uint16x8_t y_q15) {
  lanes cut;
  uint16x8_t low_bits = vdupq_n_u16(0x7fff);
  __asm__("" : "+w"(low_bits)); /* else a copy and a shorter instruction */
  cut.wy = vreinterpretq_s16_u16(vandq_u16(y_q15, low_bits));
  const uint8x16_t high =
      vreinterpretq_u8_u16(vsriq_n_u16(y_q15, x_q12, 1));
  cut.pixel = vshrq_n_u8(vuzp2q_u8(high, high), 3);
  const uint8x8_t wx = vand_u8(vshrn_n_u16(x_q12, 5), vdup_n_u8(127));
  cut.weights = vabdq_u8(vcombine_u8(wx, wx), vld1q_u8(kWeights));
  return cut;
}

/* Samples of rows 0 and 1, 16 bytes each, and of rows 1 and 2. The tables must
 * be neighbouring registers, which the compiler would make copies for. */
INLINE void look_up(const uint8_t* window, size_t stride, size_t two_rows,
                    uint8x16_t index, uint8x16_t* upper, uint8x16_t* lower) {
  register uint8x16_t row0 __asm__("v16") = vld1q_u8(window);
  register uint8x16_t row1 __asm__("v17") = vld1q_u8(window + stride);
  register uint8x16_t row2 __asm__("v18") = vld1q_u8(window + two_rows);
  __asm__("tbl %0.16b, {v16.16b, v17.16b}, %1.16b"
          : "=w"(*upper)
          : "w"(index), "w"(row0), "w"(row1));
  __asm__("tbl %0.16b, {v17.16b, v18.16b}, %1.16b"
          : "=w"(*lower)
          : "w"(index), "w"(row1), "w"(row2));
}

/* What the segments of a run, and of a row, have in common. */
typedef struct segment_constants {
  const uint8_t* data;
  size_t stride, two_rows;
  uint8x16_t offsets;
  uint16x8_t lanes_x, lanes_y; /* of the row */
} segment_constants;

INLINE uint8x8_t blend_segment(const segment_constants* s, uint64_t x_q12,
                               uint64_t y_q12, layout l) {
  const uint8_t* const window = s->data + (size_t)(y_q12 >> 12) * s->stride +
                                (size_t)(x_q12 >> 12) * l.channels;
  const lanes at = cut(
      vaddq_u16(s->lanes_x, vdupq_n_u16((uint16_t)(x_q12 & 4095))),
      vaddq_u16(s->lanes_y, vdupq_n_u16((uint16_t)((y_q12 & 4095) << 3))));
  uint8x16_t index = vaddq_u8(at.pixel, s->offsets);
  if (l.channels != 1) { /* channels times the pixel; the 16 stay */
    const uint8x16_t pixel = vandq_u8(at.pixel, vdupq_n_u8(15));
    index = l.channels == 2 ? vaddq_u8(index, pixel)
                            : vmlaq_u8(index, pixel, vdupq_n_u8(3));
  }
  uint8x16_t upper, lower;
  look_up(window, s->stride, s->two_rows, index, &upper, &lower);
  return blend_down(blend_across(upper, at.weights),
                    blend_across(lower, at.weights), at.wy);
}

/* Rows of 16 bytes a window: 8 pixels of one channel, 4 of two, 2 of four. */
INLINE void blend_short(const rg_run* run, layout l) {
  const uint32_t table = l.channels == 4 ? 2 : l.channels - 1;
  const uint16x8_t lane = vld1q_u16(kLanePixels[table]);
  const uint32_t segment_bytes = l.pixels * l.channels;
  const uint32_t rest = run->num_pixels % l.pixels;
  const uint32_t whole_bytes = (run->num_pixels - rest) * l.channels;
  const size_t out_stride = run->out_stride;
  uint8_t* out_row = run->out + run->out_pixel * l.channels;
  row_steps rows = first_row(run);
  segment_constants s;
  s.data = run->data;
  s.stride = run->stride;
  s.two_rows = 2 * (size_t)run->stride;
  s.offsets = vld1q_u8(kLaneOffsets[table]);
  for (uint32_t r = run->num_rows; r != 0; --r, out_row += out_stride) {
    const int32x4_t row = next_row(&rows);
    const int64_t step_x = vgetq_lane_s32(row, 2);
    const int64_t step_y = vgetq_lane_s32(row, 3);
    /* The window starts at the first x + 16 and the least y. */
    const int64_t last_y = (int64_t)(l.pixels - 1) * step_y;
    const int64_t up = last_y < 0 ? last_y : 0;
    const uint16x8_t steps = vreinterpretq_u16_s32(row);
    s.lanes_x = vmulq_laneq_u16(lane, steps, 4);
    s.lanes_y = vmlaq_laneq_u16(vdupq_n_u16((uint16_t)(-up * 8)), lane,
                                vshlq_n_u16(steps, 3), 6);
    int64_t x = (uint32_t)vgetq_lane_s32(row, 0) + 16;
    int64_t y = (uint32_t)vgetq_lane_s32(row, 1) + up;
    uint8_t* out = out_row;
    uint8_t* const end = out_row + whole_bytes;
    do {
      vst1_u8(out, blend_segment(&s, (uint64_t)x, (uint64_t)y, l));
      x += l.pixels * step_x;
      y += l.pixels * step_y;
      out += segment_bytes;
    } while (out != end);
    if (rest != 0) { /* the last segment begins earlier */
      const uint32_t back = l.pixels - rest;
      vst1_u8(out - back * l.channels,
              blend_segment(&s, (uint64_t)(x - back * step_x),
                            (uint64_t)(y - back * step_y), l));
    }
  }
}

/* 8 pixels of three channels from 32 bytes a row. */
INLINE void blend_triples(const rg_run* run, layout l) {
  const uint16x8_t lane = vld1q_u16(kLanePixels[0]);
  const uint8x16_t right = vcombine_u8(vdup_n_u8(0), vdup_n_u8(3));
  row_steps rows = first_row(run);
  for (uint32_t r = 0; r < run->num_rows; ++r) {
    const int32x4_t row = next_row(&rows);
    const int32_t step_x = vgetq_lane_s32(row, 2);
    const int32_t step_y = vgetq_lane_s32(row, 3);
    const int32_t last_y = (int32_t)(l.pixels - 1) * step_y;
    const int32_t up = last_y < 0 ? last_y : 0;
    const uint16x8_t lanes_x = vmulq_n_u16(lane, (uint16_t)step_x);
    const uint16x8_t lanes_y =
        vsubq_u16(vmulq_n_u16(lane, (uint16_t)(step_y * 8)),
                  vdupq_n_u16((uint16_t)(up * 8)));
    uint8_t* const out =
        run->out + (size_t)r * run->out_stride + run->out_pixel * 3;
    for (uint32_t k = 0; k < run->num_pixels; k += 8) {
      if (k + 8 > run->num_pixels) k = run->num_pixels - 8u;
      const int32_t x = vgetq_lane_s32(row, 0) + 16 + (int32_t)k * step_x;
      const int32_t y = vgetq_lane_s32(row, 1) + up + (int32_t)k * step_y;
      const uint8_t* window = run->data + (size_t)(y >> 12) * run->stride +
                              (size_t)(x >> 12) * 3;
      uint8x16x2_t source[3];
      for (int i = 0; i < 3; ++i, window += run->stride) {
        source[i].val[0] = vld1q_u8(window);
        source[i].val[1] = vld1q_u8(window + 16);
      }
      const lanes at =
          cut(vaddq_u16(lanes_x, vdupq_n_u16((uint16_t)(x & 4095))),
              vaddq_u16(lanes_y, vdupq_n_u16((uint16_t)((y & 4095) << 3))));
      /* 3 pixel + 32 in the second row = 2 (pixel + 16) + pixel */
      uint8x16_t indices = vaddq_u8(vaddq_u8(at.pixel, at.pixel), right);
      indices = vaddq_u8(indices, vandq_u8(at.pixel, vdupq_n_u8(15)));
      const uint8x16x4_t upper = {{source[0].val[0], source[0].val[1],
                                   source[1].val[0], source[1].val[1]}};
      const uint8x16x4_t lower = {{source[1].val[0], source[1].val[1],
                                   source[2].val[0], source[2].val[1]}};
      uint8x8x3_t result;
      for (int c = 0; c < 3; ++c) {
        result.val[c] = blend_down(
            blend_across(vqtbl4q_u8(upper, indices), at.weights),
            blend_across(vqtbl4q_u8(lower, indices), at.weights), at.wy);
        indices = vaddq_u8(indices, vdupq_n_u8(1));
      }
      vst3_u8(out + 3 * k, result);
    }
  }
}

/* Whether a segment's pixels and their neighbours lie in its window, on two
 * rows. Steps of rows lie between those of the first and the last but for
 * rounding, which is less than 2. */
INLINE int fits(const rg_run* run, layout l) {
  const int32_t steps = (int32_t)l.pixels - 1;
  const int32_t room = (int32_t)(l.window / l.channels - 1) * 4096 - 4112;
  for (uint32_t k = 0; k < 2; ++k) {
    rg_block_row row;
    rg_find_block_row(&run->block,
                      run->first_row + (k == 0 ? 0 : run->num_rows - 1u), &row);
    const int32_t x = row.step.q12[0], y = row.step.q12[1];
    if (x < 2 || x > 16384 || (x + 2) * steps > room || y < -8192 || y > 8192 ||
        (y + 2) * steps > 4096 || (y - 2) * steps < -4096)
      return 0;
  }
  return run->num_pixels >= l.pixels;
}

void rg_blend_1_neon(const rg_run* run) {
  const layout l = {1, 8, 16};
  if (fits(run, l))
    blend_short(run, l);
  else
    rg_blend_1(run);
}

void rg_blend_2_neon(const rg_run* run) {
  const layout l = {2, 4, 16};
  if (fits(run, l))
    blend_short(run, l);
  else
    rg_blend_2(run);
}

void rg_blend_3_neon(const rg_run* run) {
  const layout l = {3, 8, 32};
  if (fits(run, l))
    blend_triples(run, l);
  else
    rg_blend_3(run);
}

void rg_blend_4_neon(const rg_run* run) {
  const layout l = {4, 2, 16};
  if (fits(run, l))
    blend_short(run, l);
  else
    rg_blend_4(run);
}

#endif
