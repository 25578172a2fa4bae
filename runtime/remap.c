/* Undistortion of frames: formats/SPEC.md, "Remap arithmetic". One lattice of
 * the format after the other. */
#include "planes.h"
#include "remap_blocks.h"

/* ---- Whole lattices ------------------------------------------------------ */

/* Where the ring's rows are. */
static void find_ring(const rg_image* image, remap_job* job) {
  const uint32_t log2 = job->map.lattice->log2_y;
  const uint32_t first = image->first_row;
  job->is_ring = image->ring_rows != 0;
  if (!job->is_ring) return;
  job->ring_rows = (uint16_t)(image->ring_rows >> log2);
  job->ring_start =
      (uint16_t)((first - rg_remainder(first, image->ring_rows)) >> log2);
}

/* Functions of their own, this one and the checks, so that their stacks do not
 * add up. */
static RG_NOINLINE void remap_lattice(const uint8_t* section,
                                      const rg_image* image,
                                      const rg_target* target,
                                      const rg_lattice* lattice) {
  const uint32_t plane = lattice->plane;
  const uint32_t stride = image->planes[plane].stride;
  const uint32_t out_stride = target->planes[plane].stride;
  remap_job job;
  rg_lattice_map_open(&job.map, section, lattice, image->width, image->height);
  find_safe_region(&job);
  find_ring(image, &job);
  job.border = (uint8_t)target->border;
  job.sampling = (uint8_t)target->sampling;
  job.border_values = target->border_values + lattice->first_border;
  job.kernels = rg_choose_kernels(target->kernels, stride);
  job.run.data =
      image->planes[plane].data + lattice->first_row * (size_t)stride;
  job.run.stride = stride * lattice->row_step;
  job.run.out_stride = out_stride * lattice->row_step;
  job.run.first_source_row = 0;
  const uint32_t row = (uint32_t)target->first_row >> lattice->log2_y;
  remap_rows(
      &job, row, row + ((uint32_t)target->num_rows >> lattice->log2_y),
      target->planes[plane].data + lattice->first_row * (size_t)out_stride);
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
  const uint32_t odd_rows = (1u << lattice->log2_y) - 1;
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
  plane->num_rows = (num_rows >> lattice->log2_y) * lattice->row_step;
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

static rg_status check_ring(const rg_camera* camera, const rg_image* image,
                            const rg_target* target) {
  if (image->ring_rows == 0) return RG_OK;
  uint16_t first = 0, num_rows = 0;
  const rg_status status =
      rg_remap_source_rows(camera, image->format, target->first_row,
                           target->num_rows, &first, &num_rows);
  if (status != RG_OK) return status;
  if (image->num_rows > image->ring_rows ||
      (num_rows != 0 &&
       (first < image->first_row ||
        first + num_rows > image->first_row + image->num_rows)))
    return RG_ERR_ROWS_MISSING;
  return RG_OK;
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
                                          const rg_target* target,
                                          const rg_lattice* lattices,
                                          uint32_t num_lattices) {
  const uint8_t* const section = camera->remap;
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
  if (is_overlapping(section, image, target, lattices, num_lattices))
    return RG_ERR_OVERLAP;
  return check_ring(camera, image, target);
}

rg_status rg_remap(const rg_camera* camera, const rg_image* image,
                   const rg_target* target) {
  if (!camera->remap) return RG_ERR_NO_REMAP;
  const rg_lattice* lattices = 0;
  const uint32_t num_lattices = rg_format_lattices(image->format, &lattices);
  const rg_status status =
      check_frames(camera, image, target, lattices, num_lattices);
  if (status != RG_OK) return status;
  for (uint32_t k = 0; k < num_lattices; ++k)
    remap_lattice(camera->remap, image, target, &lattices[k]);
  return RG_OK;
}
