/* A kernel is an inner loop that blends the pixels of a run. This header says
 * what a run is, declares the kernels of kernel_list.h, and chooses which of
 * them runs. All give the same bits: formats/SPEC.md, "Remap arithmetic". */
#ifndef RAYGRID_KERNEL_H
#define RAYGRID_KERNEL_H

#include <stdint.h>

#include "config.h"
#include "kernels/block.h"
#include "kernels/kernel_list.h"
#include "kernels/samples.h"
#include "raygrid.h"

/* A run: pixels of a block. The source pixel of each, and its right, lower and
 * diagonal neighbours, lie in the image. */
typedef struct rg_run {
  uint16_t first_pixel; /* of the block's rows */
  uint16_t first_source_row;
  uint16_t out_pixel;            /* first_pixel, in the output's row */
  uint16_t num_rows, num_pixels; /* neither is 0 */
  uint16_t first_row;            /* of the block */
  const uint8_t* data;           /* row 0 of the source is first_source_row */
  uint32_t stride;
  uint8_t* out; /* row first_row of the output, from its left end */
  uint32_t out_stride;
  rg_block block;
} rg_run;

/* The spare rows, in q12. Kernels may read more than they need: the row below a
 * pixel's lower neighbours, and bytes of the row below that. */
#define RG_SPARE_Q12 (2 * 4096)
#define RG_MIN_STRIDE 32u

/* ---- Kernels ------------------------------------------------------------- */

/* Blends the pixels of a run, bilinear, of 8 bits. */
typedef void rg_blend(const rg_run* run);

/* Blends parts of 8 x 8 pixels that lie beside each other. The run is the first
 * of them. The others differ from it only in the corners of their blocks, which
 * are four a part. */
typedef void rg_blend_parts(const rg_run* run, const rg_position* corners,
                            uint32_t num_parts);

/* The kernels of one instruction set, for 1, 2, 3 and 4 interleaved channels.
 */
struct rg_kernels {
  const char* name;
  rg_blend* blend[4];
  rg_blend_parts* blend_parts[4]; /* NULL: none */
  uint32_t abilities;
};

#define RG_HAS_VECTORS 1u /* several channels take little longer than one */
#define RG_HAS_WORDS 2u   /* rg_blend_words_avx2() runs */

rg_blend rg_blend_1, rg_blend_2, rg_blend_3, rg_blend_4; /* portable */
#define RG_KERNEL(name, parts, abilities, runs)                     \
  rg_blend rg_blend_1_##name, rg_blend_2_##name, rg_blend_3_##name, \
      rg_blend_4_##name;                                            \
  rg_blend_parts rg_blend_parts_1_##name, rg_blend_parts_2_##name,  \
      rg_blend_parts_3_##name, rg_blend_parts_4_##name;
RG_ALL_KERNELS
#undef RG_KERNEL

/* All fields of a run of RGB565; 0, and nothing is done, where steps are too
 * large for it. */
int rg_blend_words_avx2(const rg_run* run);

/* Blends a run of a spread lattice, bilinear, by the kernels for as many
 * channels as its groups have bytes. Rows may not be wider than 64 pixels. */
void rg_blend_spread(const rg_kernels* kernels, const rg_run* run,
                     const rg_lattice* lattice);

/* Blends a run of any lattice, bilinear. */
void rg_blend_lattice(const rg_run* run, const rg_lattice* lattice);

/* Copies the nearest pixels of a run of any lattice. */
void rg_copy_lattice(const rg_run* run, const rg_lattice* lattice);

/* ---- The kernels that run ------------------------------------------------ */

/* Whether kernels that were chosen may run. is_roomy says that the spare rows
 * are there. Where kernels are built in, the chosen ones need none either. */
#define RG_MAY_RUN(is_roomy) (RG_ALL_BUILT_IN || (is_roomy))

/* The kernels that are wanted, or else the fastest. NULL, which stands for the
 * built-in ones, where rows are too short for others. */
static inline const rg_kernels* rg_choose_kernels(const rg_kernels* wanted,
                                                  uint32_t stride) {
  if (!RG_CHOOSE_KERNELS || !RG_MAY_RUN(stride >= RG_MIN_STRIDE)) return 0;
  return wanted ? wanted : rg_find_kernels(0);
}

/* Blends a run of grey pixels. */
static inline void rg_dispatch_grey(const rg_kernels* kernels,
                                    const rg_run* run, int is_roomy) {
  if (RG_CHOOSE_KERNELS && kernels && RG_MAY_RUN(is_roomy))
    kernels->blend[0](run);
  else
    RG_BUILT_IN(1)(run);
}

/* Blends a run by a kernel that every program has; 0 if there is none for so
 * many channels. */
static inline int rg_blend_built_in(const rg_run* run, uint32_t channels) {
  if (channels == 1)
    RG_BUILT_IN(1)(run);
  else if (RG_ALL_BUILT_IN && channels == 2)
    RG_BUILT_IN(2)(run);
  else if (RG_ALL_BUILT_IN && channels == 3)
    RG_BUILT_IN(3)(run);
  else if (RG_ALL_BUILT_IN && channels == 4)
    RG_BUILT_IN(4)(run);
  else
    return 0;
  return 1;
}

/* Blends a run of a lattice. */
static inline void rg_dispatch(const rg_kernels* kernels, const rg_run* run,
                               const rg_lattice* lattice, int is_roomy) {
  const uint32_t channels = rg_interleaved(lattice);
  if (RG_CHOOSE_KERNELS && kernels && RG_MAY_RUN(is_roomy) && channels != 0) {
    kernels->blend[channels - 1](run);
    return;
  }
  if (RG_BLENDS_WORDS && kernels && (kernels->abilities & RG_HAS_WORDS) != 0 &&
      lattice->kind == RG_SAMPLE_565 &&
      (lattice->first_sample != 0 || rg_blend_words_avx2(run)))
    return; /* all fields are done with the first one, here or below */
  if (RG_CHOOSE_KERNELS && kernels &&
      (kernels->abilities & RG_HAS_VECTORS) != 0 && RG_MAY_RUN(is_roomy) &&
      rg_is_spread(lattice)) {
    rg_blend_spread(kernels, run, lattice);
    return;
  }
  if (!rg_blend_built_in(run, channels)) rg_blend_lattice(run, lattice);
}

#endif /* RAYGRID_KERNEL_H */
