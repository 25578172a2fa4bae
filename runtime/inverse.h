/* Reciprocals and square roots by Newton's iteration, without division. */
#ifndef RAYGRID_INVERSE_H
#define RAYGRID_INVERSE_H

#include "fixed_point.h"

/* r + r (1 - d r): the error of r, squared. */
static RG_INLINE int32_t rg_improve_reciprocal(int32_t r_q29, int32_t d_q31) {
  /* d r in q32 loses its 1: what is left is d r - 1. */
  const uint32_t excess_q32 = (uint32_t)rg_multiply_high(d_q31, r_q29) << 4;
  return rg_multiply_high_subtract(r_q29, r_q29, (int32_t)excess_q32);
}

/* 1 / d in q29, relative error below 4e-9, for d_q32 from 2^31 on: d in
 * [1/2, 1). Errors of the steps: 1/17, 4e-3, 1.2e-5, rounding. */
static RG_INLINE int32_t rg_reciprocal_inline(uint32_t d_q32) {
  const int32_t d_q31 = (int32_t)(d_q32 >> 1);
  /* 48/17 - 32/17 d */
  int32_t r_q29 = 1515870810 - rg_multiply_high(d_q31, 2021161080);
  r_q29 = rg_improve_reciprocal(r_q29, d_q31);
  r_q29 = rg_improve_reciprocal(r_q29, d_q31);
  return rg_improve_reciprocal(r_q29, d_q31);
}

int32_t rg_reciprocal(uint32_t d_q32);

/* 1 / sqrt(u) in q29, relative error below 8e-9, for u_q32 from 2^30 on: u in
 * [1/4, 1). */
int32_t rg_inverse_root(uint32_t u_q32);

#endif /* RAYGRID_INVERSE_H */
