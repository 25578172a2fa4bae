/* rg_remap_grey(): grey frames alone, with less code than rg_remap(). */
#include "blob_layout.h"
#include "bytes.h"
#include "code_size.h"
#include "frames/planes.h"
#include "frames/walk.h"

/* A function of its own, so that its stack does not add up with the rest. */
static RG_NOINLINE rg_fault check_grey_frames(const rg_camera* camera,
                                              const rg_frame* frame,
                                              const rg_band* band) {
  const uint8_t* const section = camera->remap;
  rg_fault fault = rg_fault_of(RG_ERR_NO_REMAP);
  if (!section) return fault;
  fault = rg_fault_of(RG_ERR_FRAME_SIZE);
  if (frame->width != camera->width || frame->height != camera->height ||
      frame->stride < frame->width ||
      band->stride < rg_load_u16(section + RG_REMAP_WIDTH))
    return fault;
  const uint32_t end_row = (uint32_t)band->first_row + band->num_rows;
  fault = rg_fault_of(RG_ERR_ROWS);
  if (end_row > rg_load_u16(section + RG_REMAP_HEIGHT)) return fault;
  return rg_check_overlap(rg_load_u16(section + RG_REMAP_WIDTH), frame, band);
}

rg_status rg_remap_grey(const rg_camera* camera, const rg_frame* frame,
                        const rg_band* band) {
  const rg_fault fault = check_grey_frames(camera, frame, band);
  return fault ? (rg_status)-fault : rg_walk_grey(camera, frame, band);
}
