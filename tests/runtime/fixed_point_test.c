#include "fixed_point.h"

#include "test_frame.h"
#include "unit_test.h"

static const int32_t kEdges[] = {INT32_MIN,  INT32_MIN + 1,
                                 -65537,     -65536,
                                 -65535,     -2,
                                 -1,         0,
                                 1,          2,
                                 32768,      65535,
                                 65536,      0x7fff0000,
                                 0x7fff8000, 0x7ffffffe,
                                 INT32_MAX};
#define NUM_EDGES (sizeof(kEdges) / sizeof(kEdges[0]))

/* floor((value + 2^(shift - 1)) / 2^shift) */
static int64_t rounded(int64_t value, int shift) {
  const int64_t unit = INT64_C(1) << shift;
  const int64_t sum = value + unit / 2;
  return sum / unit - (sum % unit < 0);
}

static void check_high_words(int32_t a, int32_t b) {
  const int64_t expected = rounded((int64_t)a * b, 32);
  assert_true(rg_multiply_high(a, b) == expected);
  assert_true(rg_multiply_high_add(5, a, b / 2) ==
              5 + rounded((int64_t)a * (b / 2), 32));
  const uint64_t product = (uint64_t)(uint32_t)a * (uint32_t)b;
  const uint64_t half = UINT64_C(1) << 31;
  assert_true(rg_multiply_high_unsigned((uint32_t)a, (uint32_t)b) ==
              (product >> 32) + ((product & half) != 0));
}

static void high_words_of_edge_values_are_rounded(void** state) {
  (void)state;
  for (size_t i = 0; i < NUM_EDGES; ++i)
    for (size_t j = 0; j < NUM_EDGES; ++j)
      check_high_words(kEdges[i], kEdges[j]);
}

static void high_words_of_random_values_are_rounded(void** state) {
  (void)state;
  uint32_t random = 7;
  for (int i = 0; i < 20000; ++i) {
    const int32_t a = (int32_t)next_random(&random);
    check_high_words(a, (int32_t)next_random(&random));
  }
}

/* b is shortened so that the result fits. */
static void check_shift(int32_t a, int32_t b, int shift) {
  const int32_t factor = b >> (33 - shift);
  assert_true(rg_multiply_shift(a, factor, shift) ==
              rounded((int64_t)a * factor, shift));
}

static void shifted_products_are_rounded(void** state) {
  (void)state;
  uint32_t random = 8;
  for (int shift = 2; shift <= 31; ++shift) {
    for (int i = 0; i < 500; ++i) {
      const int32_t a = (int32_t)next_random(&random);
      check_shift(a, (int32_t)next_random(&random), shift);
    }
  }
}

static void shifted_products_carry_into_the_high_word(void** state) {
  (void)state;
  assert_int_equal(rg_multiply_shift(0xffff, 0x10001, 3), 0x20000000);
  assert_true(rg_multiply_shift(-1, 1, 31) == 0);
  assert_true(rg_multiply_shift(INT32_MIN, 1, 31) == -1);
  assert_true(rg_multiply_shift(INT32_MAX, 3, 31) == 3);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(high_words_of_edge_values_are_rounded),
      cmocka_unit_test(high_words_of_random_values_are_rounded),
      cmocka_unit_test(shifted_products_are_rounded),
      cmocka_unit_test(shifted_products_carry_into_the_high_word),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
