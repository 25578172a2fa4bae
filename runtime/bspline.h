/* Uniform cubic B-spline on a segment. */
#ifndef RAYGRID_BSPLINE_H
#define RAYGRID_BSPLINE_H

#include <stdint.h>

/* Weights of the four control points around a position t in [0, 1):
 *   (1 - t)^3 / 6, (3t^3 - 6t^2 + 4) / 6, (-3t^3 + 3t^2 + 3t + 1) / 6, t^3 / 6
 * Each within 8 LSB of that; their sum is 2^31 exactly. */
void rg_bspline_weights(uint32_t t_q32, int32_t weights_q31[4]);

#endif /* RAYGRID_BSPLINE_H */
