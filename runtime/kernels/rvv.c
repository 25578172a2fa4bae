/* Bilinear interpolation by indexed loads of 8 pixels, for any step whose
 * offsets fit into 16 bits. Uses version 1.0 of the vector extension by
 * assembler mnemonics, since compilers do not provide stable intrinsics yet.
 * Only the pixels' own neighbours are read. */
#include "kernels/kernel.h"
#include "kernels/segments.h"

#if RG_HAVE_RVV

#include <stddef.h>

#define INLINE static inline __attribute__((always_inline))

#define LANES 8

/* GCC before 13 does not accept vector registers as clobbers, and does not use
 * them. */
#if defined(__clang__) || __GNUC__ >= 13
#define VECTOR_REGISTERS \
  , "v0", "v1", "v2", "v3", "v4", "v5", "v6", "v7", "v8", "v9", "v10", "v11"
#else
#define VECTOR_REGISTERS
#endif

/* The steps of a row, and the distances from its first lane to the minimum x
 * and y of a segment. */
typedef struct lane_steps {
  int32_t x, y, back, up;
} lane_steps;

/* Processes up to 8 pixels; x and y in q12 relative to the base, the minimum of
 * the segment. v0: x; v1: y; v2: offsets; v3, v4: weights of right and left
 * samples; v5: wy in q15; v6, v7: h0 and h1; v8 to v11: samples. */
INLINE void blend_segment(const uint8_t* base, size_t stride, size_t channels,
                          uint32_t x, uint32_t y, const lane_steps* steps,
                          size_t num_pixels, uint8_t* out) {
  const uint8_t *right = base + channels, *below = base + stride;
  const uint8_t* diagonal = below + channels;
  size_t rest = channels;
  __asm__ volatile(
      "csrwi vxrm, 0\n\t" /* rounds half up */
      "vsetvli zero, %[n], e16, m1, ta, ma\n\t"
      "vid.v v8\n\t"
      "vmul.vx v0, v8, %[step_x]\n\t"
      "vmul.vx v1, v8, %[step_y]\n\t"
      "vadd.vx v0, v0, %[x]\n\t"
      "vadd.vx v1, v1, %[y]\n\t"
      "vsrl.vi v2, v0, 12\n\t"
      "vsrl.vi v3, v1, 12\n\t"
      "vmul.vx v2, v2, %[channels]\n\t"
      "vmacc.vx v2, %[stride], v3\n\t"
      "vsll.vi v5, v1, 4\n\t"
      "vsrl.vi v5, v5, 1\n\t"
      "vsetvli zero, zero, e8, mf2, ta, ma\n\t"
      "vnsrl.wi v3, v0, 5\n\t"
      "vand.vx v3, v3, %[mask]\n\t"
      "vrsub.vx v4, v3, %[one]\n\t"
      "0:\n\t"
      "vluxei16.v v8, (%[base]), v2\n\t"
      "vluxei16.v v9, (%[right]), v2\n\t"
      "vluxei16.v v10, (%[below]), v2\n\t"
      "vluxei16.v v11, (%[diagonal]), v2\n\t"
      "vwmulu.vv v6, v8, v4\n\t"
      "vwmulu.vv v7, v10, v4\n\t"
      "vwmaccu.vv v6, v9, v3\n\t"
      "vwmaccu.vv v7, v11, v3\n\t"
      /* v = h0 - ((h0 - h1) wy + 2^14) >> 15, then (v + 64) >> 7 */
      "vsetvli zero, zero, e16, m1, ta, ma\n\t"
      "vsub.vv v7, v6, v7\n\t"
      "vsmul.vv v7, v7, v5\n\t"
      "vsub.vv v6, v6, v7\n\t"
      "vsetvli zero, zero, e8, mf2, ta, ma\n\t"
      "vnclipu.wi v8, v6, 7\n\t"
      "vsse8.v v8, (%[out]), %[channels]\n\t"
      "addi %[base], %[base], 1\n\t"
      "addi %[right], %[right], 1\n\t"
      "addi %[below], %[below], 1\n\t"
      "addi %[diagonal], %[diagonal], 1\n\t"
      "addi %[out], %[out], 1\n\t"
      "addi %[rest], %[rest], -1\n\t"
      "bnez %[rest], 0b"
      : [base] "+&r"(base), [right] "+&r"(right), [below] "+&r"(below),
        [diagonal] "+&r"(diagonal), [out] "+&r"(out), [rest] "+&r"(rest)
      : [n] "r"(num_pixels), [step_x] "r"(steps->x), [step_y] "r"(steps->y),
        [x] "r"((x & 4095) - (uint32_t)steps->back),
        [y] "r"((y & 4095) - (uint32_t)steps->up), [channels] "r"(channels),
        [stride] "r"(stride), [mask] "r"(127), [one] "r"(128)
      : "memory" VECTOR_REGISTERS);
}

INLINE void blend_row(const rg_span* span, const rg_block_row* row,
                      size_t channels, uint8_t* out) {
  const int32_t step_x = row->step.q12[0], step_y = row->step.q12[1];
  const lane_steps steps = {step_x, step_y,
                            step_x < 0 ? (LANES - 1) * step_x : 0,
                            step_y < 0 ? (LANES - 1) * step_y : 0};
  int32_t x = row->start.q12[0] + 16 + steps.back;
  int32_t y = row->start.q12[1] + steps.up;
  for (size_t rest = span->num_pixels;;) {
    const size_t pixels = rest < LANES ? rest : LANES;
    /* The minimum over 8 pixels may be outside the source if fewer are left. */
    const uint8_t* const base = span->data +
                                (ptrdiff_t)(y >> 12) * (ptrdiff_t)span->stride +
                                (ptrdiff_t)(x >> 12) * (ptrdiff_t)channels;
    blend_segment(base, span->stride, channels, (uint32_t)x, (uint32_t)y,
                  &steps, pixels, out);
    rest -= pixels;
    if (rest == 0) return;
    x += LANES * step_x;
    y += LANES * step_y;
    out += LANES * channels;
  }
}

INLINE void blend(const rg_span* span, uint32_t channels, rg_blend* portable) {
  if (!rg_fits_offsets(span, LANES, channels)) {
    portable(span);
    return;
  }
  uint8_t* out = span->out + span->out_pixel * channels;
  for (uint32_t r = 0; r < span->num_rows; ++r, out += span->out_stride) {
    rg_block_row row;
    rg_compute_span_row(span, r, &row);
    blend_row(span, &row, channels, out);
  }
}

void rg_blend_1_rvv(const rg_span* span) { blend(span, 1, rg_blend_1); }
void rg_blend_2_rvv(const rg_span* span) { blend(span, 2, rg_blend_2); }
void rg_blend_3_rvv(const rg_span* span) { blend(span, 3, rg_blend_3); }
void rg_blend_4_rvv(const rg_span* span) { blend(span, 4, rg_blend_4); }

#endif
