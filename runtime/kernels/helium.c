/* Bilinear blending by gathers of 8 pixels, of any steps whose offsets fit into
 * 16 bits. Nothing is read but the pixels' own neighbours: lanes behind the
 * last pixel are predicated away. */
#if defined(__ARM_FEATURE_MVE)

#include <arm_mve.h>

#include "fixed_point.h"
#include "remap_kernels.h"

#define INLINE static inline __attribute__((always_inline))

#define LANES 8

#define ROWS 4

/* Some rows of a run at once: where the least x and y of a first segment lie,
 * and how far these are from its first lane. */
typedef struct row_group {
  int32_t x[ROWS], y[ROWS], step_x[ROWS], step_y[ROWS], back[ROWS], up[ROWS];
} row_group;

/* One coordinate of rows from row r of the block on. */
INLINE void find_rows(const rg_run* run, int c, uint32_t r, int32_t origin,
                      int32_t* start, int32_t* steps, int32_t* to_least) {
  const rg_position* const p = run->block.corners;
  const int32_t shift = -(int32_t)run->block.height_log2;
  const int32x4_t row = vreinterpretq_s32_u32(vidupq_n_u32(r, 1));
  int32x4_t down = vmulq_n_s32(row, p[2].q12[c] - p[0].q12[c]);
  const int32x4_t left =
      vaddq_n_s32(vrshlq_n_s32(down, shift), p[0].q12[c] - origin);
  down = vmulq_n_s32(row, p[3].q12[c] - p[1].q12[c]);
  const int32x4_t right =
      vaddq_n_s32(vrshlq_n_s32(down, shift), p[1].q12[c] - origin);
  const int32x4_t step =
      vrshlq_n_s32(vsubq_s32(right, left), -(int32_t)run->block.width_log2);
  const int32x4_t back =
      vminq_s32(vmulq_n_s32(step, LANES - 1), vdupq_n_s32(0));
  vstrwq_s32(start, vaddq_s32(vmlaq_n_s32(left, step, run->first_pixel), back));
  vstrwq_s32(steps, step);
  vstrwq_s32(to_least, back);
}

static RG_NOINLINE void find_row_group(const rg_run* run, uint32_t r,
                                       row_group* rows) {
  find_rows(run, 0, r, -16, rows->x, rows->step_x, rows->back);
  find_rows(run, 1, r, run->first_source_row << 12, rows->y, rows->step_y,
            rows->up);
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

/* Row k of a group. */
INLINE void blend_row(const rg_run* run, const row_group* rows, uint32_t k,
                      uint32_t channels, uint8_t* out) {
  const uint8_t* const data = run->data;
  const uint32_t stride = run->stride;
  const uint32_t num_pixels = run->num_pixels;
  const uint32_t step_x = (uint32_t)rows->step_x[k];
  const uint32_t step_y = (uint32_t)rows->step_y[k];
  uint32_t x = (uint32_t)rows->x[k], y = (uint32_t)rows->y[k];
  const uint16x8_t lane = vidupq_n_u16(0, 1);
  const uint16x8_t lanes_x =
      vsubq_n_u16(vmulq_n_u16(lane, (uint16_t)step_x), (uint16_t)rows->back[k]);
  const uint16x8_t lanes_y =
      vsubq_n_u16(vmulq_n_u16(lane, (uint16_t)step_y), (uint16_t)rows->up[k]);
  uint8_t* const last = out + (num_pixels - LANES) * channels;
  /* The second segment may begin within the first. */
  uint32_t pixels = (num_pixels - 1) % LANES + 1;
  for (;;) {
    const uint8_t* const base =
        data + (y >> 12) * stride + (x >> 12) * channels;
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

/* Functions of their own, so that their loops have all registers. */
typedef void blend_one_row(const rg_run* run, const row_group* rows, uint32_t k,
                           uint8_t* out);
#define ROW_OF(channels)                                                    \
  static RG_NOINLINE void blend_row_##channels##_helium(                    \
      const rg_run* run, const row_group* rows, uint32_t k, uint8_t* out) { \
    blend_row(run, rows, k, channels, out);                                 \
  }
ROW_OF(1)
ROW_OF(2)
ROW_OF(3)
ROW_OF(4)

INLINE void blend(const rg_run* run, uint32_t channels, blend_one_row* blend_k,
                  rg_blend* portable) {
  if (run->num_pixels < LANES || !rg_fits_offsets(run, LANES, channels)) {
    portable(run);
    return;
  }
  uint8_t* out = run->out + run->out_pixel * channels;
  uint32_t r = run->first_row, rest = run->num_rows;
  do {
    const uint32_t num_rows = rest < ROWS ? rest : ROWS;
    row_group rows;
    uint32_t k = 0;
    find_row_group(run, r, &rows);
    do {
      blend_k(run, &rows, k, out);
      out += run->out_stride;
    } while (++k != num_rows);
    r += num_rows;
    rest -= num_rows;
  } while (rest != 0);
}

void rg_blend_1_helium(const rg_run* run) {
  blend(run, 1, blend_row_1_helium, rg_blend_1);
}
void rg_blend_2_helium(const rg_run* run) {
  blend(run, 2, blend_row_2_helium, rg_blend_2);
}
void rg_blend_3_helium(const rg_run* run) {
  blend(run, 3, blend_row_3_helium, rg_blend_3);
}
void rg_blend_4_helium(const rg_run* run) {
  blend(run, 4, blend_row_4_helium, rg_blend_4);
}

#endif
