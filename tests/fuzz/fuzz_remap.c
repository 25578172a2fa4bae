/* Any frame descriptor and any table. Memory is as large as the descriptor says
 * and not a byte larger, so that the sanitizer sees what goes beyond. */
#include <stdlib.h>
#include <string.h>

#include "frames/pixel_formats.h"
#include "fuzz_target.h"
#include "kernels/kernel_list.h"
#include "raygrid.h"

#define MAX_PLANE (1u << 20) /* larger ones only take time */

static int find_plane(rg_format format, uint32_t plane,
                      rg_component* component) {
  for (uint32_t k = 0; rg_get_component(format, k, component); ++k)
    if (component->plane == plane) return 1;
  return 0;
}

/* Rows of a plane of an image of so many. */
static uint32_t plane_rows(rg_format format, uint32_t plane, uint32_t rows) {
  rg_component component;
  const int is_plane = find_plane(format, plane, &component);
  return is_plane ? (rows >> component.log2[1]) * component.row_step : rows;
}

static uint32_t row_bytes(rg_format format, uint32_t plane, uint32_t width) {
  rg_component component;
  const int is_plane = find_plane(format, plane, &component);
  return is_plane ? rg_plane_row_bytes(&component, width) : 0;
}

/* About as long as a row, mostly, or anything. */
static uint32_t make_stride(rg_format format, uint32_t plane, uint32_t width,
                            const uint8_t* data) {
  const uint32_t bytes = row_bytes(format, plane, width);
  if (data[0] % 4 == 0) return setting(data, 0) >> 8 & 0xffff;
  if (data[0] % 4 == 1 && bytes != 0) return bytes - 1 + data[1] % 3;
  return bytes + data[1];
}

/* The last row is only as long as its samples. */
static uint8_t* new_plane(rg_format format, uint32_t plane, uint32_t width,
                          uint32_t rows, uint32_t stride, uint32_t* size) {
  uint32_t last = row_bytes(format, plane, width);
  if (last > stride) last = stride;
  const uint64_t bytes = rows == 0 ? 0 : (uint64_t)(rows - 1) * stride + last;
  if (bytes > MAX_PLANE) return NULL;
  *size = (uint32_t)bytes;
  return malloc(bytes != 0 ? (size_t)bytes : 1);
}

static int make_image(const rg_camera* camera, const uint8_t* data,
                      rg_image* image) {
  memset(image, 0, sizeof(*image));
  image->format = (rg_format)(data[1] % (RG_NUM_FORMATS + 1));
  rg_frame_size(camera, &image->width, &image->height);
  if (data[2] % 16 == 0) { /* a size that is wrong */
    image->width = (uint16_t)setting(data, 4);
    image->height = (uint16_t)setting(data, 6);
  }
  uint32_t rows = image->height;
  if (data[2] & 64) {
    image->ring_rows = (uint16_t)(setting(data, 8) % (rows + 3u));
    image->first_row = (uint16_t)setting(data, 10);
    image->num_rows = (uint16_t)(setting(data, 12) % (image->ring_rows + 2u));
    if ((data[2] & 32) != 0 && rows != 0)
      image->first_row = (uint16_t)(image->first_row % rows);
    if (image->ring_rows != 0) rows = image->ring_rows;
  }
  for (uint32_t plane = 0; plane < 3; ++plane) {
    uint32_t size = 0;
    image->planes[plane].stride =
        make_stride(image->format, plane, image->width, data + 16 + 2 * plane);
    uint8_t* const memory = new_plane(image->format, plane, image->width,
                                      plane_rows(image->format, plane, rows),
                                      image->planes[plane].stride, &size);
    image->planes[plane].data = memory;
    if (!memory) return 0;
    for (uint32_t i = 0; i < size; ++i)
      memory[i] = (uint8_t)(i * 2654435761u >> 24);
  }
  return 1;
}

static int make_target(const rg_camera* camera, const uint8_t* data,
                       rg_format format, rg_target* target) {
#define RG_KERNEL(name, parts, abilities, runs) #name,
  static const char* const kNames[] = {RG_KERNELS "portable"};
  uint16_t width = 0, height = 0;
  rg_remap_size(camera, &width, &height);
  memset(target, 0, sizeof(*target));
  target->first_row = (uint16_t)(setting(data, 24) % (height + 2u));
  target->num_rows = (uint16_t)(setting(data, 26) % (height + 2u));
  if (data[3] & 1) {
    target->first_row = 0;
    target->num_rows = height;
  }
  target->border = (rg_border)(data[3] / 2 % 4);
  target->sampling = (rg_sampling)(data[3] / 8 % 4 / 2 + (data[3] == 0xff));
  target->kernels =
      rg_find_kernels(kNames[data[57] % (sizeof(kNames) / sizeof(kNames[0]))]);
  for (uint32_t c = 0; c < 4; ++c)
    target->border_values[c] = (uint16_t)setting(data, 28 + 2 * c);
  for (uint32_t plane = 0; plane < 3; ++plane) {
    uint32_t size = 0;
    target->planes[plane].stride =
        make_stride(format, plane, width, data + 36 + 2 * plane);
    target->planes[plane].data = new_plane(
        format, plane, width, plane_rows(format, plane, target->num_rows),
        target->planes[plane].stride, &size);
    if (!target->planes[plane].data) return 0;
    memset(target->planes[plane].data, 0, size);
  }
  return 1;
}

static void remap(const rg_camera* camera, const uint8_t* data) {
  rg_image image;
  rg_target target;
  memset(&target, 0, sizeof(target));
  if (make_image(camera, data, &image) &&
      make_target(camera, data, image.format, &target)) {
    rg_remap(camera, &image, &target);
    if (image.format == RG_FORMAT_GREY8 && image.ring_rows == 0) {
      const rg_grey_image frame = {image.planes[0].data, image.planes[0].stride,
                                   image.width, image.height};
      const rg_grey_target band = {target.planes[0].data,
                                   target.planes[0].stride, target.first_row,
                                   target.num_rows, data[44]};
      rg_remap_grey(camera, &frame, &band);
    }
  }
  for (uint32_t plane = 0; plane < 3; ++plane) {
    free((void*)(uintptr_t)image.planes[plane].data);
    free(target.planes[plane].data);
  }
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  uint32_t blob_size;
  uint8_t* const bytes = take_blob(data, size, &blob_size);
  if (!bytes) return 0;
  rg_camera camera;
  if (rg_camera_open(&camera, bytes, blob_size) == RG_OK) {
    uint16_t first, num;
    if (data[51] % 4 == 0)
      rg_set_operating_point(&camera, near_condition(data));
    rg_select_remap(&camera, data[45] % 4);
    if (data[51] % 4 > 1) rg_set_operating_point(&camera, near_condition(data));
    if (camera.remap) {
      rg_remap_source_rows(&camera,
                           (rg_format)(data[46] % (RG_NUM_FORMATS + 1)),
                           (uint16_t)setting(data, 47),
                           (uint16_t)setting(data, 49), &first, &num);
      remap(&camera, data);
    }
  }
  free(bytes);
  return 0;
}
