/* rg_remap() for grey frames alone, with less code. */
#include "frames/planes.h"
#include "frames/remap_pixels.h"

static const rg_lattice kGrey = {RG_SAMPLE_8, 0,      0, 1, 1,
                                 {0, 0},      {0, 0}, 0, 1, 0};

static RG_INLINE uint8_t border_of(const rg_remap_job* job) {
  return ((const rg_band*)job->how)->border;
}

/* A position with a source lies in the frame. At the last column its weight is
 * zero, or all if one counts from the column before; likewise at the last row.
 */
static void do_grey_pixel(rg_remap_job* job, const rg_position* position,
                          uint32_t out_pixel) {
  const rg_run* const run = &job->run;
  uint32_t value = border_of(job);
  if (rg_has_source(job, position)) {
    const uint32_t x = (uint32_t)position->q12[0] + rg_rounding(RG_SAMPLE_8, 0);
    const uint32_t y = (uint32_t)position->q12[1];
    const uint32_t column = rg_lesser(x >> 12, job->size[0] - 2u);
    const uint32_t row = rg_lesser(y >> 12, job->size[1] - 2u);
    const uint8_t* const upper = run->data + (size_t)row * run->stride + column;
    const uint32_t pixels =
        rg_load_pair(upper) | rg_load_pair(upper + run->stride) << 16;
    uint32_t wy_q12 = y - (row << 12);
    RG_IN_REGISTER(wy_q12);
    value = rg_blend_8(rg_even_bytes(pixels), rg_odd_bytes(pixels),
                       (x >> 5) - (column << 7), wy_q12, RG_ROUNDING_8);
  }
  run->out[out_pixel] = (uint8_t)value;
}

#if RG_KEEP_LINES

static void do_grey_run(rg_remap_job* job, rg_care care) {
  if (care == RG_CARE_NO_SOURCE) {
    const uint16_t border = border_of(job);
    rg_fill_run(&job->run, &kGrey, &border);
  } else {
    rg_dispatch_grey(rg_kernels_of(job), &job->run, care == RG_CARE_NONE);
  }
}

static RG_INLINE void do_grey_band(rg_remap_job* job, const rg_frame* frame,
                                   const rg_band* band) {
  job->lattice = &kGrey;
  rg_set_source(job, frame->width, frame->height);
  job->ring_rows = 0;
  job->walk.is_clamped = 0;
  job->run.out = band->data;
  rg_start_rows(job, &kGrey, band->first_row, band->num_rows);
  while (rg_next_part(job)) {
    do { /* the part at hand, and some to its right */
      rg_do_part(job, do_grey_run, do_grey_pixel);
    } while (rg_do_safe_parts(job, &kGrey, RG_SAMPLING_BILINEAR));
  }
}

#else

static RG_INLINE void do_grey_part(rg_remap_job* job) {
  const int is_safe = rg_is_part_safe(job);
#if RG_ALL_BUILT_IN
  if (is_safe)
    RG_BUILT_IN(1)(&job->run);
  else
    rg_do_rows(job, do_grey_pixel);
#else
  rg_do_rows(job, is_safe ? NULL : do_grey_pixel);
#endif
}

/* Remaps a band, with the steps of rg_next_part() in place. */
static RG_INLINE void do_grey_band(rg_remap_job* job, const rg_frame* frame,
                                   const rg_band* band) {
  rg_run* const run = &job->run;
  job->size[0] = frame->width;
  job->size[1] = frame->height;
  rg_set_table(job, &kGrey);
  uint8_t* out = band->data;
  uint32_t row = band->first_row, rest = band->num_rows;
  while (rest != 0) {
    const uint32_t log2 = run->block.height_log2, part = 1u << log2;
    const uint32_t first_row = row & (part - 1);
    run->first_row = (uint16_t)first_row;
    run->num_rows = (uint16_t)rg_lesser(part - first_row, rest);
    rg_start_parts(&job->walk, row >> log2);
    uint32_t pixel = 0;
    do {
      run->out = out + pixel;
      run->num_pixels = (uint16_t)rg_lesser(job->width - pixel, part);
      rg_next_corners(&job->walk, run->block.corners);
      do_grey_part(job);
      pixel += part;
    } while (pixel < job->width);
    out += (size_t)run->num_rows * run->out_stride;
    row += run->num_rows;
    rest -= run->num_rows;
  }
}

#endif

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
  rg_fault fault = check_grey_frames(camera, frame, band);
  if (!fault) {
    rg_remap_job on_stack;
    rg_remap_job* job = &on_stack;
    RG_IN_REGISTER(job);
    job->how = band;
    rg_set_kernels(job, 0, frame->stride);
    job->walk.section = camera->remap;
    job->run.data = frame->data;
    job->run.stride = frame->stride;
    job->run.out_stride = band->stride;
    do_grey_band(job, frame, band);
    fault = 0;
    RG_IN_REGISTER(fault); /* not the one above, kept meanwhile */
  }
  return (rg_status)-fault;
}
