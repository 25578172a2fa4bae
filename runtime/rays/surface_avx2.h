/* AVX2 version of rays/surface.h, with bit-identical results. */
#ifndef RAYGRID_SURFACE_AVX2_H
#define RAYGRID_SURFACE_AVX2_H

#include "rays/surface.h"

/* Whether the processor supports AVX2. */
int rg_has_avx2_surface(void);

/* rg_evaluate_spline() with AVX2. */
rg_status rg_evaluate_spline_avx2(const uint8_t* grid, int32_t x, int32_t y,
                                  rg_grid_position* grid_position);

/* rg_compute_jacobian() with AVX2. */
void rg_compute_jacobian_avx2(const uint8_t* inverse,
                              const rg_grid_position* grid_position,
                              int32_t jacobian_q5[2][2]);

#endif /* RAYGRID_SURFACE_AVX2_H */
