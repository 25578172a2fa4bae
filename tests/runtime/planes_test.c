#include "frames/planes.h"

#include <string.h>

#include "unit_test.h"

#define MEMORY_SIZE 40
#define MAX_STRIDE 6
#define MAX_ROWS 3

static uint8_t memory[MEMORY_SIZE];

/* Whether bytes of the rows of both are the same, byte by byte. */
static int do_rows_meet(const rg_grey_image* frame, const rg_grey_target* band,
                        uint32_t row_bytes) {
  uint8_t is_in_frame[MEMORY_SIZE];
  memset(is_in_frame, 0, sizeof is_in_frame);
  for (uint32_t row = 0; row < frame->height; ++row)
    memset(is_in_frame + (frame->data - memory) + row * frame->stride, 1,
           frame->width);
  const uint8_t* at = is_in_frame + (band->data - memory);
  for (uint32_t row = 0; row < band->num_rows; ++row, at += band->stride)
    if (memchr(at, 1, row_bytes)) return 1;
  return 0;
}

static rg_status check_overlap(uint32_t row_bytes, const rg_grey_image* frame,
                               const rg_grey_target* band) {
  return rg_check_overlap(frame, band->data, band->stride,
                          row_bytes | (uint32_t)band->num_rows << 16);
}

/* Wherever the band lies. */
static void check_places(const rg_grey_image* frame, rg_grey_target band,
                         uint32_t row_bytes) {
  for (band.data = memory; band.data < memory + MEMORY_SIZE / 2; ++band.data)
    assert_int_equal(
        check_overlap(row_bytes, frame, &band),
        do_rows_meet(frame, &band, row_bytes) ? RG_ERR_OVERLAP : RG_OK);
}

static void planes_of_one_stride_meet_where_rows_do(void** state) {
  (void)state;
  rg_grey_image frame = {memory + MEMORY_SIZE / 4, 0, 0, 0};
  rg_grey_target band = {memory, 0, 0, 0, 0};
  for (uint32_t stride = 1; stride <= MAX_STRIDE; ++stride) {
    frame.stride = band.stride = stride;
    for (frame.height = 1; frame.height <= MAX_ROWS; ++frame.height)
      for (frame.width = 1; frame.width <= stride; ++frame.width)
        for (band.num_rows = 0; band.num_rows <= MAX_ROWS; ++band.num_rows)
          for (uint32_t row_bytes = 1; row_bytes <= stride; ++row_bytes)
            check_places(&frame, band, row_bytes);
  }
}

static void planes_of_two_strides_meet_where_their_ends_do(void** state) {
  (void)state;
  /* Bytes 10 to 19, and 5 wherever they lie. */
  const rg_grey_image frame = {memory + 10, 4, 2, 3};
  rg_grey_target band = {memory, 3, 0, 2, 0};
  for (; band.data < memory + 30; ++band.data)
    assert_int_equal(check_overlap(2, &frame, &band),
                     band.data + 5 <= memory + 10 || band.data >= memory + 20
                         ? RG_OK
                         : RG_ERR_OVERLAP);
  band.num_rows = 0;
  band.data = memory + 12;
  assert_int_equal(check_overlap(2, &frame, &band), RG_OK);
}

static void remainders_are_those_of_division(void** state) {
  (void)state;
  for (uint32_t b = 1; b < 3000; b += 1 + b / 4)
    for (uint32_t quotient = 0; quotient < 0x20000; quotient += 4321)
      for (uint32_t rest = 0; rest < b; rest += 1 + b / 3)
        assert_int_equal(rg_remainder((uintptr_t)quotient * b + rest, b), rest);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(planes_of_one_stride_meet_where_rows_do),
      cmocka_unit_test(planes_of_two_strides_meet_where_their_ends_do),
      cmocka_unit_test(remainders_are_those_of_division),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
