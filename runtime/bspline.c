#include "bspline.h"

#include "fixed_point.h"

void rg_bspline_weights(uint32_t t_q32, int32_t weights_q31[4]) {
  const uint32_t sixth_q31 = 357913941;
  const uint32_t t2_q32 = rg_multiply_high_unsigned(t_q32, t_q32);
  const uint32_t t3_q32 = rg_multiply_high_unsigned(t2_q32, t_q32);
  /* t/6, t^2/6, t^3/6: each at most 2^31 / 6. */
  const int32_t a = (int32_t)rg_multiply_high_unsigned(t_q32, sixth_q31);
  const int32_t b = (int32_t)rg_multiply_high_unsigned(t2_q32, sixth_q31);
  const int32_t c = (int32_t)rg_multiply_high_unsigned(t3_q32, sixth_q31);

  const int32_t w0 = (int32_t)sixth_q31 - 3 * a + 3 * b - c;
  const int32_t w2 = (int32_t)sixth_q31 + 3 * a + 3 * (b - c);
  weights_q31[0] = w0;
  /* The second takes what rounding left, so that the sum is exact. */
  weights_q31[1] =
      (int32_t)(0x80000000u - (uint32_t)w0 - (uint32_t)w2 - (uint32_t)c);
  weights_q31[2] = w2;
  weights_q31[3] = c;
}

void rg_bspline_slopes(uint32_t t_q32, int32_t slopes_q31[4]) {
  const int32_t half_q31 = INT32_C(1) << 30;
  /* t and t^2 / 2, at most 2^31 - 1 and 2^30. */
  const int32_t t = (int32_t)(t_q32 >> 1);
  const int32_t square =
      (int32_t)(rg_multiply_high_unsigned(t_q32, t_q32) >> 2);
  slopes_q31[0] = t - half_q31 - square;
  slopes_q31[3] = square;
  /* -(3t^2 - 2t - 1) / 2, in an order that stays in 32 bits. */
  slopes_q31[2] = half_q31 - 2 * square + (t - square);
  slopes_q31[1] = -slopes_q31[0] - slopes_q31[2] - slopes_q31[3];
}
