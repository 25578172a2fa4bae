#include "multiply_in_parts.h"
#include "unit_test.h"
#include "wide_multiply.h"

static const uint32_t kEdges[] = {
    0,          1,          2,          0xfffe,     0xffff,     0x10000,
    0x10001,    0x1ffff,    0x7ffeffff, 0x7fff0000, 0x7fff8000, 0x7fffffff,
    0x80000000, 0x80000001, 0x8000ffff, 0x80010000, 0xfffeffff, 0xffff0000,
    0xffff0001, 0xffff8000, 0xfffffffe, 0xffffffff};
#define NUM_EDGES (sizeof(kEdges) / sizeof(kEdges[0]))

static uint64_t unsigned_product(uint32_t a, uint32_t b) {
  uint32_t low;
  const uint32_t high = rg_multiply_unsigned(a, b, &low);
  return (uint64_t)high << 32 | low;
}

static uint64_t unsigned_product_in_parts(uint32_t a, uint32_t b) {
  uint32_t low;
  const uint32_t high = multiply_unsigned_in_parts(a, b, &low);
  return (uint64_t)high << 32 | low;
}

static uint64_t signed_product(int32_t a, int32_t b) {
  uint32_t low;
  const int32_t high = rg_multiply_signed(a, b, &low);
  return (uint64_t)(uint32_t)high << 32 | low;
}

static uint64_t signed_product_in_parts(int32_t a, int32_t b) {
  uint32_t low;
  const int32_t high = multiply_signed_in_parts(a, b, &low);
  return (uint64_t)(uint32_t)high << 32 | low;
}

static void check_products(uint32_t a, uint32_t b) {
  const uint64_t expected = (uint64_t)a * b;
  assert_true(unsigned_product(a, b) == expected);
  assert_true(unsigned_product_in_parts(a, b) == expected);
  const uint64_t expected_signed = (uint64_t)((int64_t)(int32_t)a * (int32_t)b);
  assert_true(signed_product((int32_t)a, (int32_t)b) == expected_signed);
  assert_true(signed_product_in_parts((int32_t)a, (int32_t)b) ==
              expected_signed);
}

static void products_of_edge_values_are_exact(void** state) {
  (void)state;
  for (size_t i = 0; i < NUM_EDGES; ++i)
    for (size_t j = 0; j < NUM_EDGES; ++j) check_products(kEdges[i], kEdges[j]);
}

static void products_of_random_values_are_exact(void** state) {
  (void)state;
  uint32_t a = 1;
  for (int i = 0; i < 100000; ++i) {
    const uint32_t b = a * 1664525u + 1013904223u;
    check_products(a, b);
    a = b * 1664525u + 1013904223u;
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(products_of_edge_values_are_exact),
      cmocka_unit_test(products_of_random_values_are_exact),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
