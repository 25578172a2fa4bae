/* Bilinear interpolation by table lookup: 8 lanes read at most 16 contiguous
 * bytes of each of three rows (32 for two or three channels), so that table
 * lookups replace a gather. Spans with larger steps are processed by the
 * portable kernels. */
#include "kernels/kernel.h"
#include "kernels/segments.h"

#if defined(__aarch64__)

#include <arm_neon.h>
#include <stddef.h>

#define INLINE static inline __attribute__((always_inline))

/* The pixels of a segment, and the bytes of its window. */
typedef struct layout {
  uint32_t channels, pixels, window;
} layout;

static const uint16_t kLanePixels[2][8] = {{0, 1, 2, 3, 4, 5, 6, 7},
                                           {0, 0, 0, 0, 1, 1, 1, 1}};

/* The byte offsets in the window of the left samples of a segment's first
 * pixel, and of the right ones. */
static const uint8_t kLaneOffsets[2][16] = {
    {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1},
    {0, 1, 2, 3, 0, 1, 2, 3, 4, 5, 6, 7, 4, 5, 6, 7}};

/* Constants c such that |c - wx| is 128 - wx in the low half and wx in the high
 * half. */
static const uint8_t kWeights[16] = {128, 128, 128, 128, 128, 128, 128, 128};

/* Iterates over the rows of a span. */
typedef struct row_steps {
  int32x4_t top;  /* P00, P10 */
  int32x4_t down; /* (P01 - P00) r, (P11 - P10) r */
  int32x4_t height;
  int32x4_t minus_height_log2;
  int32x2_t minus_width_log2;
} row_steps;

INLINE row_steps first_row(const rg_span* span) {
  const rg_block* const block = &span->block;
  const int32_t first_y = span->first_source_row << 12;
  const int32_t origin[4] = {-16, first_y, -16, first_y};
  row_steps rows;
  rows.top = vld1q_s32(block->corners[0].q12);
  rows.height = vsubq_s32(vld1q_s32(block->corners[2].q12), rows.top);
  rows.top = vsubq_s32(rows.top, vld1q_s32(origin));
  rows.down = vmulq_n_s32(rows.height, span->first_row);
  rows.minus_height_log2 = vdupq_n_s32(-(int32_t)block->height_log2);
  rows.minus_width_log2 = vdup_n_s32(-(int32_t)block->width_log2);
  return rows;
}

/* A row: x + 16 and y at the block's left edge, and the steps. */
typedef struct row_line {
  int32x2_t start, step;
} row_line;

INLINE row_line next_row(row_steps* rows) {
  /* left, right = top + round((bottom - top) r, height_log2) */
  const int32x4_t edges =
      vaddq_s32(rows->top, vrshlq_s32(rows->down, rows->minus_height_log2));
  rows->down = vaddq_s32(rows->down, rows->height);
  row_line row;
  row.start = vget_low_s32(edges);
  row.step = vrshl_s32(vsub_s32(vget_high_s32(edges), row.start),
                       rows->minus_width_log2);
  return row;
}

#define MAX_PIXELS 32 /* per row */

/* The windows of a row's segments, which start at the first lane's x and the
 * minimum y of the lanes; and the first lane relative to these, x in q12 and y
 * in q15. */
typedef struct row_segments {
  uint32_t offsets[MAX_PIXELS / 2];
  uint16_t starts[MAX_PIXELS / 2][2];
} row_segments;

/* Computes segments k to k + 3, which begin and end at these pixels of the
 * block. */
INLINE void compute_segments(const row_line* row, int32x4_t pixels,
                             int32x4_t ends, uint32x4_t stride, layout l,
                             uint32_t k, row_segments* segments) {
  const int32x4_t start_y = vdupq_lane_s32(row->start, 1);
  const int32x4_t x =
      vmlaq_lane_s32(vdupq_lane_s32(row->start, 0), pixels, row->step, 0);
  const int32x4_t y = vmlaq_lane_s32(start_y, pixels, row->step, 1);
  const int32x4_t end_y = vmlaq_lane_s32(start_y, ends, row->step, 1);
  const uint32x4_t least = vreinterpretq_u32_s32(vminq_s32(y, end_y));
  const uint32x4_t fraction = vdupq_n_u32(4095);
  const uint32x4_t left = vreinterpretq_u32_s32(x);
  const uint32x4_t above =
      vsubq_u32(vreinterpretq_u32_s32(y), vbicq_u32(least, fraction));
  const uint32x4_t rows = vmulq_u32(vshrq_n_u32(least, 12), stride);
  vst1q_u32(segments->offsets + k,
            l.channels == 1
                ? vsraq_n_u32(rows, left, 12)
                : vmlaq_n_u32(rows, vshrq_n_u32(left, 12), l.channels));
  vst1q_u32((uint32_t*)segments->starts[k],
            vsliq_n_u32(vandq_u32(left, fraction), above, 16 + 3));
}

/* Loads the next segment, broadcast to lanes; in C, the compiler would not use
 * post-increment. */
INLINE size_t next_segment(const uint32_t** offset, const uint16_t** start,
                           uint16x8_t* x_q12, uint16x8_t* y_q15) {
  uint64_t found;
  __asm__(
      "ldr %w0, [%3], #4\n\t"
      "ld1r {%1.8h}, [%4], #2\n\t"
      "ld1r {%2.8h}, [%4], #2"
      : "=&r"(found), "=&w"(*x_q12), "=w"(*y_q15), "+r"(*offset), "+r"(*start)
      :
      : "memory");
  return found;
}

/* (v + 64) >> 7, v = h0 - ((h0 - h1) wy + 2^14) >> 15 */
INLINE uint8x8_t blend_down(uint16x8_t h0, uint16x8_t h1, int16x8_t wy) {
  const int16x8_t difference = vreinterpretq_s16_u16(vsubq_u16(h0, h1));
  const int16x8_t v =
      vsubq_s16(vreinterpretq_s16_u16(h0), vqrdmulhq_s16(difference, wy));
  return vqrshrun_n_s16(v, 7);
}

/* samples, weights: left ones in the low halves, right ones in the high halves.
 */
INLINE uint16x8_t blend_across(uint8x16_t samples, uint8x16_t weights) {
  return vmlal_high_u8(vmull_u8(vget_low_u8(samples), vget_low_u8(weights)),
                       samples, weights);
}

/* 8 lanes; their x in q12 and y in q15 are relative to the window's start. */
typedef struct lanes {
  uint8x16_t pixel; /* in the window, + 16 in the second row; twice */
  uint8x16_t weights;
  int16x8_t wy;
} lanes;

INLINE lanes cut(uint16x8_t x_q12, uint16x8_t y_q15) {
  lanes cut;
  uint16x8_t low_bits = vdupq_n_u16(0x7fff);
  /* Prevents GCC from replacing the AND by BIC with an immediate, which needs a
   * copy. */
  __asm__("" : "+w"(low_bits));
  uint16x8_t wy = vandq_u16(y_q15, low_bits);
  __asm__("" : "+w"(wy));
  cut.wy = vreinterpretq_s16_u16(wy);
  const uint8x16_t high = vreinterpretq_u8_u16(vsriq_n_u16(y_q15, x_q12, 1));
  cut.pixel = vshrq_n_u8(vuzp2q_u8(high, high), 3);
  const uint8x8_t wx = vand_u8(vshrn_n_u16(x_q12, 5), vdup_n_u8(127));
  cut.weights = vabdq_u8(vcombine_u8(wx, wx), vld1q_u8(kWeights));
  return cut;
}

/* The constants of a span's segments, and of a row's. */
typedef struct segment_constants {
  const uint8_t *row0, *row1, *row2; /* rows of the first window */
  uint8x16_t offsets;
  uint16x8_t lanes_x, lanes_y; /* of the row, relative to the first lane */
} segment_constants;

/* Looks up samples of rows 0 and 1, 16 bytes each, and of rows 1 and 2. The
 * tables must be in consecutive registers, for which the compiler would insert
 * copies. */
INLINE void look_up(const segment_constants* s, size_t offset, uint8x16_t index,
                    uint8x16_t* upper, uint8x16_t* lower) {
  register uint8x16_t row0 __asm__("v16") = vld1q_u8(s->row0 + offset);
  register uint8x16_t row1 __asm__("v17") = vld1q_u8(s->row1 + offset);
  register uint8x16_t row2 __asm__("v18") = vld1q_u8(s->row2 + offset);
  __asm__("tbl %0.16b, {v16.16b, v17.16b}, %1.16b"
          : "=w"(*upper)
          : "w"(index), "w"(row0), "w"(row1));
  __asm__("tbl %0.16b, {v17.16b, v18.16b}, %1.16b"
          : "=w"(*lower)
          : "w"(index), "w"(row1), "w"(row2));
}

INLINE lanes cut_segment(const segment_constants* s, uint16x8_t x_q12,
                         uint16x8_t y_q15) {
  return cut(vaddq_u16(s->lanes_x, x_q12), vaddq_u16(s->lanes_y, y_q15));
}

INLINE uint8x8_t blend_segment(const segment_constants* s, size_t offset,
                               lanes cut, layout l) {
  uint8x16_t index = vaddq_u8(cut.pixel, s->offsets);
  if (l.channels != 1) { /* multiplies the pixel by channels, not the 16 */
    const uint8x16_t pixel = vandq_u8(cut.pixel, vdupq_n_u8(15));
    index = vmlaq_u8(index, pixel, vdupq_n_u8((uint8_t)(l.channels - 1)));
  }
  uint8x16_t upper, lower;
  look_up(s, offset, index, &upper, &lower);
  return blend_down(blend_across(upper, cut.weights),
                    blend_across(lower, cut.weights), cut.wy);
}

/* Windows with rows of 32 bytes: rows 0 and 1, and rows 1 and 2. */
typedef struct long_window {
  uint8x16_t row0[2], row1[2], row2[2];
} long_window;

/* A single instruction; the compiler would use two. */
INLINE void load_32(const uint8_t* p, uint8x16_t loaded[2]) {
  __asm__("ldp %q0, %q1, [%2]"
          : "=w"(loaded[0]), "=w"(loaded[1])
          : "r"(p), "m"(*(const uint8_t(*)[32])p));
}

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

/* Processes 8 pixels of two or three channels. */
INLINE void blend_long_segment(const segment_constants* s, size_t offset,
                               lanes cut, layout l, uint8_t* out) {
  long_window w;
  load_32(s->row0 + offset, w.row0);
  load_32(s->row1 + offset, w.row1);
  load_32(s->row2 + offset, w.row2);
  /* channels * pixel + 32 in the second row */
  uint8x16_t index = vaddq_u8(vaddq_u8(cut.pixel, cut.pixel), s->offsets);
  if (l.channels == 3)
    index = vaddq_u8(index, vandq_u8(cut.pixel, vdupq_n_u8(15)));
  uint8x8x3_t result;
  _Pragma("GCC unroll 3") for (uint32_t c = 0; c < l.channels; ++c) {
    uint8x16_t upper, lower;
    look_up_long(&w, index, &upper, &lower);
    result.val[c] = blend_down(blend_across(upper, cut.weights),
                               blend_across(lower, cut.weights), cut.wy);
    index = vaddq_u8(index, vdupq_n_u8(1));
  }
  if (l.channels == 3) {
    vst3_u8(out, result);
  } else {
    const uint8x8x2_t pair = {{result.val[0], result.val[1]}};
    vst2_u8(out, pair);
  }
}

/* Processes the segments from out to end. */
INLINE void blend_segments(const segment_constants* s, layout l,
                           const uint32_t** offset, const uint16_t** start,
                           uint8_t* out, const uint8_t* end) {
  do {
    uint16x8_t x_q12, y_q15;
    const size_t at = next_segment(offset, start, &x_q12, &y_q15);
    const lanes cut = cut_segment(s, x_q12, y_q15);
    if (l.window == 32)
      blend_long_segment(s, at, cut, l, out);
    else
      vst1_u8(out, blend_segment(s, at, cut, l));
    out += l.pixels * l.channels;
  } while (out != end);
}

/* Processes all rows of a span. */
INLINE void blend_span(const rg_span* span, layout l) {
  static const int32_t kSegments[4] = {0, 1, 2, 3};
  const int is_long = l.window == 32;
  const uint32_t table = is_long || l.channels == 1 ? 0 : 1;
  const uint16x8_t lane = vld1q_u16(kLanePixels[table]);
  const size_t out_stride = span->out_stride;
  const size_t bytes = span->num_pixels * l.channels;
  const size_t rest = bytes % (l.pixels * l.channels);
  const int32x4_t last_pixels =
      vdupq_n_s32(span->first_pixel + span->num_pixels - (int32_t)l.pixels);
  const int32x4_t first_pixels = vmlaq_n_s32(
      vdupq_n_s32(span->first_pixel), vld1q_s32(kSegments), (int32_t)l.pixels);
  const uint32x4_t stride = vdupq_n_u32(span->stride);
  uint8_t* out = span->out + span->out_pixel * l.channels;
  row_steps rows = first_row(span);
  segment_constants s;
  s.row0 = span->data;
  s.row1 = s.row0 + span->stride;
  s.row2 = s.row1 + span->stride;
  s.offsets = is_long
                  ? vcombine_u8(vdup_n_u8(0), vdup_n_u8((uint8_t)l.channels))
                  : vld1q_u8(kLaneOffsets[table]);
  for (uint32_t r = span->num_rows; r != 0; --r, out += out_stride) {
    row_segments segments;
    const row_line row = next_row(&rows);
    int32x4_t pixels = first_pixels;
    for (uint32_t k = 0; k < MAX_PIXELS / l.pixels; k += 4) {
      const int32x4_t begins = vminq_s32(pixels, last_pixels);
      const int32x4_t ends =
          vaddq_s32(begins, vdupq_n_s32((int32_t)l.pixels - 1));
      compute_segments(&row, begins, ends, stride, l, k, &segments);
      pixels = vaddq_s32(pixels, vdupq_n_s32(4 * (int32_t)l.pixels));
    }
    const uint16x4_t steps = vreinterpret_u16_s32(row.step);
    s.lanes_x = vmulq_lane_u16(lane, steps, 0);
    s.lanes_y = vmulq_lane_u16(lane, vshl_n_u16(steps, 3), 2);
    const uint32_t* offset = segments.offsets;
    const uint16_t* start = segments.starts[0];
    uint8_t* const end = out + bytes;
    blend_segments(&s, l, &offset, &start, out, end - rest);
    if (rest != 0) /* the last segment overlaps the previous one */
      blend_segments(&s, l, &offset, &start, end - l.pixels * l.channels, end);
  }
}

/* Whether windows are large enough, and the segments' offsets fit into 32 bits.
 */
INLINE int fits(const rg_span* span, layout l) {
  return span->stride <= 1 << 18 &&
         rg_fits_windows(span, l.pixels, l.window / l.channels);
}

#define BLEND(channels, pixels, window)                  \
  void rg_blend_##channels##_neon(const rg_span* span) { \
    const layout l = {channels, pixels, window};         \
    if (fits(span, l))                                   \
      blend_span(span, l);                               \
    else                                                 \
      rg_blend_##channels(span);                         \
  }
BLEND(1, 8, 16)
BLEND(2, 8, 32)
BLEND(3, 8, 32)
BLEND(4, 2, 16)

#endif
