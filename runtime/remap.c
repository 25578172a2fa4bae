/* Undistortion of frames: formats/SPEC.md, "Remap arithmetic". One lattice of
 * the format after the other. */
#include "planes.h"
#include "remap_pixels.h"
#include "remap_source_rows.h"

/* ---- Whole lattices ------------------------------------------------------ */

/* Of a ring, the rows from one multiple of its size to the next follow each
 * other in memory: those that the block's top lies in. Pixels of others are
 * taken one by one. */
static RG_NOINLINE void choose_ring_rows(rg_remap_job* job) {
  const rg_position* const corners = job->run.block.corners;
  int32_t top = (job->size[1] - 1) << 12;
  for (int k = 0; k < 4; ++k)
    if (corners[k].q12[1] < top) top = corners[k].q12[1];
  const uint32_t row = top < 0 ? 0 : (uint32_t)top >> 12;
  const uint32_t first = row - (uint32_t)rg_remainder(row, job->ring_rows);
  const uint32_t rest = job->size[1] - first;
  job->run.first_source_row = (uint16_t)first;
  job->num_rows = (uint16_t)(rest < job->ring_rows ? rest : job->ring_rows);
}

static RG_NOINLINE void fill_run(const rg_remap_job* job,
                                 const rg_target* target) {
  if (target->border != RG_BORDER_KEEP)
    rg_fill_run(&job->run, job->lattice,
                target->border_values + job->lattice->first_border);
}

static RG_NOINLINE void remap_pixel(const rg_remap_job* job,
                                    const rg_target* target) {
  if (!rg_remap_pixel(job, job->lattice, target->sampling))
    fill_run(job, target);
}

static RG_INLINE void remap_run(const rg_remap_job* job,
                                const rg_target* target, rg_care care) {
  if (care == RG_CARE_NO_SOURCE)
    fill_run(job, target);
  else if (care == RG_CARE_PIXEL)
    remap_pixel(job, target);
  else if (target->sampling == RG_SAMPLING_NEAREST)
    rg_copy_lattice(&job->run, job->lattice);
  else
    rg_dispatch(rg_kernels_of(job), &job->run, job->lattice,
                care == RG_CARE_NONE);
}

static RG_INLINE void remap_part(rg_remap_job* job, const rg_target* target) {
  rg_bring_to_lattice(job);
  if (job->ring_rows != 0) choose_ring_rows(job);
  do {
    remap_run(job, target, rg_next_run(job));
  } while (job->rows_left != 0);
}

/* The part at hand, and some to its right. */
static RG_INLINE void remap_parts(rg_remap_job* job, const rg_target* target) {
  remap_part(job, target);
#if RG_KEEP_LINES
  while (rg_do_safe_parts(job, job->lattice, target->sampling))
    remap_part(job, target);
#endif
}

/* Before the runs of the job's lattice. */
static RG_NOINLINE void start_lattice(rg_remap_job* job, const rg_image* image,
                                      const rg_target* target) {
  const rg_lattice* const lattice = job->lattice;
  const uint32_t plane = lattice->plane, log2 = lattice->log2[1];
  const uint32_t stride = image->planes[plane].stride;
  const uint32_t out_stride = target->planes[plane].stride;
  rg_set_kernels(job, target->kernels, stride);
  job->size[0] = (uint16_t)(image->width >> lattice->log2[0]);
  job->size[1] = job->num_rows = (uint16_t)(image->height >> log2);
  job->ring_rows = (uint16_t)(image->ring_rows >> log2);
  job->run.data =
      image->planes[plane].data + lattice->first_row * (size_t)stride;
  job->run.stride = stride * lattice->row_step;
  job->run.out =
      target->planes[plane].data + lattice->first_row * (size_t)out_stride;
  job->run.out_stride = out_stride * lattice->row_step;
  job->run.first_source_row = 0;
  rg_start_rows(job, target->first_row, target->num_rows);
}

/* A function of its own, so that its stack and that of the checks do not add
 * up. */
static RG_NOINLINE rg_status remap_lattices(const uint8_t* section,
                                            const rg_image* image,
                                            const rg_target* target) {
  rg_remap_job job;
  job.walk.section = section;
  job.walk.is_clamped = target->border == RG_BORDER_CLAMP;
  for (uint32_t k = rg_format_lattices(image->format, &job.lattice); k != 0;
       --k, ++job.lattice) {
    start_lattice(&job, image, target);
    while (rg_next_part(&job)) remap_parts(&job, target);
  }
  return RG_OK;
}

/* ---- Checks -------------------------------------------------------------- */

static rg_status check_plane(const rg_lattice* lattice, const uint8_t* data,
                             uint32_t stride, uint32_t width) {
  const uint32_t row_bytes = rg_plane_row_bytes(lattice, width);
  if (row_bytes == 0 || stride < row_bytes) return RG_ERR_FRAME_SIZE;
  if (lattice->kind == RG_SAMPLE_16 && (((uintptr_t)data | stride) & 1) != 0)
    return RG_ERR_MISALIGNED;
  return RG_OK;
}

static rg_status check_lattice(const uint8_t* section, const rg_image* image,
                               const rg_target* target,
                               const rg_lattice* lattice) {
  const uint32_t odd_rows = (1u << lattice->log2[1]) - 1;
  const uint32_t output_height = rg_load_u16(section + 2);
  if (((image->height | output_height | image->ring_rows) & odd_rows) != 0)
    return RG_ERR_FRAME_SIZE;
  if (((target->first_row | target->num_rows) & odd_rows) != 0)
    return RG_ERR_ROWS;
  const uint32_t plane = lattice->plane;
  const rg_status status =
      check_plane(lattice, image->planes[plane].data,
                  image->planes[plane].stride, image->width);
  if (status != RG_OK) return status;
  return check_plane(lattice, target->planes[plane].data,
                     target->planes[plane].stride, rg_load_u16(section));
}

/* The lattice's plane of an image, or of so many rows of one. */
static void find_plane(const rg_lattice* lattice, const uint8_t* data,
                       uint32_t stride, uint32_t width, uint32_t num_rows,
                       rg_plane* plane) {
  plane->data = data;
  plane->stride = stride;
  plane->row_bytes = rg_plane_row_bytes(lattice, width);
  plane->num_rows = (num_rows >> lattice->log2[1]) * lattice->row_step;
}

static RG_NOINLINE int is_overlapping(const uint8_t* section,
                                      const rg_image* image,
                                      const rg_target* target,
                                      const rg_lattice* lattices,
                                      uint32_t num_lattices) {
  const uint32_t source_rows =
      image->ring_rows != 0 ? image->ring_rows : image->height;
  rg_plane written, other;
  for (uint32_t k = 0; k < num_lattices; ++k) {
    const uint32_t p = lattices[k].plane;
    find_plane(&lattices[k], target->planes[p].data, target->planes[p].stride,
               rg_load_u16(section), target->num_rows, &written);
    for (uint32_t j = 0; j < num_lattices; ++j) {
      const uint32_t q = lattices[j].plane;
      find_plane(&lattices[j], image->planes[q].data, image->planes[q].stride,
                 image->width, source_rows, &other);
      if (rg_do_planes_overlap(&written, &other)) return 1;
      if (q <= p) continue;
      find_plane(&lattices[j], target->planes[q].data, target->planes[q].stride,
                 rg_load_u16(section), target->num_rows, &other);
      if (rg_do_planes_overlap(&written, &other)) return 1;
    }
  }
  return 0;
}

rg_status rg_remap_size(const rg_camera* camera, uint16_t* width,
                        uint16_t* height) {
  if (!camera->remap) return RG_ERR_NO_REMAP;
  *width = rg_load_u16(camera->remap);
  *height = rg_load_u16(camera->remap + 2);
  return RG_OK;
}

static RG_NOINLINE rg_status check_frames(const rg_camera* camera,
                                          const rg_image* image,
                                          const rg_target* target) {
  const uint8_t* const section = camera->remap;
  if (!section) return RG_ERR_NO_REMAP;
  const rg_lattice* lattices = 0;
  const uint32_t num_lattices = rg_format_lattices(image->format, &lattices);
  if (num_lattices == 0 || (uint32_t)target->border > RG_BORDER_KEEP ||
      (uint32_t)target->sampling > RG_SAMPLING_NEAREST ||
      (target->border == RG_BORDER_CLAMP && image->ring_rows != 0))
    return RG_ERR_FORMAT;
  if (image->width != camera->width || image->height != camera->height)
    return RG_ERR_FRAME_SIZE;
  for (uint32_t k = 0; k < num_lattices; ++k) {
    const rg_status status =
        check_lattice(section, image, target, &lattices[k]);
    if (status != RG_OK) return status;
  }
  if ((uint32_t)target->first_row + target->num_rows > rg_load_u16(section + 2))
    return RG_ERR_ROWS;
  return is_overlapping(section, image, target, lattices, num_lattices)
             ? RG_ERR_OVERLAP
             : RG_OK;
}

rg_status rg_remap(const rg_camera* camera, const rg_image* image,
                   const rg_target* target) {
  rg_status status = check_frames(camera, image, target);
  if (status == RG_OK && image->ring_rows != 0)
    status = rg_check_ring(camera, image, target);
  return status == RG_OK ? remap_lattices(camera->remap, image, target)
                         : status;
}
