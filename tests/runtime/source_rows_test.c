/* Rows of the source that a band is told to need. */
#include <string.h>

#include "frames/pixel_format_list.h"
#include "raygrid.h"
#include "rg_blob.h"
#include "unit_test.h"

#define SOURCE 64u
#define OUTPUT 32u

static uint32_t words[256];
static uint16_t frame[SOURCE * SOURCE], other[SOURCE * SOURCE];
static uint16_t out[OUTPUT * OUTPUT], other_out[OUTPUT * OUTPUT];

/* One block of 32 x 32 pixels, as wide in the source, of about one row; its
 * right edge is 15 q12 lower, its lower edge 16, its last corner one more:
 * inner rows' rounding leads farther out than that of its first and last row.
 */
static rg_status make_camera(uint16_t height, int32_t y_q12,
                             rg_camera* camera) {
  static const char kNoText[RG_TEXT_SIZE] = {0};
  static const int32_t kControlPoints[2 * 4 * 4] = {0};
  static const uint8_t kNoEmptyBlocks[4] = {0};
  static const int16_t kResiduals[2 * 2 * 2] = {0, 0, 0, 0, 0, 0, 0, 1};
  const rg_camera_section identity = {SOURCE, height, kNoText, kNoText};
  rg_grid_section grid;
  memset(&grid, 0, sizeof(grid));
  grid.x1_q16 = RG_PIXEL(SOURCE - 1);
  grid.y1_q16 = RG_PIXEL(height - 1);
  grid.columns = grid.rows = 4;
  grid.scale_x_q32 = rg_grid_scale_q32(1, (uint32_t)grid.x1_q16);
  grid.scale_y_q32 = rg_grid_scale_q32(1, (uint32_t)grid.y1_q16);
  rg_remap_section remap;
  memset(&remap, 0, sizeof(remap));
  remap.width = remap.height = OUTPUT;
  remap.columns = remap.rows = 2;
  remap.block_log2 = 5;
  remap.max_x_q12 = (SOURCE - 1) << 12;
  remap.max_y_q12 = (height - 1) << 12;
  remap.origin_x_q12 = 2 << 12;
  remap.origin_y_q12 = y_q12;
  remap.column_step_x_q12 = 32 << 12;
  remap.column_step_y_q12 = 15;
  remap.row_step_y_q12 = 16;
  remap.fx_q16 = remap.fy_q16 = 1;
  remap.empty_blocks = kNoEmptyBlocks;
  rg_blob_contents contents;
  memset(&contents, 0, sizeof(contents));
  contents.camera = &identity;
  contents.grid = &grid;
  contents.control_points_q29 = kControlPoints;
  contents.remap = &remap;
  contents.residuals = kResiduals;
  rg_status status = rg_blob_write(&contents, words, sizeof(words));
  if (status == RG_OK) status = rg_camera_open(camera, words, sizeof(words));
  return status == RG_OK ? rg_select_remap(camera, 0) : status;
}

static rg_status undistort(const rg_camera* camera, const uint16_t* source,
                           uint16_t* result) {
  rg_image image;
  memset(&image, 0, sizeof(image));
  image.format = RG_FORMAT_GREY16;
  image.width = image.height = SOURCE;
  image.planes[0].data = (const uint8_t*)source;
  image.planes[0].stride = 2 * SOURCE;
  rg_target target;
  memset(&target, 0, sizeof(target));
  target.planes[0].data = (uint8_t*)result;
  target.planes[0].stride = 2 * OUTPUT;
  target.num_rows = OUTPUT;
  return rg_remap(camera, &image, &target);
}

static void no_row_is_missing_however_positions_are_rounded(void** state) {
  (void)state;
  for (uint32_t i = 0; i < SOURCE * SOURCE; ++i)
    frame[i] = (uint16_t)((i * 2654435761u) >> 16);
  for (int32_t y_q12 = -45; y_q12 <= 45; ++y_q12) {
    rg_camera camera;
    uint16_t first, num_rows;
    assert_int_equal(make_camera(SOURCE, (20 << 12) + y_q12, &camera), RG_OK);
    assert_int_equal(rg_remap_source_rows(&camera, RG_FORMAT_GREY16, 0, OUTPUT,
                                          &first, &num_rows),
                     RG_OK);
    for (uint32_t i = 0; i < SOURCE * SOURCE; ++i) {
      const uint32_t row = i / SOURCE;
      const int is_named = row >= first && row < (uint32_t)first + num_rows;
      other[i] = is_named ? frame[i] : (uint16_t)~frame[i];
    }
    assert_int_equal(undistort(&camera, frame, out), RG_OK);
    assert_int_equal(undistort(&camera, other, other_out), RG_OK);
    assert_memory_equal(out, other_out, sizeof(out));
    assert_in_range(num_rows, 2, 3);
  }
}

#define RG_PIXEL_FORMAT(name, kind, first, num, row_pairs, ...) \
  [RG_FORMAT_##name] = (row_pairs),
static const uint8_t kHasRowPairs[RG_NUM_FORMATS] = {RG_PIXEL_FORMATS};

/* Up to the last row of 41. */
static void no_rows_are_told_that_no_frame_has(void** state) {
  (void)state;
  rg_camera camera;
  assert_int_equal(make_camera(41, (39 << 12) + 100, &camera), RG_OK);
  for (int format = 0; format < RG_NUM_FORMATS; ++format) {
    uint16_t first = 77, num_rows = 77;
    const rg_status status = rg_remap_source_rows(&camera, (rg_format)format, 0,
                                                  OUTPUT, &first, &num_rows);
    if (kHasRowPairs[format]) {
      assert_int_equal(status, RG_ERR_FRAME_SIZE);
      assert_int_equal(first + num_rows, 2 * 77);
    } else {
      assert_int_equal(status, RG_OK);
      assert_int_equal(first + num_rows, 41);
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(no_row_is_missing_however_positions_are_rounded),
      cmocka_unit_test(no_rows_are_told_that_no_frame_has),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
