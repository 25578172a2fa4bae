#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "blob_edit.h"
#include "bytes.h"
#include "crc32.h"
#include "golden_blobs.h"
#include "raygrid.h"
#include "test_frame.h"
#include "unit_test.h"

/* kLensBlob's image and output. */
#define SOURCE_WIDTH 160u
#define SOURCE_HEIGHT 120u
#define WIDTH 120u
#define HEIGHT 90u

#define PADDING 13u
#define GUARD 0xc3
#define MARGIN 64u

static rg_camera lens;
static uint8_t source[(SOURCE_WIDTH + PADDING) * SOURCE_HEIGHT];
static uint8_t whole[WIDTH * HEIGHT];
static uint8_t output[2 * MARGIN + (WIDTH + PADDING) * HEIGHT];

static rg_grey_image make_source(uint32_t stride) {
  memset(source, GUARD, sizeof(source));
  make_test_frame(source, stride, SOURCE_WIDTH, SOURCE_HEIGHT);
  const rg_grey_image frame = {source, stride, SOURCE_WIDTH, SOURCE_HEIGHT};
  return frame;
}

static rg_status remap_rows(const rg_grey_image* frame, uint32_t first_row,
                            uint32_t num_rows, uint8_t* data) {
  const rg_grey_target band = {data, WIDTH, (uint16_t)first_row,
                               (uint16_t)num_rows, GOLDEN_BORDER};
  return rg_remap_grey(&lens, frame, &band);
}

/* Every test starts from the whole frame. */
static int remap_whole_frame(void** state) {
  (void)state;
  memset(output, GUARD, sizeof(output));
  const rg_status opened = rg_camera_open(&lens, kLensBlob, sizeof(kLensBlob));
  if (opened != RG_OK || rg_select_remap(&lens, 0) != RG_OK) return -1;
  const rg_grey_image frame = make_source(SOURCE_WIDTH);
  return remap_rows(&frame, 0, HEIGHT, whole) == RG_OK ? 0 : -1;
}

static void check_guards(const uint8_t* begin, const uint8_t* end) {
  for (; begin < end; ++begin) assert_int_equal(*begin, GUARD);
}

static void frame_is_the_golden_one(void** state) {
  (void)state;
  const uint32_t crc = rg_crc32(0, whole, sizeof(whole));
  printf("remap CRC %08lx\n", (unsigned long)crc);
  assert_int_equal(crc, GOLDEN_LENS_REMAP_CRC);
}

static void example_is_the_golden_one(void** state) {
  (void)state;
  rg_camera example;
  assert_int_equal(rg_camera_open(&example, kExampleBlob, sizeof(kExampleBlob)),
                   RG_OK);
  assert_int_equal(rg_select_remap(&example, 0), RG_OK);
  make_test_frame(source, 64, 64, 48);
  const rg_grey_image frame = {source, 64, 64, 48};
  const rg_grey_target band = {output, 16, 0, 8, GOLDEN_BORDER};
  assert_int_equal(rg_remap_grey(&example, &frame, &band), RG_OK);
  assert_int_equal(rg_crc32(0, output, 16 * 8), GOLDEN_EXAMPLE_REMAP_CRC);
  check_guards(output + 16 * 8, output + sizeof(output));
}

static void bands_of_any_height_make_the_frame(void** state) {
  (void)state;
  const rg_grey_image frame = make_source(SOURCE_WIDTH);
  for (uint32_t height = 1; height <= HEIGHT; ++height) {
    memset(output, GUARD, sizeof(output));
    for (uint32_t row = 0; row < HEIGHT; row += height) {
      const uint32_t rest = HEIGHT - row;
      assert_int_equal(remap_rows(&frame, row, rest < height ? rest : height,
                                  output + row * WIDTH),
                       RG_OK);
    }
    assert_memory_equal(output, whole, sizeof(whole));
  }
}

static void bands_may_come_in_any_order(void** state) {
  (void)state;
  const rg_grey_image frame = make_source(SOURCE_WIDTH);
  for (uint32_t k = 0; k < HEIGHT; ++k) {
    const uint32_t row = k * 37 % HEIGHT;
    assert_int_equal(remap_rows(&frame, row, 1, output + row * WIDTH), RG_OK);
  }
  assert_memory_equal(output, whole, sizeof(whole));
}

static void band_writes_only_its_rows(void** state) {
  (void)state;
  const rg_grey_image frame = make_source(SOURCE_WIDTH);
  uint8_t* band = output + MARGIN;
  assert_int_equal(remap_rows(&frame, 30, 11, band), RG_OK);
  check_guards(output, band);
  assert_memory_equal(band, whole + 30 * WIDTH, 11 * WIDTH);
  check_guards(band + 11 * WIDTH, output + sizeof(output));
}

static void padding_between_rows_is_untouched(void** state) {
  (void)state;
  const rg_grey_image frame = make_source(SOURCE_WIDTH + PADDING);
  const uint32_t stride = WIDTH + PADDING;
  const rg_grey_target band = {output + MARGIN, stride, 0, HEIGHT,
                               GOLDEN_BORDER};
  assert_int_equal(rg_remap_grey(&lens, &frame, &band), RG_OK);
  check_guards(output, output + MARGIN);
  for (uint32_t y = 0; y < HEIGHT; ++y) {
    const uint8_t* row = output + MARGIN + y * stride;
    assert_memory_equal(row, whole + y * WIDTH, WIDTH);
    check_guards(row + WIDTH, row + stride);
  }
  check_guards(output + MARGIN + HEIGHT * stride, output + sizeof(output));
}

static void band_without_rows_writes_nothing(void** state) {
  (void)state;
  const rg_grey_image frame = make_source(SOURCE_WIDTH);
  assert_int_equal(remap_rows(&frame, HEIGHT, 0, output), RG_OK);
  check_guards(output, output + sizeof(output));
}

/* A source of ones shows the border wherever the output is not 1. */
static void border_value_is_the_callers(void** state) {
  (void)state;
  memset(source, 1, sizeof(source));
  const rg_grey_image frame = {source, SOURCE_WIDTH, SOURCE_WIDTH,
                               SOURCE_HEIGHT};
  const rg_grey_target band = {output, WIDTH, 0, HEIGHT, 200};
  assert_int_equal(rg_remap_grey(&lens, &frame, &band), RG_OK);
  uint32_t num_border = 0;
  for (uint32_t i = 0; i < WIDTH * HEIGHT; ++i) {
    assert_true(output[i] == 1 || output[i] == 200);
    num_border += output[i] == 200;
  }
  assert_int_equal(num_border, GOLDEN_LENS_BORDER_PIXELS);
}

static void check_frame(uint32_t width, uint32_t height, uint32_t stride,
                        rg_status expected) {
  const rg_grey_image frame = {source, stride, (uint16_t)width,
                               (uint16_t)height};
  assert_int_equal(remap_rows(&frame, 0, HEIGHT, output), expected);
}

static void wrong_frame_size_is_refused(void** state) {
  (void)state;
  check_frame(SOURCE_WIDTH - 1, SOURCE_HEIGHT, SOURCE_WIDTH, RG_ERR_FRAME_SIZE);
  check_frame(SOURCE_WIDTH + 1, SOURCE_HEIGHT, SOURCE_WIDTH + 1,
              RG_ERR_FRAME_SIZE);
  check_frame(SOURCE_WIDTH, SOURCE_HEIGHT - 1, SOURCE_WIDTH, RG_ERR_FRAME_SIZE);
  check_frame(SOURCE_WIDTH, SOURCE_HEIGHT + 1, SOURCE_WIDTH, RG_ERR_FRAME_SIZE);
  check_guards(output, output + sizeof(output));
}

/* A bottom-up image has a stride of 2^32 less a row. */
static void strides_that_no_row_fits_are_refused(void** state) {
  (void)state;
  const uint32_t strides[] = {WIDTH - 1, UINT32_C(1) << 31, UINT32_MAX - WIDTH,
                              UINT32_MAX};
  const rg_grey_image frame = make_source(SOURCE_WIDTH);
  for (uint32_t k = 0; k < sizeof(strides) / sizeof(strides[0]); ++k) {
    check_frame(SOURCE_WIDTH, SOURCE_HEIGHT, strides[k], RG_ERR_FRAME_SIZE);
    const rg_grey_target band = {output, strides[k], 0, HEIGHT, GOLDEN_BORDER};
    assert_int_equal(rg_remap_grey(&lens, &frame, &band), RG_ERR_FRAME_SIZE);
  }
  check_frame(SOURCE_WIDTH, SOURCE_HEIGHT, SOURCE_WIDTH - 1, RG_ERR_FRAME_SIZE);
  check_guards(output, output + sizeof(output));
}

static void rows_below_the_output_are_refused(void** state) {
  (void)state;
  const rg_grey_image frame = make_source(SOURCE_WIDTH);
  assert_int_equal(remap_rows(&frame, 0, HEIGHT + 1, output), RG_ERR_ROWS);
  assert_int_equal(remap_rows(&frame, HEIGHT - 1, 2, output), RG_ERR_ROWS);
  assert_int_equal(remap_rows(&frame, 65535, 1, output), RG_ERR_ROWS);
  assert_int_equal(remap_rows(&frame, 65535, 65535, output), RG_ERR_ROWS);
  check_guards(output, output + sizeof(output));
}

static void size_of_the_output_is_told(void** state) {
  (void)state;
  uint16_t width, height;
  assert_int_equal(rg_remap_size(&lens, &width, &height), RG_OK);
  assert_int_equal(width, WIDTH);
  assert_int_equal(height, HEIGHT);
}

static void blob_without_remap_says_so(void** state) {
  (void)state;
  static uint8_t blob[sizeof(kLensBlob)] __attribute__((aligned(4)));
  const blob_section sections[2] = {section_of(kLensBlob, 0),
                                    section_of(kLensBlob, 1)};
  const uint32_t size = assemble_blob(sections, 2, blob);
  assert_int_equal(rg_camera_open(&lens, blob, size), RG_OK);
  assert_int_equal(rg_select_remap(&lens, 0), RG_ERR_NO_REMAP);
  uint16_t width = 1, height = 2;
  assert_int_equal(rg_remap_size(&lens, &width, &height), RG_ERR_NO_REMAP);
  assert_int_equal(width, 1);
  assert_int_equal(height, 2);
  const rg_grey_image frame = make_source(SOURCE_WIDTH);
  assert_int_equal(remap_rows(&frame, 0, HEIGHT, output), RG_ERR_NO_REMAP);
  check_guards(output, output + sizeof(output));
}

/* A pixel's neighbours must be in the image. */
static void source_of_one_column_or_row_is_refused(void** state) {
  (void)state;
  static uint8_t blob[sizeof(kLensBlob)] __attribute__((aligned(4)));
  for (uint32_t axis = 0; axis < 2; ++axis) {
    memcpy(blob, kLensBlob, sizeof(blob));
    uint8_t* const size =
        blob + (section_of(kLensBlob, 0).bytes - kLensBlob) + 2 * axis;
    rg_store_u16(size, 1);
    repair_crcs(blob, sizeof(blob));
    assert_int_equal(rg_camera_open(&lens, blob, sizeof(blob)), RG_OK);
    assert_int_equal(rg_select_remap(&lens, 0), RG_ERR_REMAP_SIZE);
  }
}

/* ---- Tables that move the image: output (u, v) is source (u, v) + shift ---
 */

#define MOVED_WIDTH 64u
#define MOVED_HEIGHT 48u

static const uint8_t kNoBlocks[8] = {0};
static const uint8_t kThirdBlock[8] = {4};

static rg_remap_section moving_table(uint32_t block_log2, int32_t x_q12,
                                     int32_t y_q12, const uint8_t* empty) {
  const rg_remap_section table = {
      .width = MOVED_WIDTH,
      .height = MOVED_HEIGHT,
      .columns = (uint16_t)(((MOVED_WIDTH - 1) >> block_log2) + 2),
      .rows = (uint16_t)(((MOVED_HEIGHT - 1) >> block_log2) + 2),
      .block_log2 = (uint8_t)block_log2,
      .max_x_q12 = (MOVED_WIDTH - 1) * 4096,
      .max_y_q12 = (MOVED_HEIGHT - 1) * 4096,
      .origin_x_q12 = x_q12,
      .origin_y_q12 = y_q12,
      .column_step_x_q12 = 4096 << block_log2,
      .row_step_y_q12 = 4096 << block_log2,
      .fx_q16 = 1,
      .fy_q16 = 1,
      .empty_blocks = empty};
  return table;
}

/* The example's camera with another table. */
static void open_with_table(const rg_remap_section* table, rg_camera* camera) {
  static uint8_t bytes[1024] __attribute__((aligned(4)));
  static const int16_t residuals[2 * 9 * 7];
  static const int32_t control_points[2 * 4 * 4];
  rg_blob blob;
  rg_camera_section identity;
  rg_grid_section grid;
  assert_int_equal(rg_blob_open(kExampleBlob, sizeof(kExampleBlob), &blob),
                   RG_OK);
  rg_blob_camera(&blob, &identity);
  rg_blob_grid(&blob, &grid);
  const rg_blob_contents contents = {.camera = &identity,
                                     .grid = &grid,
                                     .control_points_q29 = control_points,
                                     .remap = table,
                                     .residuals = residuals};
  assert_int_equal(rg_blob_write(&contents, bytes, sizeof(bytes)), RG_OK);
  assert_int_equal(rg_camera_open(camera, bytes, rg_blob_size(&contents)),
                   RG_OK);
  assert_int_equal(rg_select_remap(camera, 0), RG_OK);
}

/* From a source of exactly its size into output; the source goes to source. */
static void move_image(const rg_remap_section* table) {
  rg_camera camera;
  open_with_table(table, &camera);
  make_test_frame(source, MOVED_WIDTH, MOVED_WIDTH, MOVED_HEIGHT);
  uint8_t* exact = malloc(MOVED_WIDTH * MOVED_HEIGHT);
  assert_non_null(exact);
  memcpy(exact, source, MOVED_WIDTH * MOVED_HEIGHT);
  const rg_grey_image frame = {exact, MOVED_WIDTH, MOVED_WIDTH, MOVED_HEIGHT};
  const rg_grey_target band = {output, MOVED_WIDTH, 0, MOVED_HEIGHT,
                               GOLDEN_BORDER};
  assert_int_equal(rg_remap_grey(&camera, &frame, &band), RG_OK);
  free(exact);
}

static void table_without_motion_copies_the_frame(void** state) {
  (void)state;
  for (uint32_t block_log2 = 3; block_log2 <= 5; ++block_log2) {
    const rg_remap_section table = moving_table(block_log2, 0, 0, kNoBlocks);
    memset(output, GUARD, sizeof(output));
    move_image(&table);
    assert_memory_equal(output, source, MOVED_WIDTH * MOVED_HEIGHT);
  }
}

/* Between pixel i and the next one; the border where there is none. */
static uint8_t middle(uint32_t i, uint32_t next, int exists) {
  return exists ? (uint8_t)((source[i] + source[next] + 1) >> 1)
                : GOLDEN_BORDER;
}

static void half_a_pixel_to_the_right_averages_neighbours(void** state) {
  (void)state;
  const rg_remap_section table = moving_table(4, 2048, 0, kNoBlocks);
  move_image(&table);
  for (uint32_t i = 0; i < MOVED_WIDTH * MOVED_HEIGHT; ++i)
    assert_int_equal(output[i], middle(i, i + 1, (i + 1) % MOVED_WIDTH != 0));
}

static void half_a_pixel_down_averages_neighbours(void** state) {
  (void)state;
  const rg_remap_section table = moving_table(5, 0, 2048, kNoBlocks);
  move_image(&table);
  for (uint32_t i = 0; i < MOVED_WIDTH * MOVED_HEIGHT; ++i)
    assert_int_equal(output[i], middle(i, i + MOVED_WIDTH,
                                       i / MOVED_WIDTH + 1 < MOVED_HEIGHT));
}

static void empty_block_is_believed(void** state) {
  (void)state;
  const rg_remap_section table = moving_table(3, 0, 0, kThirdBlock);
  move_image(&table);
  for (uint32_t i = 0; i < MOVED_WIDTH * MOVED_HEIGHT; ++i) {
    const int is_empty = i % MOVED_WIDTH / 8 == 2 && i / MOVED_WIDTH < 8;
    assert_int_equal(output[i], is_empty ? GOLDEN_BORDER : source[i]);
  }
}

#define TEST(name) cmocka_unit_test_setup(name, remap_whole_frame)

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(frame_is_the_golden_one),
      TEST(example_is_the_golden_one),
      TEST(bands_of_any_height_make_the_frame),
      TEST(bands_may_come_in_any_order),
      TEST(band_writes_only_its_rows),
      TEST(padding_between_rows_is_untouched),
      TEST(band_without_rows_writes_nothing),
      TEST(border_value_is_the_callers),
      TEST(wrong_frame_size_is_refused),
      TEST(strides_that_no_row_fits_are_refused),
      TEST(rows_below_the_output_are_refused),
      TEST(size_of_the_output_is_told),
      TEST(blob_without_remap_says_so),
      TEST(source_of_one_column_or_row_is_refused),
      TEST(table_without_motion_copies_the_frame),
      TEST(half_a_pixel_to_the_right_averages_neighbours),
      TEST(half_a_pixel_down_averages_neighbours),
      TEST(empty_block_is_believed),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
