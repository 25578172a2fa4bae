/* rg_remap_grey(): only grey frames, with less code than rg_remap(). */
#include "blob_layout.h"
#include "bytes.h"
#include "code_size.h"
#include "frames/planes.h"
#include "frames/traversal.h"

static rg_status check_grey_frames(const rg_camera* camera,
                                   const rg_grey_image* frame,
                                   const rg_grey_target* band) {
  const uint8_t* const section = camera->remap;
  if (!section) return RG_ERR_NO_REMAP;
  if (frame->width != camera->frame_width ||
      frame->height != camera->frame_height ||
      !rg_is_stride(frame->stride, frame->width) ||
      !rg_is_stride(band->stride, rg_load_u16(section + RG_REMAP_WIDTH)))
    return RG_ERR_FRAME_SIZE;
  const uint32_t end_row = (uint32_t)band->first_row + band->num_rows;
  if (end_row > rg_load_u16(section + RG_REMAP_HEIGHT)) return RG_ERR_ROWS;
  RG_FORGET(band); /* otherwise, its rows occupy a register */
  return rg_check_overlap(
      frame, band->data, band->stride,
      rg_load_u16(section + RG_REMAP_WIDTH) | (uint32_t)band->num_rows << 16);
}

rg_status rg_remap_grey(const rg_camera* camera, const rg_grey_image* frame,
                        const rg_grey_target* band) {
  const rg_status status = check_grey_frames(camera, frame, band);
  if (status != RG_OK) return status;
  return rg_traverse_grey(camera, frame, band);
}
