#include "bytes.h"

#include "unit_test.h"

static const uint8_t kBytes[4]
    __attribute__((aligned(4))) = {0x81, 0xf2, 0x03, 0x94};

static void loads_are_little_endian(void** state) {
  (void)state;
  assert_int_equal(rg_load_u16(kBytes), 0xf281);
  assert_int_equal(rg_load_u16(kBytes + 2), 0x9403);
  assert_int_equal(rg_load_u32(kBytes), 0x9403f281u);
}

static void signed_loads_keep_the_sign(void** state) {
  (void)state;
  assert_true(rg_load_i16(kBytes) == 0xf281 - 0x10000);
  assert_true(rg_load_i32(kBytes) == (int32_t)(0x9403f281 - 0x100000000));
}

static void stores_are_little_endian(void** state) {
  (void)state;
  uint8_t bytes[4] __attribute__((aligned(4)));
  rg_store_u32(bytes, 0x9403f281u);
  assert_memory_equal(bytes, kBytes, 4);
  rg_store_i32(bytes, -2);
  assert_int_equal(bytes[0], 0xfe);
  assert_int_equal(bytes[3], 0xff);
  rg_store_u16(bytes, 0x1234);
  assert_int_equal(bytes[0], 0x34);
  assert_int_equal(bytes[1], 0x12);
  assert_int_equal(bytes[2], 0xff);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(loads_are_little_endian),
      cmocka_unit_test(signed_loads_keep_the_sign),
      cmocka_unit_test(stores_are_little_endian),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
