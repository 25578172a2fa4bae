/* AVX2 version of rays/surface.h, with bit-identical results. */
#ifndef RAYGRID_SURFACE_AVX2_H
#define RAYGRID_SURFACE_AVX2_H

#include "rays/surface.h"

/* Whether the processor supports AVX2. */
int rg_has_avx2_surface(void);

/* rg_find_place() with AVX2. */
rg_status rg_find_place_avx2(const uint8_t* grid, int32_t x, int32_t y,
                             rg_place* place);

/* rg_find_slopes() with AVX2. */
void rg_find_slopes_avx2(const uint8_t* inverse, const rg_place* place,
                         int32_t slopes_q5[2][2]);

#endif /* RAYGRID_SURFACE_AVX2_H */
