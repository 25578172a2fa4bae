#include <string.h>

#include "blob_edit.h"
#include "bytes.h"
#include "example_blob.h"
#include "fixed_point.h"
#include "raygrid.h"
#include "unit_test.h"

static uint8_t blob[sizeof(kWideBlob)] __attribute__((aligned(4)));

static void handle_is_at_most_64_bytes(void** state) {
  (void)state;
  assert_true(sizeof(rg_camera) <= 64);
}

static void camera_is_opened(void** state) {
  (void)state;
  rg_camera camera;
  assert_int_equal(rg_camera_open(&camera, kExampleBlob, sizeof(kExampleBlob)),
                   RG_OK);
}

static void damaged_blob_leaves_the_camera_untouched(void** state) {
  (void)state;
  rg_camera camera, untouched;
  memset(&camera, 0x5a, sizeof(camera));
  memset(&untouched, 0x5a, sizeof(untouched));
  memcpy(blob, kExampleBlob, SIZE);
  blob[SIZE - 1] ^= 1;
  assert_int_equal(rg_camera_open(&camera, blob, SIZE), RG_ERR_SECTION_CRC);
  assert_memory_equal(&camera, &untouched, sizeof(camera));
}

static void null_is_refused(void** state) {
  (void)state;
  rg_camera camera;
  assert_int_equal(rg_camera_open(NULL, kExampleBlob, sizeof(kExampleBlob)),
                   RG_ERR_ARGUMENT);
  assert_int_equal(rg_camera_open(&camera, NULL, sizeof(kExampleBlob)),
                   RG_ERR_ARGUMENT);
}

/* The example with other bytes in a half word, and CRCs that hold. */
static rg_status open_with(uint32_t offset, uint16_t value, rg_camera* camera) {
  memcpy(blob, kExampleBlob, SIZE);
  rg_store_u16(blob + offset, value);
  repair_crcs(blob, SIZE);
  return rg_camera_open(camera, blob, SIZE);
}

static void what_rays_need_is_checked(void** state) {
  (void)state;
  rg_camera camera;
  assert_int_equal(open_with(CAMERA - 64, 99, &camera), RG_ERR_SECTION_UNKNOWN);
  assert_int_equal(open_with(GRID + 16, 1028, &camera), RG_ERR_GRID_SIZE);
  assert_int_equal(open_with(GRID + 20, 0, &camera), RG_ERR_GRID_SCALE);
  assert_int_equal(open_with(GRID + 30, 30, &camera), RG_ERR_GRID_CHART);
  assert_int_equal(open_with(GRID + 32, 44, &camera), RG_ERR_SECTION_SIZE);
}

static void inverse_grids_are_narrow(void** state) {
  (void)state;
  rg_camera camera;
  assert_int_equal(rg_camera_open(&camera, kWideBlob, sizeof(kWideBlob)),
                   RG_OK);
  memcpy(blob, kWideBlob, sizeof(kWideBlob));
  rg_store_u16(blob + (camera.inverse - camera.blob) + 30,
               RG_CONTROL_POINT_BITS);
  repair_crcs(blob, sizeof(kWideBlob));
  assert_int_equal(rg_camera_open(&camera, blob, sizeof(kWideBlob)),
                   RG_ERR_GRID_CHART);
}

static void camera_or_grid_missing_is_refused(void** state) {
  (void)state;
  rg_camera camera;
  for (uint32_t k = 0; k < 2; ++k) {
    const blob_section section = section_of(kExampleBlob, k);
    const uint32_t size = assemble_blob(&section, 1, blob);
    assert_int_equal(rg_camera_open(&camera, blob, size),
                     RG_ERR_SECTION_MISSING);
  }
}

static void opening_chooses_no_table(void** state) {
  (void)state;
  rg_camera camera;
  uint16_t width, height;
  rg_camera_open(&camera, kExampleBlob, SIZE);
  assert_int_equal(rg_remap_size(&camera, &width, &height), RG_ERR_NO_REMAP);
}

static void broken_table_is_refused_when_it_is_chosen(void** state) {
  (void)state;
  rg_camera camera;
  assert_int_equal(open_with(REMAP, 17, &camera), RG_OK);
  const rg_camera before = camera;
  assert_int_equal(rg_select_remap(&camera, 0), RG_ERR_REMAP_BLOCK);
  assert_memory_equal(&camera, &before, sizeof(camera));
  assert_int_equal(open_with(REMAP + 8, 11 << 8 | 3, &camera), RG_OK);
  assert_int_equal(rg_select_remap(&camera, 0), RG_ERR_REMAP_SHIFT);
  assert_int_equal(open_with(VERTICES - 42, 0x7000, &camera), RG_OK);
  assert_int_equal(rg_select_remap(&camera, 0),
                   RG_FAST_TRAVERSAL ? RG_ERR_REMAP_VERTEX : RG_OK);
}

static void table_without_room_for_its_view_is_refused(void** state) {
  (void)state;
  static uint8_t views[sizeof(kViewsBlob)] __attribute__((aligned(4)));
  rg_camera camera;
  memcpy(views, kViewsBlob, sizeof(views));
  const uint8_t* const section = rg_find_section(views, RG_SECTION_REMAP, 0);
  assert_true(rg_has_view(section));
  rg_store_u32(views + (section - views) + RG_REMAP_DATA_OFFSET,
               RG_VIEW_FIELDS_SIZE - 4);
  repair_crcs(views, sizeof(views));
  assert_int_equal(rg_camera_open(&camera, views, sizeof(views)), RG_OK);
  assert_int_equal(rg_select_remap(&camera, 0), RG_ERR_DATA_OFFSET);
}

/* A word of the wide blob's section of a type. */
static void open_wide_with(uint32_t type, uint32_t offset, uint32_t value,
                           rg_camera* camera) {
  memcpy(blob, kWideBlob, sizeof(kWideBlob));
  const uint8_t* const section = rg_find_section(blob, type, 0);
  rg_store_u32(blob + (section - blob) + offset, value);
  repair_crcs(blob, sizeof(kWideBlob));
  assert_int_equal(rg_camera_open(camera, blob, sizeof(kWideBlob)), RG_OK);
}

static void mask_and_uncertainty_beyond_their_sections_are_not_read(
    void** state) {
  (void)state;
  const rg_pixel pixel = {RG_PIXEL(80), RG_PIXEL(60)};
  uint16_t sigma_q12;
  rg_camera camera;
  open_wide_with(RG_SECTION_MASK, 0, 0xffffffff, &camera);
  rg_is_valid(&camera, pixel);
  open_wide_with(RG_SECTION_MASK, 8, 0xfffff000, &camera);
  assert_int_equal(rg_is_valid(&camera, pixel), 0);
  open_wide_with(RG_SECTION_UNCERTAINTY, 12, 0xfffff000, &camera);
  assert_int_equal(rg_uncertainty(&camera, pixel, &sigma_q12),
                   RG_ERR_UNCERTAINTY);
  open_wide_with(RG_SECTION_UNCERTAINTY, 12, 17, &camera);
  assert_int_equal(rg_uncertainty(&camera, pixel, &sigma_q12),
                   RG_ERR_UNCERTAINTY);
}

/* Boards skip it, whatever its values, but not its CRC. */
static void captures_are_skipped(void** state) {
  (void)state;
  rg_camera camera;
  memcpy(blob, kCaptureBlob, sizeof(kCaptureBlob));
  uint8_t* const section =
      blob + (rg_find_section(blob, RG_SECTION_CAPTURE, 0) - blob);
  memset(section, 0xff, RG_CAPTURE_SIZE);
  assert_int_equal(rg_camera_open(&camera, blob, sizeof(kCaptureBlob)),
                   RG_ERR_SECTION_CRC);
  repair_crcs(blob, sizeof(kCaptureBlob));
  assert_int_equal(rg_camera_open(&camera, blob, sizeof(kCaptureBlob)), RG_OK);
  rg_blob whole;
  assert_int_equal(rg_blob_open(blob, sizeof(kCaptureBlob), &whole),
                   RG_ERR_RESERVED);
}

static void row_time_is_that_of_the_blob(void** state) {
  (void)state;
  rg_camera camera;
  int32_t line_delay_ns_q10 = 1;
  uint32_t std_dev_ns_q10 = 1;
  memcpy(blob, kRowTimeBlob, sizeof(kRowTimeBlob));
  assert_int_equal(rg_camera_open(&camera, blob, sizeof(kRowTimeBlob)), RG_OK);
  assert_int_equal(rg_line_delay(&camera, &line_delay_ns_q10, &std_dev_ns_q10),
                   RG_OK);
  assert_int_equal(line_delay_ns_q10, -20000 * 1024);
  assert_int_equal(std_dev_ns_q10, 31 * 1024);
  line_delay_ns_q10 = 1;
  assert_int_equal(rg_line_delay(&camera, &line_delay_ns_q10, NULL), RG_OK);
  assert_int_equal(line_delay_ns_q10, -20000 * 1024);
  assert_int_equal(rg_camera_open(&camera, kWideBlob, sizeof(kWideBlob)),
                   RG_OK);
  assert_int_equal(rg_line_delay(&camera, &line_delay_ns_q10, &std_dev_ns_q10),
                   RG_ERR_UNKNOWN);
  assert_int_equal(line_delay_ns_q10, -20000 * 1024);
}

/* Opening skips the section, and its limits are checked on use. */
static void row_time_beyond_its_limits_is_not_told(void** state) {
  (void)state;
  rg_camera camera;
  int32_t line_delay_ns_q10 = 1;
  memcpy(blob, kRowTimeBlob, sizeof(kRowTimeBlob));
  uint8_t* const section =
      blob + (rg_find_section(blob, RG_SECTION_ROW_TIME, 0) - blob);
  rg_store_u32(section, 0x80000000);
  repair_crcs(blob, sizeof(kRowTimeBlob));
  assert_int_equal(rg_camera_open(&camera, blob, sizeof(kRowTimeBlob)), RG_OK);
  assert_int_equal(rg_line_delay(&camera, &line_delay_ns_q10, NULL),
                   RG_ERR_ROW_TIME);
  rg_store_u32(section, 0);
  rg_store_u32(section + 4, (1u << 30) + 1);
  repair_crcs(blob, sizeof(kRowTimeBlob));
  assert_int_equal(rg_camera_open(&camera, blob, sizeof(kRowTimeBlob)), RG_OK);
  assert_int_equal(rg_line_delay(&camera, &line_delay_ns_q10, NULL),
                   RG_ERR_ROW_TIME);
  assert_int_equal(line_delay_ns_q10, 1);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(handle_is_at_most_64_bytes),
      cmocka_unit_test(camera_is_opened),
      cmocka_unit_test(damaged_blob_leaves_the_camera_untouched),
      cmocka_unit_test(null_is_refused),
      cmocka_unit_test(what_rays_need_is_checked),
      cmocka_unit_test(inverse_grids_are_narrow),
      cmocka_unit_test(camera_or_grid_missing_is_refused),
      cmocka_unit_test(opening_chooses_no_table),
      cmocka_unit_test(broken_table_is_refused_when_it_is_chosen),
      cmocka_unit_test(table_without_room_for_its_view_is_refused),
      cmocka_unit_test(mask_and_uncertainty_beyond_their_sections_are_not_read),
      cmocka_unit_test(captures_are_skipped),
      cmocka_unit_test(row_time_is_that_of_the_blob),
      cmocka_unit_test(row_time_beyond_its_limits_is_not_told),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
