#include <string.h>

#include "bytes.h"
#include "golden_blobs.h"
#include "rg_blob.h"
#include "unit_test.h"

#define SIZE ((uint32_t)sizeof(kExampleBlob))

static uint8_t written[8192] __attribute__((aligned(4)));

/* The contents of a golden blob, for altering and writing. */
typedef struct camera_parts {
  rg_camera_section camera;
  rg_grid_section grid;
  int32_t control_points[2 * 19 * 15];
  rg_remap_section remap;
  int16_t residuals[256];
  int8_t bends[64];
  rg_remap_section second_remap;
  int16_t second_residuals[256];
  int8_t second_bends[64];
  rg_remap_contents more_remaps[1];
  rg_quality_section quality;
  rg_inverse_section inverse;
  rg_narrow_grid inverse_points;
  int16_t inverse_residuals[512];
  int32_t line_points[3 * 16];
  rg_mask_section mask;
  rg_uncertainty_section uncertainty;
  uint16_t uncertainties[16];
  rg_capture_section capture;
  rg_row_time_section row_time;
  rg_blob_contents contents;
} camera_parts;

static camera_parts parts;

static void copy_arrays(void) {
  const uint32_t num_points = 2u * parts.grid.columns * parts.grid.rows;
  for (uint32_t i = 0; i < num_points; ++i)
    parts.control_points[i] = rg_load_i32(parts.grid.control_points + 4 * i);
}

static void take_remap(const uint8_t* section, rg_remap_section* remap,
                       int16_t* residuals, int8_t* bends) {
  rg_read_remap(section, remap);
  const uint32_t count = (uint32_t)remap->columns * remap->rows;
  const uint8_t* vertex = remap->vertices;
  for (uint32_t i = 0; i < count; ++i) {
    for (uint32_t c = 0; c < 2; ++c)
      residuals[2 * i + c] = rg_load_i16(vertex + 2 * c);
    if (remap->part_log2 != 0) memcpy(bends + 4 * i, vertex + 4, 4);
    vertex += remap->part_log2 != 0 ? 8 : 4;
  }
  remap->bends = bends;
}

/* The plane and the residuals behind it. */
static void take_narrow(const uint8_t* data, uint32_t fraction_bits,
                        uint32_t num_residuals, int16_t* residuals,
                        rg_narrow_grid* narrow) {
  narrow->fraction_bits = fraction_bits;
  narrow->residuals = residuals;
  for (uint32_t c = 0; c < 2; ++c) {
    narrow->origin_q29[c] = rg_load_i32(data + 4 * c);
    narrow->column_step_q29[c] = rg_load_i32(data + 8 + 4 * c);
    narrow->row_step_q29[c] = rg_load_i32(data + 16 + 4 * c);
  }
  for (uint32_t i = 0; i < num_residuals; ++i)
    residuals[i] = rg_load_i16(data + RG_NARROW_PLANE_SIZE + 2 * i);
}

static void take_inverse(const rg_blob* blob) {
  const uint8_t* const section = blob->bytes + blob->inverse;
  rg_blob_inverse(blob, &parts.inverse);
  take_narrow(section + rg_load_u32(section + 32), rg_load_u16(section + 30),
              2u * parts.inverse.columns * parts.inverse.rows,
              parts.inverse_residuals, &parts.inverse_points);
  parts.contents.inverse = &parts.inverse;
  parts.contents.inverse_points = &parts.inverse_points;
}

static void take_line_points(const rg_blob* blob) {
  const uint8_t* const points = rg_blob_line_points(blob);
  for (uint32_t i = 0; i < 3 * 16; ++i)
    parts.line_points[i] = rg_load_i32(points + 4 * i);
  parts.contents.line_points_q28 = parts.line_points;
}

static void take_mask_and_uncertainty(const rg_blob* blob) {
  rg_blob_mask(blob, &parts.mask);
  rg_blob_uncertainty(blob, &parts.uncertainty);
  for (uint32_t i = 0; i < 15; ++i)
    parts.uncertainties[i] = rg_load_u16(parts.uncertainty.values + 2 * i);
  parts.contents.mask = &parts.mask;
  parts.contents.uncertainty = &parts.uncertainty;
  parts.contents.uncertainties_q12 = parts.uncertainties;
}

static void take_second_remap(const uint8_t* section) {
  take_remap(section, &parts.second_remap, parts.second_residuals,
             parts.second_bends);
  parts.more_remaps[0].section = &parts.second_remap;
  parts.more_remaps[0].residuals = parts.second_residuals;
  parts.contents.more_remaps = parts.more_remaps;
  parts.contents.num_more_remaps = 1;
}

static void take_apart(const uint8_t* bytes, uint32_t size) {
  rg_blob blob;
  assert_int_equal(rg_blob_open(bytes, size, &blob), RG_OK);
  rg_blob_camera(&blob, &parts.camera);
  rg_blob_grid(&blob, &parts.grid);
  memset(&parts.remap, 0, sizeof(parts.remap));
  if (blob.remap)
    take_remap(bytes + blob.remap, &parts.remap, parts.residuals, parts.bends);
  if (blob.quality) rg_blob_quality(&blob, &parts.quality);
  copy_arrays();
  const rg_blob_contents contents = {
      .camera = &parts.camera,
      .grid = &parts.grid,
      .control_points_q29 = parts.control_points,
      .remap = blob.remap ? &parts.remap : NULL,
      .residuals = parts.residuals,
      .quality = blob.quality ? &parts.quality : NULL};
  parts.contents = contents;
  if (blob.line_points) take_line_points(&blob);
  if (blob.mask) take_mask_and_uncertainty(&blob);
  if (blob.inverse) take_inverse(&blob);
  if (blob.capture) {
    rg_blob_capture(&blob, &parts.capture);
    parts.contents.capture = &parts.capture;
  }
  if (blob.row_time) {
    rg_blob_row_time(&blob, &parts.row_time);
    parts.contents.row_time = &parts.row_time;
  }
  const uint8_t* second = rg_find_section(bytes, RG_SECTION_REMAP, 1);
  if (second) take_second_remap(second);
}

static void expect_written(const rg_blob_contents* contents,
                           const uint8_t* golden, uint32_t size) {
  assert_int_equal(rg_blob_size(contents), size);
  assert_int_equal(rg_blob_write(contents, written, sizeof(written)), RG_OK);
  assert_memory_equal(written, golden, size);
}

static rg_status write_parts(void) {
  return rg_blob_write(&parts.contents, written, sizeof(written));
}

static void expect_parts_written(const uint8_t* golden, uint32_t size) {
  take_apart(golden, size);
  expect_written(&parts.contents, golden, size);
}

static void narrow_grid_is_written_byte_for_byte(void** state) {
  (void)state;
  static int16_t residuals[sizeof(kNarrowBlob) / 2];
  rg_blob blob;
  assert_int_equal(rg_blob_open(kNarrowBlob, sizeof(kNarrowBlob), &blob),
                   RG_OK);
  rg_camera_section camera;
  rg_grid_section grid;
  rg_blob_camera(&blob, &camera);
  rg_blob_grid(&blob, &grid);
  rg_narrow_grid narrow;
  take_inverse(&blob);
  take_narrow(grid.control_points, rg_load_u16(kNarrowBlob + blob.grid + 30),
              2u * grid.columns * grid.rows, residuals, &narrow);
  const rg_blob_contents contents = {.camera = &camera,
                                     .grid = &grid,
                                     .narrow = &narrow,
                                     .inverse = &parts.inverse,
                                     .inverse_points = &parts.inverse_points};
  expect_written(&contents, kNarrowBlob, sizeof(kNarrowBlob));
  narrow.residuals = NULL;
  assert_int_equal(rg_blob_write(&contents, written, sizeof(written)),
                   RG_ERR_ARGUMENT);
}

/* The camera and the narrow grid of a blob. */
static void take_narrow_camera(const uint8_t* bytes, uint32_t size,
                               rg_camera_section* camera, rg_grid_section* grid,
                               int16_t* residuals, rg_narrow_grid* narrow) {
  rg_blob blob;
  assert_int_equal(rg_blob_open(bytes, size, &blob), RG_OK);
  rg_blob_camera(&blob, camera);
  rg_blob_grid(&blob, grid);
  take_narrow(grid->control_points,
              rg_load_u16(bytes + blob.grid + RG_GRID_FRACTION_BITS),
              2u * grid->columns * grid->rows, residuals, narrow);
}

static void bent_tables_are_written_byte_for_byte(void** state) {
  (void)state;
  static int16_t residuals[sizeof(kBentBlob) / 2];
  rg_camera_section camera;
  rg_grid_section grid;
  rg_narrow_grid narrow;
  take_narrow_camera(kBentBlob, sizeof(kBentBlob), &camera, &grid, residuals,
                     &narrow);
  take_remap(rg_find_section(kBentBlob, RG_SECTION_REMAP, 0), &parts.remap,
             parts.residuals, parts.bends);
  take_second_remap(rg_find_section(kBentBlob, RG_SECTION_REMAP, 1));
  const rg_blob_contents contents = {.camera = &camera,
                                     .grid = &grid,
                                     .narrow = &narrow,
                                     .remap = &parts.remap,
                                     .residuals = parts.residuals,
                                     .more_remaps = parts.more_remaps,
                                     .num_more_remaps = 1};
  expect_written(&contents, kBentBlob, sizeof(kBentBlob));
  parts.second_remap.bends = NULL;
  assert_int_equal(rg_blob_write(&contents, written, sizeof(written)),
                   RG_ERR_ARGUMENT);
}

static void tables_with_views_are_written_byte_for_byte(void** state) {
  (void)state;
  static rg_remap_section tables[5];
  static rg_remap_contents more[5];
  static int16_t narrow_residuals[sizeof(kViewsBlob) / 2];
  static int16_t residuals[5][sizeof(kViewsBlob) / 8];
  rg_camera_section camera;
  rg_grid_section grid;
  rg_narrow_grid narrow;
  take_narrow_camera(kViewsBlob, sizeof(kViewsBlob), &camera, &grid,
                     narrow_residuals, &narrow);
  for (uint32_t k = 0; k < 5; ++k) {
    take_remap(rg_find_section(kViewsBlob, RG_SECTION_REMAP, k), &tables[k],
               residuals[k], NULL);
    assert_true(tables[k].has_view && tables[k].projection == k);
    more[k].section = &tables[k];
    more[k].residuals = residuals[k];
  }
  const rg_blob_contents contents = {.camera = &camera,
                                     .grid = &grid,
                                     .narrow = &narrow,
                                     .remap = &tables[0],
                                     .residuals = residuals[0],
                                     .more_remaps = more + 1,
                                     .num_more_remaps = 4};
  expect_written(&contents, kViewsBlob, sizeof(kViewsBlob));
  tables[3].rotation_q30[8] = 0;
  assert_int_equal(rg_blob_write(&contents, written, sizeof(written)),
                   RG_ERR_REMAP_CAMERA);
}

static void modes_are_written_byte_for_byte(void** state) {
  (void)state;
  static rg_remap_section tables[4];
  static rg_remap_contents more[4];
  static int8_t bends[sizeof(kModesBlob)];
  static int16_t narrow_residuals[sizeof(kModesBlob) / 2];
  static int16_t residuals[4][sizeof(kModesBlob) / 8];
  static const uint8_t kTableModes[4] = {1, 2, 3, 0};
  rg_camera_section camera;
  rg_grid_section grid;
  rg_narrow_grid narrow;
  rg_mode_section modes[3];
  rg_blob blob;
  take_narrow_camera(kModesBlob, sizeof(kModesBlob), &camera, &grid,
                     narrow_residuals, &narrow);
  assert_int_equal(rg_blob_open(kModesBlob, sizeof(kModesBlob), &blob), RG_OK);
  assert_int_equal(rg_blob_num_modes(&blob), 3);
  for (uint32_t k = 0; k < 3; ++k) rg_blob_mode(&blob, k, &modes[k]);
  assert_string_equal(modes[1].name, "binned");
  assert_true(modes[1].flip_x == 1 && modes[1].flip_y == 0);
  assert_int_equal(modes[2].scale_y_q16, 5 << 15);
  for (uint32_t k = 0; k < 4; ++k) {
    take_remap(rg_find_section(kModesBlob, RG_SECTION_REMAP, k), &tables[k],
               residuals[k], k == 2 ? bends : NULL);
    assert_int_equal(tables[k].mode, kTableModes[k]);
    assert_int_equal(tables[k].direction, k == 3 ? RG_DISTORT : RG_UNDISTORT);
    more[k].section = &tables[k];
    more[k].residuals = residuals[k];
  }
  const rg_blob_contents contents = {.camera = &camera,
                                     .grid = &grid,
                                     .narrow = &narrow,
                                     .remap = &tables[0],
                                     .residuals = residuals[0],
                                     .more_remaps = more + 1,
                                     .num_more_remaps = 3,
                                     .modes = modes,
                                     .num_modes = 3};
  expect_written(&contents, kModesBlob, sizeof(kModesBlob));
  modes[2].width = 97;
  assert_int_equal(rg_blob_write(&contents, written, sizeof(written)),
                   RG_ERR_REMAP_SIZE);
}

static int take_example_apart(void** state) {
  (void)state;
  take_apart(kExampleBlob, SIZE);
  return 0;
}

static void example_is_written_byte_for_byte(void** state) {
  (void)state;
  assert_int_equal(rg_blob_size(&parts.contents), SIZE);
  memset(written, 0xa5, sizeof(written));
  assert_int_equal(write_parts(), RG_OK);
  assert_memory_equal(written, kExampleBlob, SIZE);
  assert_int_equal(written[SIZE], 0xa5);
}

static void cameras_are_written_byte_for_byte(void** state) {
  (void)state;
  expect_parts_written(kLensBlob, sizeof(kLensBlob));
  expect_parts_written(kWideBlob, sizeof(kWideBlob));
  expect_parts_written(kLinesBlob, sizeof(kLinesBlob));
}

static void capture_is_written_byte_for_byte(void** state) {
  (void)state;
  expect_parts_written(kCaptureBlob, sizeof(kCaptureBlob));
  parts.capture.crop_height = 0;
  assert_int_equal(write_parts(), RG_ERR_CAPTURE);
}

static void row_time_is_written_byte_for_byte(void** state) {
  (void)state;
  expect_parts_written(kRowTimeBlob, sizeof(kRowTimeBlob));
  parts.row_time.stddev_ns_q10 = RG_ROW_TIME_LIMIT_Q10 + 1;
  assert_int_equal(write_parts(), RG_ERR_ROW_TIME);
}

/* The blob with a change of the parts is refused. */
#define REFUSED(blob, change, status)          \
  do {                                         \
    take_apart((blob), sizeof(blob));          \
    change;                                    \
    assert_int_equal(write_parts(), (status)); \
  } while (0)

static void missing_parts_are_refused(void** state) {
  (void)state;
  assert_int_equal(rg_blob_write(NULL, written, 1024), RG_ERR_ARGUMENT);
  assert_int_equal(rg_blob_write(&parts.contents, NULL, 1024), RG_ERR_ARGUMENT);
#define MISSING(blob, part) REFUSED(blob, (part) = NULL, RG_ERR_ARGUMENT)
  MISSING(kExampleBlob, parts.contents.residuals);
  MISSING(kExampleBlob, parts.remap.empty_blocks);
  MISSING(kExampleBlob, parts.contents.control_points_q29);
  MISSING(kExampleBlob, parts.contents.grid);
  MISSING(kExampleBlob, parts.contents.camera);
  MISSING(kWideBlob, parts.contents.inverse_points);
  MISSING(kWideBlob, parts.inverse_points.residuals);
  MISSING(kWideBlob, parts.contents.uncertainties_q12);
  MISSING(kWideBlob, parts.mask.bits);
  MISSING(kWideBlob, parts.more_remaps[0].residuals);
  MISSING(kWideBlob, parts.contents.more_remaps);
}

static void unusable_values_are_refused(void** state) {
  (void)state;
#define UNUSABLE(change, status) REFUSED(kExampleBlob, change, status)
  UNUSABLE(parts.camera.width = 0, RG_ERR_IMAGE_SIZE);
  UNUSABLE(parts.camera.name = "12345678901234567890123456789012", RG_ERR_TEXT);
  UNUSABLE(parts.grid.x1_q16 = 64 * 65536, RG_ERR_AREA);
  UNUSABLE(parts.grid.rows = 3, RG_ERR_GRID_SIZE);
  UNUSABLE(parts.grid.rows = 1028, RG_ERR_GRID_SIZE);
  UNUSABLE(--parts.grid.scale_y_q32, RG_ERR_GRID_SCALE);
  UNUSABLE(parts.control_points[31] = -0x7f000001, RG_ERR_CONTROL_POINT);
  UNUSABLE(parts.remap.rows = 1, RG_ERR_REMAP_BLOCK);
  UNUSABLE(parts.remap.rows = 1026, RG_ERR_REMAP_BLOCK);
  UNUSABLE(parts.remap.height = 0, RG_ERR_REMAP_SIZE);
  UNUSABLE(parts.remap.residual_shift = 11, RG_ERR_REMAP_SHIFT);
  UNUSABLE(parts.remap.max_x_q12 = 64 * 4096, RG_ERR_REMAP_SOURCE);
  UNUSABLE(parts.remap.fy_q16 = 0, RG_ERR_REMAP_CAMERA);
  UNUSABLE(parts.remap.origin_y_q12 = 1 << 25, RG_ERR_REMAP_VERTEX);
}

static void optional_sections_may_be_left_out(void** state) {
  (void)state;
  parts.contents.remap = NULL;
  parts.contents.quality = NULL;
  assert_int_equal(write_parts(), RG_OK);
  rg_blob blob;
  assert_int_equal(rg_blob_open(written, rg_blob_size(&parts.contents), &blob),
                   RG_OK);
  assert_int_equal(blob.remap, 0);
  assert_int_equal(blob.quality, 0);
}

static void too_small_buffer_is_left_alone(void** state) {
  (void)state;
  memset(written, 0xa5, sizeof(written));
  assert_int_equal(rg_blob_write(&parts.contents, written, SIZE - 1),
                   RG_ERR_BUFFER_TOO_SMALL);
  for (uint32_t i = 0; i < SIZE; ++i) assert_int_equal(written[i], 0xa5);
}

static void buffer_of_the_exact_size_suffices(void** state) {
  (void)state;
  assert_int_equal(rg_blob_write(&parts.contents, written, SIZE), RG_OK);
}

static void misaligned_buffer_is_refused(void** state) {
  (void)state;
  assert_int_equal(rg_blob_write(&parts.contents, written + 2, 1024),
                   RG_ERR_MISALIGNED);
}

static void scale_without_remainder_has_one_value(void** state) {
  (void)state;
  parts.grid.x1_q16 = 32 << 16;
  parts.grid.scale_x_q32 = 1u << 27;
  assert_int_equal(write_parts(), RG_OK);
  --parts.grid.scale_x_q32;
  assert_int_equal(write_parts(), RG_ERR_GRID_SCALE);
  parts.grid.scale_x_q32 += 2;
  assert_int_equal(write_parts(), RG_ERR_GRID_SCALE);
}

static rg_status write_all_vertices_at(int32_t x_q12, int32_t y_q12) {
  memset(parts.residuals, 0, sizeof(parts.residuals));
  parts.remap.origin_x_q12 = x_q12;
  parts.remap.origin_y_q12 = y_q12;
  parts.remap.column_step_x_q12 = parts.remap.column_step_y_q12 = 0;
  parts.remap.row_step_x_q12 = parts.remap.row_step_y_q12 = 0;
  return write_parts();
}

static void vertices_reach_almost_to_8192(void** state) {
  (void)state;
  const int32_t limit = 1 << 25;
  assert_int_equal(write_all_vertices_at(limit - 1, 1 - limit), RG_OK);
  assert_int_equal(write_all_vertices_at(1 - limit, limit - 1), RG_OK);
  assert_int_equal(write_all_vertices_at(limit, 0), RG_ERR_REMAP_VERTEX);
  assert_int_equal(write_all_vertices_at(-limit, 0), RG_ERR_REMAP_VERTEX);
  assert_int_equal(write_all_vertices_at(0, limit), RG_ERR_REMAP_VERTEX);
  assert_int_equal(write_all_vertices_at(0, -limit), RG_ERR_REMAP_VERTEX);
}

static void padding_bits_are_written_zero(void** state) {
  (void)state;
  static const uint8_t padded_with_ones[4] = {0xfc, 0xff, 0xff, 0xff};
  parts.remap.empty_blocks = padded_with_ones;
  assert_int_equal(write_parts(), RG_OK);
  assert_memory_equal(written, kExampleBlob, sizeof(kExampleBlob));
}

static void grid_scale_is_rounded_down(void** state) {
  (void)state;
  assert_int_equal(rg_grid_scale_q32(1, 63u << 16), 68174084);
  assert_int_equal(rg_grid_scale_q32(1, 47u << 16), 91382282);
  assert_int_equal(rg_grid_scale_q32(3, 3u << 20), 1u << 28);
  assert_int_equal(rg_grid_scale_q32(1024, 0x3fffffff), 268435456);
}

#define TEST(name) cmocka_unit_test_setup(name, take_example_apart)

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(example_is_written_byte_for_byte),
      TEST(bent_tables_are_written_byte_for_byte),
      TEST(tables_with_views_are_written_byte_for_byte),
      TEST(modes_are_written_byte_for_byte),
      TEST(narrow_grid_is_written_byte_for_byte),
      TEST(cameras_are_written_byte_for_byte),
      TEST(capture_is_written_byte_for_byte),
      TEST(row_time_is_written_byte_for_byte),
      TEST(missing_parts_are_refused),
      TEST(unusable_values_are_refused),
      TEST(optional_sections_may_be_left_out),
      TEST(too_small_buffer_is_left_alone),
      TEST(buffer_of_the_exact_size_suffices),
      TEST(misaligned_buffer_is_refused),
      TEST(scale_without_remainder_has_one_value),
      TEST(vertices_reach_almost_to_8192),
      TEST(padding_bits_are_written_zero),
      TEST(grid_scale_is_rounded_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
