#include "inverse.h"

#include "fixed_point.h"

/* r + r (1 - d r): the error of r, squared. */
static RG_INLINE int32_t improve_reciprocal(int32_t r_q29, int32_t d_q31) {
  /* d r in q32 loses its 1: what is left is d r - 1. */
  const uint32_t excess_q32 = (uint32_t)rg_multiply_high(d_q31, r_q29) << 4;
  return rg_multiply_high_subtract(r_q29, r_q29, (int32_t)excess_q32);
}

/* Relative errors: 1/17, 4e-3, 1.2e-5, rounding. */
int32_t rg_reciprocal(uint32_t d_q32) {
  const int32_t d_q31 = (int32_t)(d_q32 >> 1);
  /* 48/17 - 32/17 d */
  int32_t r_q29 = 1515870810 - rg_multiply_high(d_q31, 2021161080);
  r_q29 = improve_reciprocal(r_q29, d_q31);
  r_q29 = improve_reciprocal(r_q29, d_q31);
  return improve_reciprocal(r_q29, d_q31);
}

/* r <- r + r (1 - u r^2) / 2: relative error 0.024, 8.7e-4, 1.1e-6, rounding.
 */
int32_t rg_inverse_root(uint32_t u_q32) {
  const int32_t u_q31 = (int32_t)(u_q32 >> 1);
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
