#include <stdio.h>
#include <string.h>

#include "blob_edit.h"
#include "bytes.h"
#include "crc32.h"
#include "golden_blobs.h"
#include "raygrid.h"
#include "rg_blob.h"
#include "test_frame.h"
#include "unit_test.h"

#define NUM_GOLDEN (sizeof(kLensRays) / sizeof(kLensRays[0]))
#define NUM_CHART_RAYS (sizeof(kChartRays) / sizeof(kChartRays[0]))
#define NUM_RANDOM 2000u
#define NUM_DOUBLES 3000

/* Worst difference from the golden rays in a coordinate, q30: 107 would be
 * 1e-7 rad. */
#define MAX_ERROR_Q30 40

/* The rays of the NUM_RANDOM pixels with control points of 32 and of 16 bits,
 * the same on every target. */
#define RAYS_CRC 0xde44ad00u

static rg_camera lens, narrow;
static rg_pixel pixels[NUM_RANDOM];
static rg_ray rays[NUM_RANDOM];

/* Random pixels of the area, and about as many around it. */
static void make_pixels(void) {
  uint32_t random = 11;
  for (uint32_t i = 0; i < NUM_RANDOM; ++i) {
    pixels[i].x_q16 = (int32_t)(next_random(&random) >> 8) - RG_PIXEL(40);
    pixels[i].y_q16 = (int32_t)(next_random(&random) >> 8) - RG_PIXEL(40);
  }
}

static int open_lens(void** state) {
  (void)state;
  make_pixels();
  return rg_camera_open(&lens, kLensBlob, sizeof(kLensBlob)) ||
         rg_camera_open(&narrow, kNarrowBlob, sizeof(kNarrowBlob));
}

static int32_t distance(int32_t a, int32_t b) { return a > b ? a - b : b - a; }

static int32_t ray_error(const rg_ray* ray, const int32_t expected_q30[3]) {
  const int32_t x = distance(ray->x_q30, expected_q30[0]);
  const int32_t y = distance(ray->y_q30, expected_q30[1]);
  const int32_t z = distance(ray->z_q30, expected_q30[2]);
  const int32_t xy = x > y ? x : y;
  return xy > z ? xy : z;
}

static void check_norm(const rg_ray* ray) {
  const int64_t square_q60 = (int64_t)ray->x_q30 * ray->x_q30 +
                             (int64_t)ray->y_q30 * ray->y_q30 +
                             (int64_t)ray->z_q30 * ray->z_q30;
  const int64_t excess_q60 = square_q60 - (INT64_C(1) << 60);
  const int64_t limit_q60 = (INT64_C(1) << 60) / 25000000 * 2; /* 2 x 4e-8 */
  assert_true(excess_q60 <= limit_q60 && excess_q60 >= -limit_q60);
}

static void rays_are_the_golden_ones(void** state) {
  (void)state;
  int32_t worst = 0;
  for (size_t i = 0; i < NUM_GOLDEN; ++i) {
    const rg_pixel pixel = {kLensRays[i].x, kLensRays[i].y};
    rg_ray ray;
    assert_int_equal(rg_unproject(&lens, pixel, &ray), RG_OK);
    const int32_t error = ray_error(&ray, kLensRays[i].ray_q30);
    if (error > worst) worst = error;
  }
  print_message("worst error %d LSB\n", (int)worst);
  assert_true(worst <= MAX_ERROR_Q30);
}

/* The ray of a camera whose control points are all the same. */
static rg_ray ray_at_chart_position(int32_t a_q29, int32_t b_q29) {
  static uint8_t blob[sizeof(kExampleBlob)] __attribute__((aligned(4)));
  memcpy(blob, kExampleBlob, sizeof(blob));
  const uint32_t first = (uint32_t)(section_of(blob, 1).bytes + 40 - blob);
  for (uint32_t i = 0; i < 16; ++i) {
    rg_store_i32(blob + first + 8 * i, a_q29);
    rg_store_i32(blob + first + 8 * i + 4, b_q29);
  }
  repair_crcs(blob, sizeof(blob));
  rg_camera camera;
  assert_int_equal(rg_camera_open(&camera, blob, sizeof(blob)), RG_OK);
  const rg_pixel pixel = {RG_PIXEL(20), RG_PIXEL(30)};
  rg_ray ray = {0, 0, 0};
  assert_int_equal(rg_unproject(&camera, pixel, &ray), RG_OK);
  return ray;
}

static void rays_of_16_bits_are_the_golden_ones(void** state) {
  (void)state;
  int32_t worst = 0;
  for (size_t i = 0; i < NUM_GOLDEN; ++i) {
    const rg_pixel pixel = {kNarrowRays[i].x, kNarrowRays[i].y};
    rg_ray ray;
    assert_int_equal(rg_unproject(&narrow, pixel, &ray), RG_OK);
    const int32_t error = ray_error(&ray, kNarrowRays[i].ray_q30);
    if (error > worst) worst = error;
    check_norm(&ray);
  }
  print_message("worst error %d LSB\n", (int)worst);
  assert_true(worst <= MAX_ERROR_Q30);
}

static void rays_are_right_up_to_the_limit_of_the_chart(void** state) {
  (void)state;
  int32_t worst = 0;
  for (size_t i = 0; i < NUM_CHART_RAYS; ++i) {
    const golden_ray* golden = &kChartRays[i];
    const rg_ray ray = ray_at_chart_position(golden->x, golden->y);
    const int32_t error = ray_error(&ray, golden->ray_q30);
    if (error > worst) worst = error;
  }
  print_message("worst error %d LSB\n", (int)worst);
  assert_true(worst <= MAX_ERROR_Q30);
}

static void rays_have_unit_length(void** state) {
  (void)state;
  uint32_t num_inside = 0;
  for (uint32_t i = 0; i < NUM_RANDOM; ++i) {
    if (rg_unproject(&lens, pixels[i], &rays[i]) != RG_OK) continue;
    check_norm(&rays[i]);
    ++num_inside;
  }
  assert_in_range(num_inside, 100, NUM_RANDOM - 100);
}

/* Returns a random coordinate within the limit of control points. */
static int32_t random_coordinate(uint32_t* state) {
  return (int32_t)(((int64_t)(int32_t)next_random(state) * 0x7f000000) >> 31);
}

static void backward_rays_have_unit_length(void** state) {
  (void)state;
  uint32_t random = 5;
  for (int i = 0; i < 200; ++i) {
    const int32_t a = random_coordinate(&random);
    const int32_t b = random_coordinate(&random);
    const rg_ray ray = ray_at_chart_position(a, b);
    check_norm(&ray);
  }
}

/* The weights of bspline.h in double precision. */
static void weights_of(double t, double weights[4]) {
  weights[0] = (1 - t) * (1 - t) * (1 - t) / 6;
  weights[1] = (3 * t * t * t - 6 * t * t + 4) / 6;
  weights[2] = (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6;
  weights[3] = t * t * t / 6;
}

/* A pixel's direction by the blob's spline, as SPEC.md has it. */
static void direction_of(const rg_blob* blob, const rg_grid_section* grid,
                         rg_pixel pixel, double direction[3]) {
  const double u = (double)(pixel.x_q16 - grid->x0_q16) * grid->scale_x_q32 /
                   281474976710656.0;
  const double v = (double)(pixel.y_q16 - grid->y0_q16) * grid->scale_y_q32 /
                   281474976710656.0;
  const uint32_t i = u < grid->columns - 4 ? (uint32_t)u : grid->columns - 4u;
  const uint32_t j = v < grid->rows - 4 ? (uint32_t)v : grid->rows - 4u;
  double across[4], down[4], chart[2] = {0, 0};
  weights_of(u - i, across);
  weights_of(v - j, down);
  for (uint32_t k = 0; k < 16; ++k) {
    int32_t point_q29[2];
    rg_blob_control_point(blob, i + k % 4, j + k / 4, point_q29);
    for (int c = 0; c < 2; ++c)
      chart[c] += across[k % 4] * down[k / 4] * point_q29[c] / 536870912.0;
  }
  const double s = chart[0] * chart[0] + chart[1] * chart[1];
  direction[0] = 2 * chart[0] / (1 + s);
  direction[1] = 2 * chart[1] / (1 + s);
  direction[2] = (1 - s) / (1 + s);
}

/* The square of the sine between them. */
static double squared_sine(const double a[3], const rg_ray* ray) {
  const double b[3] = {ray->x_q30 / 1073741824.0, ray->y_q30 / 1073741824.0,
                       ray->z_q30 / 1073741824.0};
  const double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2];
  const double z = a[0] * b[1] - a[1] * b[0];
  return x * x + y * y + z * z;
}

static void check_against_doubles(const uint8_t* bytes, uint32_t size) {
  rg_blob blob;
  rg_camera camera;
  rg_grid_section grid;
  assert_int_equal(rg_blob_open(bytes, size, &blob), RG_OK);
  assert_int_equal(rg_camera_open(&camera, bytes, size), RG_OK);
  rg_blob_grid(&blob, &grid);
  uint32_t random = 13;
  double worst = 0;
  for (int k = 0; k < NUM_DOUBLES; ++k) {
    const rg_pixel pixel = {
        grid.x0_q16 + (int32_t)(next_random(&random) %
                                (uint32_t)(grid.x1_q16 - grid.x0_q16 + 1)),
        grid.y0_q16 + (int32_t)(next_random(&random) %
                                (uint32_t)(grid.y1_q16 - grid.y0_q16 + 1))};
    double direction[3];
    rg_ray ray;
    direction_of(&blob, &grid, pixel, direction);
    assert_int_equal(rg_unproject(&camera, pixel, &ray), RG_OK);
    const double error = squared_sine(direction, &ray);
    if (error > worst) worst = error;
  }
  print_message("worst squared sine %d e-18\n", (int)(worst * 1e18));
  assert_true(worst <= 1e-14);
}

/* 150 and 220 degrees. */
static void rays_are_within_1e_7_of_the_spline_in_doubles(void** state) {
  (void)state;
  check_against_doubles(kLensBlob, sizeof(kLensBlob));
  check_against_doubles(kWideBlob, sizeof(kWideBlob));
  check_against_doubles(kNarrowBlob, sizeof(kNarrowBlob));
}

static void check_pixel(int32_t x_q16, int32_t y_q16, rg_status expected) {
  const rg_pixel pixel = {x_q16, y_q16};
  rg_ray ray = {1, 2, 3};
  assert_int_equal(rg_unproject(&lens, pixel, &ray), expected);
  const int is_untouched = ray.x_q30 == 1 && ray.y_q30 == 2 && ray.z_q30 == 3;
  assert_int_equal(is_untouched, expected != RG_OK);
}

static void edges_belong_to_the_area(void** state) {
  (void)state;
  const int32_t x0 = 163840, y0 = 81920, x1 = 10289152, y1 = 7766016;
  check_pixel(x0, y0, RG_OK);
  check_pixel(x1, y0, RG_OK);
  check_pixel(x0, y1, RG_OK);
  check_pixel(x1, y1, RG_OK);
  check_pixel(x0 - 1, y0, RG_ERR_OUTSIDE_AREA);
  check_pixel(x0, y0 - 1, RG_ERR_OUTSIDE_AREA);
  check_pixel(x1 + 1, y1, RG_ERR_OUTSIDE_AREA);
  check_pixel(x1, y1 + 1, RG_ERR_OUTSIDE_AREA);
}

/* A cell of 32 x 32 px, of which the far edge is exactly one cell away. */
static void far_edge_continues_the_last_cell(void** state) {
  (void)state;
  static uint8_t blob[sizeof(kExampleBlob)] __attribute__((aligned(4)));
  memcpy(blob, kExampleBlob, sizeof(blob));
  uint8_t* grid = blob + (section_of(blob, 1).bytes - blob);
  rg_store_i32(grid + 8, RG_PIXEL(32));
  rg_store_i32(grid + 12, RG_PIXEL(32));
  rg_store_u32(grid + 20, 1u << 27);
  rg_store_u32(grid + 24, 1u << 27);
  repair_crcs(blob, sizeof(blob));
  rg_camera camera;
  assert_int_equal(rg_camera_open(&camera, blob, sizeof(blob)), RG_OK);
  const rg_pixel corner = {RG_PIXEL(32), RG_PIXEL(32)};
  const rg_pixel beside = {RG_PIXEL(32) - 1, RG_PIXEL(32) - 1};
  rg_ray ray, near_ray;
  assert_int_equal(rg_unproject(&camera, corner, &ray), RG_OK);
  assert_int_equal(rg_unproject(&camera, beside, &near_ray), RG_OK);
  const int32_t near_q30[3] = {near_ray.x_q30, near_ray.y_q30, near_ray.z_q30};
  assert_in_range(ray_error(&ray, near_q30), 1, 2000); /* 2e-6 rad */
}

static void far_away_pixels_lie_outside(void** state) {
  (void)state;
  check_pixel(INT32_MIN, RG_PIXEL(60), RG_ERR_OUTSIDE_AREA);
  check_pixel(INT32_MAX, RG_PIXEL(60), RG_ERR_OUTSIDE_AREA);
  check_pixel(RG_PIXEL(80), INT32_MIN, RG_ERR_OUTSIDE_AREA);
  check_pixel(RG_PIXEL(80), INT32_MAX, RG_ERR_OUTSIDE_AREA);
}

static void batch_equals_single_calls(void** state) {
  (void)state;
  memset(rays, 0xff, sizeof(rays));
  const uint32_t num_inside =
      rg_unproject_batch(&lens, pixels, rays, NUM_RANDOM);
  uint32_t num_singles = 0;
  for (uint32_t i = 0; i < NUM_RANDOM; ++i) {
    rg_ray ray = {0, 0, 0};
    num_singles += rg_unproject(&lens, pixels[i], &ray) == RG_OK;
    assert_memory_equal(&rays[i], &ray, sizeof(ray));
  }
  assert_int_equal(num_inside, num_singles);
}

static void row_equals_single_calls(void** state) {
  (void)state;
  const rg_pixel first = {-RG_PIXEL(3) + 7, RG_PIXEL(60)};
  rg_pixel pixel = first;
  memset(rays, 0xff, sizeof(rays));
  const uint32_t num_inside = rg_unproject_row(&lens, first, rays, 166);
  uint32_t num_singles = 0;
  for (uint32_t i = 0; i < 166; ++i, pixel.x_q16 += RG_PIXEL(1)) {
    rg_ray ray = {0, 0, 0};
    num_singles += rg_unproject(&lens, pixel, &ray) == RG_OK;
    assert_memory_equal(&rays[i], &ray, sizeof(ray));
  }
  assert_int_equal(num_inside, num_singles);
  assert_in_range(num_inside, 100, 160);
}

static void empty_batch_writes_nothing(void** state) {
  (void)state;
  rays[0].x_q30 = 77;
  assert_int_equal(rg_unproject_batch(&lens, pixels, rays, 0), 0);
  assert_int_equal(rays[0].x_q30, 77);
}

static uint32_t crc_of_rays(void) {
  uint32_t crc = 0;
  for (uint32_t k = 0; k < 2 * NUM_RANDOM; ++k) {
    const uint32_t i = k % NUM_RANDOM;
    if (i == 0)
      rg_unproject_batch(k == 0 ? &lens : &narrow, pixels, rays, NUM_RANDOM);
    uint8_t bytes[12] __attribute__((aligned(4)));
    rg_store_i32(bytes, rays[i].x_q30);
    rg_store_i32(bytes + 4, rays[i].y_q30);
    rg_store_i32(bytes + 8, rays[i].z_q30);
    crc = rg_crc32(crc, bytes, sizeof(bytes));
  }
  return crc;
}

static void rays_have_the_same_bits_on_every_target(void** state) {
  (void)state;
  const uint32_t crc = crc_of_rays();
  printf("rays CRC %08lx\n", (unsigned long)crc);
  assert_int_equal(crc, RAYS_CRC);
}

static void kernels_of_rays_can_be_chosen(void** state) {
  static const char* const kNames[] = {"avx2", "portable", NULL};
  (void)state;
  for (int k = 0; k < 3; ++k) {
    const rg_status status = rg_select_ray_kernels(&lens, kNames[k]);
    assert_int_equal(rg_select_ray_kernels(&narrow, kNames[k]), status);
    assert_int_equal(status,
                     k == 0 && status != RG_OK ? RG_ERR_ARGUMENT : RG_OK);
    assert_int_equal(crc_of_rays(), RAYS_CRC);
  }
  assert_int_equal(rg_select_ray_kernels(&lens, "avx"), RG_ERR_ARGUMENT);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(rays_are_the_golden_ones),
      cmocka_unit_test(kernels_of_rays_can_be_chosen),
      cmocka_unit_test(rays_of_16_bits_are_the_golden_ones),
      cmocka_unit_test(rays_are_within_1e_7_of_the_spline_in_doubles),
      cmocka_unit_test(rays_are_right_up_to_the_limit_of_the_chart),
      cmocka_unit_test(rays_have_unit_length),
      cmocka_unit_test(backward_rays_have_unit_length),
      cmocka_unit_test(edges_belong_to_the_area),
      cmocka_unit_test(far_edge_continues_the_last_cell),
      cmocka_unit_test(far_away_pixels_lie_outside),
      cmocka_unit_test(batch_equals_single_calls),
      cmocka_unit_test(row_equals_single_calls),
      cmocka_unit_test(empty_batch_writes_nothing),
      cmocka_unit_test(rays_have_the_same_bits_on_every_target),
  };
  return cmocka_run_group_tests(tests, open_lens, NULL);
}
