/* The example runtime/examples/stream_bands.c on a golden lens: rows of the
 * test image come from the top, and what goes out is the frame undistorted
 * whole. */
#include "stream_bands.h"

#include <string.h>

#include "golden_blobs.h"
#include "test_frame.h"
#include "unit_test.h"

#define SENSOR_HEIGHT 240u
#define WIDTH 48u
#define HEIGHT 36u

static uint8_t frame[SENSOR_WIDTH * SENSOR_HEIGHT];
static uint8_t sent[WIDTH * HEIGHT], expected[WIDTH * HEIGHT];
static uint32_t num_received, num_sent;

void board_receive_row(uint8_t* pixels) {
  assert_true(num_received < SENSOR_HEIGHT);
  memcpy(pixels, frame + num_received * SENSOR_WIDTH, SENSOR_WIDTH);
  ++num_received;
}

void board_send_row(const uint8_t* pixels, uint32_t num_pixels) {
  if (num_pixels == WIDTH && num_sent < HEIGHT)
    memcpy(sent + num_sent * WIDTH, pixels, WIDTH);
  ++num_sent;
}

static int start(void** state) {
  (void)state;
  make_test_frame(frame, SENSOR_WIDTH, SENSOR_WIDTH, SENSOR_HEIGHT);
  num_received = num_sent = 0;
  return 0;
}

static void streamed_frame_is_the_whole_one(void** state) {
  (void)state;
  rg_camera camera;
  assert_int_equal(rg_camera_open(&camera, kWideBlob, sizeof(kWideBlob)),
                   RG_OK);
  assert_int_equal(rg_select_remap(&camera, 0), RG_OK);
  const rg_grey_image whole = {frame, SENSOR_WIDTH, SENSOR_WIDTH,
                               SENSOR_HEIGHT};
  const rg_grey_target band = {expected, WIDTH, 0, HEIGHT, 0};
  assert_int_equal(rg_remap_grey(&camera, &whole, &band), RG_OK);
  assert_int_equal(stream_frame(&camera), RG_OK);
  assert_int_equal(num_received, SENSOR_HEIGHT);
  assert_int_equal(num_sent, HEIGHT);
  assert_memory_equal(sent, expected, sizeof(sent));
}

/* This sensor is turned: some rows of output need nearly all of its rows. */
static void lens_that_wants_a_larger_ring_is_refused(void** state) {
  (void)state;
  rg_camera camera;
  assert_int_equal(rg_camera_open(&camera, kLensBlob, sizeof(kLensBlob)),
                   RG_OK);
  assert_int_equal(rg_select_remap(&camera, 0), RG_OK);
  assert_int_equal(stream_frame(&camera), RG_ERR_ROWS_MISSING);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup(streamed_frame_is_the_whole_one, start),
      cmocka_unit_test_setup(lens_that_wants_a_larger_ring_is_refused, start),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
