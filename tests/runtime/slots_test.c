/* Two slots in flash: one whole blob whenever power is cut. */
#include <string.h>

#include "blob_layout.h"
#include "bytes.h"
#include "golden_blobs.h"
#include "raygrid.h"
#include "unit_test.h"

#define SLOT_SIZE 2048u
#define NUM_BYTES(blob) ((uint32_t)sizeof(blob))

static union {
  uint32_t words[2 * SLOT_SIZE / 4]; /* for its alignment */
  uint8_t bytes[2 * SLOT_SIZE];
} flash;

static uint8_t* slot_at(uint32_t index) {
  return flash.bytes + index * SLOT_SIZE;
}

static rg_status choose(rg_slot* newest) {
  return rg_select_slot(slot_at(0), slot_at(1), SLOT_SIZE, newest);
}

static void put(uint32_t index, const uint8_t* blob, uint32_t num_bytes,
                uint32_t sequence) {
  uint32_t header[16];
  assert_int_equal(rg_make_slot_header(blob, num_bytes, sequence, header),
                   RG_OK);
  memset(slot_at(index), 0xff, SLOT_SIZE);
  memcpy(slot_at(index), header, sizeof(header));
  memcpy(slot_at(index) + sizeof(header), blob, num_bytes);
}

static void put_example(uint32_t index, uint32_t sequence) {
  put(index, kExampleBlob, NUM_BYTES(kExampleBlob), sequence);
}

static int erase(void** state) {
  (void)state;
  memset(flash.bytes, 0xff, sizeof(flash.bytes));
  return 0;
}

static void check_newest(uint32_t index, uint32_t sequence) {
  rg_slot newest;
  assert_int_equal(choose(&newest), RG_OK);
  assert_int_equal(newest.index, index);
  assert_int_equal(newest.sequence, sequence);
  assert_ptr_equal(newest.blob, slot_at(index) + RG_SLOT_HEADER_SIZE);
}

static void check_none(void) {
  rg_slot newest = {0, 7, 7, 7};
  assert_int_equal(choose(&newest), RG_ERR_NO_SLOT);
  assert_int_equal(newest.num_bytes, 7);
  assert_int_equal(newest.index, 7);
}

static void empty_slots_have_no_blob(void** state) {
  (void)state;
  check_none();
  memset(flash.bytes, 0, sizeof(flash.bytes));
  check_none();
}

static void newest_blob_opens_in_place(void** state) {
  (void)state;
  put_example(0, 4);
  put(1, kLensBlob, NUM_BYTES(kLensBlob), 5);
  rg_slot newest;
  rg_camera camera;
  assert_int_equal(choose(&newest), RG_OK);
  assert_int_equal(newest.num_bytes, NUM_BYTES(kLensBlob));
  assert_int_equal(rg_camera_open(&camera, newest.blob, newest.num_bytes),
                   RG_OK);
  /* Without that slot, as after a refusal, the other one counts. */
  assert_int_equal(rg_select_slot(slot_at(0), 0, SLOT_SIZE, &newest), RG_OK);
  assert_int_equal(newest.index, 0);
  assert_int_equal(rg_select_slot(0, slot_at(1), SLOT_SIZE, &newest), RG_OK);
  assert_int_equal(newest.index, 1);
}

static void sequence_wraps_around(void** state) {
  (void)state;
  static const uint32_t kPairs[][2] = {{1, 2},
                                       {0xffffffffu, 0},
                                       {0xfffffff0u, 0x10},
                                       {0x7fffffffu, 0x80000000u},
                                       {0, 0x7fffffffu}};
  for (uint32_t k = 0; k < sizeof(kPairs) / sizeof(kPairs[0]); ++k)
    for (uint32_t newer = 0; newer < 2; ++newer) {
      put_example(newer ^ 1u, kPairs[k][0]);
      put_example(newer, kPairs[k][1]);
      check_newest(newer, kPairs[k][1]);
    }
}

static void first_counts_where_neither_is_newer(void** state) {
  (void)state;
  put_example(0, 9);
  put_example(1, 9);
  check_newest(0, 9);
  put_example(1, 9u + 0x80000000u);
  check_newest(0, 9);
}

static void every_damaged_byte_leads_to_the_other_slot(void** state) {
  (void)state;
  put_example(0, 1);
  put_example(1, 2);
  const uint32_t num_bytes = RG_SLOT_HEADER_SIZE + NUM_BYTES(kExampleBlob);
  for (uint32_t k = 0; k < num_bytes; ++k) {
    slot_at(1)[k] ^= (uint8_t)(1u << k % 8);
    check_newest(0, 1);
    slot_at(1)[k] ^= (uint8_t)(1u << k % 8);
  }
  check_newest(1, 2);
  slot_at(1)[num_bytes] ^= 1; /* free */
  check_newest(1, 2);
  slot_at(0)[0] ^= 1;
  slot_at(1)[0] ^= 1;
  check_none();
}

/* The CRC is that of the changed header. */
static void set_field(uint8_t* slot, uint32_t field, uint32_t value) {
  rg_store_u32(slot + field, value);
  uint32_t crc = ~0u;
  for (uint32_t k = 0; k < 8 * RG_SLOT_HEADER_CRC; ++k) {
    crc ^= slot[k / 8] >> k % 8 & 1u;
    crc = (crc >> 1) ^ (0xedb88320u & (0u - (crc & 1u)));
  }
  rg_store_u32(slot + RG_SLOT_HEADER_CRC, ~crc);
}

static void sizes_beyond_the_slot_and_other_versions_are_refused(void** state) {
  (void)state;
  static const uint32_t kSizes[] = {0,           SLOT_SIZE - 63, SLOT_SIZE,
                                    0x7fffffffu, 0x80000000u,    0xffffffffu};
  for (uint32_t k = 0; k < sizeof(kSizes) / sizeof(kSizes[0]); ++k) {
    put_example(1, 1);
    set_field(slot_at(1), RG_SLOT_BLOB_SIZE, kSizes[k]);
    check_none();
  }
  put_example(1, 1);
  set_field(slot_at(1), RG_SLOT_MAJOR, 2 | RG_SLOT_HEADER_SIZE << 16);
  check_none();
  set_field(slot_at(1), RG_SLOT_MAJOR, 1 | RG_SLOT_HEADER_SIZE << 16);
  check_newest(1, 1);
}

static void blob_may_fill_its_slot(void** state) {
  (void)state;
  static uint8_t bytes[SLOT_SIZE - RG_SLOT_HEADER_SIZE];
  memset(bytes, 0x5a, sizeof(bytes));
  put(1, bytes, sizeof(bytes), 3);
  check_newest(1, 3);
}

static void impossible_calls_are_refused(void** state) {
  (void)state;
  rg_slot newest;
  uint32_t header[16];
  put_example(0, 1);
  assert_int_equal(rg_select_slot(0, 0, SLOT_SIZE, &newest), RG_ERR_NO_SLOT);
  assert_int_equal(rg_select_slot(slot_at(0), slot_at(1), SLOT_SIZE, 0),
                   RG_ERR_ARGUMENT);
  for (uint32_t size = 0; size <= RG_SLOT_HEADER_SIZE; size += 32)
    assert_int_equal(rg_select_slot(slot_at(0), slot_at(1), size, &newest),
                     RG_ERR_ARGUMENT);
  assert_int_equal(
      rg_select_slot(slot_at(0) + 2, slot_at(1), SLOT_SIZE, &newest),
      RG_ERR_MISALIGNED);
  assert_int_equal(
      rg_select_slot(slot_at(0), slot_at(1) + 1, SLOT_SIZE, &newest),
      RG_ERR_MISALIGNED);
  assert_int_equal(rg_make_slot_header(0, 4, 1, header), RG_ERR_ARGUMENT);
  assert_int_equal(rg_make_slot_header(kExampleBlob, 0, 1, header),
                   RG_ERR_ARGUMENT);
  assert_int_equal(rg_make_slot_header(kExampleBlob, 4, 1, 0), RG_ERR_ARGUMENT);
}

/* ---- Power cuts ---------------------------------------------------------- */

/* Writes a byte; power is cut after some of its bits came, and before. The old
 * blob counts then. */
static void change_byte(uint8_t* at, uint8_t value) {
  const uint8_t before = *at;
  check_newest(0, 0xffffffffu);
  for (uint32_t mask = 0x11; mask <= 0xff; mask += 0x33) {
    *at = (uint8_t)((before & ~mask) | (value & mask));
    if (*at != value) check_newest(0, 0xffffffffu);
  }
  *at = value;
}

/* Into slot 1, byte by byte, the header last. */
static void write_with_cuts(void) {
  uint32_t header[16];
  assert_int_equal(
      rg_make_slot_header(kExampleBlob, NUM_BYTES(kExampleBlob), 0, header),
      RG_OK);
  for (uint32_t k = 0; k < NUM_BYTES(kExampleBlob); ++k)
    change_byte(slot_at(1) + RG_SLOT_HEADER_SIZE + k, kExampleBlob[k]);
  for (uint32_t k = 0; k < RG_SLOT_HEADER_SIZE; ++k)
    change_byte(slot_at(1) + k, ((const uint8_t*)header)[k]);
  check_newest(1, 0);
}

static void cut_at_any_byte_leaves_the_old_blob(void** state) {
  (void)state;
  put_example(0, 0xffffffffu);
  write_with_cuts();
}

static void cut_while_erasing_leaves_the_old_blob(void** state) {
  (void)state;
  put_example(0, 0xffffffffu);
  put(1, kLensBlob, NUM_BYTES(kLensBlob), 0xfffffffeu);
  for (uint32_t k = 0; k < RG_SLOT_HEADER_SIZE + NUM_BYTES(kLensBlob); ++k)
    change_byte(slot_at(1) + k, 0xff);
  write_with_cuts();
}

static void cut_over_leftovers_leaves_the_old_blob(void** state) {
  (void)state;
  put_example(0, 0xffffffffu);
  uint32_t number = 1;
  for (uint32_t k = 0; k < SLOT_SIZE; ++k) {
    number = number * 1664525u + 1013904223u;
    slot_at(1)[k] = (uint8_t)(number >> 24);
  }
  write_with_cuts();
}

/* By a writer that erases nothing: over a blob that is a little older. */
static void cut_over_an_older_blob_leaves_the_old_blob(void** state) {
  (void)state;
  put_example(0, 0xffffffffu);
  put(1, kLensBlob, NUM_BYTES(kLensBlob), 0xfffffffeu);
  write_with_cuts();
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup(empty_slots_have_no_blob, erase),
      cmocka_unit_test_setup(newest_blob_opens_in_place, erase),
      cmocka_unit_test_setup(sequence_wraps_around, erase),
      cmocka_unit_test_setup(first_counts_where_neither_is_newer, erase),
      cmocka_unit_test_setup(every_damaged_byte_leads_to_the_other_slot, erase),
      cmocka_unit_test_setup(
          sizes_beyond_the_slot_and_other_versions_are_refused, erase),
      cmocka_unit_test_setup(blob_may_fill_its_slot, erase),
      cmocka_unit_test_setup(impossible_calls_are_refused, erase),
      cmocka_unit_test_setup(cut_at_any_byte_leaves_the_old_blob, erase),
      cmocka_unit_test_setup(cut_while_erasing_leaves_the_old_blob, erase),
      cmocka_unit_test_setup(cut_over_leftovers_leaves_the_old_blob, erase),
      cmocka_unit_test_setup(cut_over_an_older_blob_leaves_the_old_blob, erase),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
