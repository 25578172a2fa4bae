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
    uint8_t bytes[8] __attribute__((aligned(4)));
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

#define NUM_VIEWS (sizeof(kViewsUndistorted) / sizeof(kViewsUndistorted[0]))
#define NUM_VIEW_PIXELS (sizeof(kViewsRays) / sizeof(kViewsRays[0]))

static rg_pixel view_pixel(size_t i) {
  const rg_pixel pixel = {kViewsRays[i].x, kViewsRays[i].y};
  return pixel;
}

/* Rounding shows beyond 85 degrees from a pinhole's axis, or above and
 * below a cylinder. */
static int is_far_off(size_t view, size_t i) {
  const int32_t* const expected = kViewsUndistorted[view][i];
  const int32_t limit = view == RG_PROJECTION_PINHOLE       ? RG_PIXEL(240)
                        : view == RG_PROJECTION_CYLINDRICAL ? RG_PIXEL(145)
                                                            : RG_PIXEL(2000);
  return distance(expected[0], 0) > limit || distance(expected[1], 0) > limit;
}

static void points_of_every_view_are_the_golden_ones(void** state) {
  (void)state;
  uint32_t crc = 0;
  rg_camera views;
  assert_int_equal(rg_camera_open(&views, kViewsBlob, sizeof(kViewsBlob)),
                   RG_OK);
  for (size_t view = 0; view < NUM_VIEWS; ++view) {
    assert_int_equal(rg_select_remap(&views, (uint32_t)view), RG_OK);
    int32_t worst = 0;
    for (size_t i = 0; i < NUM_VIEW_PIXELS; ++i) {
      const int32_t* const expected = kViewsUndistorted[view][i];
      rg_pixel point = {RG_NO_PIXEL, RG_NO_PIXEL};
      const rg_status status =
          rg_undistort_point(&views, view_pixel(i), &point);
      assert_int_equal(status,
                       expected[0] == INT32_MIN ? RG_ERR_NOT_SEEN : RG_OK);
      uint8_t bytes[8] __attribute__((aligned(4)));
      rg_store_i32(bytes, point.x_q16);
      rg_store_i32(bytes + 4, point.y_q16);
      crc = rg_crc32(crc, bytes, sizeof(bytes));
      if (status != RG_OK || is_far_off(view, i)) continue;
      const int32_t x = distance(point.x_q16, expected[0]);
      const int32_t y = distance(point.y_q16, expected[1]);
      if (x > worst) worst = x;
      if (y > worst) worst = y;
    }
    print_message("view %u: worst error %d q16\n", (unsigned)view, (int)worst);
    assert_in_range(worst, 0, 8);
  }
  assert_int_equal(crc, 0x31facb1e); /* on every target */
}

static void view_is_told(void** state) {
  (void)state;
  rg_view view;
  rg_camera views;
  uint16_t width, height;
  rg_frame_size(&lens, &width, &height);
  assert_true(width == 160 && height == 120);
  assert_int_equal(rg_remap_view(&lens, &view), RG_OK);
  assert_int_equal(view.projection, RG_PROJECTION_PINHOLE);
  assert_true(view.width == 120 && view.height == 90);
  assert_true(view.fx_q16 == 24u << 16 && view.fy_q16 == 24u << 16);
  assert_true(view.cx_q16 == 119 << 15 && view.cy_q16 == 89 << 15);
  assert_int_equal(view.distorts, 0);
  for (int k = 0; k < 9; ++k)
    assert_int_equal(view.rotation_q30[k], k % 4 == 0 ? 1 << 30 : 0);

  assert_int_equal(rg_camera_open(&views, kViewsBlob, sizeof(kViewsBlob)),
                   RG_OK);
  assert_int_equal(rg_remap_view(&views, &view), RG_ERR_NO_REMAP);
  assert_int_equal(rg_select_remap(&views, RG_PROJECTION_STEREOGRAPHIC), RG_OK);
  assert_int_equal(rg_remap_view(&views, &view), RG_OK);
  assert_int_equal(view.projection, RG_PROJECTION_STEREOGRAPHIC);
  assert_int_equal(view.fx_q16, 9 << 16);
  /* Rolled by -90 degrees: what is to the right in the view is above. */
  const int32_t rolled[9] = {0, 1 << 30, 0, -(1 << 30), 0, 0, 0, 0, 1 << 30};
  assert_memory_equal(view.rotation_q30, rolled, sizeof(rolled));
}

/* The view of a table that distorts is its source; its output is the camera's
 * image. */
static void view_of_a_table_that_distorts_is_told(void** state) {
  (void)state;
  rg_view view;
  rg_camera modes;
  uint16_t width, height;
  assert_int_equal(rg_camera_open(&modes, kModesBlob, sizeof(kModesBlob)),
                   RG_OK);
  assert_int_equal(rg_select_remap(&modes, 3), RG_OK);
  assert_int_equal(rg_remap_view(&modes, &view), RG_OK);
  assert_true(view.distorts == 1 && view.width == 64 && view.height == 48);
  rg_frame_size(&modes, &width, &height);
  assert_true(width == 64 && height == 48);
  assert_int_equal(rg_remap_size(&modes, &width, &height), RG_OK);
  assert_true(width == 320 && height == 240);
  rg_calibrated_size(&modes, &width, &height);
  assert_true(width == 320 && height == 240);
}

/* Boards do not look at rotation and projection before they use them. */
static void any_view_is_safe(void** state) {
  (void)state;
  static uint8_t bytes[sizeof(kViewsBlob)] __attribute__((aligned(4)));
  const uint32_t values[4] = {0x7fffffff, 0x80000000, 0xffffffff, 0x40000000};
  rg_camera camera;
  for (uint32_t k = 0; k < 6 * 64; ++k) {
    memcpy(bytes, kViewsBlob, sizeof(bytes));
    const blob_section remap = section_of(kViewsBlob, 2);
    uint8_t* const section = bytes + (remap.bytes - kViewsBlob);
    section[RG_VIEW_PROJECTION] = (uint8_t)(k / 64 == 5 ? 77 : k / 64);
    for (uint32_t n = 0; n < 9; ++n)
      rg_store_u32(section + RG_VIEW_ROTATION + 4 * n,
                   values[k % 64 >> 2 * (n % 3) & 3]);
    repair_crcs(bytes, sizeof(bytes));
    assert_int_equal(rg_camera_open(&camera, bytes, sizeof(bytes)), RG_OK);
    assert_int_equal(rg_select_remap(&camera, 0), RG_OK);
    for (size_t i = 0; i < NUM_VIEW_PIXELS; i += 5) {
      rg_pixel point = {0, 0};
      rg_undistort_point(&camera, view_pixel(i), &point);
      assert_true(distance(point.x_q16, 0) < 1 << 30 &&
                  distance(point.y_q16, 0) < 1 << 30);
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
      cmocka_unit_test(points_of_every_view_are_the_golden_ones),
      cmocka_unit_test(view_is_told),
      cmocka_unit_test(view_of_a_table_that_distorts_is_told),
      cmocka_unit_test(any_view_is_safe),
      cmocka_unit_test(camera_without_a_table_says_so),
  };
  return cmocka_run_group_tests(tests, open_lens, NULL);
}
