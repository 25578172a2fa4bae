#include <string.h>

#include "blob_edit.h"
#include "bytes.h"
#include "crc32.h"
#include "golden_blobs.h"
#include "raygrid.h"
#include "unit_test.h"

#define NUM_GOLDEN (sizeof(kLensRays) / sizeof(kLensRays[0]))
#define MAX_ERROR_Q16 40 /* 0.0006 px, at 89 degrees too */

static rg_camera lens;
static rg_pixel pixels[NUM_GOLDEN], undistorted[NUM_GOLDEN];

static int open_lens(void** state) {
  (void)state;
  for (size_t i = 0; i < NUM_GOLDEN; ++i) {
    pixels[i].x_q16 = kLensRays[i].x;
    pixels[i].y_q16 = kLensRays[i].y;
  }
  return rg_camera_open(&lens, kLensBlob, sizeof(kLensBlob)) == RG_OK &&
                 rg_select_remap(&lens, 0) == RG_OK
             ? 0
             : -1;
}

static int32_t distance(int32_t a, int32_t b) { return a > b ? a - b : b - a; }

static void points_are_the_golden_ones(void** state) {
  (void)state;
  int32_t worst = 0;
  for (size_t i = 0; i < NUM_GOLDEN; ++i) {
    const int32_t* expected = kLensUndistorted[i];
    rg_pixel point = {5, 6};
    const rg_status status = rg_undistort_point(&lens, pixels[i], &point);
    if (expected[0] == INT32_MIN) {
      assert_int_equal(status, RG_ERR_NOT_SEEN);
      assert_true(point.x_q16 == 5 && point.y_q16 == 6);
      continue;
    }
    assert_int_equal(status, RG_OK);
    const int32_t x = distance(point.x_q16, expected[0]);
    const int32_t y = distance(point.y_q16, expected[1]);
    if (x > worst) worst = x;
    if (y > worst) worst = y;
  }
  print_message("worst error %d q16\n", (int)worst);
  assert_in_range(worst, 0, MAX_ERROR_Q16);
}

static void points_outside_the_area_are_refused(void** state) {
  (void)state;
  const rg_pixel outside = {RG_PIXEL(-3), RG_PIXEL(20)};
  rg_pixel point;
  assert_int_equal(rg_undistort_point(&lens, outside, &point),
                   RG_ERR_OUTSIDE_AREA);
}

static void batch_equals_single_calls(void** state) {
  (void)state;
  const uint32_t num_seen =
      rg_undistort_points(&lens, pixels, undistorted, NUM_GOLDEN);
  uint32_t num_singles = 0, crc = 0;
  for (size_t i = 0; i < NUM_GOLDEN; ++i) {
    rg_pixel point = {RG_NO_PIXEL, RG_NO_PIXEL};
    num_singles += rg_undistort_point(&lens, pixels[i], &point) == RG_OK;
    assert_memory_equal(&point, &undistorted[i], sizeof(point));
    uint8_t bytes[8];
    rg_store_i32(bytes, point.x_q16);
    rg_store_i32(bytes + 4, point.y_q16);
    crc = rg_crc32(crc, bytes, sizeof(bytes));
  }
  assert_int_equal(num_seen, num_singles);
  assert_int_equal(crc, 0xa2a642a0); /* on every target */
}

static uint8_t edited[sizeof(kLensBlob)] __attribute__((aligned(4)));

/* The lens with another number in a field of its table. */
static void open_with_field(uint32_t offset, uint32_t value,
                            rg_camera* camera) {
  memcpy(edited, kLensBlob, sizeof(edited));
  const blob_section remap = section_of(kLensBlob, 2);
  rg_store_u32(edited + (remap.bytes - kLensBlob) + offset, value);
  repair_crcs(edited, sizeof(edited));
  assert_int_equal(rg_camera_open(camera, edited, sizeof(edited)), RG_OK);
  assert_int_equal(rg_select_remap(camera, 0), RG_OK);
}

static void any_virtual_camera_is_safe(void** state) {
  (void)state;
  const uint32_t offsets[4] = {52, 56, 60, 64};
  const uint32_t values[5] = {1, 0x3fffffff, 0x7fffffff, 0x80000000,
                              0xffffffff};
  rg_camera camera;
  for (int k = 0; k < 4; ++k) {
    for (int v = 0; v < 5; ++v) {
      open_with_field(offsets[k], values[v], &camera);
      rg_undistort_points(&camera, pixels, undistorted, NUM_GOLDEN);
      for (size_t i = 0; i < NUM_GOLDEN; ++i)
        assert_true(undistorted[i].x_q16 == RG_NO_PIXEL ||
                    (undistorted[i].x_q16 > -(1 << 30) &&
                     undistorted[i].x_q16 < 1 << 30));
    }
  }
}

static void camera_without_a_table_says_so(void** state) {
  (void)state;
  rg_camera camera;
  assert_int_equal(rg_camera_open(&camera, kWideBlob, sizeof(kWideBlob)),
                   RG_OK);
  assert_int_equal(rg_undistort_point(&camera, pixels[0], &undistorted[0]),
                   RG_ERR_NO_REMAP);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(points_are_the_golden_ones),
      cmocka_unit_test(points_outside_the_area_are_refused),
      cmocka_unit_test(batch_equals_single_calls),
      cmocka_unit_test(any_virtual_camera_is_safe),
      cmocka_unit_test(camera_without_a_table_says_so),
  };
  return cmocka_run_group_tests(tests, open_lens, NULL);
}
