#include "crc32.h"

#include "unit_test.h"

static const uint8_t kDigits[9] = {'1', '2', '3', '4', '5', '6', '7', '8', '9'};

static void digits_have_the_check_value(void** state) {
  (void)state;
  assert_int_equal(rg_crc32(0, kDigits, sizeof(kDigits)), 0xcbf43926u);
}

static void nothing_has_crc_zero(void** state) {
  (void)state;
  assert_int_equal(rg_crc32(0, kDigits, 0), 0);
}

static void crc_continues_at_every_split(void** state) {
  (void)state;
  for (uint32_t n = 0; n <= sizeof(kDigits); ++n) {
    const uint32_t head = rg_crc32(0, kDigits, n);
    assert_int_equal(rg_crc32(head, kDigits + n, sizeof(kDigits) - n),
                     0xcbf43926u);
  }
}

static void zeros_and_ones_count(void** state) {
  (void)state;
  const uint8_t zeros[4] = {0, 0, 0, 0};
  const uint8_t ones[4] = {255, 255, 255, 255};
  assert_int_equal(rg_crc32(0, zeros, 4), 0x2144df1cu);
  assert_int_equal(rg_crc32(0, ones, 4), 0xffffffffu);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(digits_have_the_check_value),
      cmocka_unit_test(nothing_has_crc_zero),
      cmocka_unit_test(crc_continues_at_every_split),
      cmocka_unit_test(zeros_and_ones_count),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
