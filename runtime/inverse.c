#include "inverse.h"

#include "fixed_point.h"

/* r <- r + r (1 - d r): relative error 1/17, 4e-3, 1.2e-5, 2^-32. */
int32_t rg_reciprocal(uint32_t d_q32) {
  /* 48/17 - 32/17 d */
  int32_t r_q30 = (int32_t)(UINT32_C(3031741621) -
                            rg_multiply_high_unsigned(d_q32, 2021161081));
  for (int i = 0; i < 3; ++i) {
    const int32_t error_q30 =
        (int32_t)((UINT32_C(1) << 30) -
                  rg_multiply_high_unsigned(d_q32, (uint32_t)r_q30));
    r_q30 += rg_multiply_shift(r_q30, error_q30, 30);
  }
  return r_q30;
}

/* r <- r + r (1 - u r^2) / 2: relative error 0.024, 8.7e-4, 1.1e-6, rounding.
 */
int32_t rg_inverse_root(uint32_t u_q32) {
  /* 2.6708 - u (3.2854 - 1.6386 u) */
  const uint32_t slope_q29 =
      1763812404 - rg_multiply_high_unsigned(u_q32, 879699425);
  int32_t r_q29 =
      (int32_t)(1433893831 - rg_multiply_high_unsigned(u_q32, slope_q29));
  for (int i = 0; i < 3; ++i) {
    const uint32_t square_q28 = (uint32_t)rg_multiply_shift(r_q29, r_q29, 30);
    const int32_t error_q28 =
        (int32_t)((UINT32_C(1) << 28) -
                  rg_multiply_high_unsigned(u_q32, square_q28));
    r_q29 += rg_multiply_shift(r_q29, error_q28, 29);
  }
  return r_q29;
}
