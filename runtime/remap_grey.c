/* rg_remap() for grey frames alone, with less code. */
#include "planes.h"
#include "remap_pixels.h"

static const rg_lattice kGrey = {RG_SAMPLE_8, 0,      0, 1, 1,
                                 {0, 0},      {0, 0}, 0, 1, 0};

static RG_INLINE uint8_t border_of(const rg_remap_job* job) {
  return ((const rg_band*)job->how)->border;
}

static void do_grey_run(rg_remap_job* job, rg_care care) {
  if (care == RG_CARE_NO_SOURCE) {
    const uint16_t border = border_of(job);
    rg_fill_run(&job->run, &kGrey, &border);
  } else {
    rg_dispatch_grey(rg_kernels_of(job), &job->run, care == RG_CARE_NONE);
  }
}

/* A position with a source lies in the frame; a neighbour beyond that has
 * weight zero. */
static void do_grey_pixel(rg_remap_job* job, const rg_position* position) {
  const rg_run* const run = &job->run;
  const int32_t x_q12 = position->q12[0], y_q12 = position->q12[1];
  uint8_t* const out = run->out + run->out_pixel;
  *out = border_of(job);
  if (!rg_has_source(job, position, 0)) return;
  const uint32_t x = (uint32_t)x_q12 + rg_rounding(RG_SAMPLE_8, 0);
  const uint32_t y = (uint32_t)y_q12, column = x >> 12, row = y >> 12;
  const uint8_t* const upper = run->data + (size_t)row * run->stride + column;
  const uint8_t* const lower =
      row + 1 < job->size[1] ? upper + run->stride : upper;
  *out = (uint8_t)rg_blend_bytes(upper, lower, column + 1 < job->size[0], x, y);
}

/* The part at hand, and some to its right. */
static RG_INLINE void remap_grey_parts(rg_remap_job* job) {
  rg_do_part(job, do_grey_run, do_grey_pixel);
#if RG_KEEP_LINES
  while (rg_do_safe_parts(job, &kGrey, RG_SAMPLING_BILINEAR))
    rg_do_part(job, do_grey_run, do_grey_pixel);
#endif
}

/* A function of its own, so that its stack does not add up with the rest. */
static RG_NOINLINE rg_fault check_grey_frames(const rg_camera* camera,
                                              const rg_frame* frame,
                                              const rg_band* band) {
  const uint8_t* const section = camera->remap;
  rg_fault fault = rg_fault_of(RG_ERR_NO_REMAP);
  if (!section) return fault;
  fault = rg_fault_of(RG_ERR_FRAME_SIZE);
  if (frame->width != camera->width || frame->height != camera->height ||
      frame->stride < frame->width || band->stride < rg_load_u16(section))
    return fault;
  const uint32_t end_row = (uint32_t)band->first_row + band->num_rows;
  fault = rg_fault_of(RG_ERR_ROWS);
  if (end_row > rg_load_u16(section + 2)) return fault;
  return rg_check_overlap(rg_load_u16(section), frame, band);
}

rg_status rg_remap_grey(const rg_camera* camera, const rg_frame* frame,
                        const rg_band* band) {
  const rg_fault fault = check_grey_frames(camera, frame, band);
  if (fault) return (rg_status)-fault;
  rg_remap_job on_stack;
  rg_remap_job* job = &on_stack;
  RG_IN_REGISTER(job);
  for (int axis = 0; axis < 2; ++axis) /* the rest is not used */
    job->lattice.log2[axis] = job->lattice.half[axis] = 0;
  job->how = band;
  rg_set_kernels(job, 0, frame->stride);
  rg_set_source(job, frame->width, frame->height);
  job->ring_rows = 0;
  job->walk.is_clamped = 0;
  job->walk.section = camera->remap;
  job->run.data = frame->data;
  job->run.stride = frame->stride;
  job->run.out = band->data;
  job->run.out_stride = band->stride;
  rg_start_rows(job, &kGrey, band->first_row, band->num_rows);
  while (rg_next_part(job)) remap_grey_parts(job);
  return RG_OK;
}
