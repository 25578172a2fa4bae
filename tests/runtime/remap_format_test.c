/* Frames of every format, and frames that come row by row. */
#include <stdlib.h>
#include <string.h>

#include "crc32.h"
#include "frames/pixel_format_list.h"
#include "golden_blobs.h"
#include "raygrid.h"
#include "test_frame.h"
#include "unit_test.h"

/* The tables' images and outputs. */
#define SOURCE_WIDTH 320u
#define SOURCE_HEIGHT 240u
#define WIDTH 48u
#define HEIGHT 36u
#define PADDING 6u
#define GUARD 0xc3

/* Bytes of a plane for 8 image pixels, and image rows per row. */
typedef struct plane_size {
  uint32_t bytes_per_8, rows_per_row;
} plane_size;

#define RG_PIXEL_FORMAT(name, kind, first, num, row_pairs, ...) \
  [RG_FORMAT_##name] = {__VA_ARGS__},
static const plane_size kPlanes[RG_NUM_FORMATS][3] = {RG_PIXEL_FORMATS};

/* A table of a blob, and the CRCs of its frames. */
typedef struct golden_table {
  const uint8_t* blob;
  uint32_t blob_size, index;
  const uint32_t (*crcs)[3];
} golden_table;

static const golden_table kTables[] = {
    {kWideBlob, sizeof(kWideBlob), 0, kFormatCrcs},
    {kBentBlob, sizeof(kBentBlob), 0, kBentFormatCrcs},
    {kBentBlob, sizeof(kBentBlob), 1, kMoreBentFormatCrcs},
    {kStackBlob, sizeof(kStackBlob), 0, kStackFormatCrcs},
    {kStackBlob, sizeof(kStackBlob), 1, kStackPlainFormatCrcs}};
#define NUM_TABLES (sizeof(kTables) / sizeof(kTables[0]))

static rg_camera wide; /* with the table */
static const uint32_t (*crcs)[3];
static uint8_t source[3][(4 * SOURCE_WIDTH + PADDING) * SOURCE_HEIGHT]
    __attribute__((aligned(2)));
static uint8_t output[3][(4 * WIDTH + PADDING) * HEIGHT]
    __attribute__((aligned(2)));
static uint8_t whole[3][(4 * WIDTH + PADDING) * HEIGHT];

static int open_table(const golden_table* table) {
  crcs = table->crcs;
  const int is_stack = table->blob == kStackBlob;
  return rg_camera_open(&wide, table->blob, table->blob_size) == RG_OK &&
                 rg_select_remap(&wide, table->index) == RG_OK &&
                 rg_set_operating_point(&wide, GOLDEN_STACK_VALUE) ==
                     (is_stack ? RG_OK : RG_ERR_NO_STACK)
             ? 0
             : -1;
}

static int open_wide(void** state) {
  (void)state;
  return open_table(&kTables[0]);
}

static void with_every_table(void (*check)(void)) {
  for (uint32_t k = NUM_TABLES; k > 0; --k) { /* the first stays open */
    assert_int_equal(open_table(&kTables[k - 1]), 0);
    check();
  }
}

static uint32_t row_bytes(rg_format format, uint32_t plane, uint32_t width) {
  return kPlanes[format][plane].bytes_per_8 * width / 8;
}

static uint32_t rows_of(rg_format format, uint32_t plane, uint32_t height) {
  return kPlanes[format][plane].rows_per_row == 0
             ? 0
             : height / kPlanes[format][plane].rows_per_row;
}

static rg_image make_image(rg_format format) {
  rg_image image;
  memset(&image, 0, sizeof(image));
  image.format = format;
  image.width = SOURCE_WIDTH;
  image.height = SOURCE_HEIGHT;
  for (uint32_t plane = 0; plane < 3; ++plane) {
    const uint32_t bytes = row_bytes(format, plane, SOURCE_WIDTH);
    image.planes[plane].data = source[plane];
    image.planes[plane].stride = bytes + PADDING;
    memset(source[plane], GUARD, sizeof(source[plane]));
    make_test_frame(source[plane], bytes + PADDING, bytes,
                    rows_of(format, plane, SOURCE_HEIGHT));
  }
  return image;
}

static rg_target make_target(rg_format format, uint32_t mode) {
  static const uint16_t values[4] = {GOLDEN_BORDER_VALUES};
  rg_target target;
  memset(&target, 0, sizeof(target));
  for (uint32_t plane = 0; plane < 3; ++plane) {
    target.planes[plane].data = output[plane];
    target.planes[plane].stride = row_bytes(format, plane, WIDTH) + PADDING;
    memset(output[plane], GOLDEN_KEPT, sizeof(output[plane]));
  }
  target.num_rows = HEIGHT;
  target.border = (rg_border)mode;
  target.sampling = mode == 2 ? RG_SAMPLING_NEAREST : RG_SAMPLING_BILINEAR;
  memcpy(target.border_values, values, sizeof(values));
  return target;
}

/* CRC of the pixels; the bytes between the rows must be untouched. */
static uint32_t output_crc(rg_format format) {
  uint32_t crc = 0;
  for (uint32_t plane = 0; plane < 3; ++plane) {
    const uint32_t bytes = row_bytes(format, plane, WIDTH);
    const uint8_t* row = output[plane];
    for (uint32_t y = 0; y < rows_of(format, plane, HEIGHT); ++y) {
      crc = rg_crc32(crc, row, bytes);
      for (uint32_t i = 0; i < PADDING; ++i)
        assert_int_equal(row[bytes + i], GOLDEN_KEPT);
      row += bytes + PADDING;
    }
    for (; row < output[plane] + sizeof(output[plane]); ++row)
      assert_int_equal(*row, GOLDEN_KEPT);
  }
  return crc;
}

static void check_frames(void) {
  for (int format = 0; format < RG_NUM_FORMATS; ++format) {
    const rg_image image = make_image((rg_format)format);
    for (uint32_t mode = 0; mode < 3; ++mode) {
      const rg_target target = make_target((rg_format)format, mode);
      assert_int_equal(rg_remap(&wide, &image, &target), RG_OK);
      const uint32_t crc = output_crc((rg_format)format);
      if (crc != crcs[format][mode])
        print_error("format %d, mode %u\n", format, (unsigned)mode);
      assert_int_equal(crc, crcs[format][mode]);
    }
  }
}

static void frames_of_every_format_are_the_golden_ones(void** state) {
  (void)state;
  with_every_table(check_frames);
}

static void move_target(rg_target* target, rg_format format, uint32_t row) {
  for (uint32_t plane = 0; plane < 3; ++plane)
    target->planes[plane].data =
        output[plane] +
        rows_of(format, plane, row) * target->planes[plane].stride;
  target->first_row = (uint16_t)row;
}

static void check_bands(void) {
  for (int f = 0; f < RG_NUM_FORMATS; ++f) {
    const rg_format format = (rg_format)f;
    const rg_image image = make_image(format);
    rg_target target = make_target(format, 0);
    target.num_rows = 2;
    for (uint32_t row = 0; row < HEIGHT; row += 2) {
      move_target(&target, format, row);
      assert_int_equal(rg_remap(&wide, &image, &target), RG_OK);
    }
    assert_int_equal(output_crc(format), crcs[format][0]);
  }
}

static void bands_make_the_frame(void** state) {
  (void)state;
  with_every_table(check_bands);
}

/* Puts rows of the frame into rings of exactly ring_rows rows; the other slots
 * hold GUARD. */
static void fill_ring(rg_image* ring, const rg_image* image, uint8_t* memory[3],
                      uint32_t first, uint32_t num_rows) {
  for (uint32_t plane = 0; plane < 3; ++plane) {
    const uint32_t stride = image->planes[plane].stride;
    const uint32_t slots = rows_of(image->format, plane, ring->ring_rows);
    memset(memory[plane], GUARD, slots * stride + 1);
    const uint32_t end = rows_of(image->format, plane, first + num_rows);
    for (uint32_t r = rows_of(image->format, plane, first); r < end; ++r)
      memcpy(memory[plane] + r % slots * stride,
             image->planes[plane].data + r * stride, stride);
    ring->planes[plane].data = memory[plane];
  }
  ring->first_row = (uint16_t)first;
  ring->num_rows = (uint16_t)num_rows;
}

/* Band by band from a ring that holds exactly the rows asked for. */
static void check_ring(rg_format format, uint32_t band_rows) {
  const rg_image image = make_image(format);
  rg_image ring = image;
  rg_target target = make_target(format, 0);
  target.num_rows = (uint16_t)band_rows;
  for (uint32_t row = 0; row < HEIGHT; row += band_rows) {
    uint16_t first, count;
    uint8_t* memory[3];
    move_target(&target, format, row);
    assert_int_equal(rg_remap_source_rows(&wide, format, (uint16_t)row,
                                          (uint16_t)band_rows, &first, &count),
                     RG_OK);
    /* The ring has as few rows as are needed, or some more. */
    ring.ring_rows = (uint16_t)(count + row % 3 * 2 + (count == 0 ? 2u : 0u));
    for (uint32_t plane = 0; plane < 3; ++plane) {
      memory[plane] = malloc(rows_of(format, plane, ring.ring_rows) *
                                 image.planes[plane].stride +
                             1);
      assert_non_null(memory[plane]);
    }
    fill_ring(&ring, &image, memory, first, count);
    assert_int_equal(rg_remap(&wide, &ring, &target), RG_OK);
    if (count > 4) {
      ++ring.first_row;
      --ring.num_rows;
      assert_int_equal(rg_remap(&wide, &ring, &target), RG_ERR_ROWS_MISSING);
      --ring.first_row;
      assert_int_equal(rg_remap(&wide, &ring, &target), RG_ERR_ROWS_MISSING);
    }
    for (uint32_t plane = 0; plane < 3; ++plane) free(memory[plane]);
  }
  assert_int_equal(output_crc(format), crcs[format][0]);
}

static void check_rings(void) {
  for (int format = 0; format < RG_NUM_FORMATS; ++format) {
    check_ring((rg_format)format, 2);
    check_ring((rg_format)format, 6);
    check_ring((rg_format)format, 12);
  }
}

static void rings_of_the_rows_needed_make_the_frame(void** state) {
  (void)state;
  with_every_table(check_rings);
}

/* A row that is needed changes the output when it changes. */
static void check_rows_told(void) {
  const rg_image image = make_image(RG_FORMAT_GREY8);
  rg_target target = make_target(RG_FORMAT_GREY8, 0);
  target.num_rows = 1;
  for (uint32_t row = 0; row < HEIGHT; ++row) {
    uint16_t first, count;
    target.first_row = (uint16_t)row;
    assert_int_equal(rg_remap_source_rows(&wide, RG_FORMAT_GREY8, (uint16_t)row,
                                          1, &first, &count),
                     RG_OK);
    assert_int_equal(rg_remap(&wide, &image, &target), RG_OK);
    memcpy(whole[0], output[0], WIDTH);
    /* The second and the last but one: one at either end may be spare. */
    for (int end = 0; end < 2 && count > 3; ++end) {
      const uint32_t r = end == 0 ? first + 1u : first + count - 2u;
      uint8_t* changed = source[0] + r * image.planes[0].stride;
      for (uint32_t i = 0; i < SOURCE_WIDTH; ++i) changed[i] ^= 0xff;
      changed +=
          end == 0 ? -(int)image.planes[0].stride : (int)image.planes[0].stride;
      for (uint32_t i = 0; i < SOURCE_WIDTH; ++i) changed[i] ^= 0xff;
      assert_int_equal(rg_remap(&wide, &image, &target), RG_OK);
      assert_memory_not_equal(output[0], whole[0], WIDTH);
      make_image(RG_FORMAT_GREY8);
    }
  }
}

static void rows_told_are_needed(void** state) {
  (void)state;
  with_every_table(check_rows_told);
}

/* Channels of black frames, and whether what is border has their values. */
static void check_border(rg_format format, uint32_t plane,
                         const uint8_t channels[4]) {
  const uint32_t bytes = row_bytes(format, plane, WIDTH);
  const uint8_t* row = output[plane];
  uint32_t found = 0;
  for (uint32_t y = 0; y < rows_of(format, plane, HEIGHT); ++y) {
    for (uint32_t i = 0; i < bytes; ++i) {
      if (row[i] == 0) continue;
      assert_int_equal(row[i], channels[i % 4]);
      found |= 1u << (i % 4);
    }
    row += bytes + PADDING;
  }
  assert_int_equal(found, 15);
}

static void border_values_are_luma_first_and_second_chroma(void** state) {
  (void)state;
  static const struct {
    rg_format format;
    uint8_t channels[3][4]; /* of each plane's bytes */
  } kCases[] = {{RG_FORMAT_YUYV, {{1, 2, 1, 3}}},
                {RG_FORMAT_UYVY, {{2, 1, 3, 1}}},
                {RG_FORMAT_NV12, {{1, 1, 1, 1}, {2, 3, 2, 3}}},
                {RG_FORMAT_YUV420, {{1, 1, 1, 1}, {2, 2, 2, 2}, {3, 3, 3, 3}}}};
  for (uint32_t k = 0; k < sizeof(kCases) / sizeof(kCases[0]); ++k) {
    const rg_format format = kCases[k].format;
    const rg_image image = make_image(format);
    memset(source, 0, sizeof(source));
    rg_target target = make_target(format, 0);
    for (uint16_t c = 0; c < 4; ++c)
      target.border_values[c] = (uint16_t)(c + 1);
    assert_int_equal(rg_remap(&wide, &image, &target), RG_OK);
    for (uint32_t plane = 0; plane < 3; ++plane)
      if (row_bytes(format, plane, WIDTH) != 0)
        check_border(format, plane, kCases[k].channels[plane]);
  }
}

/* And not a byte of the target is touched. */
static void check_refused(rg_image image, rg_target target,
                          rg_status expected) {
  memcpy(whole, output, sizeof(output));
  assert_int_equal(rg_remap(&wide, &image, &target), expected);
  if (expected != RG_OK) assert_memory_equal(output, whole, sizeof(output));
}

static void wrong_calls_are_refused(void** state) {
  (void)state;
  const rg_image nv12 = make_image(RG_FORMAT_NV12);
  const rg_target whole_nv12 = make_target(RG_FORMAT_NV12, 0);
  rg_image image = nv12;
  image.format = RG_NUM_FORMATS;
  check_refused(image, whole_nv12, RG_ERR_FORMAT);
  image = nv12;
  image.planes[1].stride = SOURCE_WIDTH - 1;
  check_refused(image, whole_nv12, RG_ERR_FRAME_SIZE);
  image.planes[1].stride = UINT32_C(1) << 31;
  check_refused(image, whole_nv12, RG_ERR_FRAME_SIZE);
  image = nv12;
  image.width = SOURCE_WIDTH - 2;
  check_refused(image, whole_nv12, RG_ERR_FRAME_SIZE);
  rg_target target = whole_nv12;
  target.planes[1].stride = WIDTH - 1;
  check_refused(nv12, target, RG_ERR_FRAME_SIZE);
  target = whole_nv12;
  target.num_rows = 3;
  check_refused(nv12, target, RG_ERR_ROWS);
  target.num_rows = 2;
  target.first_row = 1;
  check_refused(nv12, target, RG_ERR_ROWS);
  target.first_row = HEIGHT;
  check_refused(nv12, target, RG_ERR_ROWS);
  target = whole_nv12;
  target.border = (rg_border)3;
  check_refused(nv12, target, RG_ERR_FORMAT);
  target = whole_nv12;
  target.sampling = (rg_sampling)2;
  check_refused(nv12, target, RG_ERR_FORMAT);
  image = nv12;
  image.ring_rows = SOURCE_HEIGHT;
  image.num_rows = SOURCE_HEIGHT;
  check_refused(image, whole_nv12, RG_OK);
  target = whole_nv12;
  target.border = RG_BORDER_CLAMP;
  check_refused(image, target, RG_ERR_FORMAT);
  image.ring_rows = 101;
  check_refused(image, whole_nv12, RG_ERR_FRAME_SIZE);
  image.ring_rows = 100;
  check_refused(image, whole_nv12, RG_ERR_ROWS_MISSING);
}

static void overlapping_planes_are_refused(void** state) {
  (void)state;
  const rg_image image = make_image(RG_FORMAT_NV12);
  const rg_target whole_nv12 = make_target(RG_FORMAT_NV12, 0);
  /* Chroma in the last row of luma, and behind it. */
  rg_target target = whole_nv12;
  target.planes[0].stride = target.planes[1].stride = WIDTH;
  target.planes[1].data = target.planes[0].data + WIDTH * (HEIGHT - 1);
  check_refused(image, target, RG_ERR_OVERLAP);
  target.planes[1].data += WIDTH - 1;
  check_refused(image, target, RG_ERR_OVERLAP);
  target.planes[1].data += 1;
  check_refused(image, target, RG_OK);
  /* Chroma beside luma, and a byte too near. */
  target.planes[0].stride = target.planes[1].stride = 2 * WIDTH;
  target.planes[1].data = target.planes[0].data + WIDTH;
  check_refused(image, target, RG_OK);
  target.planes[1].data -= 1;
  check_refused(image, target, RG_ERR_OVERLAP);
  target.planes[1].data += 2;
  check_refused(image, target, RG_ERR_OVERLAP);
  /* The target in the source. */
  target = whole_nv12;
  target.planes[0].data = source[1] + (SOURCE_HEIGHT / 2 - 1) * SOURCE_WIDTH;
  check_refused(image, target, RG_ERR_OVERLAP);
  target = whole_nv12;
  target.planes[1].data = source[0] + 1;
  check_refused(image, target, RG_ERR_OVERLAP);
}

static void odd_addresses_of_words_are_refused(void** state) {
  (void)state;
  rg_image image = make_image(RG_FORMAT_GREY16);
  rg_target target = make_target(RG_FORMAT_GREY16, 0);
  image.planes[0].data += 1;
  check_refused(image, target, RG_ERR_MISALIGNED);
  image.planes[0].data -= 1;
  image.planes[0].stride += 1;
  check_refused(image, target, RG_ERR_MISALIGNED);
  image.planes[0].stride -= 1;
  target.planes[0].data += 1;
  check_refused(image, target, RG_ERR_MISALIGNED);
}

static void further_tables_may_be_selected(void** state) {
  (void)state;
  rg_camera camera = wide;
  uint16_t width, height;
  assert_int_equal(rg_select_remap(&camera, 1), RG_OK);
  assert_int_equal(rg_remap_size(&camera, &width, &height), RG_OK);
  assert_int_equal(width, 36);
  assert_int_equal(height, 28);
  assert_int_equal(rg_select_remap(&camera, 2), RG_ERR_NO_REMAP);
  assert_int_equal(rg_select_remap(&camera, 0xffffffff), RG_ERR_NO_REMAP);
  assert_int_equal(rg_remap_size(&camera, &width, &height), RG_OK);
  assert_int_equal(width, 36);
  assert_int_equal(rg_select_remap(&camera, 0), RG_OK);
  assert_memory_equal(&camera, &wide, sizeof(camera));
}

static void frames_of_every_view_are_the_golden_ones(void** state) {
  (void)state;
  rg_camera camera;
  assert_int_equal(rg_camera_open(&camera, kViewsBlob, sizeof(kViewsBlob)),
                   RG_OK);
  make_test_frame(source[0], SOURCE_WIDTH, SOURCE_WIDTH, SOURCE_HEIGHT);
  const rg_grey_image frame = {source[0], SOURCE_WIDTH, SOURCE_WIDTH,
                               SOURCE_HEIGHT};
  for (uint32_t k = 0; k < sizeof(kViewsCrcs) / sizeof(kViewsCrcs[0]); ++k) {
    rg_view view;
    assert_int_equal(rg_select_remap(&camera, k), RG_OK);
    assert_int_equal(rg_remap_view(&camera, &view), RG_OK);
    const rg_grey_target band = {output[0], view.width, 0, view.height,
                                 GOLDEN_BORDER};
    assert_int_equal(rg_remap_grey(&camera, &frame, &band), RG_OK);
    const uint32_t size = (uint32_t)view.width * view.height;
    assert_int_equal(rg_crc32(0, output[0], size), kViewsCrcs[k]);
  }
}

static void frames_of_every_mode_are_the_golden_ones(void** state) {
  (void)state;
  static uint8_t frame_of_mode[SOURCE_WIDTH * SOURCE_HEIGHT];
  static uint8_t undistorted[SOURCE_WIDTH * SOURCE_HEIGHT];
  rg_camera camera;
  assert_int_equal(rg_camera_open(&camera, kModesBlob, sizeof(kModesBlob)),
                   RG_OK);
  for (uint32_t k = 0; k < sizeof(kModesCrcs) / sizeof(kModesCrcs[0]); ++k) {
    rg_grey_image frame = {frame_of_mode, 0, 0, 0};
    uint16_t width, height;
    assert_int_equal(rg_select_remap(&camera, k), RG_OK);
    rg_frame_size(&camera, &frame.width, &frame.height);
    frame.stride = frame.width;
    make_test_frame(frame_of_mode, frame.width, frame.width, frame.height);
    assert_int_equal(rg_remap_size(&camera, &width, &height), RG_OK);
    const rg_grey_target band = {undistorted, width, 0, height, GOLDEN_BORDER};
    assert_int_equal(rg_remap_grey(&camera, &frame, &band), RG_OK);
    assert_int_equal(rg_crc32(0, undistorted, (uint32_t)width * height),
                     kModesCrcs[k]);
    frame.height -= 1;
    assert_int_equal(rg_remap_grey(&camera, &frame, &band), RG_ERR_FRAME_SIZE);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(frames_of_every_format_are_the_golden_ones),
      cmocka_unit_test(bands_make_the_frame),
      cmocka_unit_test(rings_of_the_rows_needed_make_the_frame),
      cmocka_unit_test(rows_told_are_needed),
      cmocka_unit_test(border_values_are_luma_first_and_second_chroma),
      cmocka_unit_test(wrong_calls_are_refused),
      cmocka_unit_test(overlapping_planes_are_refused),
      cmocka_unit_test(odd_addresses_of_words_are_refused),
      cmocka_unit_test(further_tables_may_be_selected),
      cmocka_unit_test(frames_of_every_view_are_the_golden_ones),
      cmocka_unit_test(frames_of_every_mode_are_the_golden_ones),
  };
  return cmocka_run_group_tests(tests, open_wide, NULL);
}
