#include <stdio.h>
#include <string.h>

#include "blob_edit.h"
#include "bytes.h"
#include "crc32.h"
#include "golden_blobs.h"
#include "raygrid.h"
#include "rays/surface_choice.h"
#include "test_frame.h"
#include "unit_test.h"

#define NUM_GOLDEN (sizeof(kWideProjections) / sizeof(kWideProjections[0]))
#define NUM_RANDOM 1000u

/* 0.002 px */
#define MAX_ERROR_Q16 131

/* The pixels of NUM_RANDOM directions, the same on every target. */
#define PIXELS_CRC 0x4bdb23ffu

static rg_camera wide, narrow, without_inverse;
static rg_ray directions[NUM_RANDOM];
static rg_pixel pixels[NUM_RANDOM];

static int open_cameras(void** state) {
  (void)state;
  static uint8_t blob[sizeof(kWideBlob)] __attribute__((aligned(4)));
  const blob_section sections[2] = {section_of(kWideBlob, 0),
                                    section_of(kWideBlob, 1)};
  const uint32_t size = assemble_blob(sections, 2, blob);
  return rg_camera_open(&wide, kWideBlob, sizeof(kWideBlob)) ||
         rg_camera_open(&narrow, kNarrowBlob, sizeof(kNarrowBlob)) ||
         rg_camera_open(&without_inverse, blob, size);
}

/* Towards random pixels of a camera's area, and as many random ones. */
static void make_directions(const rg_camera* camera) {
  uint32_t random = 23;
  for (uint32_t i = 0; i < NUM_RANDOM; ++i) {
    const rg_pixel pixel = {
        (int32_t)(next_random(&random) >> 7) % RG_PIXEL(158),
        (int32_t)(next_random(&random) >> 7) % RG_PIXEL(119)};
    directions[i].x_q30 = (int32_t)next_random(&random);
    directions[i].y_q30 = (int32_t)next_random(&random);
    directions[i].z_q30 = (int32_t)next_random(&random);
    if (i % 2 == 0) rg_unproject(camera, pixel, &directions[i]);
  }
}

static int32_t distance(int32_t a, int32_t b) { return a > b ? a - b : b - a; }

static int32_t pixel_error(rg_pixel a, rg_pixel b) {
  const int32_t x = distance(a.x_q16, b.x_q16);
  const int32_t y = distance(a.y_q16, b.y_q16);
  return x > y ? x : y;
}

/* The worst error of the golden pixels; -1 if others are seen. */
static int32_t worst_golden_error(const rg_camera* camera) {
  int32_t worst = 0;
  for (size_t i = 0; i < NUM_GOLDEN; ++i) {
    const golden_ray* golden = &kWideProjections[i];
    const rg_ray ray = {golden->ray_q30[0], golden->ray_q30[1],
                        golden->ray_q30[2]};
    const rg_pixel expected = {golden->x, golden->y};
    rg_pixel pixel = {1, 2};
    const rg_status status = rg_project(camera, &ray, &pixel);
    const int is_seen = golden->x != INT32_MIN;
    assert_int_equal(status, is_seen ? RG_OK : RG_ERR_NOT_SEEN);
    if (!is_seen) assert_true(pixel.x_q16 == 1 && pixel.y_q16 == 2);
    if (!is_seen) continue;
    const int32_t error = pixel_error(pixel, expected);
    if (error > worst) worst = error;
  }
  print_message("worst error %d q16\n", (int)worst);
  return worst;
}

static void pixels_are_the_golden_ones(void** state) {
  (void)state;
  assert_in_range(worst_golden_error(&wide), 0, MAX_ERROR_Q16);
}

static void blobs_without_an_inverse_are_refused(void** state) {
  (void)state;
  const rg_ray ahead = {0, 0, 1};
  rg_pixel pixel = {1, 2};
  assert_int_equal(rg_project(&without_inverse, &ahead, &pixel),
                   RG_ERR_NO_INVERSE);
  assert_true(pixel.x_q16 == 1 && pixel.y_q16 == 2);
}

/* An end of the calibrated area: 0, 1: the lower one of x, y; 2, 3: the upper.
 */
static int32_t end_q16(const rg_camera* camera, uint32_t k) {
  return rg_load_i32(camera->grid + 4 * k);
}

static void check_round_trips(const rg_camera* camera) {
  int32_t worst = 0;
  const int32_t width = end_q16(camera, 2) - end_q16(camera, 0);
  const int32_t height = end_q16(camera, 3) - end_q16(camera, 1);
  for (int32_t j = 0; j <= 40; ++j) {
    for (int32_t i = 0; i <= 50; ++i) {
      const rg_pixel pixel = {end_q16(camera, 0) + width / 50 * i,
                              end_q16(camera, 1) + height / 40 * j};
      rg_ray ray;
      rg_pixel back;
      assert_int_equal(rg_unproject(camera, pixel, &ray), RG_OK);
      assert_int_equal(rg_project(camera, &ray, &back), RG_OK);
      const int32_t error = pixel_error(pixel, back);
      if (error > worst) worst = error;
    }
  }
  print_message("worst round trip %d q16\n", (int)worst);
  assert_in_range(worst, 0, MAX_ERROR_Q16);
}

static void projection_inverts_unprojection(void** state) {
  (void)state;
  check_round_trips(&wide);
  check_round_trips(&narrow);
}

/* How far the inverse grid's slopes lead for half a pixel along an axis. */
static void check_slopes(const rg_grid_position* from,
                         const rg_grid_position* to,
                         const int32_t slopes_q5[2][2], uint32_t along) {
  double found_px[2] = {0, 0};
  for (uint32_t c = 0; c < 2; ++c)
    for (uint32_t k = 0; k < 2; ++k)
      found_px[k] += (double)(to->value.q27[c] - from->value.q27[c]) *
                     slopes_q5[c][k] / 4294967296.0;
  for (uint32_t k = 0; k < 2; ++k) {
    const double error_px = found_px[k] - (k == along ? 0.5 : 0);
    assert_true(error_px < 0.015 && error_px > -0.015);
  }
}

/* A start within 1/16 px, whose slopes are right to 3 %. */
static void check_starts(const rg_camera* camera) {
  const int32_t width = end_q16(camera, 2) - end_q16(camera, 0);
  const int32_t height = end_q16(camera, 3) - end_q16(camera, 1);
  const uint8_t* const grid = camera->grid;
  for (int32_t k = 0; k <= 41 * 51 - 1; ++k) {
    const rg_pixel pixel = {
        end_q16(camera, 0) + (width - 0x8000) / 50 * (k % 51),
        end_q16(camera, 1) + (height - 0x8000) / 40 * (k / 51)};
    rg_grid_position place, beside, start;
    int32_t slopes_q5[2][2];
    assert_int_equal(rg_evaluate_spline(grid, pixel.x_q16, pixel.y_q16, &place),
                     RG_OK);
    assert_int_equal(rg_evaluate_spline(camera->inverse, place.value.q27[0],
                                        place.value.q27[1], &start),
                     RG_OK);
    const rg_pixel found = {2 * start.value.q27[0], 2 * start.value.q27[1]};
    assert_in_range(pixel_error(pixel, found), 0, 4096);
    rg_compute_jacobian(camera->inverse, &start, slopes_q5);
    rg_evaluate_spline(grid, pixel.x_q16 + 0x8000, pixel.y_q16, &beside);
    check_slopes(&place, &beside, slopes_q5, 0);
    rg_evaluate_spline(grid, pixel.x_q16, pixel.y_q16 + 0x8000, &beside);
    check_slopes(&place, &beside, slopes_q5, 1);
  }
}

static void one_step_is_enough(void** state) {
  (void)state;
  check_starts(&wide);
  check_starts(&narrow);
}

static void length_does_not_matter(void** state) {
  (void)state;
  const rg_pixel pixel = {RG_PIXEL(40), RG_PIXEL(200)};
  rg_ray ray;
  assert_int_equal(rg_unproject(&wide, pixel, &ray), RG_OK);
  for (int shift = 0; shift <= 12; ++shift) {
    const rg_ray shorter = {ray.x_q30 >> shift, ray.y_q30 >> shift,
                            ray.z_q30 >> shift};
    rg_pixel back;
    assert_int_equal(rg_project(&wide, &shorter, &back), RG_OK);
    assert_in_range(pixel_error(pixel, back), 0,
                    MAX_ERROR_Q16 + (65536 >> (20 - shift)));
  }
}

static void check_direction(int32_t x, int32_t y, int32_t z,
                            rg_status expected) {
  const rg_ray ray = {x, y, z};
  rg_pixel pixel;
  assert_int_equal(rg_project(&wide, &ray, &pixel), expected);
}

static void extreme_vectors_are_answered(void** state) {
  (void)state;
  check_direction(0, 0, 0, RG_ERR_NOT_SEEN);
  check_direction(0, 0, 1, RG_OK);
  check_direction(0, 0, INT32_MAX, RG_OK);
  check_direction(0, 0, -1, RG_ERR_NOT_SEEN);
  check_direction(0, 0, INT32_MIN, RG_ERR_NOT_SEEN);
  check_direction(1, -1, INT32_MIN, RG_ERR_NOT_SEEN);
  check_direction(INT32_MIN, 0, 0, RG_OK);
  check_direction(INT32_MAX, 0, 0, RG_OK);
  check_direction(INT32_MIN, INT32_MIN, INT32_MIN, RG_ERR_NOT_SEEN);
  check_direction(INT32_MIN, INT32_MIN, INT32_MAX, RG_OK);
}

/* Whatever the surface, a pixel that is found looks there. */
static void surfaces_of_noise_give_no_wrong_pixel(void** state) {
  (void)state;
  static uint8_t blob[sizeof(kWideBlob)] __attribute__((aligned(4)));
  uint32_t random = 3, num_found = 0;
  for (uint32_t round = 0; round < 60; ++round) {
    memcpy(blob, kWideBlob, sizeof(blob));
    uint8_t* points = blob + (section_of(blob, 1).bytes - blob) + 40;
    for (uint32_t i = 0; i < 2 * 19 * 15; ++i)
      rg_store_i32(points + 4 * i,
                   (int32_t)next_random(&random) >> (1 + round % 20));
    repair_crcs(blob, sizeof(blob));
    rg_camera camera;
    assert_int_equal(rg_camera_open(&camera, blob, sizeof(blob)), RG_OK);
    for (uint32_t i = 0; i < 40; ++i) {
      const rg_ray ray = {(int32_t)next_random(&random) >> (round % 20),
                          (int32_t)next_random(&random) >> (round % 20),
                          INT32_MAX};
      rg_pixel pixel;
      rg_ray seen;
      if (rg_project(&camera, &ray, &pixel) != RG_OK) continue;
      ++num_found;
      assert_int_equal(rg_unproject(&camera, pixel, &seen), RG_OK);
      /* 2^-30 of seen x ray: sines in about q31. */
      const int64_t sine =
          ((int64_t)seen.x_q30 * ray.z_q30 - (int64_t)seen.z_q30 * ray.x_q30) >>
          30;
      assert_true(sine < 0x2000000 && sine > -0x2000000);
    }
  }
  print_message("%u found\n", (unsigned)num_found);
  assert_true(num_found > 20);
}

static void batch_equals_single_calls(void** state) {
  (void)state;
  make_directions(&narrow);
  const uint32_t num_seen =
      rg_project_batch(&narrow, directions, pixels, NUM_RANDOM);
  uint32_t num_singles = 0;
  for (uint32_t i = 0; i < NUM_RANDOM; ++i) {
    rg_pixel pixel = {RG_NO_PIXEL, RG_NO_PIXEL};
    num_singles += rg_project(&narrow, &directions[i], &pixel) == RG_OK;
    assert_memory_equal(&pixels[i], &pixel, sizeof(pixel));
  }
  assert_int_equal(num_seen, num_singles);
  assert_in_range(num_seen, NUM_RANDOM / 3, NUM_RANDOM - NUM_RANDOM / 5);
}

static uint32_t pixels_crc(const rg_camera* camera, uint32_t crc) {
  make_directions(camera);
  rg_project_batch(camera, directions, pixels, NUM_RANDOM);
  for (uint32_t i = 0; i < NUM_RANDOM; ++i) {
    uint8_t bytes[8] __attribute__((aligned(4)));
    rg_store_i32(bytes, pixels[i].x_q16);
    rg_store_i32(bytes + 4, pixels[i].y_q16);
    crc = rg_crc32(crc, bytes, sizeof(bytes));
  }
  return crc;
}

static void pixels_have_the_same_bits_on_every_target(void** state) {
  (void)state;
  const uint32_t crc = pixels_crc(&wide, pixels_crc(&narrow, 0));
  printf("pixels CRC %08lx\n", (unsigned long)crc);
  assert_int_equal(crc, PIXELS_CRC);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(pixels_are_the_golden_ones),
      cmocka_unit_test(blobs_without_an_inverse_are_refused),
      cmocka_unit_test(projection_inverts_unprojection),
      cmocka_unit_test(one_step_is_enough),
      cmocka_unit_test(length_does_not_matter),
      cmocka_unit_test(extreme_vectors_are_answered),
      cmocka_unit_test(surfaces_of_noise_give_no_wrong_pixel),
      cmocka_unit_test(batch_equals_single_calls),
      cmocka_unit_test(pixels_have_the_same_bits_on_every_target),
  };
  return cmocka_run_group_tests(tests, open_cameras, NULL);
}
