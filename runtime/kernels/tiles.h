/* Portable kernels for compilers that vectorize loops. */
#ifndef RAYGRID_TILES_H
#define RAYGRID_TILES_H

#include "kernels/kernel.h"

/* Blends a span of whole tiles of 8 x 8 pixels, with 1 to 4 interleaved
 * channels. Returns 0 for other spans, or without such kernels. */
int rg_blend_tiles(const rg_span* span, uint32_t channels);

/* Copies the nearest pixels of such a span, with one channel. Returns 0 as
 * rg_blend_tiles(). */
int rg_copy_tiles(const rg_span* span);

#endif /* RAYGRID_TILES_H */
