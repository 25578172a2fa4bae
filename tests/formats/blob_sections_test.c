/* Sections hold what they should, and may stand in any order. */
#include <string.h>

#include "blob_edit.h"
#include "bytes.h"
#include "example_blob.h"
#include "rg_blob.h"
#include "unit_test.h"

static uint8_t edited[2048] __attribute__((aligned(16)));

static void golden_blobs_open(void** state) {
  (void)state;
  rg_blob blob;
  assert_int_equal(rg_blob_open(kExampleBlob, SIZE, &blob), RG_OK);
  assert_ptr_equal(blob.bytes, kExampleBlob);
  assert_int_equal(blob.size, SIZE);
  assert_int_equal(blob.camera, CAMERA);
  assert_int_equal(blob.grid, GRID);
  assert_int_equal(blob.remap, REMAP);
  assert_int_equal(blob.quality, QUALITY);
  assert_int_equal(rg_blob_open(kLensBlob, sizeof(kLensBlob), &blob), RG_OK);
}

static void camera_is_read(void** state) {
  (void)state;
  rg_blob blob;
  rg_camera_section camera;
  assert_int_equal(rg_blob_open(kLensBlob, sizeof(kLensBlob), &blob), RG_OK);
  rg_blob_camera(&blob, &camera);
  assert_int_equal(camera.width, 160);
  assert_int_equal(camera.height, 120);
  assert_string_equal(camera.name, "Weitwinkel \xc3\x9f");
  assert_string_equal(camera.serial, "L-150/7");
}

static void grid_is_read(void** state) {
  (void)state;
  rg_blob blob;
  rg_grid_section grid;
  assert_int_equal(rg_blob_open(kLensBlob, sizeof(kLensBlob), &blob), RG_OK);
  rg_blob_grid(&blob, &grid);
  assert_int_equal(grid.x0_q16, 163840);
  assert_int_equal(grid.y0_q16, 81920);
  assert_int_equal(grid.x1_q16, 10289152);
  assert_int_equal(grid.y1_q16, 7766016);
  assert_int_equal(grid.columns, 9);
  assert_int_equal(grid.rows, 8);
  assert_int_equal(grid.scale_x_q32, 166794846);
  assert_int_equal(grid.scale_y_q32, 183154255);
  assert_ptr_equal(grid.control_points, kLensBlob + blob.grid + 40);
}

static void remap_is_read(void** state) {
  (void)state;
  rg_remap_section remap;
  rg_read_remap(kExampleBlob + REMAP, &remap);
  assert_int_equal(remap.width, 16);
  assert_int_equal(remap.height, 8);
  assert_int_equal(remap.columns, 3);
  assert_int_equal(remap.rows, 2);
  assert_int_equal(remap.block_log2, 3);
  assert_int_equal(remap.residual_shift, 0);
  assert_int_equal(remap.max_x_q12, 63 * 4096);
  assert_int_equal(remap.max_y_q12, 47 * 4096);
  assert_int_equal(remap.fx_q16, 28 * 65536);
  assert_int_equal(remap.fy_q16, 28 * 65536);
  assert_int_equal(remap.cx_q16, 15 * 32768);
  assert_int_equal(remap.cy_q16, 7 * 32768);
  assert_int_equal(remap.bound_upx, 100000);
  assert_ptr_equal(remap.vertices, kExampleBlob + VERTICES);
  assert_ptr_equal(remap.empty_blocks, kExampleBlob + MASK);
}

/* Each field of 4 bytes gets a value of its own. */
static void remap_fields_are_not_confused(void** state) {
  (void)state;
  memcpy(edited, kExampleBlob, SIZE);
  for (uint32_t i = 12; i < 76; i += 4) rg_store_u32(edited + REMAP + i, i);
  rg_remap_section remap;
  rg_read_remap(edited + REMAP, &remap);
  const uint32_t fields[16] = {(uint32_t)remap.min_x_q12,
                               (uint32_t)remap.min_y_q12,
                               (uint32_t)remap.max_x_q12,
                               (uint32_t)remap.max_y_q12,
                               (uint32_t)remap.origin_x_q12,
                               (uint32_t)remap.origin_y_q12,
                               (uint32_t)remap.column_step_x_q12,
                               (uint32_t)remap.column_step_y_q12,
                               (uint32_t)remap.row_step_x_q12,
                               (uint32_t)remap.row_step_y_q12,
                               remap.fx_q16,
                               remap.fy_q16,
                               (uint32_t)remap.cx_q16,
                               (uint32_t)remap.cy_q16,
                               remap.bound_upx,
                               remap.max_error_upx};
  for (uint32_t i = 0; i < 16; ++i) assert_int_equal(fields[i], 12 + 4 * i);
}

static void quality_is_read(void** state) {
  (void)state;
  rg_blob blob;
  rg_quality_section quality;
  assert_int_equal(rg_blob_open(kLensBlob, sizeof(kLensBlob), &blob), RG_OK);
  rg_blob_quality(&blob, &quality);
  assert_int_equal(quality.training_median_upx, 31000);
  assert_int_equal(quality.training_rms_upx, 42000);
  assert_int_equal(quality.training_max_upx, 350000);
  assert_int_equal(quality.training_count, 12345);
  assert_int_equal(quality.held_out_median_upx, 33000);
  assert_int_equal(quality.held_out_rms_upx, 45000);
  assert_int_equal(quality.held_out_max_upx, 410000);
  assert_int_equal(quality.held_out_count, 6789);
  assert_int_equal(quality.packing_error_npx, 1729);
  assert_int_equal(quality.packing_error_prad, 21835);
}

/* The sections of kExampleBlob, and one that no version knows. */
static uint32_t take_sections(blob_section sections[5]) {
  static const uint8_t unknown[4] = {1, 2, 3, 4};
  for (uint32_t k = 0; k < 4; ++k) sections[k] = section_of(kExampleBlob, k);
  const blob_section last = {99, 0, unknown, sizeof(unknown)};
  sections[4] = last;
  return 5;
}

static void sections_put_together_give_the_example(void** state) {
  (void)state;
  blob_section sections[5];
  take_sections(sections);
  assert_int_equal(assemble_blob(sections, 4, edited), SIZE);
  assert_memory_equal(edited, kExampleBlob, SIZE);
}

static void unknown_optional_section_is_skipped(void** state) {
  (void)state;
  blob_section sections[5];
  const uint32_t count = take_sections(sections);
  assert_int_equal(open_copy(edited, assemble_blob(sections, count, edited)),
                   RG_OK);
}

static void unknown_critical_section_is_refused(void** state) {
  (void)state;
  blob_section sections[5];
  const uint32_t count = take_sections(sections);
  sections[4].flags = RG_SECTION_CRITICAL;
  assert_int_equal(open_copy(edited, assemble_blob(sections, count, edited)),
                   RG_ERR_SECTION_UNKNOWN);
}

static void unknown_flag_of_an_unknown_section_is_refused(void** state) {
  (void)state;
  blob_section sections[5];
  const uint32_t count = take_sections(sections);
  sections[4].flags = 2;
  assert_int_equal(open_copy(edited, assemble_blob(sections, count, edited)),
                   RG_ERR_SECTION_FLAGS);
}

static void empty_section_is_refused(void** state) {
  (void)state;
  blob_section sections[5];
  const uint32_t count = take_sections(sections);
  sections[4].size = 0;
  assert_int_equal(open_copy(edited, assemble_blob(sections, count, edited)),
                   RG_ERR_SECTION_TABLE);
}

static void sections_may_stand_in_any_order(void** state) {
  (void)state;
  blob_section sections[5], reversed[5];
  const uint32_t count = take_sections(sections);
  for (uint32_t k = 0; k < count; ++k) reversed[k] = sections[count - 1 - k];
  const uint32_t size = assemble_blob(reversed, count, edited);
  rg_blob blob;
  assert_int_equal(rg_blob_open(edited, size, &blob), RG_OK);
  assert_memory_equal(edited + blob.camera, kExampleBlob + CAMERA, 72);
  assert_memory_equal(edited + blob.quality, kExampleBlob + QUALITY, 40);
}

/* The grid's area is checked by a width that is not. */
static void wrong_width_behind_the_grid_is_refused(void** state) {
  (void)state;
  static const uint8_t widths[][2] = {
      {1, 0x40}, {0, 0x80}, {1, 0x80}, {0xff, 0xff}};
  blob_section sections[5];
  take_sections(sections);
  const blob_section grid_first[2] = {sections[1], sections[0]};
  for (uint32_t k = 0; k < 4; ++k) {
    const uint32_t size = assemble_blob(grid_first, 2, edited);
    memcpy(edited + size - sections[0].size, widths[k], 2);
    repair_crcs(edited, size);
    assert_int_equal(open_copy(edited, size), RG_ERR_IMAGE_SIZE);
  }
}

static void first_of_two_remaps_is_used(void** state) {
  (void)state;
  blob_section sections[5];
  const uint32_t count = take_sections(sections);
  sections[4] = sections[2];
  const uint32_t size = assemble_blob(sections, count, edited);
  rg_blob blob;
  assert_int_equal(rg_blob_open(edited, size, &blob), RG_OK);
  assert_int_equal(blob.remap, REMAP + RG_SECTION_ENTRY_SIZE);
}

static void fault_in_the_second_remap_is_refused(void** state) {
  (void)state;
  static uint8_t second[108];
  blob_section sections[5];
  const uint32_t count = take_sections(sections);
  assert_int_equal(sections[2].size, sizeof(second));
  memcpy(second, sections[2].bytes, sizeof(second));
  second[9] = 11;
  sections[4] = sections[2];
  sections[4].bytes = second;
  assert_int_equal(open_copy(edited, assemble_blob(sections, count, edited)),
                   RG_ERR_REMAP_SHIFT);
}

static void camera_and_grid_suffice(void** state) {
  (void)state;
  blob_section sections[5];
  take_sections(sections);
  const uint32_t size = assemble_blob(sections, 2, edited);
  rg_blob blob;
  assert_int_equal(rg_blob_open(edited, size, &blob), RG_OK);
  assert_int_equal(blob.remap, 0);
  assert_int_equal(blob.quality, 0);
}

/* The section stands last, so that reading on would leave the blob. */
static rg_status open_with_short_section(uint32_t k, uint32_t size) {
  blob_section sections[5];
  take_sections(sections);
  const blob_section last = sections[3];
  sections[3] = sections[k];
  if (k != 3) sections[k] = last;
  sections[3].size = size;
  return open_copy(edited, assemble_blob(sections, 4, edited));
}

static void section_shorter_than_its_fields_is_refused(void** state) {
  (void)state;
  const uint32_t fields_size[4] = {72, 40, 80, 40};
  for (uint32_t k = 0; k < 4; ++k)
    for (uint32_t size = 4; size < fields_size[k]; size += 4)
      assert_int_equal(open_with_short_section(k, size), RG_ERR_SECTION_SIZE);
}

/* Sections of a later minor version: 8 bytes more of fields. */
static uint32_t assemble_longer_sections(void) {
  static uint8_t longer[4][192];
  const uint32_t fields_size[4] = {72, 40, 80, 40};
  blob_section sections[5];
  take_sections(sections);
  for (uint32_t k = 0; k < 4; ++k) {
    const uint32_t n = fields_size[k];
    memcpy(longer[k], sections[k].bytes, n);
    memset(longer[k] + n, 0xee, 8);
    memcpy(longer[k] + n + 8, sections[k].bytes + n, sections[k].size - n);
    sections[k].bytes = longer[k];
    sections[k].size += 8;
  }
  rg_store_u32(longer[1] + 32, 48);
  rg_store_u32(longer[2] + 76, 88);
  return assemble_blob(sections, 4, edited);
}

static void longer_sections_are_read(void** state) {
  (void)state;
  const uint32_t size = assemble_longer_sections();
  rg_blob blob;
  assert_int_equal(rg_blob_open(edited, size, &blob), RG_OK);
  rg_grid_section grid;
  rg_blob_grid(&blob, &grid);
  assert_memory_equal(grid.control_points, kExampleBlob + CONTROL_POINTS, 128);
  rg_remap_section remap;
  rg_read_remap(edited + blob.remap, &remap);
  assert_memory_equal(remap.vertices, kExampleBlob + VERTICES, 24);
}

static void array_with_bytes_left_over_is_refused(void** state) {
  (void)state;
  static uint8_t longer[2][192];
  blob_section sections[5];
  for (uint32_t k = 1; k <= 2; ++k) {
    take_sections(sections);
    memcpy(longer[k - 1], sections[k].bytes, sections[k].size);
    sections[k].bytes = longer[k - 1];
    sections[k].size += 4;
    assert_int_equal(open_copy(edited, assemble_blob(sections, 4, edited)),
                     RG_ERR_SECTION_SIZE);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(golden_blobs_open),
      cmocka_unit_test(camera_is_read),
      cmocka_unit_test(grid_is_read),
      cmocka_unit_test(remap_is_read),
      cmocka_unit_test(remap_fields_are_not_confused),
      cmocka_unit_test(quality_is_read),
      cmocka_unit_test(sections_put_together_give_the_example),
      cmocka_unit_test(unknown_optional_section_is_skipped),
      cmocka_unit_test(unknown_critical_section_is_refused),
      cmocka_unit_test(unknown_flag_of_an_unknown_section_is_refused),
      cmocka_unit_test(empty_section_is_refused),
      cmocka_unit_test(sections_may_stand_in_any_order),
      cmocka_unit_test(wrong_width_behind_the_grid_is_refused),
      cmocka_unit_test(first_of_two_remaps_is_used),
      cmocka_unit_test(fault_in_the_second_remap_is_refused),
      cmocka_unit_test(camera_and_grid_suffice),
      cmocka_unit_test(section_shorter_than_its_fields_is_refused),
      cmocka_unit_test(longer_sections_are_read),
      cmocka_unit_test(array_with_bytes_left_over_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
