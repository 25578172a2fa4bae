/* Directions and their stereographic coordinates, the chart of the control
 * points: (a, b) = tan(theta / 2) (cos phi, sin phi). */
#ifndef RAYGRID_STEREOGRAPHIC_H
#define RAYGRID_STEREOGRAPHIC_H

#include "fixed_point.h"
#include "inverse.h"
#include "raygrid.h"

typedef struct rg_chart_point {
  int32_t q27[2]; /* a, b */
} rg_chart_point;

/* The direction of a chart position, |a| and |b| below 4:
 * (2a, 2b, 1 - s) / (1 + s) with s = a^2 + b^2. */
static RG_INLINE void rg_direction_of(const rg_chart_point* point,
                                      rg_ray* ray) {
  const int32_t a_q29 = rg_shift_left(point->q27[0], 2);
  const int32_t b_q29 = rg_shift_left(point->q27[1], 2);
  const uint32_t sum_q26 = (uint32_t)rg_multiply_high_add(
                               rg_multiply_high(a_q29, a_q29), b_q29, b_q29) +
                           (UINT32_C(1) << 26);
  /* 1 + s = D 2^(6 - zeros) with D in [1/2, 1); 1 / D in q29. */
  const int zeros = rg_leading_zeros(sum_q26); /* at most 5 */
  const int32_t r_q29 = rg_reciprocal(sum_q26 << zeros);
  const int32_t r_q30 = r_q29 >> (5 - zeros); /* 1 / (1 + s) */
  ray->x_q30 = rg_multiply_high(a_q29, r_q30) * 16;
  ray->y_q30 = rg_multiply_high(b_q29, r_q30) * 16;
  /* (1 - s) r = 2r - 1 */
  ray->z_q30 = (int32_t)(2 * (uint32_t)r_q30 - (UINT32_C(1) << 30));
}

/* The chart position of a direction of any length, within 1e-8 (1 + a^2 + b^2).
 *
 * limit_q30  c |c|, with c a cosine: directions farther from the z axis than
 *            that are refused at little cost. -2^30: none.
 *
 * 0, and *point untouched, for those, for (0, 0, 0), and from 151 degrees on,
 * where a^2 + b^2 would reach 15. */
int rg_chart_point_of(const rg_ray* direction, int32_t limit_q30,
                      rg_chart_point* point);

#endif /* RAYGRID_STEREOGRAPHIC_H */
