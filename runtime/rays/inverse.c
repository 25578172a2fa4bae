#include "rays/inverse.h"

#include "fixed_point.h"

/* r + r (1 - d r): squares the error of r. */
static RG_INLINE int32_t improve_reciprocal(int32_t r_q29, int32_t d_q31) {
  /* d r in q32 overflows its 1: the remainder is d r - 1. */
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
