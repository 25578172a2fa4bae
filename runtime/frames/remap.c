/* Undistortion of frames: formats/SPEC.md, "Remap arithmetic". One lattice of
 * the format after the other. */
#include "frames/planes.h"
#include "frames/remap_pixels.h"
#include "frames/remap_source_rows.h"

/* ---- Whole lattices ------------------------------------------------------ */

/* Rows of a ring, from one multiple of its size to the next, follow each other
 * in memory. Returns how many of these lie around the block's top, and the
 * first one. */
static RG_INLINE uint32_t find_ring_rows(const rg_remap_job* job, int32_t top,
                                         uint32_t* first) {
  const uint32_t row = top < 0 ? 0 : (uint32_t)top >> 12;
  *first = row - (uint32_t)rg_remainder(row, job->ring_rows);
  const uint32_t rest = job->size[1] - *first;
  return rest < job->ring_rows ? rest : job->ring_rows;
}

#if RG_KEEP_LINES

/* Pixels of other rows are taken one by one. */
static RG_NOINLINE void choose_ring_rows(rg_remap_job* job) {
  const rg_position* const corners = job->run.block.corners;
  int32_t top = (job->size[1] - 1) << 12;
  for (int k = 0; k < 4; ++k)
    if (corners[k].q12[1] < top) top = corners[k].q12[1];
  uint32_t first;
  job->num_rows = (uint16_t)find_ring_rows(job, top, &first);
  job->run.first_source_row = (uint16_t)first;
}

#else

/* Whether all rows that a safe part needs follow each other: its corners are
 * then counted from the first one in memory. */
static RG_NOINLINE int move_to_ring(rg_remap_job* job) {
  rg_position* const corners = job->run.block.corners;
  int32_t top = corners[0].q12[1], bottom = top;
  for (int k = 1; k < 4; ++k) {
    if (corners[k].q12[1] < top) top = corners[k].q12[1];
    if (corners[k].q12[1] > bottom) bottom = corners[k].q12[1];
  }
  uint32_t first;
  const uint32_t num = find_ring_rows(job, top, &first);
  const int32_t first_q12 = (int32_t)(first << 12);
  if (top - first_q12 < RG_POSITION_MARGIN ||
      bottom - first_q12 > (int32_t)((num - 1) << 12) - RG_POSITION_MARGIN)
    return 0;
  for (int k = 0; k < 4; ++k) corners[k].q12[1] -= first_q12;
  return 1;
}

#endif

static RG_INLINE const rg_target* target_of(const rg_remap_job* job) {
  return (const rg_target*)job->how;
}

static RG_INLINE const uint8_t* source_row(const rg_remap_job* job,
                                           uint32_t row) {
  if (job->ring_rows != 0) row = (uint32_t)rg_remainder(row, job->ring_rows);
  return job->run.data + (size_t)row * job->run.stride;
}

/* Rounded to the last bit that is kept, coordinate c. */
static RG_INLINE uint32_t round_position(const rg_remap_job* job, int32_t q12,
                                         int c) {
  if (target_of(job)->sampling != RG_SAMPLING_NEAREST)
    return (uint32_t)q12 + rg_rounding(rg_lattice_of(job)->kind, c);
  uint32_t pixel = ((uint32_t)q12 + 2048) >> 12;
  RG_IN_REGISTER(pixel); /* else a mask is kept in one */
  return pixel << 12;
}

/* Coordinate c of the nearest position that has a source. */
static RG_SHARED int32_t nearest_source(const rg_remap_job* job, int32_t q12,
                                        int c) {
#if RG_KEEP_LINES
  const rg_range range = job->ranges[c];
#else
  const uint8_t* const min = job->ranges + 4 * c;
  const rg_range range = {rg_load_i32(min), rg_load_i32(min + 8)};
#endif
  return rg_clamp(rg_clamp(q12, range.min_q12, range.max_q12), 0,
                  (job->size[c] - 1) << 12);
}

/* The neighbours around a position; those beyond the last have weight zero. */
static RG_INLINE void find_neighbors(const rg_remap_job* job,
                                     const rg_position* position,
                                     rg_neighbors* at) {
  at->x_q12 = round_position(job, nearest_source(job, position->q12[0], 0), 0);
  at->y_q12 = round_position(job, nearest_source(job, position->q12[1], 1), 1);
  const uint32_t row = at->y_q12 >> 12;
  at->upper = source_row(job, row);
  at->lower = source_row(job, row + (row + 1 < job->size[1]));
  at->right = (at->x_q12 >> 12) + 1 < job->size[0]
                  ? rg_lattice_of(job)->sample_step
                  : 0;
}

static RG_INLINE int takes_source(const rg_remap_job* job,
                                  const rg_position* position) {
  return target_of(job)->border == RG_BORDER_CLAMP ||
         rg_has_source(job, position);
}

static RG_INLINE void put_border(const rg_remap_job* job, uint32_t out_pixel) {
  const rg_target* const target = target_of(job);
  const rg_lattice* const lattice = rg_lattice_of(job);
  if (target->border == RG_BORDER_KEEP) return;
  const uint16_t* value = target->border_values + lattice->index;
  uint32_t index = rg_first_sample(lattice, out_pixel);
  for (uint32_t c = lattice->num_channels; c != 0; --c)
    rg_put_sample(lattice->kind, job->run.out, index++, *value++);
}

#if RG_KEEP_LINES

/* With every check. */
static void remap_pixel(rg_remap_job* job, const rg_position* position,
                        uint32_t out_pixel) {
  if (takes_source(job, position)) {
    rg_neighbors at;
    find_neighbors(job, position, &at);
    rg_blend_pixel(rg_lattice_of(job), &at, job->run.out, out_pixel);
  } else {
    put_border(job, out_pixel);
  }
}

static RG_NOINLINE void fill_run(const rg_remap_job* job) {
  const rg_target* const target = target_of(job);
  if (target->border != RG_BORDER_KEEP)
    rg_fill_run(&job->run, rg_lattice_of(job),
                target->border_values + rg_lattice_of(job)->index);
}

static RG_INLINE void remap_run(rg_remap_job* job, rg_care care) {
  if (care == RG_CARE_NO_SOURCE)
    fill_run(job);
  else if (target_of(job)->sampling == RG_SAMPLING_NEAREST)
    rg_copy_lattice(&job->run, rg_lattice_of(job));
  else
    rg_dispatch(rg_kernels_of(job), &job->run, rg_lattice_of(job),
                care == RG_CARE_NONE);
}

#else

/* The neighbours around a position of a part that asks for no care. */
static RG_INLINE void find_safe_neighbors(const rg_remap_job* job,
                                          const rg_position* position,
                                          rg_neighbors* at) {
  at->x_q12 = round_position(job, position->q12[0], 0);
  at->y_q12 = round_position(job, position->q12[1], 1);
  at->upper = at->lower =
      job->run.data + (size_t)(at->y_q12 >> 12) * job->run.stride;
  at->right = 0;
  if (target_of(job)->sampling != RG_SAMPLING_NEAREST) {
    at->lower += job->run.stride;
    at->right = rg_lattice_of(job)->sample_step;
  }
}

/* Does pixels one by one, where no kernel is built in or the run asks for care.
 * One function for both takes less stack. */
static RG_NOINLINE void remap_pixels(rg_remap_job* job) {
  rg_block_row row;
  rg_neighbors at;
  uint32_t r = 0;
  do {
    RG_IN_REGISTER(job);
    rg_find_block_row(&job->run.block, job->run.first_row + r, &row);
    uint32_t pixel = job->run.out_pixel;
    do {
      if (job->run.block.is_safe || takes_source(job, &row.start)) {
        if (job->run.block.is_safe)
          find_safe_neighbors(job, &row.start, &at);
        else
          find_neighbors(job, &row.start, &at);
        rg_blend_pixel(rg_lattice_of(job), &at, job->run.out, pixel);
      } else {
        put_border(job, pixel);
      }
      rg_go_on_in_row(&row);
    } while (++pixel != (uint32_t)job->run.out_pixel + job->run.num_pixels);
    job->run.out += job->run.out_stride;
  } while (++r != job->run.num_rows);
}

#endif

static RG_INLINE void remap_part(rg_remap_job* job) {
#if RG_KEEP_LINES
  if (job->ring_rows != 0) choose_ring_rows(job);
  rg_do_part(job, remap_run, remap_pixel);
#else
  rg_bring_to_lattice(job);
  job->run.block.is_safe =
      (uint8_t)(rg_is_part_safe(job) &&
                (job->ring_rows == 0 || move_to_ring(job)));
  if (!job->run.block.is_safe ||
      target_of(job)->sampling == RG_SAMPLING_NEAREST ||
      !rg_blend_part(job, rg_interleaved(rg_lattice_of(job))))
    remap_pixels(job);
#endif
}

/* The part at hand, and some to its right. */
static RG_INLINE void remap_parts(rg_remap_job* job) {
  remap_part(job);
#if RG_KEEP_LINES
  while (rg_do_safe_parts(job, rg_lattice_of(job), target_of(job)->sampling))
    remap_part(job);
#endif
}

/* Before the runs of the job's lattice. */
static RG_NOINLINE void start_lattice(rg_lattice_job* whole,
                                      const rg_camera* camera,
                                      const rg_image* image) {
  rg_remap_job* const job = &whole->job;
  const rg_target* const target = target_of(job);
  const rg_lattice* const lattice = rg_lattice_of(job);
  const uint32_t plane = lattice->plane;
  const uint32_t stride = image->planes[plane].stride;
  const uint32_t out_stride = target->planes[plane].stride;
  rg_set_kernels(job, target->kernels, stride);
  job->ring_rows = (uint16_t)(image->ring_rows >> lattice->log2[1]);
  job->run.data =
      image->planes[plane].data + lattice->first_row * (size_t)stride;
  job->run.stride = stride * lattice->row_step;
  job->run.out =
      target->planes[plane].data + lattice->first_row * (size_t)out_stride;
  job->run.out_stride = out_stride * lattice->row_step;
  rg_start_lattice(job, camera, target->first_row, target->num_rows);
#if !RG_KEEP_LINES
  rg_set_ranges(whole);
#endif
}

/* A function of its own, so that its stack and that of the checks do not add
 * up. */
static RG_NOINLINE rg_status remap_lattices(const rg_camera* camera,
                                            const rg_image* image,
                                            const rg_target* target) {
  rg_lattice_job whole;
  rg_remap_job* const job = &whole.job;
  job->how = target;
  job->walk.section = camera->remap;
#if RG_KEEP_LINES
  job->lattice = &whole.lattice;
  job->walk.is_clamped = target->border == RG_BORDER_CLAMP;
#endif
  for (uint32_t k = 0; rg_find_lattice(image->format, k, &whole.lattice);
       k = whole.lattice.index + 1u) {
    start_lattice(&whole, camera, image);
    while (rg_next_part(job)) remap_parts(job);
  }
  return RG_OK;
}

/* ---- Checks -------------------------------------------------------------- */

/* The plane of a lattice of an image, or of so many rows of one, as bytes. */
static RG_NOINLINE rg_status find_plane(const rg_lattice* lattice,
                                        uint32_t width, uint32_t num_rows,
                                        rg_frame* plane) {
  /* Below 2^16: the width is that of a remap, at most 8192 pixels. */
  const uint32_t row_bytes = rg_plane_row_bytes(lattice, width);
  plane->width = (uint16_t)row_bytes;
  plane->height =
      (uint16_t)((num_rows >> lattice->log2[1]) * lattice->row_step);
  if (row_bytes == 0 || plane->stride < row_bytes ||
      plane->stride > INT32_MAX) /* two rows are counted in 32 bits */
    return RG_ERR_FRAME_SIZE;
  return lattice->kind >= RG_SAMPLE_16 &&
                 (((uintptr_t)plane->data | plane->stride) & 1) != 0
             ? RG_ERR_MISALIGNED
             : RG_OK;
}

/* Checks the planes of image and target, whose formats, sizes and rows are
 * right. */
static RG_NOINLINE rg_status check_planes(const uint8_t* section,
                                          const rg_image* image,
                                          const rg_target* target) {
  const uint32_t source_rows =
      image->ring_rows != 0 ? image->ring_rows : image->height;
  rg_frame planes[6]; /* each of the image, and behind it the target's */
  uint32_t num_planes = 0;
  rg_lattice lattice;
  for (uint32_t k = 0; rg_find_lattice(image->format, k, &lattice); ++k) {
    const uint32_t p = lattice.plane;
    rg_frame* const plane = &planes[2 * p];
    plane[0].data = image->planes[p].data;
    plane[0].stride = image->planes[p].stride;
    plane[1].data = target->planes[p].data;
    plane[1].stride = target->planes[p].stride;
    rg_status status = find_plane(&lattice, image->width, source_rows, plane);
    if (status == RG_OK)
      status = find_plane(&lattice, rg_load_u16(section), target->num_rows,
                          plane + 1);
    if (status != RG_OK) return status;
    num_planes = 2 * p + 2;
  }
  for (uint32_t k = 1; k < num_planes; k += 2) {
    const rg_band written = {target->planes[k / 2].data, planes[k].stride, 0,
                             planes[k].height, 0};
    for (uint32_t other = 0; other < num_planes; ++other)
      if (other != k &&
          rg_check_overlap(planes[k].width, &planes[other], &written) != 0)
        return RG_ERR_OVERLAP;
  }
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
  if (image->width != camera->width || image->height != camera->height ||
      (image->ring_rows & rg_row_pairs(image->format)) != 0)
    return RG_ERR_FRAME_SIZE;
  return check_planes(camera->remap, image, target);
}

rg_status rg_remap_size(const rg_camera* camera, uint16_t* width,
                        uint16_t* height) {
  if (!camera->remap) return RG_ERR_NO_REMAP;
  *width = rg_load_u16(camera->remap);
  *height = rg_load_u16(camera->remap + 2);
  return RG_OK;
}

/* Whether a ring holds rows as rg_find_source_rows() has them. */
static RG_NOINLINE int are_rows_there(const rg_image* image, uint32_t rows) {
  const uint32_t first = rows & 0xffff, num_rows = rows >> 16;
  return image->num_rows <= image->ring_rows &&
         (num_rows == 0 ||
          (first >= image->first_row &&
           first + num_rows <= (uint32_t)image->first_row + image->num_rows));
}

static RG_NOINLINE rg_status remap_ring(const rg_camera* camera,
                                        const rg_image* image,
                                        const rg_target* target) {
  const int32_t rows = rg_find_source_rows(camera, image->format,
                                           target->first_row, target->num_rows);
  if (!are_rows_there(image, (uint32_t)rows)) return RG_ERR_ROWS_MISSING;
  return remap_lattices(camera, image, target);
}

rg_status rg_remap(const rg_camera* camera, const rg_image* image,
                   const rg_target* target) {
  const rg_status status = check_frames(camera, image, target);
  if (status != RG_OK) return status;
  if (image->ring_rows != 0) return remap_ring(camera, image, target);
  return remap_lattices(camera, image, target);
}
