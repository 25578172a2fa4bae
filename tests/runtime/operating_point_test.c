/* Cameras at a condition of their stack. */
#include <stdlib.h>
#include <string.h>

#include "blob_edit.h"
#include "blob_layout.h"
#include "bytes.h"
#include "crc32.h"
#include "golden_blobs.h"
#include "raygrid.h"
#include "rg_blob.h"
#include "test_frame.h"
#include "unit_test.h"

#define NUM_CONDITIONS (sizeof(kStackCrcs) / sizeof(kStackCrcs[0]))
#define FIRST_VALUE kStackCrcs[1].value_q16
#define MIDDLE_VALUE kStackCrcs[4].value_q16
#define LAST_VALUE kStackCrcs[7].value_q16

static uint8_t edited[sizeof(kStackBlob)] GOLDEN_ALIGNED;

static rg_camera open_stack(void) {
  rg_camera camera;
  assert_int_equal(rg_camera_open(&camera, kStackBlob, sizeof(kStackBlob)),
                   RG_OK);
  return camera;
}

/* The CRC of what the table in use undistorts. */
static uint32_t remap_crc(const rg_camera* camera) {
  static uint8_t frame[320 * 240], output[48 * 36];
  uint16_t width, height;
  make_test_frame(frame, 320, 320, 240);
  assert_int_equal(rg_remap_size(camera, &width, &height), RG_OK);
  const rg_grey_image source = {frame, 320, 320, 240};
  const rg_grey_target band = {output, width, 0, height, GOLDEN_BORDER};
  assert_int_equal(rg_remap_grey(camera, &source, &band), RG_OK);
  return rg_crc32(0, output, (uint32_t)width * height);
}

static rg_status expected_status(int32_t value_q16) {
  return value_q16 < FIRST_VALUE || value_q16 > LAST_VALUE ? RG_EXTRAPOLATED
                                                           : RG_OK;
}

static void frames_are_those_of_the_reference(void** state) {
  (void)state;
  for (uint32_t k = 0; k < NUM_CONDITIONS; ++k) {
    rg_camera camera = open_stack();
    const int32_t value_q16 = kStackCrcs[k].value_q16;
    assert_int_equal(rg_set_operating_point(&camera, value_q16),
                     expected_status(value_q16));
    for (uint32_t table = 0; table < 3; ++table) {
      assert_int_equal(rg_select_remap(&camera, table), RG_OK);
      assert_int_equal(remap_crc(&camera), kStackCrcs[k].crcs[table]);
    }
  }
}

/* A table that was chosen before follows, from condition to condition. */
static void conditions_keep_the_table(void** state) {
  (void)state;
  rg_camera camera = open_stack();
  for (uint32_t table = 0; table < 3; ++table) {
    assert_int_equal(rg_select_remap(&camera, table), RG_OK);
    for (uint32_t k = NUM_CONDITIONS; k-- != 0;) {
      const int32_t value_q16 = kStackCrcs[k].value_q16;
      assert_int_equal(rg_set_operating_point(&camera, value_q16),
                       expected_status(value_q16));
      assert_int_equal(remap_crc(&camera), kStackCrcs[k].crcs[table]);
    }
  }
  /* The table before the first condition of all */
  camera = open_stack();
  assert_int_equal(rg_select_remap(&camera, 2), RG_OK);
  assert_int_equal(rg_set_operating_point(&camera, kStackCrcs[3].value_q16),
                   RG_OK);
  assert_int_equal(remap_crc(&camera), kStackCrcs[3].crcs[2]);
  assert_int_equal(rg_select_remap(&camera, 3), RG_ERR_NO_REMAP);
  assert_int_equal(remap_crc(&camera), kStackCrcs[3].crcs[2]);
}

/* The blob's own sections are the camera at the middle sample. */
static void without_a_condition_the_blobs_own_camera_is_in_use(void** state) {
  (void)state;
  rg_camera camera = open_stack();
  assert_int_equal(rg_select_remap(&camera, 1), RG_OK);
  assert_int_equal(remap_crc(&camera), kStackCrcs[4].crcs[1]);
  rg_camera other = open_stack();
  assert_int_equal(rg_set_operating_point(&other, MIDDLE_VALUE), RG_OK);
  for (int32_t y = 5; y < 120; y += 7) {
    const rg_pixel pixel = {RG_PIXEL(y), RG_PIXEL(y)};
    rg_ray a, b;
    assert_int_equal(rg_unproject(&camera, pixel, &a),
                     rg_unproject(&other, pixel, &b));
    if (rg_unproject(&camera, pixel, &a) == RG_OK)
      assert_memory_equal(&a, &b, sizeof(a));
  }
}

/* Within the rounding of a blend, a ray at a condition lies on the line between
 * those at the samples; and it leads back to its pixel. */
static void rays_lie_between_those_of_the_knots(void** state) {
  (void)state;
  const rg_pixel pixel = {RG_PIXEL(100), RG_PIXEL(40)};
  int32_t last = 0;
  for (int32_t step = 0; step <= 64; ++step) {
    rg_camera camera = open_stack();
    const int32_t value_q16 =
        FIRST_VALUE + (MIDDLE_VALUE - FIRST_VALUE) / 64 * step;
    rg_ray ray;
    rg_pixel back;
    rg_set_operating_point(&camera, value_q16);
    assert_int_equal(rg_unproject(&camera, pixel, &ray), RG_OK);
    if (step > 0) {
      assert_true(ray.x_q30 != last);
      assert_true(labs((long)ray.x_q30 - last) < 1 << 20);
    }
    last = ray.x_q30;
    assert_int_equal(rg_project(&camera, &ray, &back), RG_OK);
    assert_true(labs((long)back.x_q16 - pixel.x_q16) <= 131);
    assert_true(labs((long)back.y_q16 - pixel.y_q16) <= 131);
  }
}

static void fails(rg_camera* camera, int32_t value_q16, rg_status expected) {
  rg_camera before;
  memcpy(&before, camera, sizeof(before));
  assert_int_equal(rg_set_operating_point(camera, value_q16), expected);
  assert_memory_equal(&before, camera, sizeof(before));
}

static void blobs_without_a_stack_have_no_conditions(void** state) {
  (void)state;
  rg_camera camera;
  memset(&camera, 0, sizeof(camera));
  assert_int_equal(rg_camera_open(&camera, kNarrowBlob, sizeof(kNarrowBlob)),
                   RG_OK);
  fails(&camera, 0, RG_ERR_NO_STACK);
}

/* ---- Faults -------------------------------------------------------------- */

static uint32_t stack_offset(void) {
  return (uint32_t)(rg_find_section(kStackBlob, RG_SECTION_STACK, 0) -
                    kStackBlob);
}

static rg_camera open_edited(void) {
  rg_camera camera;
  memset(&camera, 0, sizeof(camera));
  repair_crcs(edited, sizeof(edited));
  assert_int_equal(rg_camera_open(&camera, edited, sizeof(edited)), RG_OK);
  return camera;
}

/* A value in a part of a sample, counted from 1. */
typedef struct fault {
  uint32_t sample, type, index, offset;
  uint8_t size;
  uint32_t value;
} fault;

/* The blob's own sections and the stack's fields, and a sample and its value.
 */
static uint32_t sample_size(void) {
  return stack_offset() + RG_STACK_FIELDS_SIZE -
         (uint32_t)(rg_find_section(kStackBlob, RG_SECTION_CENTRAL_GRID, 0) -
                    kStackBlob);
}

static void make_fault(const fault* made) {
  memcpy(edited, kStackBlob, sizeof(edited));
  const uint8_t* const own =
      rg_find_section(kStackBlob, made->type, made->index);
  uint8_t* const at =
      edited + (own - kStackBlob) + made->sample * sample_size() + made->offset;
  for (uint32_t k = 0; k < made->size; ++k)
    at[k] = (uint8_t)(made->value >> 8 * k);
}

static rg_status open_whole(void) {
  rg_blob blob;
  return rg_blob_open(edited, sizeof(edited), &blob);
}

/* Fields of grids, which boards read in samples. */
static const fault kFaults[] = {
    {1, RG_SECTION_CENTRAL_GRID, 0, RG_GRID_COLUMNS, 2, 8},
    {1, RG_SECTION_CENTRAL_GRID, 0, RG_GRID_CHART, 2, 2},
    {2, RG_SECTION_CENTRAL_GRID, 0, RG_GRID_X0, 4, 1},
    {3, RG_SECTION_CENTRAL_GRID, 0, RG_GRID_DATA_OFFSET, 4, 44},
    {3, RG_SECTION_CENTRAL_GRID, 0, RG_GRID_RESERVED, 4, 1},
    {1, RG_SECTION_INVERSE, 0, RG_GRID_FRACTION_BITS, 2, 29},
    {2, RG_SECTION_INVERSE, 0, RG_GRID_FRACTION_BITS, 2, 20},
    {3, RG_SECTION_INVERSE, 0, RG_INVERSE_COS_LIMIT, 4, 5}};

static void other_grids_are_refused(void** state) {
  (void)state;
  for (uint32_t k = 0; k < sizeof(kFaults) / sizeof(kFaults[0]); ++k) {
    make_fault(&kFaults[k]);
    rg_camera camera = open_edited();
    assert_int_equal(rg_select_remap(&camera, 1), RG_OK);
    fails(&camera, 0, RG_ERR_STACK);
    assert_true(open_whole() != RG_OK);
  }
}

/* Fields of tables, which boards read in the blob's own. Whole readers do not
 * ask for the error that each sample has measured, either. */
static const fault kUnread[] = {
    {1, RG_SECTION_REMAP, 1, RG_REMAP_BLOCK_LOG2, 1, 4},
    {2, RG_SECTION_REMAP, 1, RG_REMAP_ORIGIN, 4, 7},
    {3, RG_SECTION_REMAP, 1, RG_REMAP_DATA_OFFSET, 4, 84},
    {3, RG_SECTION_REMAP, 1, RG_REMAP_COLUMNS, 2, 0xffff},
    {3, RG_SECTION_REMAP, 0, RG_REMAP_PART_LOG2, 1, 0},
    {2, RG_SECTION_REMAP, 0, RG_REMAP_RESIDUAL_SHIFT, 1, 255},
    {2, RG_SECTION_REMAP, 2, RG_VIEW_ROTATION, 4, 4},
    {3, RG_SECTION_REMAP, 1, RG_REMAP_MAX_ERROR_UPX, 4, 84}};

static void fields_of_tables_in_knots_are_not_used(void** state) {
  (void)state;
  for (uint32_t k = 0; k < sizeof(kUnread) / sizeof(kUnread[0]); ++k) {
    make_fault(&kUnread[k]);
    rg_camera camera = open_edited();
    for (uint32_t n = 0; n < NUM_CONDITIONS * 3; ++n) {
      const int32_t value_q16 = kStackCrcs[n / 3].value_q16;
      assert_int_equal(rg_select_remap(&camera, n % 3), RG_OK);
      assert_int_equal(rg_set_operating_point(&camera, value_q16),
                       expected_status(value_q16));
      assert_int_equal(remap_crc(&camera), kStackCrcs[n / 3].crcs[n % 3]);
    }
    assert_int_equal(open_whole() == RG_OK,
                     kUnread[k].offset == RG_REMAP_MAX_ERROR_UPX);
  }
}

/* Boards see how many samples there are by the size of the section. */
static void number_of_knots_is_that_of_the_section(void** state) {
  (void)state;
  static const uint16_t kNumbers[] = {0, 1, 2, 4, 64, 65, 0xffff};
  for (uint32_t k = 0; k < sizeof(kNumbers) / sizeof(kNumbers[0]); ++k) {
    memcpy(edited, kStackBlob, sizeof(edited));
    rg_store_u16(edited + stack_offset() + RG_STACK_KNOTS, kNumbers[k]);
    rg_camera camera = open_edited();
    assert_int_equal(rg_select_remap(&camera, 2), RG_OK);
    assert_int_equal(rg_set_operating_point(&camera, LAST_VALUE), RG_OK);
    assert_int_equal(remap_crc(&camera), kStackCrcs[7].crcs[2]);
    assert_true(open_whole() != RG_OK);
  }
}

static void lines_have_no_conditions(void** state) {
  (void)state;
  static uint8_t large[2 * sizeof(kStackBlob)] GOLDEN_ALIGNED;
  static uint8_t points[RG_LINE_POINTS_FIELDS_SIZE +
                        9 * 8 * RG_LINE_POINT_SIZE] GOLDEN_ALIGNED;
  const uint8_t* const grid =
      rg_find_section(kStackBlob, RG_SECTION_CENTRAL_GRID, 0);
  const uint32_t num = (uint32_t)rg_load_u16(grid + RG_GRID_COLUMNS) *
                       rg_load_u16(grid + RG_GRID_ROWS);
  assert_int_equal(num, 9 * 8);
  rg_store_u16(points, RG_LINE_POINT_BITS);
  rg_store_u32(points + RG_LINE_POINTS_DATA_OFFSET, RG_LINE_POINTS_FIELDS_SIZE);
  blob_section sections[8] = {
      {RG_SECTION_LINE_POINTS, RG_SECTION_CRITICAL, points, sizeof(points)}};
  for (uint32_t n = 0; n < 7; ++n) sections[n + 1] = section_of(kStackBlob, n);
  const uint32_t size = assemble_blob(sections, 8, large);
  rg_camera camera;
  assert_int_equal(rg_camera_open(&camera, large, size), RG_OK);
  fails(&camera, 0, RG_ERR_STACK);
}

/* ---- Bounds -------------------------------------------------------------- */

/* The grids of all whole samples get the fields of the blob's own, from
 * wherever the samples are. */
static void make_grids_alike(uint8_t* blob) {
  static const uint32_t kTypes[] = {RG_SECTION_CENTRAL_GRID,
                                    RG_SECTION_INVERSE};
  const uint32_t num = rg_load_u16(blob + RG_HEADER_SECTION_COUNT);
  const blob_section stack = section_of(blob, num - 1);
  const uint32_t apart =
      (uint32_t)(stack.bytes -
                 rg_find_section(blob, RG_SECTION_CENTRAL_GRID, 0)) +
      RG_STACK_FIELDS_SIZE;
  for (uint32_t shift = apart; shift < stack.size; shift += apart)
    for (uint32_t k = 0; k < 2; ++k) {
      uint8_t* const own = blob + (rg_find_section(blob, kTypes[k], 0) - blob);
      memcpy(own + shift, own, RG_GRID_FIELDS_SIZE);
    }
}

/* Uses all tables and both grids, at conditions of all samples. */
static void use_all(const uint8_t* blob, uint32_t size, rg_status* status) {
  rg_camera camera;
  assert_int_equal(rg_camera_open(&camera, blob, size), RG_OK);
  for (uint32_t n = 0; n < NUM_CONDITIONS * 3; ++n) {
    *status = rg_set_operating_point(&camera, kStackCrcs[n / 3].value_q16);
    if (*status != RG_OK && *status != RG_EXTRAPOLATED) return;
    /* Some processors refuse vertices that are none. */
    if (rg_select_remap(&camera, n % 3) == RG_OK) remap_crc(&camera);
    for (int32_t at = 0; at < 320; at += 29) {
      const rg_pixel pixel = {RG_PIXEL(at), RG_PIXEL(at)};
      rg_ray ray = {0, 0, 1 << 30};
      rg_pixel back;
      rg_unproject(&camera, pixel, &ray);
      rg_project(&camera, &ray, &back);
    }
  }
  *status = RG_OK;
}

/* use_all() of a blob in memory of its own, so that a sanitizer sees what is
 * read beyond; with grids that are alike, or not. */
static rg_status use_copy(const blob_section* sections, uint32_t num,
                          int are_alike) {
  uint32_t size = RG_HEADER_SIZE + RG_SECTION_ENTRY_SIZE * num;
  for (uint32_t k = 0; k < num; ++k) size += sections[k].size;
  uint8_t* const blob = (uint8_t*)malloc(size);
  assert_non_null(blob);
  assert_int_equal(assemble_blob(sections, num, blob), size);
  if (are_alike) make_grids_alike(blob);
  repair_crcs(blob, size);
  rg_status status;
  use_all(blob, size, &status);
  free(blob);
  return status;
}

/* A stack of any size ends behind its last whole sample. */
static void stacks_of_any_size_stay_in_the_blob(void** state) {
  (void)state;
  blob_section sections[7];
  for (uint32_t n = 0; n < 7; ++n) sections[n] = section_of(kStackBlob, n);
  const uint32_t whole = sections[6].size;
  for (uint32_t size = 4; size <= whole; size += size % 1024 < 64 ? 4 : 64) {
    sections[6].size = size;
    assert_int_equal(use_copy(sections, 7, 0),
                     size > sample_size() ? RG_OK : RG_ERR_STACK);
  }
  sections[6].size = sample_size();
  assert_int_equal(use_copy(sections, 7, 0), RG_ERR_STACK);
  sections[6].size = sample_size() + 4;
  assert_int_equal(use_copy(sections, 7, 0), RG_OK);
}

/* Whole readers refuse sections apart. Boards see another size of the samples
 * then, whose grids are none; and if these are, they stay in the blob. */
static void sections_apart_stay_in_the_blob(void** state) {
  (void)state;
  static const uint32_t kMoved[][2] = {{5, 0}, {2, 0}, {2, 1}, {1, 5}, {0, 5}};
  for (uint32_t k = 0; k < sizeof(kMoved) / sizeof(kMoved[0]); ++k) {
    const uint32_t from = kMoved[k][0], to = kMoved[k][1];
    blob_section sections[7];
    for (uint32_t n = 0; n < 7; ++n) sections[n] = section_of(kStackBlob, n);
    const blob_section moved = sections[from];
    for (uint32_t n = from; n > to; --n) sections[n] = sections[n - 1];
    for (uint32_t n = from; n < to; ++n) sections[n] = sections[n + 1];
    sections[to] = moved;
    assert_int_equal(assemble_blob(sections, 7, edited), sizeof(edited));
    assert_int_equal(open_copy(edited, sizeof(edited)), RG_ERR_STACK);
    assert_int_equal(use_copy(sections, 7, 0), RG_ERR_STACK);
    assert_int_equal(use_copy(sections, 7, 1), RG_OK);
  }
}

static void a_stack_that_is_not_last_is_none(void** state) {
  (void)state;
  blob_section sections[7];
  for (uint32_t n = 0; n < 7; ++n) sections[n] = section_of(kStackBlob, n);
  const blob_section camera = sections[0];
  for (uint32_t n = 0; n < 6; ++n) sections[n] = sections[n + 1];
  sections[6] = camera;
  assert_int_equal(assemble_blob(sections, 7, edited), sizeof(edited));
  assert_int_equal(open_copy(edited, sizeof(edited)), RG_ERR_STACK);
  rg_camera opened = open_edited();
  fails(&opened, 0, RG_ERR_NO_STACK);
}

/* Values that do not ascend, which whole readers refuse, harm nothing. */
static void values_in_no_order_harm_nothing(void** state) {
  (void)state;
  static const int32_t kValues[] = {INT32_MIN, -1, 0, 1, 65536, INT32_MAX};
  uint8_t* const fields = edited + stack_offset();
  for (uint32_t k = 0; k < 6 * 6 * 6; ++k) {
    memcpy(edited, kStackBlob, sizeof(edited));
    rg_store_i32(fields + sample_size(), kValues[k % 6]);
    rg_store_i32(fields + 2 * sample_size(), kValues[k / 6 % 6]);
    rg_store_i32(fields + 3 * sample_size(), kValues[k / 36]);
    rg_camera camera = open_edited();
    assert_int_equal(rg_select_remap(&camera, 0), RG_OK);
    for (uint32_t v = 0; v < 6; ++v) {
      const rg_status status = rg_set_operating_point(&camera, kValues[v]);
      assert_true(status == RG_OK || status == RG_EXTRAPOLATED);
      assert_true(camera.weight_q14 < 1 << 14);
      remap_crc(&camera);
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(frames_are_those_of_the_reference),
      cmocka_unit_test(conditions_keep_the_table),
      cmocka_unit_test(without_a_condition_the_blobs_own_camera_is_in_use),
      cmocka_unit_test(rays_lie_between_those_of_the_knots),
      cmocka_unit_test(blobs_without_a_stack_have_no_conditions),
      cmocka_unit_test(other_grids_are_refused),
      cmocka_unit_test(fields_of_tables_in_knots_are_not_used),
      cmocka_unit_test(number_of_knots_is_that_of_the_section),
      cmocka_unit_test(lines_have_no_conditions),
      cmocka_unit_test(stacks_of_any_size_stay_in_the_blob),
      cmocka_unit_test(sections_apart_stay_in_the_blob),
      cmocka_unit_test(a_stack_that_is_not_last_is_none),
      cmocka_unit_test(values_in_no_order_harm_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
