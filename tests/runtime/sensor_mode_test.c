#include "golden_blobs.h"
#include "raygrid.h"
#include "test_frame.h"
#include "unit_test.h"

static rg_camera lens; /* 160 x 120, serial "L-150/7" */

static int open_lens(void** state) {
  (void)state;
  return rg_camera_open(&lens, kLensBlob, sizeof(kLensBlob)) == RG_OK ? 0 : -1;
}

static rg_mode make_mode(uint32_t width, uint32_t height, int32_t x, int32_t y,
                         uint32_t scale_q16) {
  const rg_mode mode = {
      (uint16_t)width, (uint16_t)height, RG_PIXEL(x), RG_PIXEL(y),
      scale_q16,       scale_q16,        0,           0};
  return mode;
}

static void check_position(const rg_mode* mode, int32_t x_q16, int32_t y_q16,
                           int32_t expected_x_q16, int32_t expected_y_q16) {
  const rg_pixel pixel = {x_q16, y_q16};
  rg_pixel calibrated, back;
  assert_int_equal(rg_mode_to_calibrated(mode, pixel, &calibrated), RG_OK);
  assert_int_equal(calibrated.x_q16, expected_x_q16);
  assert_int_equal(calibrated.y_q16, expected_y_q16);
  assert_int_equal(rg_mode_from_calibrated(mode, calibrated, &back), RG_OK);
  assert_in_range(back.x_q16 - x_q16 + 1, 0, 2);
  assert_in_range(back.y_q16 - y_q16 + 1, 0, 2);
}

static void crops_move_pixels(void** state) {
  (void)state;
  const rg_mode mode = make_mode(80, 60, 40, 30, 65536);
  check_position(&mode, 0, 0, RG_PIXEL(40), RG_PIXEL(30));
  check_position(&mode, 12345, -4321, RG_PIXEL(40) + 12345,
                 RG_PIXEL(30) - 4321);
}

/* The centre of a binned pixel is the corner of four. */
static void binning_keeps_edges_in_place(void** state) {
  (void)state;
  const rg_mode mode = make_mode(80, 60, 0, 0, 2 << 16);
  check_position(&mode, 0, 0, 0x8000, 0x8000);
  check_position(&mode, -0x8000, -0x8000, -0x8000, -0x8000);
  check_position(&mode, RG_PIXEL(79) + 0x8000, RG_PIXEL(59) + 0x8000,
                 RG_PIXEL(159) + 0x8000, RG_PIXEL(119) + 0x8000);
}

static void flips_count_from_the_other_side(void** state) {
  (void)state;
  rg_mode mode = make_mode(160, 120, 0, 0, 65536);
  mode.flip_x = 1;
  check_position(&mode, 0, 0, RG_PIXEL(159), 0);
  mode.flip_y = 1;
  check_position(&mode, RG_PIXEL(100), RG_PIXEL(7), RG_PIXEL(59),
                 RG_PIXEL(112));
}

static int32_t distance(int32_t a, int32_t b) { return a > b ? a - b : b - a; }

static void positions_come_back_within_their_error(void** state) {
  (void)state;
  uint32_t random = 9;
  for (int i = 0; i < 5000; ++i) {
    rg_mode mode = make_mode(4000, 3000, (int32_t)(next_random(&random) >> 21),
                             (int32_t)(next_random(&random) >> 21), 65536);
    mode.scale_x_q16 = 0x8000 + (next_random(&random) >> 14);
    mode.scale_y_q16 = 0x8000 + (next_random(&random) >> 14);
    mode.flip_x = i & 1;
    mode.flip_y = (i >> 1) & 1;
    const rg_pixel pixel = {(int32_t)(next_random(&random) >> 4),
                            (int32_t)(next_random(&random) >> 5)};
    rg_pixel calibrated, back;
    if (rg_mode_to_calibrated(&mode, pixel, &calibrated) != RG_OK) continue;
    if (rg_mode_from_calibrated(&mode, calibrated, &back) != RG_OK) continue;
    assert_in_range(distance(pixel.x_q16, back.x_q16), 0, 6);
    assert_in_range(distance(pixel.y_q16, back.y_q16), 0, 6);
  }
}

static void impossible_modes_are_refused(void** state) {
  (void)state;
  const rg_pixel pixel = {0, 0}, far_away = {INT32_MAX, INT32_MIN};
  rg_pixel result = {3, 4};
  rg_mode mode = make_mode(80, 60, 0, 0, 65536);
  assert_int_equal(rg_mode_to_calibrated(&mode, far_away, &result),
                   RG_ERR_ARGUMENT);
  assert_int_equal(rg_mode_from_calibrated(&mode, far_away, &result),
                   RG_ERR_ARGUMENT);
  mode.scale_y_q16 = 0;
  assert_int_equal(rg_mode_to_calibrated(&mode, pixel, &result),
                   RG_ERR_ARGUMENT);
  mode = make_mode(0, 60, 0, 0, 65536);
  assert_int_equal(rg_mode_from_calibrated(&mode, pixel, &result),
                   RG_ERR_ARGUMENT);
  mode = make_mode(80, 60, 0, 0, 65 << 16);
  assert_int_equal(rg_mode_to_calibrated(&mode, pixel, &result),
                   RG_ERR_ARGUMENT);
  /* Half the way from the limit, twice as far, and all the way again. */
  mode = make_mode(80, 60, 0, 0, 2 << 16);
  mode.offset_x_q16 = -(1 << 30) + 1;
  const rg_pixel before = {-(1 << 29) - 32768, 0};
  assert_int_equal(rg_mode_to_calibrated(&mode, before, &result),
                   RG_ERR_ARGUMENT);
  assert_true(result.x_q16 == 3 && result.y_q16 == 4);
}

static void frames_as_calibrated_match(void** state) {
  (void)state;
  const rg_mode same = make_mode(160, 120, 0, 0, 65536);
  assert_int_equal(rg_match(&lens, NULL, 160, 120, NULL, NULL), RG_MATCH_EXACT);
  assert_int_equal(rg_match(&lens, &same, 160, 120, "L-150/7", NULL),
                   RG_MATCH_EXACT);
}

static void parts_of_the_calibrated_frames_are_derivable(void** state) {
  (void)state;
  const rg_mode binned = make_mode(80, 60, 0, 0, 2 << 16);
  const rg_mode crop = make_mode(60, 40, 100, 80, 65536);
  rg_mode mirrored = make_mode(160, 120, 0, 0, 65536);
  mirrored.flip_x = 1;
  assert_int_equal(rg_match(&lens, &binned, 80, 60, NULL, NULL),
                   RG_MATCH_DERIVABLE);
  assert_int_equal(rg_match(&lens, &crop, 60, 40, NULL, NULL),
                   RG_MATCH_DERIVABLE);
  assert_int_equal(rg_match(&lens, &mirrored, 160, 120, NULL, NULL),
                   RG_MATCH_DERIVABLE);
}

/* No scale is exactly 160 / 107, and most are not. */
static void scales_may_be_rounded_up(void** state) {
  (void)state;
  for (uint32_t width = 3; width <= 160; ++width) {
    const uint32_t scale = ((160u << 17) / width + 1) / 2;
    rg_mode mode = make_mode((uint16_t)width, 60, 0, 0, scale);
    mode.scale_y_q16 = 2 << 16;
    assert_true(rg_match(&lens, &mode, (uint16_t)width, 60, NULL, NULL) !=
                RG_MATCH_NONE);
    mode.scale_x_q16 = scale + 2;
    assert_int_equal(rg_match(&lens, &mode, (uint16_t)width, 60, NULL, NULL),
                     RG_MATCH_NONE);
  }
}

static void anything_else_is_a_mismatch(void** state) {
  (void)state;
  const rg_mode binned = make_mode(80, 60, 0, 0, 2 << 16);
  const rg_mode beyond = make_mode(61, 40, 100, 80, 65536);
  const rg_mode before = make_mode(60, 40, -1, 0, 65536);
  assert_int_equal(rg_match(&lens, NULL, 80, 60, NULL, NULL), RG_MATCH_NONE);
  assert_int_equal(rg_match(&lens, NULL, 120, 160, NULL, NULL), RG_MATCH_NONE);
  assert_int_equal(rg_match(&lens, &binned, 160, 120, NULL, NULL),
                   RG_MATCH_NONE);
  assert_int_equal(rg_match(&lens, &beyond, 61, 40, NULL, NULL), RG_MATCH_NONE);
  assert_int_equal(rg_match(&lens, &before, 60, 40, NULL, NULL), RG_MATCH_NONE);
}

static void another_serial_is_a_mismatch(void** state) {
  (void)state;
  rg_camera anonymous;
  assert_int_equal(rg_match(&lens, NULL, 160, 120, "L-150/8", NULL),
                   RG_MATCH_NONE);
  assert_int_equal(rg_match(&lens, NULL, 160, 120, "L-150/", NULL),
                   RG_MATCH_NONE);
  assert_int_equal(rg_match(&lens, NULL, 160, 120, "L-150/77", NULL),
                   RG_MATCH_NONE);
  assert_int_equal(rg_match(&lens, NULL, 160, 120, "", NULL), RG_MATCH_NONE);
  assert_int_equal(rg_camera_open(&anonymous, kWideBlob, sizeof(kWideBlob)),
                   RG_OK);
  assert_int_equal(rg_match(&anonymous, NULL, 320, 240, "any", NULL),
                   RG_MATCH_EXACT);
}

/* kModesBlob: a crop, binning that is mirrored, a scaled crop upside down, and
 * a table that distorts. */
static rg_mode mode_of_table(uint32_t index) {
  rg_camera modes;
  rg_mode mode;
  assert_int_equal(rg_camera_open(&modes, kModesBlob, sizeof(kModesBlob)),
                   RG_OK);
  assert_int_equal(rg_remap_mode(&modes, &mode), RG_ERR_NO_REMAP);
  assert_int_equal(rg_select_remap(&modes, index), RG_OK);
  assert_int_equal(rg_remap_mode(&modes, &mode), RG_OK);
  return mode;
}

static void tables_tell_their_modes(void** state) {
  (void)state;
  const rg_mode crop = mode_of_table(0), binned = mode_of_table(1);
  const rg_mode calibrated = mode_of_table(3);
  assert_true(crop.width == 120 && crop.height == 100);
  assert_true(crop.offset_x_q16 == RG_PIXEL(90) &&
              crop.offset_y_q16 == RG_PIXEL(60));
  assert_true(binned.scale_x_q16 == 2 << 16 && binned.flip_x == 1 &&
              binned.flip_y == 0);
  assert_true(calibrated.width == 320 && calibrated.scale_y_q16 == 65536);
}

/* Whether and by which table kModesBlob serves frames of a mode. */
static rg_match_result match_mode(const rg_mode* mode, uint32_t* table) {
  rg_camera modes;
  assert_int_equal(rg_camera_open(&modes, kModesBlob, sizeof(kModesBlob)),
                   RG_OK);
  return rg_match(&modes, mode, mode->width, mode->height, NULL, table);
}

static void modes_find_their_tables(void** state) {
  (void)state;
  for (uint32_t k = 0; k < 3; ++k) {
    uint32_t table = 77;
    rg_mode mode = mode_of_table(k);
    assert_int_equal(match_mode(&mode, &table), RG_MATCH_MODE);
    assert_int_equal(table, k);
    --mode.scale_x_q16; /* rounded otherwise */
    assert_int_equal(match_mode(&mode, &table), RG_MATCH_MODE);
    --mode.scale_x_q16;
    assert_int_equal(match_mode(&mode, &table), RG_MATCH_DERIVABLE);
    assert_int_equal(table, RG_NO_TABLE);
  }
  uint32_t table = 77;
  rg_mode mode = mode_of_table(2);
  mode.offset_y_q16 += 2;
  assert_int_equal(match_mode(&mode, &table), RG_MATCH_DERIVABLE);
  --mode.offset_y_q16;
  assert_int_equal(match_mode(&mode, &table), RG_MATCH_MODE);
  mode.flip_y = 0;
  assert_int_equal(match_mode(&mode, &table), RG_MATCH_DERIVABLE);
}

/* That table takes the view, not frames. */
static void tables_that_distort_serve_no_frames(void** state) {
  (void)state;
  uint32_t table = 77;
  const rg_mode calibrated = mode_of_table(3);
  assert_int_equal(match_mode(&calibrated, &table), RG_MATCH_EXACT);
  assert_int_equal(table, RG_NO_TABLE);
  assert_int_equal(rg_match(&lens, NULL, 160, 120, NULL, &table),
                   RG_MATCH_EXACT);
  assert_int_equal(table, 0);
  assert_int_equal(rg_match(&lens, NULL, 160, 120, "other", &table),
                   RG_MATCH_NONE);
  assert_int_equal(table, RG_NO_TABLE);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(crops_move_pixels),
      cmocka_unit_test(binning_keeps_edges_in_place),
      cmocka_unit_test(flips_count_from_the_other_side),
      cmocka_unit_test(positions_come_back_within_their_error),
      cmocka_unit_test(impossible_modes_are_refused),
      cmocka_unit_test(frames_as_calibrated_match),
      cmocka_unit_test(parts_of_the_calibrated_frames_are_derivable),
      cmocka_unit_test(scales_may_be_rounded_up),
      cmocka_unit_test(anything_else_is_a_mismatch),
      cmocka_unit_test(another_serial_is_a_mismatch),
      cmocka_unit_test(tables_tell_their_modes),
      cmocka_unit_test(modes_find_their_tables),
      cmocka_unit_test(tables_that_distort_serve_no_frames),
  };
  return cmocka_run_group_tests(tests, open_lens, NULL);
}
