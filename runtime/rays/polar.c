#include "rays/polar.h"

/* atan(2^-k), q29. From k = 10 on, it equals 2^-k at this precision. */
static const int32_t kAngles[] = {421657428, 248918915, 131521918, 66762579,
                                  33510843,  16771758,  8387925,   4194219,
                                  2097141,   1048575};
#define NUM_ANGLES ((int)(sizeof kAngles / sizeof kAngles[0]))
#define NUM_TURNS 30

int32_t rg_compute_angle(int32_t x_q30, int32_t y_q30, int32_t* length_q30) {
  int32_t x = x_q30, y = y_q30, angle_q29 = 0;
  if (x < 0) { /* rotate by a right angle */
    const int32_t old_x = x;
    angle_q29 = y < 0 ? -RG_HALF_PI_Q29 : RG_HALF_PI_Q29;
    x = y < 0 ? rg_subtract(0, y) : y;
    y = y < 0 ? old_x : rg_subtract(0, old_x);
  }
  for (int k = 0; k < NUM_TURNS; ++k) {
    const int32_t turn_q29 =
        k < NUM_ANGLES ? kAngles[k] : (INT32_C(1) << 29) >> k;
    const int32_t half_x = x >> k, half_y = y >> k;
    if (y < 0) {
      x = rg_subtract(x, half_y);
      y = rg_add(y, half_x);
      angle_q29 -= turn_q29;
    } else {
      x = rg_add(x, half_y);
      y = rg_subtract(y, half_x);
      angle_q29 += turn_q29;
    }
  }
  /* The rotations have scaled the vector: times 0.6072529350 in q32. */
  *length_q30 =
      (int32_t)rg_multiply_high_unsigned((uint32_t)x, UINT32_C(2608131496));
  return angle_q29;
}
