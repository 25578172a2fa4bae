#include "rays/bspline.h"

#include "test_frame.h"
#include "unit_test.h"

#define NUM_POSITIONS 10000
#define MAX_ERROR 12 /* LSB, as bspline.h says */

static void check_sum_and_sign(int32_t t_q30) {
  int32_t weights[4];
  rg_bspline_weights(t_q30, weights);
  int64_t sum = 0;
  for (int i = 0; i < 4; ++i) {
    assert_true(weights[i] >= -MAX_ERROR);
    sum += weights[i];
  }
  assert_true(sum == INT64_C(1) << 31);
}

static void weights_add_up_to_one(void** state) {
  (void)state;
  uint32_t random = 3;
  check_sum_and_sign(0);
  check_sum_and_sign(1 << 30);
  for (int i = 0; i < NUM_POSITIONS; ++i)
    check_sum_and_sign((int32_t)(next_random(&random) >> 2));
}

/* Six times the weights in q60, exactly, for t in q20. */
static void exact_weights(int64_t t_q20, int64_t six_weights_q60[4]) {
  const int64_t one_q60 = INT64_C(1) << 60;
  const int64_t rest_q20 = (INT64_C(1) << 20) - t_q20;
  const int64_t t_q60 = t_q20 << 40;
  const int64_t t2_q60 = t_q20 * t_q20 << 20;
  const int64_t t3_q60 = t_q20 * t_q20 * t_q20;
  six_weights_q60[0] = rest_q20 * rest_q20 * rest_q20;
  six_weights_q60[1] = one_q60 + 3 * (one_q60 - 2 * t2_q60 + t3_q60);
  six_weights_q60[2] = one_q60 + 3 * (t_q60 + t2_q60 - t3_q60);
  six_weights_q60[3] = t3_q60;
}

static void check_weights(uint32_t t_q20) {
  int64_t expected[4];
  int32_t weights[4];
  exact_weights(t_q20, expected);
  rg_bspline_weights((int32_t)(t_q20 << 10), weights);
  const int64_t six_lsb = 6 * (INT64_C(1) << 29);
  for (int i = 0; i < 4; ++i) {
    const int64_t error = weights[i] * six_lsb - expected[i];
    assert_true(error <= MAX_ERROR * six_lsb && error >= -MAX_ERROR * six_lsb);
  }
}

static void weights_are_the_polynomials(void** state) {
  (void)state;
  for (uint32_t i = 0; i < NUM_POSITIONS; ++i)
    check_weights((uint32_t)((uint64_t)i * 0x100000 / (NUM_POSITIONS - 1)));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(weights_add_up_to_one),
      cmocka_unit_test(weights_are_the_polynomials),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
