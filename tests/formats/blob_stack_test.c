/* Stacks are written and read byte for byte. */
#include <string.h>

#include "blob_edit.h"
#include "bytes.h"
#include "golden_blobs.h"
#include "narrow_grid.h"
#include "rg_blob.h"
#include "unit_test.h"

#define SIZE ((uint32_t)sizeof(kStackBlob))
#define KNOTS 3u
#define TABLES 3u

/* The parts of the blob itself (number KNOTS) or of a sample, as they are given
 * to the writer. */
typedef struct knot_parts {
  rg_narrow_grid narrow, inverse_points;
  int16_t grid_residuals[256], inverse_residuals[256];
  rg_remap_section tables[TABLES];
  rg_remap_contents remaps[TABLES];
  int16_t residuals[TABLES][128];
  int8_t bends[TABLES][128];
} knot_parts;

static knot_parts parts[KNOTS + 1];
static rg_stack_sample_contents samples[KNOTS];
static rg_stack_contents stack;
static rg_camera_section camera;
static rg_grid_section grid;
static rg_inverse_section inverse;
static rg_blob_contents contents;
static uint8_t written[sizeof(kStackBlob)] GOLDEN_ALIGNED;

static void take_table(const uint8_t* section, uint32_t k, knot_parts* to) {
  rg_remap_section* const table = &to->tables[k];
  rg_read_remap(section, table);
  const uint8_t* vertex = table->vertices;
  for (uint32_t i = 0; i < (uint32_t)table->columns * table->rows; ++i) {
    for (uint32_t c = 0; c < 2; ++c)
      to->residuals[k][2 * i + c] = rg_load_i16(vertex + 2 * c);
    vertex += RG_VERTEX_SIZE;
    if (table->part_log2 == 0) continue;
    memcpy(to->bends[k] + 4 * i, vertex, 4);
    vertex += RG_BENT_VERTEX_SIZE - RG_VERTEX_SIZE;
  }
  table->bends = to->bends[k];
  to->remaps[k].section = table;
  to->remaps[k].residuals = to->residuals[k];
}

/* In the order of the golden blob. */
static void take_apart(void) {
  rg_blob blob;
  rg_stack_section section;
  assert_int_equal(rg_blob_open(kStackBlob, SIZE, &blob), RG_OK);
  rg_blob_camera(&blob, &camera);
  rg_blob_grid(&blob, &grid);
  rg_blob_inverse(&blob, &inverse);
  rg_blob_stack(&blob, &section);
  assert_int_equal(section.condition, RG_OPERATING_PARAMETER_LENS_POSITION);
  assert_int_equal(section.num_samples, KNOTS);
  static const uint32_t kTypes[] = {RG_SECTION_CENTRAL_GRID, RG_SECTION_REMAP,
                                    RG_SECTION_REMAP, RG_SECTION_REMAP,
                                    RG_SECTION_INVERSE};
  for (uint32_t k = 0; k <= KNOTS; ++k) {
    uint32_t at = k * section.sample_size;
    for (uint32_t n = 0; n < 5; ++n) {
      const uint32_t index = kTypes[n] == RG_SECTION_REMAP ? n - 1 : 0;
      const uint8_t* const own = rg_find_section(kStackBlob, kTypes[n], index);
      const uint8_t* const part = k == KNOTS ? own : section.samples + at;
      if (n == 0)
        read_narrow_grid(part, parts[k].grid_residuals, &parts[k].narrow);
      else if (n == 4)
        read_narrow_grid(part, parts[k].inverse_residuals,
                         &parts[k].inverse_points);
      else
        take_table(part, index, &parts[k]);
      const uint8_t* entry = kStackBlob + RG_HEADER_SIZE;
      while (kStackBlob + rg_load_u32(entry + RG_ENTRY_OFFSET) != own)
        entry += RG_SECTION_ENTRY_SIZE;
      at += rg_load_u32(entry + RG_ENTRY_SIZE);
    }
    if (k == KNOTS) break;
    assert_int_equal(at + RG_STACK_SAMPLE_VALUE_SIZE,
                     (k + 1) * section.sample_size);
    const rg_stack_sample_contents sample = {
        .value_q16 = rg_stack_sample_value(&section, k),
        .narrow = &parts[k].narrow,
        .inverse_points = &parts[k].inverse_points,
        .remaps = parts[k].remaps};
    samples[k] = sample;
  }
  const rg_stack_contents whole = {section.condition, section.num_samples,
                                   samples};
  stack = whole;
  const knot_parts* const own = &parts[KNOTS];
  const rg_blob_contents all = {.camera = &camera,
                                .grid = &grid,
                                .narrow = &own->narrow,
                                .remap = own->remaps[0].section,
                                .residuals = own->remaps[0].residuals,
                                .inverse = &inverse,
                                .inverse_points = &own->inverse_points,
                                .more_remaps = own->remaps + 1,
                                .num_more_remaps = TABLES - 1,
                                .stack = &stack};
  contents = all;
}

static rg_status write_all(void) {
  return rg_blob_write(&contents, written, SIZE);
}

static void stack_is_written_byte_for_byte(void** state) {
  (void)state;
  take_apart();
  assert_int_equal(rg_blob_size(&contents), SIZE);
  assert_int_equal(write_all(), RG_OK);
  assert_memory_equal(written, kStackBlob, SIZE);
}

/* Sections that samples have no like of stand in front of the others. */
static void stack_stands_behind_all_else(void** state) {
  (void)state;
  static uint8_t large[sizeof(kStackBlob) + 64] GOLDEN_ALIGNED;
  static const uint16_t kTypes[] = {
      RG_SECTION_CAMERA,  RG_SECTION_ROW_TIME, RG_SECTION_CENTRAL_GRID,
      RG_SECTION_REMAP,   RG_SECTION_REMAP,    RG_SECTION_REMAP,
      RG_SECTION_INVERSE, RG_SECTION_STACK};
  const rg_row_time_section row_time = {10 << 10, 0};
  take_apart();
  contents.row_time = &row_time;
  assert_int_equal(rg_blob_write(&contents, large, sizeof(large)), RG_OK);
  assert_int_equal(rg_load_u16(large + RG_HEADER_SECTION_COUNT), 8);
  for (uint32_t k = 0; k < 8; ++k)
    assert_int_equal(section_of(large, k).type, kTypes[k]);
  const blob_section stack_section = section_of(large, 7);
  assert_int_equal(stack_section.size, section_of(kStackBlob, 6).size);
}

static void missing_parts_are_refused(void** state) {
  (void)state;
  take_apart();
  samples[1].narrow = NULL;
  assert_int_equal(write_all(), RG_ERR_ARGUMENT);
  take_apart();
  samples[2].inverse_points = NULL;
  assert_int_equal(write_all(), RG_ERR_ARGUMENT);
  take_apart();
  samples[0].remaps = NULL;
  assert_int_equal(write_all(), RG_ERR_ARGUMENT);
  take_apart();
  parts[0].remaps[2].residuals = NULL;
  assert_int_equal(write_all(), RG_ERR_ARGUMENT);
  take_apart();
  stack.samples = NULL;
  assert_int_equal(write_all(), RG_ERR_ARGUMENT);
}

static void other_tables_than_the_blobs_are_refused(void** state) {
  (void)state;
  take_apart();
  ++parts[1].tables[0].columns;
  assert_int_equal(write_all(), RG_ERR_ARGUMENT);
  take_apart();
  parts[1].tables[1].part_log2 = 3; /* which has bends */
  assert_int_equal(write_all(), RG_ERR_ARGUMENT);
  take_apart();
  ++parts[2].tables[2].residual_shift;
  assert_int_equal(write_all(), RG_ERR_STACK);
  take_apart();
  ++parts[2].tables[2].row_step_y_q12;
  assert_int_equal(write_all(), RG_ERR_STACK);
  take_apart();
  ++parts[2].tables[2].max_error_upx;
  assert_int_equal(write_all(), RG_OK);
  take_apart();
  static const uint8_t kNoneEmpty[4] = {0};
  parts[1].tables[1].empty_blocks = kNoneEmpty;
  assert_int_equal(write_all(), RG_ERR_STACK);
  take_apart();
  parts[1].narrow.fraction_bits = 20;
  assert_int_equal(write_all(), RG_ERR_STACK);
}

static void stacks_of_lines_are_refused(void** state) {
  (void)state;
  static const int32_t line_points[3 * 256];
  static uint8_t large[2 * sizeof(kStackBlob)] GOLDEN_ALIGNED;
  take_apart();
  contents.line_points_q28 = line_points;
  assert_int_equal(rg_blob_write(&contents, large, sizeof(large)),
                   RG_ERR_STACK);
  contents.stack = NULL;
  assert_int_equal(rg_blob_write(&contents, large, sizeof(large)), RG_OK);
}

/* A whole reader checks in each sample what no board does. */
static void values_beyond_their_limits_are_refused(void** state) {
  (void)state;
  take_apart();
  parts[2].narrow.origin_q29[1] = RG_CONTROL_POINT_LIMIT;
  assert_int_equal(write_all(), RG_ERR_CONTROL_POINT);
  take_apart();
  parts[1].inverse_points.row_step_q29[0] = 1 << 28;
  assert_int_equal(write_all(), RG_ERR_CONTROL_POINT);
}

/* With the stack's section twice, or cut off behind so many bytes. */
static rg_status open_with_stack(uint32_t num_copies, uint32_t size) {
  static uint8_t bytes[2 * sizeof(kStackBlob)] GOLDEN_ALIGNED;
  blob_section sections[RG_MAX_SECTIONS];
  const uint32_t num = rg_load_u16(kStackBlob + RG_HEADER_SECTION_COUNT);
  for (uint32_t k = 0; k < num; ++k) sections[k] = section_of(kStackBlob, k);
  if (size != 0) sections[num - 1].size = size;
  sections[num] = sections[num - 1];
  return open_copy(bytes, assemble_blob(sections, num - 1 + num_copies, bytes));
}

static void stack_stands_once_and_whole(void** state) {
  (void)state;
  assert_int_equal(open_with_stack(0, 0), RG_OK);
  assert_int_equal(open_with_stack(1, 0), RG_OK);
  assert_int_equal(open_with_stack(2, 0), RG_ERR_SECTION_DUPLICATE);
  for (uint32_t size = 4; size < 200; size += 4)
    assert_int_equal(open_with_stack(1, size), RG_ERR_SECTION_SIZE);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(stack_is_written_byte_for_byte),
      cmocka_unit_test(stack_stands_behind_all_else),
      cmocka_unit_test(stack_stands_once_and_whole),
      cmocka_unit_test(missing_parts_are_refused),
      cmocka_unit_test(other_tables_than_the_blobs_are_refused),
      cmocka_unit_test(stacks_of_lines_are_refused),
      cmocka_unit_test(values_beyond_their_limits_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
