/* Tests that all examples of boards have in common: what is sent is the frame
 * undistorted whole, and mutants of the board are noticed. Included behind the
 * example and its board. */
#ifndef RAYGRID_BOARD_FRAMES_H
#define RAYGRID_BOARD_FRAMES_H

#include <stdio.h>

#include "crc32.h"
#include "golden_blobs.h"
#include "mock_board.h"
#include "test_frame.h"

/* kWideBlob's output. */
#define VIEW_WIDTH 48u
#define VIEW_HEIGHT 36u

static uint8_t board_frame[WIDTH * HEIGHT * 2];
static uint8_t board_expected[VIEW_WIDTH * VIEW_HEIGHT * 2];
static rg_camera board_camera;
static uint32_t board_view_bytes;

/* The frame that the board must send. */
static void undistort_whole(void) {
  const uint32_t stride = WIDTH * stream.pixel_bytes;
  const rg_image image = {.format = stream.format,
                          .width = WIDTH,
                          .height = HEIGHT,
                          .planes = {{board_frame, stride}}};
  const int is_yuv = stream.format == RG_FORMAT_YUYV;
  const rg_target target = {
      .planes = {{board_expected, VIEW_WIDTH * stream.pixel_bytes}},
      .num_rows = VIEW_HEIGHT,
      .border_values = {is_yuv ? 16 : 0, is_yuv ? 128 : 0, is_yuv ? 128 : 0}};
  assert_int_equal(rg_remap(&board_camera, &image, &target), RG_OK);
}

static int start_board(void** state) {
  (void)state;
  if (rg_camera_open(&board_camera, kWideBlob, sizeof(kWideBlob)) != RG_OK ||
      rg_select_remap(&board_camera, 0) != RG_OK)
    return -1;
  const uint32_t stride = WIDTH * stream.pixel_bytes;
  make_test_frame(board_frame, stride, stride, HEIGHT);
  board_view_bytes = VIEW_WIDTH * VIEW_HEIGHT * stream.pixel_bytes;
  memset(mock_blocks, 0, sizeof(mock_blocks));
  memset(&mock_camera, 0, sizeof(mock_camera));
  memset(&mock_sent, 0, sizeof(mock_sent));
  mock_camera.num_at_once = 1;
  mock_start_memory(BOARD_HAS_CACHE, ring, sizeof(ring), out[0], sizeof(out));
  start_registers();
  camera_init();
  undistort_whole();
  return 0;
}

static rg_status take_frame(void) {
  mock_sent.num_bytes = 0;
  mock_camera.frame = board_frame;
  mock_camera.band_bytes = BAND_BYTES;
  mock_camera.num_bands = HEIGHT >> BAND_ROWS_LOG2;
  mock_camera.band = 0;
  const rg_status status = camera_frame(&board_camera);
  mock_poll(); /* the last band leaves */
  return status;
}

static int is_as_expected(void) {
  return mock_sent.num_bytes == board_view_bytes &&
         memcmp(mock_sent.bytes, board_expected, board_view_bytes) == 0;
}

static void lens_suits_the_ring(void** state) {
  (void)state;
  assert_int_equal(dma_stream_check(&stream, &board_camera), RG_OK);
}

static void lens_of_other_frames_is_refused(void** state) {
  (void)state;
  rg_camera other;
  assert_int_equal(rg_camera_open(&other, kLensBlob, sizeof(kLensBlob)), RG_OK);
  assert_int_equal(rg_select_remap(&other, 0), RG_OK);
  assert_int_equal(dma_stream_check(&stream, &other), RG_ERR_FRAME_SIZE);
}

static void ring_that_is_too_small_is_refused(void** state) {
  (void)state;
  dma_stream small = stream;
  small.num_slots_log2 = 1;
  assert_int_equal(dma_stream_check(&small, &board_camera),
                   RG_ERR_ROWS_MISSING);
}

static void sent_frame_is_the_whole_one(void** state) {
  (void)state;
  assert_int_equal(take_frame(), RG_OK);
  const uint32_t crc = rg_crc32(0, mock_sent.bytes, mock_sent.num_bytes);
  printf("sent frame CRC %08lx\n", (unsigned long)crc);
  assert_true(is_as_expected());
  assert_int_equal(crc, BOARD_CRC);
  assert_int_equal(mock_camera.band, mock_camera.num_bands);
}

static void frames_follow_each_other(void** state) {
  (void)state;
  for (uint32_t k = 0; k < 3; ++k) {
    for (uint32_t i = 0; i < sizeof(board_frame); ++i) board_frame[i] ^= 0x55;
    undistort_whole();
    assert_int_equal(take_frame(), RG_OK);
    assert_true(is_as_expected());
  }
}

/* All bands that the ring may lose come while one is waited for. */
static void overtaken_rows_are_not_sent(void** state) {
  (void)state;
  mock_camera.num_at_once = 1u << NUM_SLOTS_LOG2;
  assert_int_equal(take_frame(), RG_ERR_ROWS_MISSING);
  assert_true(mock_sent.num_bytes < board_view_bytes);
  assert_memory_equal(mock_sent.bytes, board_expected, mock_sent.num_bytes);
  mock_camera.num_at_once = 1;
  assert_int_equal(take_frame(), RG_OK);
  assert_true(is_as_expected());
}

static void failed_dma_is_told(void** state) {
  (void)state;
  for (fail_at_band = 9; fail_at_band < 11; ++fail_at_band)
    assert_int_equal(take_frame(), RG_ERR_ROWS_MISSING);
  fail_at_band = UINT32_MAX;
  assert_int_equal(take_frame(), RG_OK);
  assert_true(is_as_expected());
}

/* An interrupt that was lost shifts all that comes later. */
static void lost_interrupt_is_told(void** state) {
  (void)state;
  lose_at_band = 6;
  assert_int_equal(take_frame(), RG_ERR_ROWS_MISSING);
  lose_at_band = UINT32_MAX;
  assert_int_equal(take_frame(), RG_OK);
  assert_true(is_as_expected());
}

/* ---- Mutants ------------------------------------------------------------ */

static void band_written_too_early_shows(void** state) {
  (void)state;
  mock_camera.never_gives_slots = 1;
  assert_int_equal(take_frame(), RG_OK);
  assert_false(is_as_expected());
}

static void missing_invalidate_shows(void** state) {
  (void)state;
  mock_memory.ignores_invalidate = 1;
  assert_int_equal(take_frame(), RG_OK);
  assert_false(is_as_expected());
}

static void missing_invalidate_before_the_dma_shows(void** state) {
  (void)state;
  mock_memory.ignores_first_invalidate = 1;
  assert_int_equal(take_frame(), RG_OK);
  assert_false(is_as_expected());
}

static void missing_clean_shows(void** state) {
  (void)state;
  mock_memory.ignores_clean = 1;
  assert_int_equal(take_frame(), RG_OK);
  assert_false(is_as_expected());
}

static int test_board(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup(lens_suits_the_ring, start_board),
      cmocka_unit_test_setup(lens_of_other_frames_is_refused, start_board),
      cmocka_unit_test_setup(ring_that_is_too_small_is_refused, start_board),
      cmocka_unit_test_setup(sent_frame_is_the_whole_one, start_board),
      cmocka_unit_test_setup(frames_follow_each_other, start_board),
      cmocka_unit_test_setup(overtaken_rows_are_not_sent, start_board),
      cmocka_unit_test_setup(failed_dma_is_told, start_board),
      cmocka_unit_test_setup(lost_interrupt_is_told, start_board),
      cmocka_unit_test_setup(band_written_too_early_shows, start_board),
      /* The last ones where there is a cache. */
      cmocka_unit_test_setup(missing_invalidate_shows, start_board),
      cmocka_unit_test_setup(missing_invalidate_before_the_dma_shows,
                             start_board),
      cmocka_unit_test_setup(missing_clean_shows, start_board),
  };
  const size_t num_tests =
      sizeof(tests) / sizeof(tests[0]) - (BOARD_HAS_CACHE ? 0 : 3);
  return _cmocka_run_group_tests("board", tests, num_tests, NULL, NULL);
}

#endif /* RAYGRID_BOARD_FRAMES_H */
