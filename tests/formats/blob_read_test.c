/* Damaged blobs are refused, each fault with its own status. */
#include <string.h>

#include "blob_edit.h"
#include "bytes.h"
#include "example_blob.h"
#include "rg_blob.h"
#include "unit_test.h"

static uint8_t edited[2048] __attribute__((aligned(16)));

/* A value that one field of kExampleBlob must not have. */
typedef struct field_fault {
  const char* what;
  uint32_t offset, num_bytes, value;
  rg_status status;
} field_fault;

static const field_fault kFieldFaults[] = {
    {"magic, first byte", 0, 1, 'r', RG_ERR_MAGIC},
    {"magic, last byte", 7, 1, ' ', RG_ERR_MAGIC},
    {"major version 0", 8, 2, 0, RG_ERR_VERSION},
    {"major version 2", 8, 2, 2, RG_ERR_VERSION},
    {"more bytes announced than given", 12, 4, 488, RG_ERR_TRUNCATED},
    {"most bytes announced", 12, 4, 0xfffffffc, RG_ERR_TRUNCATED},
    {"odd total size", 12, 4, 482, RG_ERR_HEADER},
    {"total size ends in the table", 12, 4, 92, RG_ERR_HEADER},
    {"no section", 16, 2, 0, RG_ERR_HEADER},
    {"17 sections", 16, 2, 17, RG_ERR_HEADER},
    {"header size", 18, 2, 36, RG_ERR_HEADER},
    {"first reserved field of the header", 20, 4, 1, RG_ERR_RESERVED},
    {"second reserved field of the header", 24, 4, 1u << 31, RG_ERR_RESERVED},

    {"bytes after the last section", 16, 2, 3, RG_ERR_SECTION_TABLE},
    {"last section beyond the end", 12, 4, 480, RG_ERR_SECTION_TABLE},
    {"gap before a section", ENTRY(0) + 4, 4, 100, RG_ERR_SECTION_TABLE},
    {"section over the table", ENTRY(0) + 4, 4, 92, RG_ERR_SECTION_TABLE},
    {"section offset of 4 GB", ENTRY(1) + 4, 4, 0xfffffff8,
     RG_ERR_SECTION_TABLE},
    {"empty section", ENTRY(1) + 8, 4, 0, RG_ERR_SECTION_TABLE},
    {"odd section size", ENTRY(3) + 8, 4, 38, RG_ERR_SECTION_TABLE},
    {"section shorter than its fields", ENTRY(3) + 8, 4, 36,
     RG_ERR_SECTION_SIZE},
    {"section too long", ENTRY(3) + 8, 4, 44, RG_ERR_SECTION_TABLE},
    {"section of 4 GB", ENTRY(2) + 8, 4, 0xfffffffc, RG_ERR_SECTION_TABLE},
    {"unknown flag", ENTRY(0) + 2, 2, 3, RG_ERR_SECTION_FLAGS},
    {"camera not critical", ENTRY(0) + 2, 2, 0, RG_ERR_SECTION_FLAGS},
    {"grid not critical", ENTRY(1) + 2, 2, 0, RG_ERR_SECTION_FLAGS},
    {"remap critical", ENTRY(2) + 2, 2, 1, RG_ERR_SECTION_FLAGS},
    {"quality critical", ENTRY(3) + 2, 2, 1, RG_ERR_SECTION_FLAGS},
    {"unknown critical section", ENTRY(0), 2, 77, RG_ERR_SECTION_UNKNOWN},
    {"two cameras", ENTRY(1), 2, 1, RG_ERR_SECTION_DUPLICATE},
    {"two grids", ENTRY(0), 2, 2, RG_ERR_SECTION_DUPLICATE},
    {"two qualities", ENTRY(2), 2, 4, RG_ERR_SECTION_DUPLICATE},
    {"no camera", ENTRY(0), 4, 99, RG_ERR_SECTION_MISSING},
    {"no grid", ENTRY(1), 4, 99, RG_ERR_SECTION_MISSING},

    {"image width 0", CAMERA, 2, 0, RG_ERR_IMAGE_SIZE},
    {"image width 16385", CAMERA, 2, 16385, RG_ERR_IMAGE_SIZE},
    {"image height 0", CAMERA + 2, 2, 0, RG_ERR_IMAGE_SIZE},
    {"image height 65535", CAMERA + 2, 2, 65535, RG_ERR_IMAGE_SIZE},
    {"reserved field of the camera", CAMERA + 4, 4, 256, RG_ERR_RESERVED},
    {"name of 32 bytes", CAMERA + 39, 1, 'x', RG_ERR_TEXT},
    {"serial of 32 bytes", CAMERA + 71, 1, 'x', RG_ERR_TEXT},

    {"area starts left of the image", GRID, 4, (uint32_t)-32769, RG_ERR_AREA},
    {"area starts above the image", GRID + 4, 4, (uint32_t)-32769, RG_ERR_AREA},
    {"area ends right of the image", GRID + 8, 4, 63 * 65536 + 32769,
     RG_ERR_AREA},
    {"area ends below the image", GRID + 12, 4, 47 * 65536 + 32769,
     RG_ERR_AREA},
    {"area without width", GRID, 4, 63 * 65536, RG_ERR_AREA},
    {"area without height", GRID + 12, 4, 0, RG_ERR_AREA},
    {"image smaller than the area", CAMERA, 2, 63, RG_ERR_AREA},
    {"3 columns", GRID + 16, 2, 3, RG_ERR_GRID_SIZE},
    {"1028 columns", GRID + 16, 2, 1028, RG_ERR_GRID_SIZE},
    {"no row", GRID + 18, 2, 0, RG_ERR_GRID_SIZE},
    {"65535 rows", GRID + 18, 2, 65535, RG_ERR_GRID_SIZE},
    {"columns against the scale", GRID + 16, 2, 5, RG_ERR_GRID_SCALE},
    {"area against the scale", GRID + 8, 4, 62 * 65536, RG_ERR_GRID_SCALE},
    {"horizontal scale 1 too low", GRID + 20, 4, 68174083, RG_ERR_GRID_SCALE},
    {"horizontal scale 1 too high", GRID + 20, 4, 68174085, RG_ERR_GRID_SCALE},
    {"vertical scale 1 too low", GRID + 24, 4, 91382281, RG_ERR_GRID_SCALE},
    {"vertical scale 1 too high", GRID + 24, 4, 91382283, RG_ERR_GRID_SCALE},
    {"unknown chart", GRID + 28, 2, 2, RG_ERR_GRID_CHART},
    {"unknown fraction bits", GRID + 30, 2, 30, RG_ERR_GRID_CHART},
    {"control points in the fields", GRID + 32, 4, 36, RG_ERR_DATA_OFFSET},
    {"control points at an odd place", GRID + 32, 4, 42, RG_ERR_DATA_OFFSET},
    {"control points end too late", GRID + 32, 4, 44, RG_ERR_SECTION_SIZE},
    {"control points beyond the section", GRID + 32, 4, 172,
     RG_ERR_SECTION_SIZE},
    {"control points so far that the end wraps", GRID + 32, 4, 0xfffffffc,
     RG_ERR_SECTION_SIZE},
    {"reserved field of the grid", GRID + 36, 4, 1, RG_ERR_RESERVED},
    {"first control point too high", CONTROL_POINTS, 4, 0x7f000001,
     RG_ERR_CONTROL_POINT},
    {"last control point too low", REMAP - 4, 4, 0x80ffffff,
     RG_ERR_CONTROL_POINT},
    {"lowest number as control point", CONTROL_POINTS + 64, 4, 0x80000000,
     RG_ERR_CONTROL_POINT},

    {"output width 0", REMAP, 2, 0, RG_ERR_REMAP_SIZE},
    {"output width 8193", REMAP, 2, 8193, RG_ERR_REMAP_SIZE},
    {"output height 0", REMAP + 2, 2, 0, RG_ERR_REMAP_SIZE},
    {"output height 8193", REMAP + 2, 2, 8193, RG_ERR_REMAP_SIZE},
    {"source wider than 8192", CAMERA, 2, 8193, RG_ERR_REMAP_SIZE},
    {"source higher than 8192", CAMERA + 2, 2, 8193, RG_ERR_REMAP_SIZE},
    {"width against the vertices", REMAP, 2, 17, RG_ERR_REMAP_BLOCK},
    {"height against the vertices", REMAP + 2, 2, 9, RG_ERR_REMAP_BLOCK},
    {"a column of vertices too few", REMAP + 4, 2, 2, RG_ERR_REMAP_BLOCK},
    {"a row of vertices too many", REMAP + 6, 2, 3, RG_ERR_REMAP_BLOCK},
    {"blocks of 4", REMAP + 8, 1, 2, RG_ERR_REMAP_BLOCK},
    {"blocks of 64", REMAP + 8, 1, 6, RG_ERR_REMAP_BLOCK},
    {"blocks of 16 against the vertices", REMAP + 8, 1, 4, RG_ERR_REMAP_BLOCK},
    {"residual shift 11", REMAP + 9, 1, 11, RG_ERR_REMAP_SHIFT},
    {"parts of 8, as large as blocks", REMAP + 10, 1, 3, RG_ERR_REMAP_BLOCK},
    {"bend shift without bends", REMAP + 11, 1, 1, RG_ERR_RESERVED},
    {"source from column -1", REMAP + 12, 4, (uint32_t)-1, RG_ERR_REMAP_SOURCE},
    {"source from row -1", REMAP + 16, 4, (uint32_t)-1, RG_ERR_REMAP_SOURCE},
    {"source beyond the last column", REMAP + 20, 4, 63 * 4096 + 1,
     RG_ERR_REMAP_SOURCE},
    {"source beyond the last row", REMAP + 24, 4, 47 * 4096 + 1,
     RG_ERR_REMAP_SOURCE},
    {"source without width", REMAP + 12, 4, 63 * 4096 + 1, RG_ERR_REMAP_SOURCE},
    {"source without height", REMAP + 16, 4, 47 * 4096 + 1,
     RG_ERR_REMAP_SOURCE},
    {"horizontal focal length 0", REMAP + 52, 4, 0, RG_ERR_REMAP_CAMERA},
    {"vertical focal length 0", REMAP + 56, 4, 0, RG_ERR_REMAP_CAMERA},
    {"vertices in the fields", REMAP + 76, 4, 76, RG_ERR_DATA_OFFSET},
    {"vertices at an odd place", REMAP + 76, 4, 82, RG_ERR_DATA_OFFSET},
    {"vertices end too late", REMAP + 76, 4, 84, RG_ERR_SECTION_SIZE},
    {"vertices beyond the section", REMAP + 76, 4, 0xfffffffc,
     RG_ERR_SECTION_SIZE},
    {"vertices right of 8192", REMAP + 28, 4, 1u << 25, RG_ERR_REMAP_VERTEX},
    {"vertices above -8192", REMAP + 32, 4, 0xfe000000, RG_ERR_REMAP_VERTEX},
    {"last vertex too far right", REMAP + 36, 4, 1u << 24, RG_ERR_REMAP_VERTEX},
    {"last vertex too far down", REMAP + 48, 4, 1u << 25, RG_ERR_REMAP_VERTEX},
};

/* Values that one field of kExampleBlob may still have. */
static const field_fault kAllowedFields[] = {
    {"a higher minor version", 10, 2, 65535, RG_OK},
    {"largest image", CAMERA, 4, 8192u << 16 | 8192u, RG_OK},
    {"empty serial", CAMERA + 40, 4, 0, RG_OK},
    {"name of 7 bytes that are not UTF-8", CAMERA + 8, 4, 0xffc0ff80, RG_OK},
    {"control point at the upper limit", CONTROL_POINTS, 4, 0x7f000000, RG_OK},
    {"control point at the lower limit", CONTROL_POINTS, 4, 0x81000000, RG_OK},
    {"source of one column", REMAP + 12, 4, 63 * 4096, RG_OK},
    {"residual shift 10", REMAP + 9, 1, 10, RG_OK},
    {"virtual camera of any centre", REMAP + 60, 4, 0x80000000, RG_OK},
    {"all blocks empty", MASK, 1, 3, RG_OK},
    {"padding bits of the mask", MASK + 1, 2, 0xffff, RG_OK},
    {"bytes after the name's zero", CAMERA + 20, 1, 'x', RG_OK},
    {"bytes after the serial's zero", CAMERA + 45, 1, 'x', RG_OK},
    {"any figure", QUALITY + 12, 4, 0, RG_OK},
};

static void store(uint8_t* p, uint32_t num_bytes, uint32_t value) {
  for (uint32_t i = 0; i < num_bytes; ++i) p[i] = (uint8_t)(value >> 8 * i);
}

static void check_field(const field_fault* fault) {
  memcpy(edited, kExampleBlob, SIZE);
  store(edited + fault->offset, fault->num_bytes, fault->value);
  repair_crcs(edited, SIZE);
  const rg_status status = open_copy(edited, SIZE);
  if (status != fault->status) print_error("%s\n", fault->what);
  assert_int_equal(status, fault->status);
}

static void each_fault_has_its_own_status(void** state) {
  (void)state;
  for (size_t i = 0; i < sizeof(kFieldFaults) / sizeof(kFieldFaults[0]); ++i)
    check_field(&kFieldFaults[i]);
}

static void values_at_the_limits_are_accepted(void** state) {
  (void)state;
  for (size_t i = 0; i < sizeof(kAllowedFields) / sizeof(kAllowedFields[0]);
       ++i)
    check_field(&kAllowedFields[i]);
}

static void truncated_blob_is_refused(void** state) {
  (void)state;
  for (uint32_t size = 0; size < SIZE; ++size)
    assert_int_equal(open_copy(kExampleBlob, size), RG_ERR_TRUNCATED);
  for (uint32_t size = 0; size < sizeof(kLensBlob); ++size)
    assert_int_equal(open_copy(kLensBlob, size), RG_ERR_TRUNCATED);
}

static void bytes_after_the_blob_are_ignored(void** state) {
  (void)state;
  memcpy(edited, kExampleBlob, SIZE);
  memset(edited + SIZE, 0xa5, 7);
  assert_int_equal(open_copy(edited, SIZE + 7), RG_OK);
}

static void flip_each_bit(const uint8_t* golden, uint32_t size) {
  memcpy(edited, golden, size);
  rg_blob blob;
  for (uint32_t bit = 0; bit < 8 * size; ++bit) {
    edited[bit / 8] ^= (uint8_t)(1u << bit % 8);
    assert_int_not_equal(rg_blob_open(edited, size, &blob), RG_OK);
    edited[bit / 8] ^= (uint8_t)(1u << bit % 8);
  }
}

static void every_flipped_bit_is_refused(void** state) {
  (void)state;
  flip_each_bit(kExampleBlob, SIZE);
  flip_each_bit(kLensBlob, sizeof(kLensBlob));
}

static void every_lost_byte_is_refused(void** state) {
  (void)state;
  memcpy(edited, kExampleBlob, SIZE);
  rg_blob blob;
  for (uint32_t i = 0; i < SIZE; ++i) {
    edited[i] = kExampleBlob[i] == 0xff ? 0 : 0xff;
    assert_int_not_equal(rg_blob_open(edited, SIZE, &blob), RG_OK);
    edited[i] = kExampleBlob[i];
  }
}

static void damaged_table_is_a_header_crc_fault(void** state) {
  (void)state;
  for (uint32_t i = 20; i < CAMERA; ++i) {
    memcpy(edited, kExampleBlob, SIZE);
    edited[i] ^= 0x10;
    assert_int_equal(open_copy(edited, SIZE), RG_ERR_HEADER_CRC);
  }
}

static void damaged_section_is_a_section_crc_fault(void** state) {
  (void)state;
  for (uint32_t i = CAMERA; i < SIZE; ++i) {
    memcpy(edited, kExampleBlob, SIZE);
    edited[i] ^= 0x80;
    assert_int_equal(open_copy(edited, SIZE), RG_ERR_SECTION_CRC);
  }
}

static void misaligned_address_is_refused(void** state) {
  (void)state;
  rg_blob blob;
  for (uint32_t shift = 1; shift < 16; ++shift) {
    memcpy(edited + shift, kExampleBlob, SIZE);
    const rg_status expected = shift % 4 == 0 ? RG_OK : RG_ERR_MISALIGNED;
    assert_int_equal(rg_blob_open(edited + shift, SIZE, &blob), expected);
  }
}

static void null_is_refused(void** state) {
  (void)state;
  rg_blob blob;
  assert_int_equal(rg_blob_open(NULL, SIZE, &blob), RG_ERR_ARGUMENT);
  assert_int_equal(rg_blob_open(kExampleBlob, SIZE, NULL), RG_ERR_ARGUMENT);
}

static void output_is_untouched_on_failure(void** state) {
  (void)state;
  rg_blob blob, untouched;
  memset(&blob, 0x5a, sizeof(blob));
  memset(&untouched, 0x5a, sizeof(untouched));
  for (size_t i = 0; i < sizeof(kFieldFaults) / sizeof(kFieldFaults[0]); ++i) {
    memcpy(edited, kExampleBlob, SIZE);
    store(edited + kFieldFaults[i].offset, kFieldFaults[i].num_bytes,
          kFieldFaults[i].value);
    repair_crcs(edited, SIZE);
    assert_int_not_equal(rg_blob_open(edited, SIZE, &blob), RG_OK);
    assert_memory_equal(&blob, &untouched, sizeof(blob));
  }
}

/* The first section ends in the table once its end has wrapped around. */
static void sections_that_wrap_around_are_refused(void** state) {
  (void)state;
  memcpy(edited, kExampleBlob, SIZE);
  rg_store_u32(edited + ENTRY(0) + 8, (uint32_t)-32);
  rg_store_u32(edited + ENTRY(1) + 4, CAMERA - 32);
  rg_store_u32(edited + ENTRY(1) + 8, REMAP - CAMERA + 32);
  repair_crcs(edited, SIZE);
  assert_int_equal(open_copy(edited, SIZE), RG_ERR_SECTION_TABLE);
}

/* 4 x 19 control points, placed so that their end wraps to the section's. */
static void array_that_wraps_around_is_refused(void** state) {
  (void)state;
  const uint32_t data_size = 8 * 4 * 19;
  memcpy(edited, kExampleBlob, SIZE);
  rg_store_u16(edited + GRID + 18, 19);
  rg_store_u32(edited + GRID + 24, rg_grid_scale_q32(16, 47u << 16));
  rg_store_u32(edited + GRID + 32, REMAP - GRID - data_size);
  repair_crcs(edited, SIZE);
  assert_int_equal(open_copy(edited, SIZE), RG_ERR_SECTION_SIZE);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(each_fault_has_its_own_status),
      cmocka_unit_test(values_at_the_limits_are_accepted),
      cmocka_unit_test(truncated_blob_is_refused),
      cmocka_unit_test(bytes_after_the_blob_are_ignored),
      cmocka_unit_test(every_flipped_bit_is_refused),
      cmocka_unit_test(every_lost_byte_is_refused),
      cmocka_unit_test(damaged_table_is_a_header_crc_fault),
      cmocka_unit_test(damaged_section_is_a_section_crc_fault),
      cmocka_unit_test(misaligned_address_is_refused),
      cmocka_unit_test(null_is_refused),
      cmocka_unit_test(output_is_untouched_on_failure),
      cmocka_unit_test(sections_that_wrap_around_are_refused),
      cmocka_unit_test(array_that_wraps_around_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
