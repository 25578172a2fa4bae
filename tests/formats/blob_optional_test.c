/* The optional sections of version 1.1: their fields, and each fault of them
 * refused with its own status. */
#include <string.h>

#include "blob_edit.h"
#include "bytes.h"
#include "golden_blobs.h"
#include "rg_blob.h"
#include "unit_test.h"

static uint8_t edited[sizeof(kWideBlob)] __attribute__((aligned(16)));

/* A value of a field of kWideBlob's section of that type. */
typedef struct field_value {
  const char* what;
  uint32_t type, offset, num_bytes, value;
  rg_status status;
} field_value;

static const field_value kValues[] = {
    {"left of the chart", 9, 0, 4, (uint32_t)-0x40000001, RG_ERR_START_CHART},
    {"above the chart", 9, 4, 4, 0x80000000, RG_ERR_START_CHART},
    {"right of the chart", 9, 8, 4, 0x40000001, RG_ERR_START_CHART},
    {"below the chart", 9, 12, 4, 0x7fffffff, RG_ERR_START_CHART},
    {"no width", 9, 8, 4, 0xc0000000, RG_ERR_START_CHART},
    {"one column", 9, 16, 2, 1, RG_ERR_START_GRID},
    {"66 rows", 9, 18, 2, 66, RG_ERR_START_GRID},
    {"columns against the scale", 9, 16, 2, 13, RG_ERR_START_GRID},
    {"horizontal scale 0", 9, 20, 4, 0, RG_ERR_START_GRID},
    {"vertical scale too high", 9, 24, 4, 0xffffffff, RG_ERR_START_GRID},
    {"cosine of 1", 9, 28, 4, 0x40000000, RG_ERR_START_CHART},
    {"cosine below -1", 9, 28, 4, (uint32_t)-0x40000001, RG_ERR_START_CHART},
    {"cosine of -1", 9, 28, 4, (uint32_t)-0x40000000, RG_OK},
    {"vertices in the fields", 9, 32, 4, 32, RG_ERR_DATA_OFFSET},
    {"vertices at an odd place", 9, 32, 4, 38, RG_ERR_DATA_OFFSET},
    {"vertices end too late", 9, 32, 4, 40, RG_ERR_SECTION_SIZE},
    {"vertices so far that the end wraps", 9, 32, 4, 0xfffffffc,
     RG_ERR_SECTION_SIZE},
    {"any vertex", 9, 36, 4, 0x80008000, RG_OK},
};

static uint32_t entry_of_type(uint32_t type) {
  uint32_t entry = RG_HEADER_SIZE;
  while (rg_load_u16(kWideBlob + entry) != type) entry += 16;
  return entry;
}

static void store(uint8_t* p, uint32_t num_bytes, uint32_t value) {
  for (uint32_t i = 0; i < num_bytes; ++i) p[i] = (uint8_t)(value >> 8 * i);
}

static void each_fault_has_its_own_status(void** state) {
  (void)state;
  for (size_t i = 0; i < sizeof(kValues) / sizeof(kValues[0]); ++i) {
    const field_value* value = &kValues[i];
    memcpy(edited, kWideBlob, sizeof(edited));
    const uint32_t section =
        rg_load_u32(kWideBlob + entry_of_type(value->type) + 4);
    store(edited + section + value->offset, value->num_bytes, value->value);
    repair_crcs(edited, sizeof(edited));
    const rg_status status = open_copy(edited, sizeof(edited));
    if (status != value->status) print_error("%s\n", value->what);
    assert_int_equal(status, value->status);
  }
}

static const uint16_t kTypes[] = {9};
#define NUM_TYPES (sizeof(kTypes) / sizeof(kTypes[0]))

static void sections_are_not_critical(void** state) {
  (void)state;
  for (size_t i = 0; i < NUM_TYPES; ++i) {
    memcpy(edited, kWideBlob, sizeof(edited));
    rg_store_u16(edited + entry_of_type(kTypes[i]) + 2, RG_SECTION_CRITICAL);
    repair_crcs(edited, sizeof(edited));
    assert_int_equal(open_copy(edited, sizeof(edited)), RG_ERR_SECTION_FLAGS);
  }
}

/* The camera, the grid and another section, once or twice. */
static rg_status open_with_copies(uint32_t type, uint32_t num_copies,
                                  uint32_t size) {
  static uint8_t bytes[2 * sizeof(kWideBlob)] __attribute__((aligned(4)));
  const uint32_t k = (entry_of_type(type) - RG_HEADER_SIZE) / 16;
  blob_section sections[4] = {
      section_of(kWideBlob, 0), section_of(kWideBlob, 1),
      section_of(kWideBlob, k), section_of(kWideBlob, k)};
  if (size != 0) sections[2].size = size;
  return open_copy(bytes, assemble_blob(sections, 2 + num_copies, bytes));
}

static void sections_stand_once(void** state) {
  (void)state;
  for (size_t i = 0; i < NUM_TYPES; ++i) {
    assert_int_equal(open_with_copies(kTypes[i], 1, 0), RG_OK);
    assert_int_equal(open_with_copies(kTypes[i], 2, 0),
                     RG_ERR_SECTION_DUPLICATE);
  }
}

static void short_sections_are_refused(void** state) {
  (void)state;
  for (size_t i = 0; i < NUM_TYPES; ++i) {
    const uint32_t size = rg_load_u32(kWideBlob + entry_of_type(kTypes[i]) + 8);
    for (uint32_t length = 4; length < size; length += 4)
      assert_int_equal(open_with_copies(kTypes[i], 1, length),
                       RG_ERR_SECTION_SIZE);
  }
}

static void start_is_read(void** state) {
  (void)state;
  rg_blob blob;
  rg_start_section start;
  assert_int_equal(rg_blob_open(kWideBlob, sizeof(kWideBlob), &blob), RG_OK);
  rg_blob_start(&blob, &start);
  assert_int_equal(start.columns, 14);
  assert_int_equal(start.rows, 12);
  assert_true(start.a0_q28 < 0 && start.a1_q28 > 0);
  assert_true(start.b0_q28 < 0 && start.b1_q28 > 0);
  assert_int_equal(
      start.scale_a_q20,
      rg_grid_scale_q32(13, (uint32_t)start.a1_q28 - (uint32_t)start.a0_q28));
  assert_true(start.cos_limit_q30 < 0);
  assert_ptr_equal(start.vertices, kWideBlob + blob.start + 36);
}

static void every_flipped_bit_is_refused(void** state) {
  (void)state;
  memcpy(edited, kWideBlob, sizeof(edited));
  rg_blob blob;
  for (uint32_t bit = 0; bit < 8 * sizeof(edited); bit += 5) {
    edited[bit / 8] ^= (uint8_t)(1u << bit % 8);
    assert_int_not_equal(rg_blob_open(edited, sizeof(edited), &blob), RG_OK);
    edited[bit / 8] ^= (uint8_t)(1u << bit % 8);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(each_fault_has_its_own_status),
      cmocka_unit_test(sections_are_not_critical),
      cmocka_unit_test(sections_stand_once),
      cmocka_unit_test(short_sections_are_refused),
      cmocka_unit_test(start_is_read),
      cmocka_unit_test(every_flipped_bit_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
