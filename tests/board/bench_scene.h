/* The scene of the instruction counters: cameras, pixels, directions, frames.
 */
#ifndef RAYGRID_BENCH_SCENE_H
#define RAYGRID_BENCH_SCENE_H

#include <string.h>

#include "golden_blobs.h"
#include "raygrid.h"
#include "rg_blob.h"
#include "test_frame.h"

#define NUM_POINTS 512u
#define WIDTH 64u
#define HEIGHT 48u

static rg_camera lens, narrow, lines, seen_lines, wide, inner;
static rg_pixel pixels[NUM_POINTS], line_pixels[NUM_POINTS], points[NUM_POINTS];
static rg_ray rays[NUM_POINTS], wide_rays[NUM_POINTS], outside[NUM_POINTS];
static int32_t near_points[NUM_POINTS][3];
static uint8_t source[160 * 120] __attribute__((aligned(4)));
static uint8_t output[WIDTH * HEIGHT * 4] __attribute__((aligned(4)));

/* In q16, from 0 to a number of pixels. */
static int32_t random_position(uint32_t* random, uint32_t size) {
  return (int32_t)((uint64_t)next_random(random) * size >> 16);
}

/* Random pixels of an area. */
static void make_pixels(const rg_camera* camera, rg_pixel* result) {
  uint32_t random = 7;
  uint32_t num_made = 0;
  uint16_t width, height;
  rg_calibrated_size(camera, &width, &height);
  while (num_made < NUM_POINTS) {
    const rg_pixel pixel = {random_position(&random, width),
                            random_position(&random, height)};
    if (rg_is_valid(camera, pixel)) result[num_made++] = pixel;
  }
}

/* Points 1 m along the lines of random pixels. */
static void make_near_points(void) {
  make_pixels(&seen_lines, points);
  for (uint32_t k = 0; k < NUM_POINTS; ++k) {
    rg_line line = {{0, 0, 0}, {0, 0, 0}};
    rg_unproject_line(&seen_lines, points[k], &line);
    near_points[k][0] = (line.point_q28[0] >> 4) + (line.direction.x_q30 >> 6);
    near_points[k][1] = (line.point_q28[1] >> 4) + (line.direction.y_q30 >> 6);
    near_points[k][2] = (line.point_q28[2] >> 4) + (line.direction.z_q30 >> 6);
  }
}

/* A table of blocks whose sources all lie inside. */
static void open_inner(uint8_t block_log2) {
  static uint8_t bytes[1024] __attribute__((aligned(4)));
  static const int16_t residuals[2 * 5 * 4];
  static const uint8_t empty[4];
  static const int32_t control_points[2 * 4 * 4];
  rg_blob blob;
  rg_camera_section identity;
  rg_grid_section grid;
  const int32_t columns = (int32_t)((WIDTH - 1) >> block_log2) + 1;
  const int32_t rows = (int32_t)((HEIGHT - 1) >> block_log2) + 1;
  const rg_remap_section table = {.width = WIDTH,
                                  .height = HEIGHT,
                                  .columns = (uint16_t)(columns + 1),
                                  .rows = (uint16_t)(rows + 1),
                                  .block_log2 = block_log2,
                                  .max_x_q12 = 63 << 12,
                                  .max_y_q12 = 47 << 12,
                                  .origin_x_q12 = 5000,
                                  .origin_y_q12 = 9000,
                                  .column_step_x_q12 = 236000 / columns,
                                  .column_step_y_q12 = 5200 / columns,
                                  .row_step_x_q12 = -2400 / rows,
                                  .row_step_y_q12 = 140000 / rows,
                                  .fx_q16 = 1,
                                  .fy_q16 = 1,
                                  .empty_blocks = empty};
  if (rg_blob_open(kExampleBlob, sizeof(kExampleBlob), &blob) != RG_OK) return;
  rg_blob_camera(&blob, &identity);
  rg_blob_grid(&blob, &grid);
  const rg_blob_contents contents = {.camera = &identity,
                                     .grid = &grid,
                                     .control_points_q29 = control_points,
                                     .remap = &table,
                                     .residuals = residuals};
  if (rg_blob_write(&contents, bytes, sizeof(bytes)) == RG_OK &&
      rg_camera_open(&inner, bytes, sizeof(bytes)) == RG_OK)
    rg_select_remap(&inner, 0);
}

/* Undistorts the frame into output. */
static rg_status remap_frame(rg_format format, const uint32_t strides[3]) {
  rg_image image;
  rg_target target;
  memset(&image, 0, sizeof(image));
  memset(&target, 0, sizeof(target));
  image.format = format;
  image.width = WIDTH;
  image.height = HEIGHT;
  target.num_rows = HEIGHT;
  for (int plane = 0; plane < 3; ++plane) {
    image.planes[plane].data = source;
    image.planes[plane].stride = strides[plane];
    target.planes[plane].data = output + (uint32_t)plane * (WIDTH * HEIGHT);
    target.planes[plane].stride = strides[plane];
  }
  return rg_remap(&inner, &image, &target);
}

/* 0 on failure. */
static int make_scene(uint8_t block_log2) {
  if (rg_camera_open(&lens, kLensBlob, sizeof(kLensBlob)) != RG_OK ||
      rg_select_remap(&lens, 0) != RG_OK ||
      rg_camera_open(&narrow, kNarrowBlob, sizeof(kNarrowBlob)) != RG_OK ||
      rg_camera_open(&lines, kLinesBlob, sizeof(kLinesBlob)) != RG_OK ||
      rg_camera_open(&seen_lines, kSeenLinesBlob, sizeof(kSeenLinesBlob)) !=
          RG_OK ||
      rg_camera_open(&wide, kWideBlob, sizeof(kWideBlob)) != RG_OK)
    return 0;
  open_inner(block_log2);
  make_pixels(&lens, pixels);
  make_pixels(&lines, line_pixels);
  make_near_points();
  make_test_frame(source, 4 * WIDTH, 4 * WIDTH, HEIGHT);
  make_pixels(&wide, points);
  rg_unproject_batch(&wide, points, wide_rays, NUM_POINTS);
  for (uint32_t k = 0; k < NUM_POINTS; ++k) {
    outside[k] = wide_rays[k];
    outside[k].z_q30 = -0x7fffffff;
  }
  return 1;
}

#endif /* RAYGRID_BENCH_SCENE_H */
