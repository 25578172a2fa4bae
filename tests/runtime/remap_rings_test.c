/* Frames of every format, each plane in memory of exactly its size; and the
 * same from a ring of rows that holds no more than a band of the output needs.
 */
#if defined(__linux__)
#define _GNU_SOURCE
#endif
#include <string.h>

#include "frames/pixel_formats.h"
#include "random_tables.h"

#if defined(__x86_64__)
#define NUM_CASES 10000u
#elif defined(__unix__)
#define NUM_CASES 1000u /* emulated */
#else
#define NUM_CASES 60u
#endif

/* Four samples of 16 bits a pixel at most. */
static uint8_t from_frame[3][8 * MAX_SIZE * MAX_SIZE];
static uint8_t from_ring[3][8 * MAX_SIZE * MAX_SIZE];

/* Bytes of a row of a plane, and rows, of an image of so many. */
typedef struct plane_size {
  uint32_t row_bytes, num_rows;
} plane_size;

static plane_size size_of_plane(rg_format format, uint32_t plane,
                                uint32_t width, uint32_t num_rows) {
  plane_size size = {0, 0};
  rg_component component;
  for (uint32_t k = 0; rg_get_component(format, k, &component); ++k) {
    if (component.plane != plane) continue;
    size.row_bytes = rg_plane_row_bytes(&component, width);
    size.num_rows = (num_rows >> component.log2[1]) * component.row_step;
  }
  return size;
}

static exact_memory new_plane(plane_size size) {
  exact_memory memory = new_memory((size_t)size.row_bytes * size.num_rows);
  for (uint32_t i = 0; i < size.row_bytes * size.num_rows; ++i)
    memory.bytes[i] = (uint8_t)below(256);
  return memory;
}

static void remap_to(uint8_t (*out)[8 * MAX_SIZE * MAX_SIZE],
                     const rg_image* image, rg_target* target) {
  for (uint32_t p = 0; p < 3; ++p) {
    memset(out[p], 0xc3, sizeof(out[p]));
    target->planes[p].data = out[p];
  }
  assert_int_equal(rg_remap(&camera, image, target), RG_OK);
}

/* The image's rows that a band needs, in a ring of a few more. */
static void remap_from_ring(const rg_image* frame, rg_target* target) {
  const uint32_t pairs = rg_row_pairs(frame->format);
  rg_image ring = *frame;
  exact_memory memory[3];
  assert_int_equal(
      rg_remap_source_rows(&camera, frame->format, target->first_row,
                           target->num_rows, &ring.first_row, &ring.num_rows),
      RG_OK);
  ring.ring_rows = (uint16_t)(ring.num_rows + below(3) * (1 + pairs));
  if (ring.ring_rows == 0) ring.ring_rows = 2;
  for (uint32_t p = 0; p < 3; ++p) {
    const plane_size image =
        size_of_plane(frame->format, p, frame->width, frame->height);
    const plane_size size =
        size_of_plane(frame->format, p, frame->width, ring.ring_rows);
    if (size.row_bytes == 0) continue;
    const uint32_t shift = image.num_rows < frame->height;
    const uint32_t first = (uint32_t)ring.first_row >> shift;
    const uint32_t end = first + ((uint32_t)ring.num_rows >> shift);
    memory[p] = new_plane(size);
    ring.planes[p].data = memory[p].bytes;
    for (uint32_t row = first; row < end; ++row)
      memcpy(memory[p].bytes + row % size.num_rows * size.row_bytes,
             frame->planes[p].data + row * size.row_bytes, size.row_bytes);
  }
  remap_to(from_ring, &ring, target);
  for (uint32_t p = 0; p < 3; ++p)
    if (ring.planes[p].data != frame->planes[p].data) free_memory(&memory[p]);
}

static void check_frame(rg_format format) {
  rg_image image;
  rg_target target;
  exact_memory memory[3];
  memset(&image, 0, sizeof(image));
  memset(&target, 0, sizeof(target));
  uint16_t width, height;
  rg_remap_size(&camera, &width, &height);
  image.format = format;
  image.width = camera.frame_width;
  image.height = camera.frame_height;
  target.sampling = below(2) == 0 ? RG_SAMPLING_NEAREST : RG_SAMPLING_BILINEAR;
  target.border = below(2) == 0 ? RG_BORDER_VALUE : RG_BORDER_KEEP;
  target.first_row = (uint16_t)(below(height) & ~1u);
  target.num_rows = (uint16_t)((1 + below(height - target.first_row)) & ~1u);
  for (uint32_t p = 0; p < 3; ++p) {
    const plane_size size = size_of_plane(format, p, image.width, image.height);
    if (size.row_bytes == 0) continue;
    memory[p] = new_plane(size);
    image.planes[p].data = memory[p].bytes;
    image.planes[p].stride = size.row_bytes;
    target.planes[p].stride = size_of_plane(format, p, width, height).row_bytes;
  }
  remap_to(from_frame, &image, &target);
  remap_from_ring(&image, &target);
  assert_memory_equal(from_ring, from_frame, sizeof(from_ring));
  for (uint32_t p = 0; p < 3; ++p)
    if (image.planes[p].data) free_memory(&memory[p]);
}

static void rings_give_what_frames_give(void** context) {
  (void)context;
  for (uint32_t k = 0; k < NUM_CASES; ++k) {
    state = 4321 + 7919 * k;
    if (make_table(k % NUM_STYLES, 4))
      check_frame(k / NUM_STYLES % RG_NUM_FORMATS);
  }
}

/* A table of one block of 8, for frames of 32 x 32 pixels. */
static rg_remap_section new_table(uint16_t width, uint16_t height) {
  static const uint8_t empty[4] = {0};
  rg_remap_section table;
  memset(&table, 0, sizeof(table));
  table.width = width;
  table.height = height;
  table.block_log2 = 3;
  table.columns = table.rows = 2;
  table.max_x_q12 = table.max_y_q12 = 31 << 12;
  table.fx_q16 = table.fy_q16 = 1;
  table.empty_blocks = empty;
  return table;
}

static void use_table(const rg_remap_section* table) {
  static const int16_t residuals[8] = {0};
  rg_write_remap(table, residuals, SECTION);
  memset(&camera, 0, sizeof(camera));
  camera.frame_width = camera.frame_height = 32;
  camera.remap = SECTION;
}

/* A source row that begins a ring, and corners that lie just below it: rounding
 * of steps takes pixels above it. */
static void rounding_may_lead_before_a_ring(void** context) {
  (void)context;
  uint8_t rows[4 * 32];
  for (uint32_t i = 0; i < sizeof(rows); ++i) rows[i] = (uint8_t)(10 + i / 32);
  rg_remap_section table = new_table(8, 8);
  table.origin_x_q12 = table.column_step_x_q12 = 8 << 12;
  table.origin_y_q12 = (12 << 12) + 6;
  table.column_step_y_q12 = -6;
  use_table(&table);
  rg_image image;
  rg_target target;
  uint8_t out[64];
  memset(&image, 0, sizeof(image));
  memset(&target, 0, sizeof(target));
  image.width = image.height = 32;
  image.ring_rows = 4;
  image.planes[0].data = rows;
  image.planes[0].stride = 32;
  target.planes[0].data = out;
  target.planes[0].stride = 8;
  target.num_rows = 8;
  assert_int_equal(rg_remap_source_rows(&camera, RG_FORMAT_GREY8, 0, 8,
                                        &image.first_row, &image.num_rows),
                   RG_OK);
  assert_int_equal(image.first_row, 11);
  assert_int_equal(rg_remap(&camera, &image, &target), RG_OK);
  for (uint32_t i = 0; i < sizeof(out); ++i) assert_int_equal(out[i], 10);
}

/* The chroma component of a table of one column has no pixels: there is no
 * frame, but its rows may be asked for. */
static void lattice_of_no_pixels_needs_no_rows(void** context) {
  (void)context;
  rg_remap_section table = new_table(1, 2);
  table.origin_x_q12 = -50000;
  use_table(&table);
  uint16_t first, num;
  assert_int_equal(
      rg_remap_source_rows(&camera, RG_FORMAT_NV12, 0, 2, &first, &num), RG_OK);
  assert_int_equal(num, 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(rings_give_what_frames_give),
      cmocka_unit_test(rounding_may_lead_before_a_ring),
      cmocka_unit_test(lattice_of_no_pixels_needs_no_rows),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
