/* Undistorted pictures against bilinear interpolation in double at the same
 * positions, those of the table's own arithmetic. Prints what DESIGN.md says of
 * the image error. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "cortex_m/tile_corners.h"
#include "golden_blobs.h"
#include "raygrid.h"
#include "rg_blob.h"
#include "test_frame.h"
#include "unit_test.h"

#define MAX_WIDTH 320u
#define MAX_HEIGHT 240u
#define NUM_PICTURES 4u

static uint8_t picture[MAX_WIDTH * MAX_HEIGHT];
static uint8_t output[MAX_WIDTH * MAX_HEIGHT];
static uint8_t other_border[MAX_WIDTH * MAX_HEIGHT];

/* ---- Pictures ------------------------------------------------------------ */

static uint32_t state;

static uint32_t below(uint32_t limit) {
  return (uint32_t)(((uint64_t)next_random(&state) * limit) >> 32);
}

static double waves(uint32_t x, uint32_t y) {
  return 128 + 60 * sin(x * 0.13) + 50 * cos(y * 0.11 + x * 0.05);
}

static uint8_t smooth(uint32_t x, uint32_t y) { return (uint8_t)waves(x, y); }

static uint8_t photograph(uint32_t x, uint32_t y) {
  return (uint8_t)(waves(x, y) + below(17) - 8);
}

static uint8_t noise(uint32_t x, uint32_t y) {
  (void)x, (void)y;
  return (uint8_t)below(256);
}

static uint8_t checkerboard(uint32_t x, uint32_t y) {
  return (x / 8 + y / 8) % 2 == 0 ? 255 : 0;
}

static uint8_t black_and_white(uint32_t x, uint32_t y) {
  (void)x, (void)y;
  return (uint8_t)(255 * below(2));
}

/* ---- Errors -------------------------------------------------------------- */

typedef struct image_error {
  double sum_of_squares, worst;
  double
      worst_rounded; /* against the exact value rounded to whole grey levels */
  uint32_t num_pixels;
} image_error;

static double interpolate(const rg_camera* camera, double x, double y) {
  const uint32_t column = (uint32_t)x, row = (uint32_t)y;
  const uint32_t right = column + 1u < camera->frame_width ? 1 : 0;
  const uint32_t lower =
      row + 1u < camera->frame_height ? camera->frame_width : 0;
  const uint8_t* const p = picture + row * camera->frame_width + column;
  const double u = x - column, v = y - row;
  return (p[0] * (1 - u) + p[right] * u) * (1 - v) +
         (p[lower] * (1 - u) + p[lower + right] * u) * v;
}

static void add_pixel(image_error* error, double exact, uint8_t result) {
  const double difference = fabs(exact - result);
  error->sum_of_squares += difference * difference;
  error->worst = fmax(error->worst, difference);
  error->worst_rounded =
      fmax(error->worst_rounded, fabs(floor(exact + 0.5) - result));
  ++error->num_pixels;
}

/* All pixels that have a source: those that do not depend on the border. */
static void add_frame(const rg_camera* camera, image_error* error) {
  rg_remap_section table;
  rg_read_remap(camera->remap, &table);
  const uint32_t log2 =
      table.part_log2 != 0 ? table.part_log2 : table.block_log2;
  const uint32_t mask = (1u << log2) - 1;
  for (uint32_t y = 0; y < table.height; ++y) {
    rg_tile_row parts;
    rg_block_row row;
    memset(&parts, 0, sizeof(parts));
    rg_init_tile_row(camera->remap, log2, log2, y >> log2, &parts);
    for (uint32_t x = 0; x < table.width; ++x) {
      if ((x & mask) == 0) {
        rg_block block;
        rg_next_block(&parts, &block);
        rg_compute_block_row(&block, y & mask, &row);
      }
      const uint32_t pixel = y * table.width + x;
      const rg_position p = rg_row_position(&row, x & mask);
      if (output[pixel] == other_border[pixel])
        add_pixel(error,
                  interpolate(camera, p.q12[0] / 4096.0, p.q12[1] / 4096.0),
                  output[pixel]);
    }
  }
}

static void remap_picture(const rg_camera* camera, uint8_t border,
                          uint8_t* result) {
  const rg_grey_image frame = {picture, camera->frame_width,
                               camera->frame_width, camera->frame_height};
  rg_grey_target band = {result, 0, 0, 0, border};
  uint16_t width;
  assert_int_equal(rg_remap_size(camera, &width, &band.num_rows), RG_OK);
  band.stride = width;
  assert_int_equal(rg_remap_grey(camera, &frame, &band), RG_OK);
}

static void add_table(const void* blob, uint32_t size, uint32_t index,
                      uint8_t (*make)(uint32_t x, uint32_t y),
                      image_error* error) {
  rg_camera camera;
  assert_int_equal(rg_camera_open(&camera, blob, size), RG_OK);
  assert_int_equal(rg_select_remap(&camera, index), RG_OK);
  assert_true(camera.frame_width <= MAX_WIDTH &&
              camera.frame_height <= MAX_HEIGHT);
  for (uint32_t k = 0; k < NUM_PICTURES; ++k) {
    for (uint32_t y = 0; y < camera.frame_height; ++y)
      for (uint32_t x = 0; x < camera.frame_width; ++x)
        picture[y * camera.frame_width + x] = make(x, y);
    remap_picture(&camera, 0, output);
    remap_picture(&camera, 255, other_border);
    add_frame(&camera, error);
  }
}

/* The error of images over tables without and with bends. */
static image_error measure(const char* name,
                           uint8_t (*make)(uint32_t x, uint32_t y)) {
  image_error error = {0, 0, 0, 0};
  state = 1;
  add_table(kLensBlob, sizeof(kLensBlob), 0, make, &error);
  add_table(kBentBlob, sizeof(kBentBlob), 0, make, &error);
  add_table(kBentBlob, sizeof(kBentBlob), 1, make, &error);
  printf(
      "%s: %.3f grey levels RMS, %.3f at most, %.0f when rounded; %u pixels\n",
      name, sqrt(error.sum_of_squares / error.num_pixels), error.worst,
      error.worst_rounded, (unsigned)error.num_pixels);
  assert_true(error.num_pixels > 20000);
  return error;
}

/* Limits: the largest, in grey levels. Rounded results are next to rounded ones
 * of doubles at worst. */
static void check(const char* name, uint8_t (*make)(uint32_t x, uint32_t y),
                  double rms, double worst) {
  const image_error error = measure(name, make);
  assert_true(sqrt(error.sum_of_squares / error.num_pixels) <= rms);
  assert_true(error.worst <= worst);
  assert_true(error.worst_rounded <= 1);
}

static void pictures_are_exact_to_a_third_of_a_grey_level(void** unused) {
  (void)unused;
  check("smooth", smooth, 0.3, 0.6);
  check("photograph", photograph, 0.3, 0.6);
}

static void hard_edges_and_noise_are_within_one_grey_level_when_rounded(
    void** unused) {
  (void)unused;
  check("checkerboard", checkerboard, 0.35, 1.5);
  check("noise", noise, 0.35, 1.5);
  check("black and white noise", black_and_white, 0.45, 1.5);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(pictures_are_exact_to_a_third_of_a_grey_level),
      cmocka_unit_test(
          hard_edges_and_noise_are_within_one_grey_level_when_rounded),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
