/* Lines of non-central cameras, both ways, and how far pixels may be trusted.
 */
#include <string.h>

#include "bytes.h"
#include "crc32.h"
#include "golden_blobs.h"
#include "raygrid.h"
#include "unit_test.h"

#define NUM_POINTS (sizeof(kLinePoints) / sizeof(kLinePoints[0]))
#define MAX_ERROR_Q28 13 /* 5e-8 m */

/* The points, the same on every target. */
#define POINTS_CRC 0x5c1cd907u

/* The pixels of points are off by 0.002 px at most, and the same on every
 * target. */
#define MAX_PIXEL_ERROR_Q16 131
#define PIXELS_CRC 0x69a5d19cu
#define NUM_SEEN_POINTS (sizeof(kSeenPoints) / sizeof(kSeenPoints[0]))

static rg_camera lines, seen_lines, narrow, wide, example;

static int open_cameras(void** state) {
  (void)state;
  return rg_camera_open(&lines, kLinesBlob, sizeof(kLinesBlob)) ||
         rg_camera_open(&seen_lines, kSeenLinesBlob, sizeof(kSeenLinesBlob)) ||
         rg_camera_open(&narrow, kNarrowBlob, sizeof(kNarrowBlob)) ||
         rg_camera_open(&example, kExampleBlob, sizeof(kExampleBlob)) ||
         rg_camera_open(&wide, kWideBlob, sizeof(kWideBlob));
}

static void points_are_the_golden_ones(void** state) {
  (void)state;
  uint32_t crc = 0;
  for (size_t i = 0; i < NUM_POINTS; ++i) {
    const rg_pixel pixel = {kLinePoints[i].x, kLinePoints[i].y};
    rg_line line;
    assert_int_equal(rg_unproject_line(&lines, pixel, &line), RG_OK);
    for (int c = 0; c < 3; ++c) {
      const int32_t error = line.point_q28[c] - kLinePoints[i].ray_q30[c];
      assert_true(error <= MAX_ERROR_Q28 && error >= -MAX_ERROR_Q28);
      uint8_t bytes[4] __attribute__((aligned(4)));
      rg_store_i32(bytes, line.point_q28[c]);
      crc = rg_crc32(crc, bytes, sizeof(bytes));
    }
  }
  assert_int_equal(crc, POINTS_CRC);
}

static void directions_are_those_of_the_grid(void** state) {
  (void)state;
  const rg_pixel pixel = {RG_PIXEL(11), RG_PIXEL(30)};
  rg_line line, central;
  rg_ray ray;
  assert_int_equal(rg_unproject_line(&lines, pixel, &line), RG_OK);
  assert_int_equal(rg_unproject(&example, pixel, &ray), RG_OK);
  assert_memory_equal(&line.direction, &ray, sizeof(ray));
  assert_int_equal(rg_unproject_line(&example, pixel, &central), RG_OK);
  assert_memory_equal(&central.direction, &ray, sizeof(ray));
  assert_true(central.point_q28[0] == 0 && central.point_q28[1] == 0 &&
              central.point_q28[2] == 0);
}

static void central_calls_refuse_a_camera_of_lines(void** state) {
  (void)state;
  const rg_pixel pixel = {RG_PIXEL(11), RG_PIXEL(30)};
  const rg_pixel outside = {RG_PIXEL(-11), RG_PIXEL(30)};
  rg_ray ray = {0, 0, 1};
  rg_pixel seen;
  rg_line line;
  assert_int_equal(rg_unproject(&lines, pixel, &ray), RG_ERR_NONCENTRAL);
  assert_int_equal(rg_project(&lines, &ray, &seen), RG_ERR_NONCENTRAL);
  assert_int_equal(rg_unproject_line(&lines, outside, &line),
                   RG_ERR_OUTSIDE_AREA);
  rg_ray ahead[9];
  rg_pixel all_seen[9];
  for (int i = 0; i < 9; ++i) ahead[i] = ray;
  assert_int_equal(rg_project_batch(&seen_lines, ahead, all_seen, 9), 0);
  for (int i = 0; i < 9; ++i)
    assert_true(all_seen[i].x_q16 == RG_NO_PIXEL &&
                all_seen[i].y_q16 == RG_NO_PIXEL);
}

static void lines_of_several_pixels_are_those_of_each(void** state) {
  (void)state;
  const rg_line none = {{0, 0, 0}, {0, 0, 0}};
  rg_pixel pixels[NUM_POINTS + 1];
  rg_line all[NUM_POINTS + 1];
  for (size_t i = 0; i < NUM_POINTS; ++i) {
    pixels[i].x_q16 = kLinePoints[i].x;
    pixels[i].y_q16 = kLinePoints[i].y;
  }
  pixels[NUM_POINTS].x_q16 = RG_PIXEL(-11);
  pixels[NUM_POINTS].y_q16 = RG_PIXEL(30);
  memset(all, 0xff, sizeof(all));
  assert_int_equal(rg_unproject_lines(&lines, pixels, all, NUM_POINTS + 1),
                   NUM_POINTS);
  for (size_t i = 0; i < NUM_POINTS; ++i) {
    rg_line line;
    assert_int_equal(rg_unproject_line(&lines, pixels[i], &line), RG_OK);
    assert_memory_equal(&all[i], &line, sizeof(line));
  }
  assert_memory_equal(&all[NUM_POINTS], &none, sizeof(none));
}

static int32_t difference(int32_t a, int32_t b) {
  return a < b ? b - a : a - b;
}

/* Whether a pixel lies farther than that inside the area. */
static int is_inside(const golden_ray* golden, int32_t margin_q16) {
  const uint8_t* const area = seen_lines.grid;
  return golden->x - rg_load_i32(area) > margin_q16 &&
         rg_load_i32(area + 8) - golden->x > margin_q16 &&
         golden->y - rg_load_i32(area + 4) > margin_q16 &&
         rg_load_i32(area + 12) - golden->y > margin_q16;
}

static void points_are_seen_by_the_golden_pixels(void** state) {
  (void)state;
  uint32_t crc = 0;
  int32_t worst = 0;
  for (size_t i = 0; i < NUM_SEEN_POINTS; ++i) {
    const golden_ray* const golden = &kSeenPoints[i];
    const int is_seen = golden->x != RG_NO_PIXEL;
    rg_pixel pixel = {1, 2};
    assert_int_equal(rg_project_point(&seen_lines, golden->ray_q30, 24, &pixel),
                     is_seen ? RG_OK : RG_ERR_NOT_SEEN);
    if (is_seen) {
      const int32_t x = difference(pixel.x_q16, golden->x);
      const int32_t y = difference(pixel.y_q16, golden->y);
      if (worst < x) worst = x;
      if (worst < y) worst = y;
    } else {
      assert_true(pixel.x_q16 == 1 && pixel.y_q16 == 2);
    }
    uint8_t bytes[8] __attribute__((aligned(4)));
    rg_store_i32(bytes, pixel.x_q16);
    rg_store_i32(bytes + 4, pixel.y_q16);
    crc = rg_crc32(crc, bytes, sizeof(bytes));
  }
  print_message("worst error %d q16\n", (int)worst);
  assert_in_range(worst, 0, MAX_PIXEL_ERROR_Q16);
  assert_int_equal(crc, PIXELS_CRC);
}

/* Points are seen in coarse formats, too. A format that rounds a point at one
 * metre by a pixel or more may give any answer but none. */
static void coarse_points_are_seen(void** state) {
  (void)state;
  for (uint32_t bits = 0; bits <= 24; ++bits) {
    /* 72 px a radian at most, two steps of three coordinates each */
    const int32_t error_q16 = (int32_t)(UINT32_C(400 << 16) >> bits) + 64;
    int num_seen = 0;
    for (size_t i = 0; i < NUM_SEEN_POINTS; ++i) {
      const golden_ray* const golden = &kSeenPoints[i];
      const uint32_t shift = 24 - bits;
      const int32_t point[3] = {golden->ray_q30[0] >> shift,
                                golden->ray_q30[1] >> shift,
                                golden->ray_q30[2] >> shift};
      rg_pixel pixel;
      /* at least one metre away, and well inside */
      if (golden->ray_q30[2] < 1 << 24 || golden->x == RG_NO_PIXEL ||
          !is_inside(golden, error_q16))
        continue;
      ++num_seen;
      assert_int_equal(rg_project_point(&seen_lines, point, bits, &pixel),
                       RG_OK);
      assert_in_range(difference(pixel.x_q16, golden->x), 0, error_q16);
      assert_in_range(difference(pixel.y_q16, golden->y), 0, error_q16);
    }
    if (bits >= 5) assert_in_range(num_seen, 10, NUM_SEEN_POINTS);
  }
}

static void more_fraction_bits_are_refused(void** state) {
  (void)state;
  const int32_t ahead[3] = {0, 0, 1 << 25};
  rg_pixel pixel = {1, 2};
  assert_int_equal(
      rg_project_point(&seen_lines, ahead, RG_POINT_MAX_BITS + 1, &pixel),
      RG_ERR_ARGUMENT);
  assert_int_equal(rg_project_point(&wide, ahead, UINT32_MAX, &pixel),
                   RG_ERR_ARGUMENT);
  assert_true(pixel.x_q16 == 1 && pixel.y_q16 == 2);
}

static void points_of_a_central_camera_are_directions(void** state) {
  (void)state;
  for (size_t i = 0; i < NUM_SEEN_POINTS; ++i) {
    const int32_t* const point = kSeenPoints[i].ray_q30;
    const rg_ray direction = {point[0], point[1], point[2]};
    rg_pixel by_point = {1, 2}, by_direction = {1, 2};
    assert_int_equal(rg_project_point(&narrow, point, 7, &by_point),
                     rg_project(&narrow, &direction, &by_direction));
    assert_memory_equal(&by_point, &by_direction, sizeof(by_point));
  }
}

static void lines_without_an_inverse_see_no_points(void** state) {
  (void)state;
  const int32_t ahead[3] = {0, 0, 1 << 20};
  rg_pixel pixel = {1, 2};
  assert_int_equal(rg_project_point(&lines, ahead, 20, &pixel),
                   RG_ERR_NO_INVERSE);
  assert_true(pixel.x_q16 == 1 && pixel.y_q16 == 2);
}

static void no_line_sees_the_centre_or_what_lies_behind(void** state) {
  (void)state;
  static const int32_t points[][3] = {{0, 0, 0},
                                      {0, 0, -1048576},
                                      {1, -1, -1},
                                      {INT32_MIN, INT32_MIN, INT32_MIN},
                                      {INT32_MAX, 0, INT32_MIN}};
  for (size_t i = 0; i < sizeof(points) / sizeof(points[0]); ++i) {
    rg_pixel pixel = {1, 2};
    assert_int_equal(rg_project_point(&seen_lines, points[i], 20, &pixel),
                     RG_ERR_NOT_SEEN);
    assert_true(pixel.x_q16 == 1 && pixel.y_q16 == 2);
  }
}

static int is_valid(int32_t x_q16, int32_t y_q16) {
  const rg_pixel pixel = {x_q16, y_q16};
  return rg_is_valid(&wide, pixel);
}

/* Cells (i, j) of 32 px with 3 < i + j < 13. */
static void mask_tells_valid_pixels(void** state) {
  (void)state;
  const int32_t edge = RG_PIXEL(32) - 0x8000;
  assert_false(is_valid(0, 0));
  assert_false(is_valid(4 * RG_PIXEL(32) - 0x8001, edge - 1));
  assert_true(is_valid(4 * RG_PIXEL(32) - 0x8000, edge - 1));
  assert_true(is_valid(3 * RG_PIXEL(32), edge));
  assert_true(is_valid(RG_PIXEL(319), RG_PIXEL(100)));
  assert_false(is_valid(RG_PIXEL(319), RG_PIXEL(130)));
  assert_false(is_valid(RG_PIXEL(319) + 1, RG_PIXEL(100)));
  assert_false(is_valid(INT32_MIN, INT32_MAX));
}

static void without_mask_the_area_is_valid(void** state) {
  (void)state;
  const rg_pixel inside = {0, 0}, outside = {-1, 0};
  assert_true(rg_is_valid(&example, inside));
  assert_false(rg_is_valid(&example, outside));
}

/* Values 40 + 3 i^2 + 7 j at multiples of 79.75 and 119.5 px. */
static void uncertainty_is_bilinear(void** state) {
  (void)state;
  const rg_pixel corner = {0, 0}, vertex = {159 * 65536 + 0x8000, 0};
  const rg_pixel middle = {39 * 65536 + 0xe000, 59 * 65536 + 0xc000};
  const rg_pixel last = {RG_PIXEL(319), RG_PIXEL(239)};
  const rg_pixel outside = {-1, 0};
  uint16_t px_q12 = 1;
  assert_int_equal(rg_uncertainty(&wide, corner, &px_q12), RG_OK);
  assert_int_equal(px_q12, 40);
  assert_int_equal(rg_uncertainty(&wide, vertex, &px_q12), RG_OK);
  assert_int_equal(px_q12, 52);
  assert_int_equal(rg_uncertainty(&wide, middle, &px_q12), RG_OK);
  assert_int_equal(px_q12, 45); /* (40 + 43 + 47 + 50) / 4 */
  px_q12 = 7;
  assert_int_equal(rg_uncertainty(&wide, last, &px_q12), RG_ERR_UNKNOWN);
  assert_int_equal(rg_uncertainty(&example, corner, &px_q12), RG_ERR_UNKNOWN);
  assert_int_equal(rg_uncertainty(&wide, outside, &px_q12),
                   RG_ERR_OUTSIDE_AREA);
  assert_int_equal(px_q12, 7);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(points_are_the_golden_ones),
      cmocka_unit_test(directions_are_those_of_the_grid),
      cmocka_unit_test(central_calls_refuse_a_camera_of_lines),
      cmocka_unit_test(lines_of_several_pixels_are_those_of_each),
      cmocka_unit_test(points_are_seen_by_the_golden_pixels),
      cmocka_unit_test(coarse_points_are_seen),
      cmocka_unit_test(more_fraction_bits_are_refused),
      cmocka_unit_test(points_of_a_central_camera_are_directions),
      cmocka_unit_test(lines_without_an_inverse_see_no_points),
      cmocka_unit_test(no_line_sees_the_centre_or_what_lies_behind),
      cmocka_unit_test(mask_tells_valid_pixels),
      cmocka_unit_test(without_mask_the_area_is_valid),
      cmocka_unit_test(uncertainty_is_bilinear),
  };
  return cmocka_run_group_tests(tests, open_cameras, NULL);
}
