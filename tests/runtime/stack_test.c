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
  const rg_frame source = {frame, 320, 320, 240};
  const rg_band band = {output, width, 0, height, GOLDEN_BORDER};
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
    assert_int_equal(rg_set_condition(&camera, value_q16),
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
      assert_int_equal(rg_set_condition(&camera, value_q16),
                       expected_status(value_q16));
      assert_int_equal(remap_crc(&camera), kStackCrcs[k].crcs[table]);
    }
  }
  /* The table before the first condition of all */
  camera = open_stack();
  assert_int_equal(rg_select_remap(&camera, 2), RG_OK);
  assert_int_equal(rg_set_condition(&camera, kStackCrcs[3].value_q16), RG_OK);
  assert_int_equal(remap_crc(&camera), kStackCrcs[3].crcs[2]);
  assert_int_equal(rg_select_remap(&camera, 3), RG_ERR_NO_REMAP);
  assert_int_equal(remap_crc(&camera), kStackCrcs[3].crcs[2]);
}

/* The blob's own sections are the camera at the middle knot. */
static void without_a_condition_the_blobs_own_camera_is_in_use(void** state) {
  (void)state;
  rg_camera camera = open_stack();
  assert_int_equal(rg_select_remap(&camera, 1), RG_OK);
  assert_int_equal(remap_crc(&camera), kStackCrcs[4].crcs[1]);
  rg_camera other = open_stack();
  assert_int_equal(rg_set_condition(&other, MIDDLE_VALUE), RG_OK);
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
 * those at the knots; and it leads back to its pixel. */
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
    rg_set_condition(&camera, value_q16);
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
  assert_int_equal(rg_set_condition(camera, value_q16), expected);
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

typedef struct fault {
  uint32_t knot; /* 0: fields of the section itself */
  uint32_t type, index, offset;
  uint8_t size;
  uint32_t value;
  rg_status expected; /* of a board */
} fault;

static const fault kFaults[] = {
    {0, 0, 0, RG_STACK_KNOTS, 2, 1, RG_ERR_STACK},
    {0, 0, 0, RG_STACK_KNOTS, 2, 0, RG_ERR_STACK},
    {0, 0, 0, RG_STACK_KNOTS, 2, 65, RG_ERR_STACK},
    {0, 0, 0, RG_STACK_KNOTS, 2, 2, RG_ERR_SECTION_SIZE},
    {0, 0, 0, RG_STACK_KNOTS, 2, 4, RG_ERR_DATA_OFFSET},
    {0, 0, 0, RG_STACK_KNOT_SIZE, 4, 0, RG_ERR_SECTION_SIZE},
    {0, 0, 0, RG_STACK_KNOT_SIZE, 4, 0x80000000, RG_ERR_SECTION_SIZE},
    {0, 0, 0, RG_STACK_DATA_OFFSET, 4, 16, RG_ERR_DATA_OFFSET},
    {0, 0, 0, RG_STACK_DATA_OFFSET, 4, 25, RG_ERR_DATA_OFFSET},
    {0, 0, 0, RG_STACK_DATA_OFFSET, 4, 28, RG_ERR_SECTION_SIZE},
    {0, 0, 0, RG_STACK_DATA_OFFSET, 4, 0x7ffffffc, RG_ERR_SECTION_SIZE},
    {1, RG_SECTION_CENTRAL_GRID, 0, RG_GRID_COLUMNS, 2, 8, RG_ERR_STACK},
    {1, RG_SECTION_CENTRAL_GRID, 0, RG_GRID_CHART, 2, 2, RG_ERR_STACK},
    {2, RG_SECTION_CENTRAL_GRID, 0, RG_GRID_X0, 4, 1, RG_ERR_STACK},
    {3, RG_SECTION_CENTRAL_GRID, 0, RG_GRID_DATA_OFFSET, 4, 44, RG_ERR_STACK},
    {1, RG_SECTION_INVERSE, 0, RG_GRID_FRACTION_BITS, 2, 29, RG_ERR_STACK},
    {2, RG_SECTION_INVERSE, 0, RG_GRID_FRACTION_BITS, 2, 20, RG_ERR_STACK},
    {3, RG_SECTION_INVERSE, 0, RG_INVERSE_COS_LIMIT, 4, 5, RG_ERR_STACK},
    {1, RG_SECTION_REMAP, 1, RG_REMAP_BLOCK_LOG2, 1, 4, RG_ERR_STACK},
    {2, RG_SECTION_REMAP, 1, RG_REMAP_ORIGIN, 4, 7, RG_ERR_STACK},
    {3, RG_SECTION_REMAP, 1, RG_REMAP_DATA_OFFSET, 4, 84, RG_ERR_STACK},
    {3, RG_SECTION_REMAP, 1, RG_REMAP_MAX_ERROR_UPX, 4, 84, RG_OK},
    {3, RG_SECTION_REMAP, 0, RG_REMAP_BLOCK_LOG2, 1, 4, RG_ERR_STACK},
    {2, RG_SECTION_REMAP, 2, RG_VIEW_ROTATION, 4, 4, RG_ERR_STACK}};

/* The offset of a part of a knot, counted from 1, in the blob. */
static uint32_t part_offset(const fault* of) {
  rg_blob blob;
  rg_stack_section stack;
  assert_int_equal(rg_blob_open(kStackBlob, sizeof(kStackBlob), &blob), RG_OK);
  rg_blob_stack(&blob, &stack);
  const uint8_t* const knot = stack.knots + (of->knot - 1) * stack.knot_size;
  const uint8_t* const own = rg_find_section(kStackBlob, of->type, of->index);
  const uint8_t* const first =
      rg_find_section(kStackBlob, RG_SECTION_CENTRAL_GRID, 0);
  return (uint32_t)(knot - kStackBlob + (own - first));
}

static void make_fault(const fault* made) {
  memcpy(edited, kStackBlob, sizeof(edited));
  const uint32_t at =
      (made->knot == 0 ? stack_offset() : part_offset(made)) + made->offset;
  for (uint32_t k = 0; k < made->size; ++k)
    edited[at + k] = (uint8_t)(made->value >> 8 * k);
}

/* With table 1, which was chosen before; and the whole reader refuses as well,
 * but for an error that each knot has measured. */
static void faults_are_refused(void** state) {
  (void)state;
  for (uint32_t k = 0; k < sizeof(kFaults) / sizeof(kFaults[0]); ++k) {
    make_fault(&kFaults[k]);
    rg_camera camera = open_edited();
    assert_int_equal(rg_select_remap(&camera, 1), RG_OK);
    if (kFaults[k].expected == RG_OK)
      assert_int_equal(rg_set_condition(&camera, 0), RG_OK);
    else
      fails(&camera, 0, kFaults[k].expected);
    rg_blob blob;
    const int is_whole = rg_blob_open(edited, sizeof(edited), &blob) == RG_OK;
    assert_int_equal(is_whole, kFaults[k].offset == RG_REMAP_MAX_ERROR_UPX);
  }
}

/* Sections that knots have their like of are together, the grid first. */
static void sections_apart_are_refused(void** state) {
  (void)state;
  static const uint32_t kMoved[][2] = {{5, 0}, {2, 0}, {2, 1}, {4, 6}};
  const uint32_t num = rg_load_u16(kStackBlob + RG_HEADER_SECTION_COUNT);
  for (uint32_t k = 0; k < sizeof(kMoved) / sizeof(kMoved[0]); ++k) {
    const uint32_t from = kMoved[k][0], to = kMoved[k][1];
    blob_section sections[7];
    assert_int_equal(num, 7);
    for (uint32_t n = 0; n < num; ++n) sections[n] = section_of(kStackBlob, n);
    const blob_section moved = sections[from];
    for (uint32_t n = from; n > to; --n) sections[n] = sections[n - 1];
    for (uint32_t n = from; n < to; ++n) sections[n] = sections[n + 1];
    sections[to] = moved;
    assert_int_equal(assemble_blob(sections, num, edited), sizeof(edited));
    rg_camera camera;
    assert_int_equal(rg_camera_open(&camera, edited, sizeof(edited)), RG_OK);
    fails(&camera, 0, RG_ERR_STACK);
    assert_int_equal(open_copy(edited, sizeof(edited)), RG_ERR_STACK);
  }
}

/* Two knots that could lie at odd addresses. */
static void knots_of_whole_words_are_asked_for(void** state) {
  (void)state;
  enum {
    kKnotSize = 1446,
    kDataOffset = 24,
    kSize = kDataOffset + 2 * kKnotSize
  };
  blob_section sections[7];
  for (uint32_t n = 0; n < 7; ++n) sections[n] = section_of(kStackBlob, n);
  static uint8_t stack[kSize] GOLDEN_ALIGNED;
  assert_true(kSize <= sections[6].size);
  memcpy(stack, sections[6].bytes, kSize);
  rg_store_u16(stack + RG_STACK_KNOTS, 2);
  rg_store_u32(stack + RG_STACK_KNOT_SIZE, kKnotSize);
  sections[6].bytes = stack;
  sections[6].size = kSize;
  const uint32_t size = assemble_blob(sections, 7, edited);
  rg_camera camera;
  assert_int_equal(rg_camera_open(&camera, edited, size), RG_OK);
  fails(&camera, 0, RG_ERR_STACK);
  assert_int_equal(open_copy(edited, size), RG_ERR_STACK);
}

/* Values that do not ascend, which whole readers refuse, harm nothing. */
static void values_in_no_order_harm_nothing(void** state) {
  (void)state;
  static const int32_t kValues[] = {INT32_MIN, -1, 0, 1, 65536, INT32_MAX};
  const uint32_t at = stack_offset() + RG_STACK_FIELDS_SIZE;
  for (uint32_t k = 0; k < 6 * 6 * 6; ++k) {
    memcpy(edited, kStackBlob, sizeof(edited));
    rg_store_i32(edited + at, kValues[k % 6]);
    rg_store_i32(edited + at + 4, kValues[k / 6 % 6]);
    rg_store_i32(edited + at + 8, kValues[k / 36]);
    rg_camera camera = open_edited();
    assert_int_equal(rg_select_remap(&camera, 0), RG_OK);
    for (uint32_t v = 0; v < 6; ++v) {
      const rg_status status = rg_set_condition(&camera, kValues[v]);
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
      cmocka_unit_test(faults_are_refused),
      cmocka_unit_test(sections_apart_are_refused),
      cmocka_unit_test(knots_of_whole_words_are_asked_for),
      cmocka_unit_test(values_in_no_order_harm_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
