/* The WebAssembly module of raygrid.js: the functions of raygrid.h with numbers
 * and addresses as arguments. An instance of the module has one camera and no
 * imports. */
#include "raygrid.h"

#define EXPORT(name) __attribute__((export_name(name)))

extern uint8_t __heap_base; /* end of the linker's static data */

static rg_camera camera;

/* Compilers generate calls to this function. */
__attribute__((no_builtin("memcpy"))) void* memcpy(void* to, const void* from,
                                                   size_t num_bytes) {
  uint8_t* out = to;
  const uint8_t* in = from;
  for (size_t i = 0; i < num_bytes; ++i) out[i] = in[i];
  return to;
}

/* The first free address for blobs, frames and points. */
EXPORT("free_memory") uint32_t free_memory(void) {
  return (uint32_t)(uintptr_t)&__heap_base;
}

EXPORT("status_text") const char* status_text(int32_t status) {
  return rg_status_text((rg_status)status);
}

EXPORT("crc32") uint32_t crc32(const uint8_t* bytes, uint32_t num_bytes) {
  return rg_crc32(0, bytes, num_bytes);
}

EXPORT("open") int32_t open_blob(const uint8_t* blob, uint32_t num_bytes) {
  return rg_camera_open(&camera, blob, num_bytes);
}

EXPORT("is_central") int32_t is_central(void) { return !camera.line_points; }

EXPORT("can_project") int32_t can_project(void) { return !!camera.inverse; }

/* sizes: width and height of calibrated frames, of the table's frames, and of
 * its output (zeros without a table). */
EXPORT("sizes") void sizes(int32_t* sizes) {
  uint16_t values[6] = {0};
  rg_calibrated_size(&camera, &values[0], &values[1]);
  rg_frame_size(&camera, &values[2], &values[3]);
  (void)rg_remap_size(&camera, &values[4], &values[5]);
  for (int k = 0; k < 6; ++k) sizes[k] = values[k];
}

/* ---- Points -------------------------------------------------------------- */

EXPORT("unproject")
void unproject(const rg_pixel* pixels, rg_ray* rays, uint32_t num_pixels) {
  (void)rg_unproject_batch(&camera, pixels, rays, num_pixels);
}

EXPORT("unproject_lines")
void unproject_lines(const rg_pixel* pixels, rg_line* lines,
                     uint32_t num_pixels) {
  (void)rg_unproject_lines(&camera, pixels, lines, num_pixels);
}

EXPORT("project")
void project(const rg_ray* directions, rg_pixel* pixels, uint32_t num_points) {
  (void)rg_project_batch(&camera, directions, pixels, num_points);
}

/* Each point consists of x, y, z and the number of fraction bits. */
EXPORT("project_points")
void project_points(const int32_t* points, rg_pixel* pixels,
                    uint32_t num_points) {
  for (uint32_t k = 0; k < num_points; ++k, points += 4) {
    const rg_pixel none = {RG_NO_PIXEL, RG_NO_PIXEL};
    pixels[k] = none;
    (void)rg_project_point(&camera, points, (uint32_t)points[3], &pixels[k]);
  }
}

EXPORT("undistort_points")
void undistort_points(const rg_pixel* pixels, rg_pixel* undistorted,
                      uint32_t num_points) {
  (void)rg_undistort_points(&camera, pixels, undistorted, num_points);
}

EXPORT("is_valid")
void is_valid(const rg_pixel* pixels, int32_t* valid, uint32_t num_pixels) {
  for (uint32_t k = 0; k < num_pixels; ++k)
    valid[k] = rg_is_valid(&camera, pixels[k]);
}

/* Stores -1 outside the area, and if the blob does not contain the uncertainty.
 */
EXPORT("uncertainty")
int32_t uncertainty(const rg_pixel* pixels, int32_t* deviations_q12,
                    uint32_t num_pixels) {
  for (uint32_t k = 0; k < num_pixels; ++k) {
    uint16_t value = 0;
    const rg_status status = rg_uncertainty(&camera, pixels[k], &value);
    if (status == RG_ERR_UNCERTAINTY) return status;
    deviations_q12[k] = status == RG_OK ? value : -1;
  }
  return RG_OK;
}

/* ---- Tables -------------------------------------------------------------- */

EXPORT("select_remap") int32_t select_remap(uint32_t index) {
  return rg_select_remap(&camera, index);
}

EXPORT("set_condition") int32_t set_condition(int32_t value_q16) {
  return rg_set_operating_point(&camera, value_q16);
}

/* view: projection, fx, fy, cx, cy, distorts, followed by the rotation. */
EXPORT("view") int32_t view(int32_t* out) {
  rg_view found;
  const rg_status status = rg_remap_view(&camera, &found);
  if (status != RG_OK) return status;
  out[0] = (int32_t)found.projection;
  out[1] = (int32_t)found.fx_q16;
  out[2] = (int32_t)found.fy_q16;
  out[3] = found.cx_q16;
  out[4] = found.cy_q16;
  out[5] = found.distorts;
  for (int k = 0; k < 9; ++k) out[6 + k] = found.rotation_q30[k];
  return RG_OK;
}

/* mode: width, height, offset_x and _y, scale_x and _y, flip_x and _y. */
EXPORT("mode") int32_t mode(int32_t* out) {
  rg_mode found;
  const rg_status status = rg_remap_mode(&camera, &found);
  if (status != RG_OK) return status;
  out[0] = found.width;
  out[1] = found.height;
  out[2] = found.offset_x_q16;
  out[3] = found.offset_y_q16;
  out[4] = (int32_t)found.scale_x_q16;
  out[5] = (int32_t)found.scale_y_q16;
  out[6] = found.flip_x;
  out[7] = found.flip_y;
  return RG_OK;
}

/* mode as above, or NULL; table: index, or -1. */
EXPORT("match")
int32_t match(const int32_t* mode, uint32_t width, uint32_t height,
              const char* serial, uint32_t* table) {
  rg_mode asked;
  if (mode) {
    asked.width = (uint16_t)mode[0];
    asked.height = (uint16_t)mode[1];
    asked.offset_x_q16 = mode[2];
    asked.offset_y_q16 = mode[3];
    asked.scale_x_q16 = (uint32_t)mode[4];
    asked.scale_y_q16 = (uint32_t)mode[5];
    asked.flip_x = (uint8_t)mode[6];
    asked.flip_y = (uint8_t)mode[7];
  }
  return (int32_t)rg_match(&camera, mode ? &asked : 0, (uint16_t)width,
                           (uint16_t)height, serial, table);
}

/* ---- Frames -------------------------------------------------------------- */

/* A plane of the input frame and of the undistorted frame. */
typedef struct plane_pair {
  const uint8_t* source;
  uint32_t source_stride;
  uint8_t* target;
  uint32_t target_stride;
} plane_pair;

/* Undistorts a whole frame of the table's size. */
EXPORT("undistort")
int32_t undistort(uint32_t format, const plane_pair* planes, uint32_t border,
                  uint32_t sampling, const uint32_t* border_values) {
  rg_image image = {0};
  rg_target target = {0};
  uint16_t width = 0;
  const rg_status status = rg_remap_size(&camera, &width, &target.num_rows);
  if (status != RG_OK) return status;
  rg_frame_size(&camera, &image.width, &image.height);
  image.format = (rg_format)format;
  for (int k = 0; k < 3; ++k) {
    image.planes[k].data = planes[k].source;
    image.planes[k].stride = planes[k].source_stride;
    target.planes[k].data = planes[k].target;
    target.planes[k].stride = planes[k].target_stride;
  }
  target.border = (rg_border)border;
  target.sampling = (rg_sampling)sampling;
  for (int k = 0; k < 4; ++k)
    target.border_values[k] = (uint16_t)border_values[k];
  return rg_remap(&camera, &image, &target);
}
