/* rg_remap() for grey frames alone, with less code. */
#define RG_GREY_ONLY
#include "planes.h"
#include "remap_blocks.h"

/* A function of its own, so that its stack does not add up with the rest. */
static RG_NOINLINE rg_status check_grey_frames(const rg_camera* camera,
                                               const rg_frame* frame,
                                               const rg_band* band) {
  const uint8_t* const section = camera->remap;
  if (!section) return RG_ERR_NO_REMAP;
  if (frame->width != camera->width || frame->height != camera->height ||
      frame->stride < frame->width || band->stride < rg_load_u16(section))
    return RG_ERR_FRAME_SIZE;
  const uint32_t end_row = (uint32_t)band->first_row + band->num_rows;
  if (end_row > rg_load_u16(section + 2)) return RG_ERR_ROWS;
  const rg_plane source = {frame->data, frame->stride, frame->width,
                           frame->height};
  const rg_plane written = {band->data, band->stride, rg_load_u16(section),
                            band->num_rows};
  return rg_do_planes_overlap(&source, &written) ? RG_ERR_OVERLAP : RG_OK;
}

rg_status rg_remap_grey(const rg_camera* camera, const rg_frame* frame,
                        const rg_band* band) {
  const rg_status status = check_grey_frames(camera, frame, band);
  if (status != RG_OK) return status;
  const uint8_t* const section = camera->remap;
  const uint16_t border = band->border;
  remap_job job;
  job.map.section = section;
  job.map.width = frame->width;
  job.map.height = frame->height;
  for (int c = 0; c < 2; ++c) {
    job.map.min.q12[c] = rg_load_i32(section + 12 + 4 * c);
    job.map.max.q12[c] = rg_load_i32(section + 20 + 4 * c);
  }
  find_safe_region(&job);
  job.border_values = &border;
  job.kernels = rg_choose_kernels(0, frame->stride);
  job.run.data = frame->data;
  job.run.stride = frame->stride;
  job.run.out_stride = band->stride;
  job.run.first_source_row = 0;
  remap_rows(&job, band->first_row, (uint32_t)band->first_row + band->num_rows,
             band->data);
  return RG_OK;
}
