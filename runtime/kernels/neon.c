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

static const uint16_t kLanePixels[2][8] = {{0, 1, 2, 3, 4, 5, 6, 7},
                                           {0, 0, 0, 0, 1, 1, 1, 1}};

/* Where the window has the left samples of a segment's first pixel, and the
 * right ones. */
static const uint8_t kLaneOffsets[2][16] = {
    {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1},
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
  const int32x2_t step =
      vrshl_s32(vsub_s32(vget_high_s32(edges), left), rows->minus_width_log2);
  return vcombine_s32(vmla_s32(left, step, rows->first_pixel), step);
}

/* (v + 64) >> 7, v = h0 - ((h0 - h1) wy + 2^14) >> 15 */
INLINE uint8x8_t blend_down(uint16x8_t h0, uint16x8_t h1, int16x8_t wy) {
  const int16x8_t difference = vreinterpretq_s16_u16(vsubq_u16(h0, h1));
  const int16x8_t v =
      vsubq_s16(vreinterpretq_s16_u16(h0), vqrdmulhq_s16(difference, wy));
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
  uint16x8_t wy = vandq_u16(y_q15, low_bits);
  __asm__("" : "+w"(wy));
  cut.wy = vreinterpretq_s16_u16(wy);
  const uint8x16_t high = vreinterpretq_u8_u16(vsriq_n_u16(y_q15, x_q12, 1));
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

/* Three instructions; the compiler's own choice of sums takes more. */
INLINE const uint8_t* find_window(const segment_constants* s, uint64_t x_q12,
                                  uint64_t y_q12, layout l) {
  const uint8_t* window = s->data + (size_t)(y_q12 >> 12) * s->stride;
  __asm__("" : "+r"(window));
  window += (size_t)(x_q12 >> 12) * l.channels;
  __asm__("" : "+r"(window));
  return window;
}

INLINE uint8x8_t blend_segment(const segment_constants* s, uint64_t x_q12,
                               uint64_t y_q12, layout l) {
  const uint8_t* const window = find_window(s, x_q12, y_q12, l);
  const lanes at =
      cut(vaddq_u16(s->lanes_x, vdupq_n_u16((uint16_t)(x_q12 & 4095))),
          vaddq_u16(s->lanes_y, vdupq_n_u16((uint16_t)((y_q12 & 4095) << 3))));
  uint8x16_t index = vaddq_u8(at.pixel, s->offsets);
  if (l.channels != 1) { /* channels times the pixel; the 16 stay */
    const uint8x16_t pixel = vandq_u8(at.pixel, vdupq_n_u8(15));
    index = vmlaq_u8(index, pixel, vdupq_n_u8((uint8_t)(l.channels - 1)));
  }
  uint8x16_t upper, lower;
  look_up(window, s->stride, s->two_rows, index, &upper, &lower);
  return blend_down(blend_across(upper, at.weights),
                    blend_across(lower, at.weights), at.wy);
}

/* Rows of 32 bytes a window: rows 0 and 1, and rows 1 and 2. */
typedef struct long_window {
  uint8x16_t row0[2], row1[2], row2[2];
} long_window;

INLINE void look_up_long(const long_window* w, uint8x16_t index,
                         uint8x16_t* upper, uint8x16_t* lower) {
  register uint8x16_t row00 __asm__("v16") = w->row0[0];
  register uint8x16_t row01 __asm__("v17") = w->row0[1];
  register uint8x16_t row10 __asm__("v18") = w->row1[0];
  register uint8x16_t row11 __asm__("v19") = w->row1[1];
  register uint8x16_t row20 __asm__("v20") = w->row2[0];
  register uint8x16_t row21 __asm__("v21") = w->row2[1];
  __asm__("tbl %0.16b, {v16.16b, v17.16b, v18.16b, v19.16b}, %1.16b"
          : "=w"(*upper)
          : "w"(index), "w"(row00), "w"(row01), "w"(row10), "w"(row11));
  __asm__("tbl %0.16b, {v18.16b, v19.16b, v20.16b, v21.16b}, %1.16b"
          : "=w"(*lower)
          : "w"(index), "w"(row10), "w"(row11), "w"(row20), "w"(row21));
}

/* 8 pixels of two or three channels. */
INLINE void blend_long_segment(const segment_constants* s, uint64_t x_q12,
                               uint64_t y_q12, layout l, uint8_t* out) {
  const uint8_t* const window = find_window(s, x_q12, y_q12, l);
  const long_window w = {
      {vld1q_u8(window), vld1q_u8(window + 16)},
      {vld1q_u8(window + s->stride), vld1q_u8(window + s->stride + 16)},
      {vld1q_u8(window + s->two_rows), vld1q_u8(window + s->two_rows + 16)}};
  const lanes at =
      cut(vaddq_u16(s->lanes_x, vdupq_n_u16((uint16_t)(x_q12 & 4095))),
          vaddq_u16(s->lanes_y, vdupq_n_u16((uint16_t)((y_q12 & 4095) << 3))));
  /* channels * pixel + 32 in the second row */
  uint8x16_t index = vaddq_u8(vaddq_u8(at.pixel, at.pixel), s->offsets);
  if (l.channels == 3)
    index = vaddq_u8(index, vandq_u8(at.pixel, vdupq_n_u8(15)));
  uint8x8x3_t result;
  for (uint32_t c = 0; c < l.channels; ++c) {
    uint8x16_t upper, lower;
    look_up_long(&w, index, &upper, &lower);
    result.val[c] = blend_down(blend_across(upper, at.weights),
                               blend_across(lower, at.weights), at.wy);
    index = vaddq_u8(index, vdupq_n_u8(1));
  }
  if (l.channels == 3) {
    vst3_u8(out, result);
  } else {
    const uint8x8x2_t pair = {{result.val[0], result.val[1]}};
    vst2_u8(out, pair);
  }
}

INLINE void blend(const segment_constants* s, uint64_t x_q12, uint64_t y_q12,
                  layout l, uint8_t* out) {
  if (l.window == 32)
    blend_long_segment(s, x_q12, y_q12, l, out);
  else
    vst1_u8(out, blend_segment(s, x_q12, y_q12, l));
}

/* All segments of a run. */
INLINE void blend_run(const rg_run* run, layout l) {
  const int is_long = l.window == 32;
  const uint32_t table = is_long || l.channels == 1 ? 0 : 1;
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
  __asm__("" : "+r"(s.two_rows)); /* an offset of its own */
  s.offsets = is_long
                  ? vcombine_u8(vdup_n_u8(0), vdup_n_u8((uint8_t)l.channels))
                  : vld1q_u8(kLaneOffsets[table]);
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
      blend(&s, (uint64_t)x, (uint64_t)y, l, out);
      x += l.pixels * step_x;
      y += l.pixels * step_y;
      out += segment_bytes;
    } while (out != end);
    if (rest != 0) { /* the last segment begins earlier */
      const uint32_t back = l.pixels - rest;
      blend(&s, (uint64_t)(x - back * step_x), (uint64_t)(y - back * step_y), l,
            out - back * l.channels);
    }
  }
}

void rg_blend_1_neon(const rg_run* run) {
  const layout l = {1, 8, 16};
  if (rg_fits_windows(run, l.pixels, l.window / l.channels))
    blend_run(run, l);
  else
    rg_blend_1(run);
}

void rg_blend_2_neon(const rg_run* run) {
  const layout l = {2, 8, 32};
  if (rg_fits_windows(run, l.pixels, l.window / l.channels))
    blend_run(run, l);
  else
    rg_blend_2(run);
}

void rg_blend_3_neon(const rg_run* run) {
  const layout l = {3, 8, 32};
  if (rg_fits_windows(run, l.pixels, l.window / l.channels))
    blend_run(run, l);
  else
    rg_blend_3(run);
}

void rg_blend_4_neon(const rg_run* run) {
  const layout l = {4, 2, 16};
  if (rg_fits_windows(run, l.pixels, l.window / l.channels))
    blend_run(run, l);
  else
    rg_blend_4(run);
}

#endif
