/* rg_remap(): frames of any format. */
#include <stddef.h>

#include "blob_checks.h"
#include "blob_layout.h"
#include "bytes.h"
#include "code_size.h"
#include "frames/pixel_formats.h"
#include "frames/planes.h"
#include "frames/remap_source_rows.h"
#include "frames/traversal.h"

/* Finds the plane of a component in an image, or in a band of it, as bytes. */
static rg_status find_plane(const rg_component* component, uint32_t width,
                            uint32_t num_rows, rg_grey_image* plane) {
  /* Below 2^16: the width is that of a remap, at most 8192 pixels. */
  const uint32_t row_bytes = rg_plane_row_bytes(component, width);
  plane->width = (uint16_t)row_bytes;
  plane->height =
      (uint16_t)((num_rows >> component->log2[1]) * component->row_step);
  if (row_bytes == 0 || !rg_is_stride(plane->stride, row_bytes))
    return RG_ERR_FRAME_SIZE;
  return component->kind >= RG_SAMPLE_16 &&
                 (((uintptr_t)plane->data | plane->stride) & 1) != 0
             ? RG_ERR_MISALIGNED
             : RG_OK;
}

/* Checks the planes of image and target, whose formats, sizes and rows are
 * already checked. */
static rg_status check_planes(const uint8_t* section, const rg_image* image,
                              const rg_target* target) {
  const uint32_t source_rows =
      image->ring_rows != 0 ? image->ring_rows : image->height;
  rg_grey_image planes[6]; /* the image's and the target's, in pairs */
  const rg_grey_image* end = planes;
  rg_component component;
  for (uint32_t k = 0; rg_get_component(image->format, k, &component); ++k) {
    const uint32_t p = component.plane;
    rg_grey_image* const own = &planes[2 * p + 1];
    rg_grey_image* const source = own - 1;
    source->data = image->planes[p].data;
    source->stride = image->planes[p].stride;
    own->data = target->planes[p].data;
    own->stride = target->planes[p].stride;
    rg_status status =
        find_plane(&component, image->width, source_rows, source);
    if (status == RG_OK)
      status = find_plane(&component, rg_load_u16(section + RG_REMAP_WIDTH),
                          target->num_rows, own);
    if (status != RG_OK) return status;
    end = own + 1;
  }
  for (const rg_grey_image* own = planes + 1; own < end; own += 2)
    for (const rg_grey_image* other = planes; other != end; ++other)
      if (other != own &&
          rg_check_overlap(other, own->data, own->stride,
                           own->width | (uint32_t)own->height << 16) != RG_OK)
        return RG_ERR_OVERLAP;
  return RG_OK;
}

static RG_NOINLINE rg_status check_frames(const rg_camera* camera,
                                          const rg_image* image,
                                          const rg_target* target) {
  const rg_status status =
      rg_check_rows(camera, image->format, target->first_row, target->num_rows);
  if (status != RG_OK) return status;
  if ((uint32_t)target->border > RG_BORDER_KEEP ||
      (uint32_t)target->sampling > RG_SAMPLING_NEAREST ||
      (target->border == RG_BORDER_CLAMP && image->ring_rows != 0))
    return RG_ERR_FORMAT;
  if (image->width != camera->frame_width ||
      image->height != camera->frame_height ||
      (image->ring_rows & rg_row_pairs(image->format)) != 0)
    return RG_ERR_FRAME_SIZE;
  return check_planes(camera->remap, image, target);
}

rg_status rg_remap_size(const rg_camera* camera, uint16_t* width,
                        uint16_t* height) {
  if (!camera->remap) return RG_ERR_NO_REMAP;
  *width = rg_load_u16(camera->remap + RG_REMAP_WIDTH);
  *height = rg_load_u16(camera->remap + RG_REMAP_HEIGHT);
  return RG_OK;
}

void rg_frame_size(const rg_camera* camera, uint16_t* width, uint16_t* height) {
  *width = camera->frame_width;
  *height = camera->frame_height;
}

void rg_calibrated_size(const rg_camera* camera, uint16_t* width,
                        uint16_t* height) {
  const uint32_t size = rg_camera_size(camera->blob);
  *width = (uint16_t)size;
  *height = (uint16_t)(size >> 16);
}

rg_status rg_remap_view(const rg_camera* camera, rg_view* view) {
  const uint8_t* const section = camera->remap;
  const rg_status status = rg_remap_size(camera, &view->width, &view->height);
  if (status != RG_OK) return status;
  const int has_view = rg_has_view(section);
  view->projection = RG_PROJECTION_PINHOLE;
  if (has_view) view->projection = (rg_projection)section[RG_VIEW_PROJECTION];
  view->distorts = has_view && section[RG_VIEW_DIRECTION] == RG_DISTORT;
  if (view->distorts) rg_frame_size(camera, &view->width, &view->height);
  view->fx_q16 = rg_load_u32(section + RG_REMAP_FX);
  view->fy_q16 = rg_load_u32(section + RG_REMAP_FY);
  view->cx_q16 = rg_load_i32(section + RG_REMAP_CX);
  view->cy_q16 = rg_load_i32(section + RG_REMAP_CY);
  for (uint32_t k = 0; k < 9; ++k)
    view->rotation_q30[k] =
        has_view       ? rg_load_i32(section + RG_VIEW_ROTATION + 4 * k)
        : k % 4u == 0u ? INT32_C(1) << 30
                       : 0;
  return RG_OK;
}

/* Whether a ring buffer holds the rows given by rg_find_source_rows(). */
static RG_NOINLINE int are_rows_there(const rg_image* image, uint32_t rows) {
  const uint32_t first = rows & 0xffff, num_rows = rows >> 16;
  return image->num_rows <= image->ring_rows &&
         (num_rows == 0 ||
          (first >= image->first_row &&
           first + num_rows <= (uint32_t)image->first_row + image->num_rows));
}

static rg_status remap_ring(const rg_camera* camera, const rg_image* image,
                            const rg_target* target) {
  const int32_t rows = rg_find_source_rows(camera, image->format,
                                           target->first_row, target->num_rows);
  if (!are_rows_there(image, (uint32_t)rows)) return RG_ERR_ROWS_MISSING;
  return rg_traverse_image(camera, image, target);
}

rg_status rg_remap(const rg_camera* camera, const rg_image* image,
                   const rg_target* target) {
  const rg_status status = check_frames(camera, image, target);
  if (status != RG_OK) return status;
  if (image->ring_rows != 0) return remap_ring(camera, image, target);
  return rg_traverse_image(camera, image, target);
}
