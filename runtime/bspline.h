/* Uniform cubic B-spline on a segment. */
#ifndef RAYGRID_BSPLINE_H
#define RAYGRID_BSPLINE_H

#include <stdint.h>

#include "fixed_point.h"

/* Weights of the four control points around a position t in [0, 1):
 *   (1 - t)^3 / 6, (3t^3 - 6t^2 + 4) / 6, (-3t^3 + 3t^2 + 3t + 1) / 6, t^3 / 6
 * Each within 4 LSB of that; their sum is 2^31 exactly. */
static RG_INLINE void rg_bspline_weights(int32_t t_q31,
                                         int32_t weights_q31[4]) {
  const int32_t sixth_q31 = 357913941, sixth_q32 = 715827883;
  /* t^2 and t^3 in q30 are their halves in q31. */
  const int32_t half_t = t_q31 >> 1;
  const int32_t half_t2 = rg_multiply_high(t_q31, t_q31);
  const int32_t half_t3 = rg_multiply_high(2 * half_t2, t_q31);
  const int32_t w3 = rg_multiply_high(2 * half_t3, sixth_q32);
  const int32_t w0 = sixth_q31 - half_t + half_t2 - w3;
  const int32_t w2 = sixth_q31 + half_t + half_t2 - half_t3;
  weights_q31[0] = w0;
  /* The second takes what rounding left, so that the sum is exact. */
  weights_q31[1] =
      (int32_t)(0x80000000u - (uint32_t)w0 - (uint32_t)w2 - (uint32_t)w3);
  weights_q31[2] = w2;
  weights_q31[3] = w3;
}

#endif /* RAYGRID_BSPLINE_H */
