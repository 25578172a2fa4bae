/* The inner loops of remapping: blocks of pixels that need no care. Faster
 * versions for a core give the same bits: formats/SPEC.md, "Remap arithmetic".
 */
#ifndef RAYGRID_REMAP_KERNELS_H
#define RAYGRID_REMAP_KERNELS_H

#include <stdint.h>

#include "config.h"
#if RG_HAVE_SIMD32
#include <arm_acle.h>
#endif

#include "fixed_point.h"
#include "frames/pixel_formats.h"
#include "frames/remap_table.h"
#include "raygrid.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Pixels of a block. The source pixel of each, and its right, lower and
 * diagonal neighbours, lie in the image. */
typedef struct rg_run {
  uint16_t out_pixel; /* first_pixel of the block, in the output's row */
  uint16_t first_source_row;
  uint16_t first_row, num_rows;     /* of the block */
  uint16_t first_pixel, num_pixels; /* of the block's rows; neither num is 0 */
  const uint8_t* data; /* row 0 of the source is first_source_row */
  uint32_t stride;
  uint8_t* out; /* row first_row of the output, from its left end */
  uint32_t out_stride;
  rg_block block;
} rg_run;

/* From a row of the run's block: position (0, 0) becomes data. */
static RG_INLINE void rg_move_to_run(const rg_run* run, rg_block_row* row) {
  row->start = rg_row_position(row, run->first_pixel);
  row->start.q12[1] -= (int32_t)run->first_source_row << 12;
}

/* Row r of a run. */
static RG_INLINE void rg_find_run_row(const rg_run* run, uint32_t r,
                                      rg_block_row* row) {
  rg_find_row(&run->block, run->first_row + r, row);
  rg_move_to_run(run, row);
}

/* Kernels may read beyond what they need: the row below a pixel's lower
 * neighbours, and bytes of the row below that. */
#define RG_SPARE_Q12 (2 * 4096)
#define RG_MIN_STRIDE 32u

/* The step between neighbouring pixels of the block's upper (0) or lower (1)
 * edge. Steps of rows lie between these but for rounding, which is less than 2.
 */
static inline int32_t rg_edge_step(const rg_run* run, uint32_t k, int c) {
  const rg_position* const edge = run->block.corners + 2 * k;
  return (edge[1].q12[c] - edge[0].q12[c]) >> run->block.width_log2;
}

/* Whether any so many neighbouring pixels of a run, and their own neighbours,
 * lie in windows of a number of pixels that start at the first one, on two
 * rows. */
static inline int rg_fits_windows(const rg_run* run, uint32_t num_pixels,
                                  uint32_t window_pixels) {
  const int32_t steps = (int32_t)num_pixels - 1;
  const int32_t room = (int32_t)(window_pixels - 1) * 4096 - 4112;
  for (uint32_t k = 0; k < 2; ++k) {
    const int32_t x = rg_edge_step(run, k, 0), y = rg_edge_step(run, k, 1);
    if (x < 2 || x > 16384 || (x + 2) * steps > room || y < -8192 || y > 8192 ||
        (y + 2) * steps > 4096 || (y - 2) * steps < -4096)
      return 0;
  }
  return run->num_pixels >= num_pixels;
}

/* Whether positions of so many neighbouring pixels, in q12, and the offsets of
 * their samples, in bytes, fit into 16 bits when counted from the least. */
static inline int rg_fits_offsets(const rg_run* run, uint32_t num_pixels,
                                  uint32_t channels) {
  for (uint32_t k = 0; k < 2; ++k) {
    uint32_t beyond[2]; /* pixels that the last one is away at most */
    for (int c = 0; c < 2; ++c) {
      const int32_t step = rg_edge_step(run, k, c);
      const uint32_t size = (uint32_t)(step < 0 ? -step : step) + 2;
      if (size > (65535 - 4111) / (num_pixels - 1)) return 0;
      beyond[c] = ((num_pixels - 1) * size + 4111) >> 12;
    }
    if (run->stride > 65535 ||
        beyond[1] * run->stride + beyond[0] * channels > 65535)
      return 0;
  }
  return 1;
}

/* A function that does a pixel of the output, which comes from a position. */
struct rg_remap_job;
typedef void rg_do_pixel(struct rg_remap_job* job, const rg_position* position,
                         uint32_t out_pixel);

/* Bilinear, 8 bits: pixels of 1, 2, 3 and 4 interleaved channels. */
typedef void rg_blend(const rg_run* run);
/* The parts of a row to the right of the one at hand, which was done in one
 * run, as far as they are whole and safe; parts have 8 x 8 pixels. Returns
 * whether the one then at hand is to be done, with care. */
typedef int rg_blend_parts(struct rg_remap_job* job);
struct rg_kernels {
  const char* name;
  rg_blend* blend[4];
  rg_blend_parts* blend_parts[4]; /* NULL: none */
};

rg_blend rg_blend_1, rg_blend_2, rg_blend_3, rg_blend_4;

rg_blend rg_blend_1_sse4, rg_blend_2_sse4, rg_blend_3_sse4, rg_blend_4_sse4;
rg_blend rg_blend_1_avx2, rg_blend_2_avx2, rg_blend_3_avx2, rg_blend_4_avx2;
rg_blend rg_blend_1_avx512, rg_blend_2_avx512, rg_blend_3_avx512,
    rg_blend_4_avx512;
rg_blend_parts rg_blend_parts_1_avx512, rg_blend_parts_2_avx512,
    rg_blend_parts_3_avx512, rg_blend_parts_4_avx512;
rg_blend rg_blend_1_neon, rg_blend_2_neon, rg_blend_3_neon, rg_blend_4_neon;
rg_blend rg_blend_1_helium, rg_blend_2_helium, rg_blend_3_helium,
    rg_blend_4_helium;
rg_blend rg_blend_1_rvv, rg_blend_2_rvv, rg_blend_3_rvv, rg_blend_4_rvv;

/* The portable ones where compilers make vectors of loops: 1 to 4 interleaved
 * channels of 8 bits, bilinear, or one, nearest. Return whether the run was
 * done, which is made of tiles of 8 x 8 pixels then. */
#if RG_HAS_TILES
int rg_blend_tiles(const rg_run* run, uint32_t channels);
int rg_copy_tiles(const rg_run* run);
#else
static inline int rg_blend_tiles(const rg_run* run, uint32_t channels) {
  (void)run, (void)channels;
  return 0;
}
static inline int rg_copy_tiles(const rg_run* run) {
  (void)run;
  return 0;
}
#endif

/* Any lattice, bilinear; nearest. */
void rg_blend_lattice(const rg_run* run, const rg_lattice* lattice);
void rg_copy_lattice(const rg_run* run, const rg_lattice* lattice);

/* Two neighbours, the left one in the low byte. */
static inline uint32_t rg_load_pair(const uint8_t* p) {
  return p[0] | (uint32_t)p[1] << 8;
}

/* Bytes 0 and 2 to halves, and bytes 1 and 3. */
static inline uint32_t rg_even_bytes(uint32_t bytes) {
#if RG_HAVE_SIMD32
  return (uint32_t)__uxtb16(bytes);
#else
  return bytes & 0x00ff00ff;
#endif
}

static inline uint32_t rg_odd_bytes(uint32_t bytes) {
#if RG_HAVE_SIMD32
  uint32_t odd = bytes; /* the compiler would rotate first */
  __asm__("uxtb16 %0, %1, ror #8" : "=r"(odd) : "r"(odd));
  return odd;
#else
  return (bytes >> 8) & 0x00ff00ff;
#endif
}

/* The sum of both roundings of a blended pixel of 8 bits. */
#define RG_ROUNDING_8 UINT32_C(0x407ff)

/* With weights across, up to 128, and down, up to 4096; both roundings in one.
 * Samples are the upper row's in the low half, the lower row's in the high.
 * Bits above the lowest 8 are those above 27 of the rounding. */
static RG_INLINE uint32_t rg_blend_8(uint32_t left, uint32_t right,
                                     uint32_t wx_q7, uint32_t wy_q12,
                                     uint32_t rounding) {
  /* h0 below and h1 above 16 bits */
  const uint32_t h_q7 = (right - left) * wx_q7 + (left << 7);
#if RG_HAVE_SIMD32
  /* h0 (4096 - wy) + h1 wy: one instruction */
  const uint32_t weights = (wy_q12 << 16) - wy_q12 + 4096;
  return (uint32_t)__smlad((int16x2_t)h_q7, (int16x2_t)weights,
                           (int32_t)rounding) >>
         19;
#else
  const uint32_t upper_q7 = h_q7 & 0xffff;
  const uint32_t down_q7 = (h_q7 >> 16) - upper_q7;
  return (down_q7 * wy_q12 + ((upper_q7 << 12) + rounding)) >> 19;
#endif
}

/* Half the last bit that a position keeps across, and down: added before the
 * position is cut into pixel and weight. */
static inline uint32_t rg_rounding(uint32_t kind, int c) {
  return kind != RG_SAMPLE_8 ? 8 : c == 0 ? 16 : 0;
}

/* The blend of the bytes around a position to which the rounding was added. The
 * right samples lie right bytes on. */
static RG_INLINE uint32_t rg_blend_bytes(const uint8_t* upper,
                                         const uint8_t* lower, uint32_t right,
                                         uint32_t x_q12, uint32_t y_q12) {
  return rg_blend_8(upper[0] | (uint32_t)lower[0] << 16,
                    upper[right] | (uint32_t)lower[right] << 16,
                    (x_q12 >> 5) & 127, y_q12 & 4095, RG_ROUNDING_8);
}

/* The neighbours around a position to which the rounding was added. */
typedef struct rg_neighbors {
  uint32_t x_q12, y_q12;
  const uint8_t *upper, *lower; /* rows */
  uint32_t right;               /* samples to the right ones */
} rg_neighbors;

/* Two samples of a row, of up to 16 bits, with 8-bit weights. */
static inline uint32_t rg_blend_pair(const rg_neighbors* at, uint32_t left,
                                     uint32_t right) {
  const uint32_t wx_q8 = (at->x_q12 >> 4) & 255;
  return left * (256 - wx_q8) + right * wx_q8;
}

/* Each field is read when it is needed: that takes less stack. */
#if RG_IS_FAST
#define RG_READ_LATE(at) ((void)(at))
#else
#define RG_READ_LATE(at) RG_IN_REGISTER(at)
#endif

/* The blend of samples of more than 8 bits: sample number index of the upper
 * row, and its neighbours. Sums of samples of 16 bits are below 2^32 - 2^15. */
static RG_INLINE uint32_t rg_blend_wide(uint32_t kind, const rg_neighbors* at,
                                        uint32_t index) {
  uint32_t left = rg_load_sample(kind, at->upper, index);
  RG_READ_LATE(at);
  uint32_t right = rg_load_sample(kind, at->upper, index + at->right);
  RG_READ_LATE(at);
  const uint32_t upper_q8 = rg_blend_pair(at, left, right);
  left = rg_load_sample(kind, at->lower, index);
  RG_READ_LATE(at);
  right = rg_load_sample(kind, at->lower, index + at->right);
  RG_READ_LATE(at);
  const uint32_t lower_q8 = rg_blend_pair(at, left, right);
  const uint32_t wy_q8 = (at->y_q12 >> 4) & 255;
  return (upper_q8 * (256 - wy_q8) + lower_q8 * wy_q8 + 0x8000) >> 16;
}

/* The blend of samples of any kind. */
static RG_INLINE uint32_t rg_blend_samples(uint32_t kind,
                                           const rg_neighbors* at,
                                           uint32_t index) {
  return kind == RG_SAMPLE_8
             ? rg_blend_bytes(at->upper + index, at->lower + index, at->right,
                              at->x_q12, at->y_q12)
             : rg_blend_wide(kind, at, index);
}

/* rg_mix_samples() blends one sample of more than 8 bits, rg_mix_bytes() so
 * many of 8 bits that follow each other. */
uint32_t rg_mix_samples(uint32_t kind, const rg_neighbors* at, uint32_t index);
void rg_mix_bytes(const rg_neighbors* at, uint32_t index, uint8_t* out,
                  uint32_t num_channels);

static RG_INLINE uint32_t rg_first_sample(const rg_lattice* lattice,
                                          uint32_t pixel) {
  return lattice->first_sample + pixel * lattice->sample_step;
}

/* A pixel of any lattice, to the output's row. */
static RG_INLINE void rg_blend_pixel(const rg_lattice* lattice,
                                     const rg_neighbors* at, uint8_t* row,
                                     uint32_t out_pixel) {
  const uint32_t index = rg_first_sample(lattice, at->x_q12 >> 12);
  const uint32_t target = rg_first_sample(lattice, out_pixel);
  if (lattice->kind == RG_SAMPLE_8)
    rg_mix_bytes(at, index, row + target, lattice->num_channels);
  else
    rg_put_sample(lattice->kind, row, target,
                  rg_mix_samples(lattice->kind, at, index));
}

#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_REMAP_KERNELS_H */
