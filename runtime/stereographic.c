#include "stereographic.h"

#include "fixed_point.h"
#include "inverse.h"

/* 1 / (1 + s) in q30, for s_q26 <= 2^31: 1 + s scaled to [1/2, 1). */
static int32_t reciprocal_of_one_plus(uint32_t s_q26) {
  const uint32_t sum_q26 = s_q26 + (UINT32_C(1) << 26);
  const int doublings = rg_leading_zeros(sum_q26); /* at most 5 */
  const int32_t r_q30 = rg_reciprocal(sum_q26 << doublings);
  /* 1 / (1 + s) = r 2^(doublings - 6) */
  const int shift = 6 - doublings;
  return (int32_t)(((uint32_t)r_q30 + (UINT32_C(1) << (shift - 1))) >> shift);
}

/* (2a, 2b, 1 - s) / (1 + s) with s = a^2 + b^2. */
void rg_direction_of(const rg_chart_point* point, rg_ray* ray) {
  const int32_t a_q29 = 2 * point->q28[0], b_q29 = 2 * point->q28[1];
  const uint32_t s_q26 = (uint32_t)rg_multiply_high(a_q29, a_q29) +
                         (uint32_t)rg_multiply_high(b_q29, b_q29);
  const int32_t r_q30 = reciprocal_of_one_plus(s_q26);
  ray->x_q30 = rg_multiply_shift(point->q28[0], r_q30, 27);
  ray->y_q30 = rg_multiply_shift(point->q28[1], r_q30, 27);
  ray->z_q30 = 2 * r_q30 - (INT32_C(1) << 30); /* (1 - s) r = 2r - 1 */
}

/* Shifts left so that magnitude's highest bit becomes bit 30. */
static int32_t scale(int32_t value, int leading_zeros) {
  return leading_zeros > 0 ? (int32_t)((uint32_t)value << (leading_zeros - 1))
                           : value >> 1;
}

/* sqrt(s) in q30, for s_q30 from 2^28 on, that is s in [1/4, 4). */
static uint32_t square_root(uint32_t s_q30) {
  const int is_below_1 = s_q30 < UINT32_C(1) << 30;
  const uint32_t u_q32 = is_below_1 ? s_q30 << 2 : s_q30; /* s or s / 4 */
  uint32_t low;
  const uint32_t high =
      rg_multiply_unsigned(u_q32, (uint32_t)rg_inverse_root(u_q32), &low);
  const uint32_t root_q30 = (high << 1) | (low >> 31); /* q61 >> 31 */
  return is_below_1 ? root_q30 : 2 * root_q30;
}

/* x / d in q28 for |x| < 1; *overflow is set where that reaches 4.
 * d = sum_q30 / 2^30 = D 2^(2 - zeros) with D in [1/2, 1). */
static int32_t divide(int32_t x_q31, int32_t reciprocal_q30, int zeros,
                      int* overflow) {
  const int32_t product_q29 = rg_multiply_high(x_q31, reciprocal_q30);
  const int shift = zeros - 3; /* x / D in q29 to x / d in q28 */
  if (shift < 0) return (product_q29 + (1 << (-shift - 1))) >> -shift;
  const int32_t limit = (INT32_C(1) << 30) >> shift;
  if (product_q29 >= limit || product_q29 <= -limit) *overflow = 1;
  return (int32_t)((uint32_t)product_q29 << shift);
}

/* (x, y) / (n + z) with n the length. */
int rg_chart_point_of(const rg_ray* direction, int32_t limit_q30,
                      rg_chart_point* point) {
  const uint32_t magnitudes = rg_magnitude(direction->x_q30) |
                              rg_magnitude(direction->y_q30) |
                              rg_magnitude(direction->z_q30);
  if (magnitudes == 0) return 0;
  const int zeros = rg_leading_zeros(magnitudes);
  const int32_t x_q31 = scale(direction->x_q30, zeros);
  const int32_t y_q31 = scale(direction->y_q30, zeros);
  const int32_t z_q31 = scale(direction->z_q30, zeros);
  const int32_t z_square_q30 = rg_multiply_high(z_q31, z_q31);
  const uint32_t square_q30 = (uint32_t)rg_multiply_high(x_q31, x_q31) +
                              (uint32_t)rg_multiply_high(y_q31, y_q31) +
                              (uint32_t)z_square_q30;
  if (rg_product(z_q31 < 0 ? -z_square_q30 : z_square_q30, 1 << 29) <
      rg_product(limit_q30, (int32_t)(square_q30 >> 1)))
    return 0;
  const uint32_t length_q30 = square_root(square_q30);
  const int32_t z_q30 = z_q31 >> 1;
  if (z_q30 < 0 && length_q30 <= rg_magnitude(z_q30)) return 0;
  const uint32_t sum_q30 = length_q30 + (uint32_t)z_q30;
  /* Within the chart, n + z >= 2n / 33. */
  const int sum_zeros = rg_leading_zeros(sum_q30);
  if (sum_zeros > 7) return 0;
  const int32_t r_q30 = rg_reciprocal(sum_q30 << sum_zeros);
  int overflow = 0;
  const int32_t a_q28 = divide(x_q31, r_q30, sum_zeros, &overflow);
  const int32_t b_q28 = divide(y_q31, r_q30, sum_zeros, &overflow);
  if (overflow) return 0;
  point->q28[0] = a_q28;
  point->q28[1] = b_q28;
  return 1;
}
