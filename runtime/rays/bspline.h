/* Uniform cubic B-spline on a segment. */
#ifndef RAYGRID_BSPLINE_H
#define RAYGRID_BSPLINE_H

#include <stdint.h>

#include "fixed_point.h"

/* Weights of the four control points around a position t in [0, 1]:
 *   (1 - t)^3 / 6, (3t^3 - 6t^2 + 4) / 6, (-3t^3 + 3t^2 + 3t + 1) / 6, t^3 / 6
 * Their sum is exactly 2^31, and each error is below 12 LSB. As all four have
 * the same errors of t^2 and t^3, these errors multiply only second and third
 * differences of the control points. */
static RG_INLINE void rg_bspline_weights(int32_t t_q30,
                                         int32_t weights_q31[4]) {
  const int32_t sixth_q31 = 357913941;
  const int32_t third_q32 = 4 * sixth_q31;
  const int32_t t2_q30 = 4 * rg_multiply_high(t_q30, t_q30);
  const int32_t t3_q28 = rg_multiply_high(t2_q30, t_q30);
  /* q30 values are halves in q31, q28 eighths; t^3 / 6 is 4/3 of t3_q28. */
  const int32_t even_q31 = sixth_q31 + t2_q30;
  const int32_t w0_and_w3 = even_q31 - t_q30;
  const int32_t w2 = even_q31 - 4 * t3_q28 + t_q30;
  const int32_t w3 = rg_multiply_high_add(t3_q28, t3_q28, third_q32);
  weights_q31[0] = w0_and_w3 - w3;
  /* The second weight absorbs the rounding, so that the sum is exact. */
  weights_q31[1] = (int32_t)(0x80000000u - (uint32_t)w0_and_w3 - (uint32_t)w2);
  weights_q31[2] = w2;
  weights_q31[3] = w3;
}

#endif /* RAYGRID_BSPLINE_H */
