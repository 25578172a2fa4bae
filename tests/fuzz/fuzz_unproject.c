/* Any pixel and any direction of any camera that opens. */
#include <stdlib.h>
#include <string.h>

#include "blob_layout.h"
#include "bytes.h"
#include "fuzz_target.h"
#include "raygrid.h"

/* |v|^2 in q28 near 1; lines of broken control points too have directions. */
static int is_unit(const rg_ray* ray) {
  const int64_t x = ray->x_q30, y = ray->y_q30, z = ray->z_q30;
  const int64_t square_q28 = (x * x + y * y + z * z) >> 32;
  return llabs(square_q28 - (INT64_C(1) << 28)) < 256;
}

static void try_pixel(const rg_camera* camera, rg_pixel pixel) {
  rg_ray ray;
  rg_line line;
  rg_pixel other;
  uint16_t sigma_q12;
  int32_t row_time_ns_q10;
  uint32_t stddev_ns_q10;
  const rg_status status = rg_unproject(camera, pixel, &ray);
  require(status == RG_OK || status == RG_ERR_OUTSIDE_AREA ||
              status == RG_ERR_NONCENTRAL,
          "statuses of unprojection");
  if (status == RG_OK) {
    require(is_unit(&ray), "a direction has unit length");
    rg_project(camera, &ray, &other);
  }
  if (rg_unproject_line(camera, pixel, &line) == RG_OK)
    require(is_unit(&line.direction), "a line's direction has unit length");
  if (rg_is_valid(camera, pixel)) rg_uncertainty(camera, pixel, &sigma_q12);
  rg_uncertainty(camera, pixel, &sigma_q12);
  rg_line_delay(camera, &row_time_ns_q10, &stddev_ns_q10);
  rg_undistort_point(camera, pixel, &other);
}

static void try_direction(const rg_camera* camera, const rg_ray* direction) {
  rg_pixel pixel;
  rg_ray ray;
  if (rg_project(camera, direction, &pixel) != RG_OK) return;
  require(rg_unproject(camera, pixel, &ray) == RG_OK,
          "a projected pixel lies in the area");
}

static void try_point(const rg_camera* camera, const int32_t point[3],
                      uint32_t fraction_bits) {
  rg_pixel pixel;
  rg_line line;
  if (rg_project_point(camera, point, fraction_bits, &pixel) != RG_OK) return;
  require(rg_unproject_line(camera, pixel, &line) == RG_OK,
          "a point's pixel lies in the area");
}

/* A point that is likely to be seen, from 1/8 to 64 m away. */
static void try_on_line(const rg_camera* camera, rg_pixel pixel,
                        uint32_t distance) {
  rg_line line;
  if (rg_unproject_line(camera, pixel, &line) != RG_OK) return;
  const int shift = (int)(distance % 10);
  const int32_t point[3] = {
      (line.point_q28[0] >> 4) + (line.direction.x_q30 >> shift),
      (line.point_q28[1] >> 4) + (line.direction.y_q30 >> shift),
      (line.point_q28[2] >> 4) + (line.direction.z_q30 >> shift)};
  try_point(camera, point, 24);
}

static void try_mode(const rg_camera* camera, const uint8_t* data,
                     rg_pixel pixel) {
  const rg_mode mode = {(uint16_t)setting(data, 32),
                        (uint16_t)setting(data, 34),
                        (int32_t)setting(data, 36),
                        (int32_t)setting(data, 40),
                        setting(data, 44),
                        setting(data, 48),
                        data[52] & 1,
                        data[52] >> 1 & 1};
  rg_mode of_table;
  rg_pixel other;
  if (rg_mode_to_calibrated(&mode, pixel, &other) == RG_OK)
    rg_mode_from_calibrated(&mode, other, &pixel);
  rg_mode_from_calibrated(&mode, pixel, &other);
  const char serial[4] = {(char)data[53], (char)data[54], (char)data[55], 0};
  uint32_t table;
  rg_match(camera, &mode, mode.width, mode.height, serial, &table);
  if (rg_remap_mode(camera, &of_table) == RG_OK)
    rg_mode_to_calibrated(&of_table, pixel, &other);
  rg_match(camera, NULL, mode.width, mode.height, NULL, NULL);
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  uint32_t blob_size;
  uint8_t* const bytes = take_blob(data, size, &blob_size);
  if (!bytes) return 0;
  rg_camera camera;
  if (rg_camera_open(&camera, bytes, blob_size) == RG_OK) {
    rg_select_remap(&camera, 0);
    if (data[2] % 2 != 0) rg_set_operating_point(&camera, near_condition(data));
    const rg_pixel pixel = {(int32_t)setting(data, 4),
                            (int32_t)setting(data, 8)};
    const rg_ray direction = {(int32_t)setting(data, 12),
                              (int32_t)setting(data, 16),
                              (int32_t)setting(data, 20)};
    try_pixel(&camera, pixel);
    /* One that is likely to lie inside. */
    uint16_t width, height;
    rg_calibrated_size(&camera, &width, &height);
    const rg_pixel inside = {
        (int32_t)(setting(data, 24) % ((width % 16384u + 1) << 16)),
        (int32_t)(setting(data, 28) % ((height % 16384u + 1) << 16))};
    try_pixel(&camera, inside);
    const rg_pixel far_corner = {rg_load_i32(camera.grid + RG_GRID_X1),
                                 rg_load_i32(camera.grid + RG_GRID_Y1)};
    try_pixel(&camera, far_corner);
    try_direction(&camera, &direction);
    const int32_t point[3] = {direction.x_q30, direction.y_q30,
                              direction.z_q30};
    try_point(&camera, point, data[3] % 32u);
    try_on_line(&camera, inside, data[28]);
    try_mode(&camera, data, inside);
  }
  free(bytes);
  return 0;
}
