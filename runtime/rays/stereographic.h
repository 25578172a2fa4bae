/* Directions and their stereographic coordinates, the chart of the control
 * points: (a, b) = tan(theta / 2) (cos phi, sin phi). */
#ifndef RAYGRID_STEREOGRAPHIC_H
#define RAYGRID_STEREOGRAPHIC_H

#include "fixed_point.h"
#include "raygrid.h"
#include "rays/inverse.h"

typedef struct rg_chart_point {
  int32_t q27[2]; /* a, b */
} rg_chart_point;

/* Computes the direction of a chart position, |a| and |b| below 4:
 * (2a, 2b, 1 - s) / (1 + s) with s = a^2 + b^2. */
static RG_INLINE void rg_chart_to_direction(const rg_chart_point* point,
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

/* sqrt(s) in q29, for s_q28 in [2^26, 2^30): s in [1/4, 4). */
static RG_INLINE int32_t rg_square_root(uint32_t s_q28) {
  uint32_t u_q31 = s_q28 << 1; /* s / 4, or s */
  int shift = 2;
  if (u_q31 < UINT32_C(1) << 29) {
    u_q31 <<= 2;
    shift = 1;
  }
  return rg_multiply_high((int32_t)u_q31, rg_inverse_root((int32_t)u_q31))
         << shift;
}

/* The bits of a value that differ from its sign bit. */
static inline uint32_t rg_magnitude_bits(int32_t value) {
  return (uint32_t)(value ^ (value >> 31));
}

/* Computes the chart position of a direction of any length, within 1e-8 (1 +
 * a^2 + b^2): (x, y) / (n + z) with n the length.
 *
 * limit_q30  c |c|, with c a cosine: directions farther from the z axis are
 *            rejected early. -2^30: no limit.
 *
 * Returns 0, with *point unchanged, for rejected directions, for (0, 0, 0), and
 * for angles of 151 degrees or more, where a^2 + b^2 would reach 15. */
static RG_INLINE int rg_direction_to_chart(const rg_ray* direction,
                                           int32_t limit_q30,
                                           rg_chart_point* point) {
  const int32_t x = direction->x_q30, y = direction->y_q30;
  const int32_t z = direction->z_q30;
  /* Scaled so that the largest magnitude is in [1/2, 1]. */
  const int shift =
      rg_leading_zeros(rg_magnitude_bits(x) | rg_magnitude_bits(y) |
                       rg_magnitude_bits(z) | 1) -
      1;
  const int32_t x_q30 = (int32_t)((uint32_t)x << shift) >> 1;
  const int32_t y_q30 = (int32_t)((uint32_t)y << shift) >> 1;
  const int32_t z_q30 = (int32_t)((uint32_t)z << shift) >> 1;
  const int32_t z_square_q28 = rg_multiply_high(z_q30, z_q30);
  const int32_t square_q28 = rg_multiply_high_add(
      rg_multiply_high_add(z_square_q28, x_q30, x_q30), y_q30, y_q30);
  if ((z < 0 ? -z_square_q28 : z_square_q28) <
      2 * rg_multiply_high(limit_q30, 2 * square_q28))
    return 0;
  const int32_t length_q29 = rg_square_root((uint32_t)square_q28);
  const int32_t sum_q29 = length_q29 + (z_q30 >> 1);
  /* a^2 + b^2 = (n - z) / (n + z) is below 15; (0, 0, 0) ends here too. */
  if (sum_q29 <= length_q29 >> 3) return 0;
  /* n + z = D 2^(3 - zeros) with D in [1/2, 1); 1 / D in q29. */
  const int zeros = rg_leading_zeros((uint32_t)sum_q29); /* 1 to 6 */
  const int32_t r_q29 = rg_reciprocal((uint32_t)sum_q29 << zeros);
  /* x / (n + z) = x / D 2^(zeros - 3) */
  point->q27[0] = rg_multiply_high(x_q30, r_q29) * (1 << (zeros - 1)) >> 2;
  point->q27[1] = rg_multiply_high(y_q30, r_q29) * (1 << (zeros - 1)) >> 2;
  return 1;
}

#endif /* RAYGRID_STEREOGRAPHIC_H */
