/* Reciprocals and square roots by Newton's method, without division. */
#ifndef RAYGRID_INVERSE_H
#define RAYGRID_INVERSE_H

#include <stdint.h>

#include "fixed_point.h"

/* 1 / d in q29, relative error below 4e-9, for d_q32 >= 2^31: d in [1/2, 1). */
int32_t rg_reciprocal(uint32_t d_q32);

/* 1 / sqrt(u) in q29, relative error below 8e-9, for u_q31 >= 2^29: u in [1/4,
 * 1). r <- r + r (1 - u r^2) / 2: errors 0.024, 8.7e-4, 1.1e-6, rounding.
 */
static RG_INLINE int32_t rg_inverse_root(int32_t u_q31) {
  /* 2.6708 - u (3.2854 - 1.6386 u) */
  const int32_t slope_q29 = 1763812404 - rg_multiply_high(u_q31, 1759398850);
  int32_t r_q29 = 1433893831 - 2 * rg_multiply_high(u_q31, slope_q29);
  for (int i = 0; i < 3; ++i) {
    const int32_t square_q28 = rg_multiply_high(r_q29, r_q29) << 2;
    const uint32_t product_q31 = (uint32_t)rg_multiply_high(u_q31, square_q28)
                                 << 4;
    const int32_t half_error_q32 = (int32_t)(0x80000000u - product_q31);
    r_q29 = rg_multiply_high_add(r_q29, r_q29, half_error_q32);
  }
  return r_q29;
}

#endif /* RAYGRID_INVERSE_H */
