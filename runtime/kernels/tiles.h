/* The portable kernels where compilers make vectors of loops. */
#ifndef RAYGRID_TILES_H
#define RAYGRID_TILES_H

#include "kernels/kernel.h"

/* Blends a run that is made of tiles of 8 x 8 pixels, of 1 to 4 interleaved
 * channels; 0 if it is not, or there are no such kernels. */
int rg_blend_tiles(const rg_run* run, uint32_t channels);

/* Copies the nearest pixels of such a run, of one channel; 0 likewise. */
int rg_copy_tiles(const rg_run* run);

#endif /* RAYGRID_TILES_H */
