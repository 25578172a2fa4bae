/* A kernel is an inner loop that blends the pixels of a span. This header
 * defines spans, declares the kernels of kernel_list.h, and selects one of
 * them. All are bit-identical: formats/SPEC.md, "Remap arithmetic". */
#ifndef RAYGRID_KERNEL_H
#define RAYGRID_KERNEL_H

#include <stdint.h>

#include "config.h"
#include "kernels/block.h"
#include "kernels/kernel_list.h"
#include "kernels/samples.h"
#include "raygrid.h"

/* A span: a rectangle of pixels of a block. The source pixel of each, and its
 * right, lower and diagonal neighbours, are in the image. */
typedef struct rg_span {
  uint16_t first_pixel; /* column in the block */
  uint16_t first_source_row;
  uint16_t out_pixel;            /* column in the output */
  uint16_t num_rows, num_pixels; /* neither is 0 */
  uint16_t first_row;            /* row in the block */
  const uint8_t* data;           /* address of source row first_source_row */
  uint32_t stride;
  uint8_t* out; /* output row of first_row, at its left end */
  uint32_t out_stride;
  rg_block block;
} rg_span;

/* Size of the spare rows in q12: kernels may read beyond the source pixels, the
 * row below a pixel's lower neighbours, and bytes of the row after it. */
#define RG_SPARE_Q12 (2 * 4096)
#define RG_MIN_STRIDE 32u

/* ---- Kernels ------------------------------------------------------------- */

/* Blends the pixels of a span of 8-bit samples bilinearly. */
typedef void rg_blend(const rg_span* span);

/* Blends horizontally adjacent tiles of 8 x 8 pixels. The span is the first of
 * them. The other tiles differ from it only in their corners, of which there
 * are four per tile. */
typedef void rg_blend_tile_row(const rg_span* span, const rg_position* corners,
                               uint32_t num_tiles);

/* The kernels of one instruction set, for 1, 2, 3 and 4 interleaved channels.
 */
struct rg_kernels {
  const char* name;
  rg_blend* blend[4];
  rg_blend_tile_row* blend_tile_row[4]; /* NULL: not available */
  uint32_t abilities;
};

#define RG_HAS_VECTORS 1u /* several channels cost little more than one */
#define RG_HAS_WORDS 2u   /* rg_blend_words_avx2() may be called */

rg_blend rg_blend_1, rg_blend_2, rg_blend_3, rg_blend_4; /* portable */
#define RG_KERNEL(name, parts, abilities, spans)                            \
  rg_blend rg_blend_1_##name, rg_blend_2_##name, rg_blend_3_##name,         \
      rg_blend_4_##name;                                                    \
  rg_blend_tile_row rg_blend_tile_row_1_##name, rg_blend_tile_row_2_##name, \
      rg_blend_tile_row_3_##name, rg_blend_tile_row_4_##name;
RG_ALL_KERNELS
#undef RG_KERNEL

/* Blends all fields of a span of RGB565. Returns 0, without output, if steps
 * are too large. */
int rg_blend_words_avx2(const rg_span* span);

/* Blends a span of a strided component bilinearly with the kernels for
 * sample_step channels. Spans are at most 64 pixels wide. */
void rg_blend_strided(const rg_kernels* kernels, const rg_span* span,
                      const rg_component* component);

/* Blends a span of any component bilinearly. */
void rg_blend_component(const rg_span* span, const rg_component* component);

/* Copies the nearest source pixels of a span of any component. */
void rg_copy_component(const rg_span* span, const rg_component* component);

/* ---- Selection of kernels ------------------------------------------------ */

/* Whether the selected kernels may run. is_roomy: the spare rows are readable,
 * which built-in kernels do not need. */
#define RG_MAY_RUN(is_roomy) (RG_ALL_BUILT_IN || (is_roomy))

/* Returns the requested kernels, or the fastest if NULL. Returns NULL for the
 * built-in kernels if rows are too short for others. */
static inline const rg_kernels* rg_select_kernels(const rg_kernels* wanted,
                                                  uint32_t stride) {
  if (!RG_SELECT_KERNELS || !RG_MAY_RUN(stride >= RG_MIN_STRIDE)) return 0;
  return wanted ? wanted : rg_find_kernels(0);
}

/* Blends a span of grey pixels. */
static inline void rg_dispatch_grey(const rg_kernels* kernels,
                                    const rg_span* span, int is_roomy) {
  if (RG_SELECT_KERNELS && kernels && RG_MAY_RUN(is_roomy))
    kernels->blend[0](span);
  else
    RG_BUILT_IN(1)(span);
}

/* Blends a span with a kernel that is always available; returns 0 if there is
 * none for this number of channels. */
static inline int rg_blend_built_in(const rg_span* span, uint32_t channels) {
  if (channels == 1)
    RG_BUILT_IN(1)(span);
  else if (RG_ALL_BUILT_IN && channels == 2)
    RG_BUILT_IN(2)(span);
  else if (RG_ALL_BUILT_IN && channels == 3)
    RG_BUILT_IN(3)(span);
  else if (RG_ALL_BUILT_IN && channels == 4)
    RG_BUILT_IN(4)(span);
  else
    return 0;
  return 1;
}

/* Blends a span of a component. */
static inline void rg_dispatch(const rg_kernels* kernels, const rg_span* span,
                               const rg_component* component, int is_roomy) {
  const uint32_t channels = rg_interleaved(component);
  if (RG_SELECT_KERNELS && kernels && RG_MAY_RUN(is_roomy) && channels != 0) {
    kernels->blend[channels - 1](span);
    return;
  }
  if (RG_BLENDS_WORDS && kernels && (kernels->abilities & RG_HAS_WORDS) != 0 &&
      component->kind == RG_SAMPLE_565 &&
      (component->first_sample != 0 || rg_blend_words_avx2(span)))
    return; /* all fields are blended with the first one */
  if (RG_SELECT_KERNELS && kernels &&
      (kernels->abilities & RG_HAS_VECTORS) != 0 && RG_MAY_RUN(is_roomy) &&
      rg_is_strided(component)) {
    rg_blend_strided(kernels, span, component);
    return;
  }
  if (!rg_blend_built_in(span, channels)) rg_blend_component(span, component);
}

#endif /* RAYGRID_KERNEL_H */
