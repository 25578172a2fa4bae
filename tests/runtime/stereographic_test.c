#include "rays/stereographic.h"

#include "fixed_point.h"
#include "rays/inverse.h"
#include "test_frame.h"
#include "unit_test.h"

#define NUM_VALUES 20000

static void reciprocals_are_within_their_error(void** state) {
  (void)state;
  uint32_t random = 1;
  for (int i = 0; i < NUM_VALUES; ++i) {
    const uint32_t d_q32 =
        i == 0 ? 0x80000000u : next_random(&random) | 1u << 31;
    /* d r - 1 in q61 */
    const int64_t error =
        (int64_t)((uint64_t)d_q32 * (uint32_t)rg_reciprocal(d_q32)) -
        (INT64_C(1) << 61);
    const int64_t limit = (INT64_C(1) << 61) / 1000000000 * 4;
    assert_true(error <= limit && error >= -limit);
  }
}

static void check_root(uint32_t u_q32) {
  const int64_t r_q29 = rg_inverse_root((int32_t)(u_q32 >> 1));
  /* r is right within e if u (r (1 - e))^2 <= 1 <= u (r (1 + e))^2. */
  const int64_t low = r_q29 - r_q29 / 125000000 - 1;
  const int64_t high = r_q29 + r_q29 / 125000000 + 1;
  const uint64_t one_q58 = UINT64_C(1) << 58;
  /* u r^2 in q90, by parts: r^2 in q58, times u, in q58. */
  const uint64_t low2 = (uint64_t)(low * low), high2 = (uint64_t)(high * high);
  const uint64_t below =
      (low2 >> 32) * u_q32 + (((low2 & 0xffffffffu) * u_q32) >> 32);
  const uint64_t above =
      (high2 >> 32) * u_q32 + (((high2 & 0xffffffffu) * u_q32) >> 32);
  assert_true(below <= one_q58 && above + 1 >= one_q58);
}

static void inverse_roots_are_within_their_error(void** state) {
  (void)state;
  uint32_t random = 2;
  check_root(1u << 30);
  check_root(UINT32_MAX);
  for (int i = 0; i < NUM_VALUES; ++i) {
    const uint32_t u_q32 = next_random(&random);
    if (u_q32 >= 1u << 30) check_root(u_q32);
  }
}

static void leading_zeros_are_counted(void** state) {
  (void)state;
  for (int bit = 0; bit < 32; ++bit) {
    assert_int_equal(rg_leading_zeros(1u << bit), 31 - bit);
    assert_int_equal(rg_leading_zeros(UINT32_MAX >> bit), bit);
  }
}

static int32_t distance(int32_t a, int32_t b) { return a > b ? a - b : b - a; }

/* Error below 2e-8 (1 + a^2 + b^2) on either way, in q27: 5.4 LSB in all. */
static void chart_points_of_their_directions_come_back(void** state) {
  (void)state;
  uint32_t random = 4;
  for (int i = 0; i < NUM_VALUES; ++i) {
    const rg_chart_point point = {
        {(int32_t)next_random(&random) >> (2 + i % 9),
         (int32_t)next_random(&random) >> (2 + i % 9)}};
    rg_ray ray;
    rg_chart_point back;
    rg_chart_to_direction(&point, &ray);
    const int is_found = rg_direction_to_chart(&ray, -(1 << 30), &back);
    const int64_t a = point.q27[0], b = point.q27[1];
    const int64_t beyond_q38 = (a * a + b * b - (INT64_C(15) << 54)) >> 16;
    if (is_found)
      assert_true(beyond_q38 < 1 << 23);
    else
      assert_true(beyond_q38 > -(1 << 23));
    if (!is_found) continue;
    const int32_t a_q8 = point.q27[0] >> 19, b_q8 = point.q27[1] >> 19;
    const int32_t limit = 6 + 6 * ((a_q8 * a_q8 + b_q8 * b_q8) >> 16);
    assert_in_range(distance(back.q27[0], point.q27[0]), 0, limit);
    assert_in_range(distance(back.q27[1], point.q27[1]), 0, limit);
  }
}

static void directions_beyond_the_limit_are_refused(void** state) {
  (void)state;
  const rg_ray forward = {0, 0, 5}, aside = {3, -4, 0}, back = {1, 2, -9};
  rg_chart_point point;
  const int32_t one = 1 << 30;
  assert_true(rg_direction_to_chart(&forward, one - 1000, &point));
  assert_false(rg_direction_to_chart(&aside, 1000, &point));
  assert_true(rg_direction_to_chart(&aside, -1000, &point));
  assert_false(rg_direction_to_chart(&back, -one / 2, &point));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(reciprocals_are_within_their_error),
      cmocka_unit_test(inverse_roots_are_within_their_error),
      cmocka_unit_test(leading_zeros_are_counted),
      cmocka_unit_test(chart_points_of_their_directions_come_back),
      cmocka_unit_test(directions_beyond_the_limit_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
