/* Uniform cubic B-spline on a segment. */
#ifndef RAYGRID_BSPLINE_H
#define RAYGRID_BSPLINE_H

#include <stdint.h>

/* Weights of the four control points around a position t in [0, 1):
 *   (1 - t)^3 / 6, (3t^3 - 6t^2 + 4) / 6, (-3t^3 + 3t^2 + 3t + 1) / 6, t^3 / 6
 * Each within 8 LSB of that; their sum is 2^31 exactly. */
void rg_bspline_weights(uint32_t t_q32, int32_t weights_q31[4]);

/* Their derivatives by t:
 *   -(1 - t)^2 / 2, (3t^2 - 4t) / 2, (-3t^2 + 2t + 1) / 2, t^2 / 2
 * Each within 4 LSB of that; their sum is 0 exactly. */
void rg_bspline_slopes(uint32_t t_q32, int32_t slopes_q31[4]);

#endif /* RAYGRID_BSPLINE_H */
