/* Undistortion of frames: formats/SPEC.md, "Remap arithmetic". One lattice of
 * the format after the other. */
#include <stddef.h>

#include "fixed_point.h"
#include "lattice_map.h"
#include "raygrid.h"
#include "remap_rows.h"

/* More than rounding moves the positions of a row, in q12. */
#define SAFE_MARGIN 64

/* What every block of a lattice needs. Positions are in its own pixels. */
typedef struct remap_job {
  rg_lattice_map map;
  const uint8_t* data; /* source row ring_start */
  uint32_t stride;
  uint16_t ring_start, ring_rows; /* rows from ring_start + ring_rows on wrap */
  uint8_t border, sampling;       /* rg_border, rg_sampling */
  const uint16_t* border_values;  /* of the lattice's channels */
  uint8_t* out;                   /* where the first row goes */
  uint32_t out_stride;
} remap_job;

/* A block, one row of it, and where that goes. */
typedef struct block_target {
  rg_block corners;
  rg_lattice_row row;
  uint32_t first_pixel, num_pixels; /* of the output's rows */
  uint8_t* out;                     /* the output's row */
} block_target;

static int32_t min_of(int32_t a, int32_t b) { return a < b ? a : b; }
static int32_t max_of(int32_t a, int32_t b) { return a > b ? a : b; }

/* ---- Single pixels, with every check ------------------------------------- */

static const uint8_t* source_row(const remap_job* job, uint32_t row) {
  uint32_t slot = row - job->ring_start;
  if (slot >= job->ring_rows) slot -= job->ring_rows;
  return job->data + (size_t)slot * job->stride;
}

static void store_border(const remap_job* job, uint8_t* out, uint32_t index) {
  const rg_lattice* const lattice = job->map.lattice;
  for (uint32_t c = 0; c < lattice->num_channels; ++c)
    rg_store_sample(lattice->kind, out, index + c, job->border_values[c]);
}

/* Bilinear or nearest, at a position that is moved into the lattice. */
static void store_source(const remap_job* job, rg_position p, uint8_t* out,
                         uint32_t index) {
  const rg_lattice* const lattice = job->map.lattice;
  const int32_t last[2] = {(int32_t)(job->map.width - 1) << 12,
                           (int32_t)(job->map.height - 1) << 12};
  for (int c = 0; c < 2; ++c) {
    p.q12[c] = max_of(min_of(p.q12[c], last[c]), 0);
    if (job->sampling == RG_SAMPLING_NEAREST)
      p.q12[c] = (int32_t)((uint32_t)(p.q12[c] + 2048) & ~4095u);
  }
  const rg_cut_position cut = rg_cut(lattice->kind, p);
  /* A neighbour beyond the last column or row has weight zero. */
  const uint32_t right =
      cut.column + 1 < job->map.width ? lattice->sample_step : 0;
  const uint32_t below = cut.row + 1 < job->map.height;
  const uint8_t* const upper = source_row(job, cut.row);
  const uint8_t* const lower = source_row(job, cut.row + below);
  const uint32_t first =
      lattice->first_sample + cut.column * lattice->sample_step;
  for (uint32_t c = 0; c < lattice->num_channels; ++c)
    rg_store_sample(
        lattice->kind, out, index + c,
        rg_blend(lattice->kind, upper, lower, first + c, right, cut));
}

static void remap_pixel(const remap_job* job, rg_position p, uint8_t* out,
                        uint32_t pixel) {
  const rg_lattice* const lattice = job->map.lattice;
  const uint32_t index = lattice->first_sample + pixel * lattice->sample_step;
  if (!rg_has_source(&job->map, &p)) {
    if (job->border == RG_BORDER_KEEP) return;
    if (job->border == RG_BORDER_VALUE) {
      store_border(job, out, index);
      return;
    }
    for (int c = 0; c < 2; ++c)
      p.q12[c] =
          max_of(min_of(p.q12[c], job->map.max.q12[c]), job->map.min.q12[c]);
  }
  store_source(job, p, out, index);
}

/* ---- Rows of blocks ------------------------------------------------------ */

/* A position whose neighbours are all in the image, whatever was rounded. */
static int is_safe(const remap_job* job, const rg_position* p) {
  const uint32_t size[2] = {job->map.width, job->map.height};
  for (int c = 0; c < 2; ++c) {
    const int32_t last = (int32_t)(size[c] - 1) << 12;
    if (p->q12[c] < max_of(job->map.min.q12[c], 0) + SAFE_MARGIN ||
        p->q12[c] > min_of(job->map.max.q12[c], last) - SAFE_MARGIN)
      return 0;
  }
  return 1;
}

#define NO_RUN (-1)

/* If positions between these need no care, how many rows of the ring come
 * before their memory; otherwise NO_RUN. */
static int32_t find_run(const remap_job* job, const rg_position* positions,
                        uint32_t num_positions) {
  int32_t low = INT32_MAX, high = INT32_MIN;
  for (uint32_t k = 0; k < num_positions; ++k) {
    if (!is_safe(job, &positions[k])) return NO_RUN;
    low = min_of(low, positions[k].q12[1]);
    high = max_of(high, positions[k].q12[1]);
  }
  const int32_t wrap = job->ring_start + job->ring_rows;
  if (((high + SAFE_MARGIN) >> 12) + 1 < wrap) return job->ring_start;
  return (low - SAFE_MARGIN) >> 12 >= wrap ? wrap : NO_RUN;
}

static RG_NOINLINE int32_t find_block_run(const remap_job* job,
                                          const block_target* block) {
  rg_position corners[4];
  if (job->sampling != RG_SAMPLING_BILINEAR) return NO_RUN;
  for (int k = 0; k < 4; ++k)
    corners[k] =
        rg_lattice_position(job->map.lattice, &block->corners.corners[k]);
  return find_run(job, corners, 4);
}

static RG_NOINLINE int32_t find_row_run(const remap_job* job,
                                        const block_target* block) {
  const uint32_t end = UINT32_C(1) << job->map.block_width_log2;
  if (job->sampling != RG_SAMPLING_BILINEAR) return NO_RUN;
  const rg_position ends[2] = {rg_lattice_segment(&job->map, &block->row, 0),
                               rg_lattice_segment(&job->map, &block->row, end)};
  return find_run(job, ends, 2);
}

/* Segments without care. */
static RG_NOINLINE void blend_row(const remap_job* job,
                                  const block_target* block,
                                  uint32_t rows_before) {
  const rg_lattice* const lattice = job->map.lattice;
  const int is_grey = lattice->kind == RG_SAMPLE_8 && lattice->sample_step == 1;
  rg_run run;
  run.data = job->data;
  run.stride = job->stride;
  run.step = block->row.step;
  for (uint32_t k = 0; k < block->num_pixels; k += RG_SEGMENT_SIZE) {
    const uint32_t pixel = block->first_pixel + k;
    run.start = rg_lattice_segment(&job->map, &block->row, k);
    run.start.q12[1] -= (int32_t)(rows_before << 12);
    run.num_pixels = (uint32_t)min_of((int32_t)(block->num_pixels - k),
                                      (int32_t)RG_SEGMENT_SIZE);
    if (is_grey)
      rg_blend_grey8(&run, block->out + pixel);
    else
      rg_blend_lattice(&run, lattice, block->out, pixel);
  }
}

/* Pixel by pixel. */
static RG_NOINLINE void remap_pixels(const remap_job* job,
                                     const block_target* block) {
  rg_position p = {{0, 0}};
  for (uint32_t k = 0; k < block->num_pixels; ++k) {
    if (k % RG_SEGMENT_SIZE == 0)
      p = rg_lattice_segment(&job->map, &block->row, k);
    remap_pixel(job, p, block->out, block->first_pixel + k);
    rg_next_pixel(&p, &block->row.step);
  }
}

static void fill_block_row(const remap_job* job, const block_target* block) {
  const uint32_t step = job->map.lattice->sample_step;
  uint32_t index = job->map.lattice->first_sample + block->first_pixel * step;
  for (uint32_t k = 0; k < block->num_pixels; ++k, index += step)
    store_border(job, block->out, index);
}

/* Rows [row, end) of block (i, j). */
static void remap_block(const remap_job* job, uint32_t i, uint32_t j,
                        uint32_t row, uint32_t end, block_target* block) {
  const int is_empty = job->border != RG_BORDER_CLAMP &&
                       rg_remap_is_empty(job->map.section, i, j);
  if (is_empty && job->border == RG_BORDER_KEEP) return;
  rg_remap_block(job->map.section, i, j, &block->corners);
  const int32_t block_run = is_empty ? NO_RUN : find_block_run(job, block);
  for (; row < end; ++row, block->out += job->out_stride) {
    if (is_empty) {
      fill_block_row(job, block);
      continue;
    }
    rg_lattice_block_row(&job->map, &block->corners, row, &block->row);
    const int32_t run =
        block_run != NO_RUN ? block_run : find_row_run(job, block);
    if (run != NO_RUN)
      blend_row(job, block, (uint32_t)run);
    else
      remap_pixels(job, block);
  }
}

/* Rows [row, end) of block row j. */
static void remap_block_row(const remap_job* job, uint32_t j, uint32_t row,
                            uint32_t end, uint8_t* out) {
  const uint32_t width =
      (uint32_t)rg_load_u16(job->map.section) >> job->map.lattice->log2_x;
  const uint32_t block_width = UINT32_C(1) << job->map.block_width_log2;
  block_target block;
  block.first_pixel = 0;
  for (uint32_t i = 0; block.first_pixel < width; ++i) {
    block.num_pixels = (uint32_t)min_of((int32_t)(width - block.first_pixel),
                                        (int32_t)block_width);
    block.out = out;
    remap_block(job, i, j, row, end, &block);
    block.first_pixel += block_width;
  }
}

/* ---- Whole lattices ------------------------------------------------------ */

/* a mod b without division, which not every core has. */
static uint32_t remainder_of(uint32_t a, uint32_t b) {
  for (int shift = 15; shift >= 0; --shift)
    if (a >= b << shift) a -= b << shift;
  return a;
}

/* Rows [row, end) of the lattice's output. */
static void remap_rows(const remap_job* job, uint32_t row, uint32_t end) {
  const uint32_t height_log2 = job->map.block_height_log2;
  uint8_t* out = job->out;
  while (row < end) {
    const uint32_t j = row >> height_log2;
    const uint32_t first = j << height_log2;
    const uint32_t next =
        (uint32_t)min_of((int32_t)end, (int32_t)((j + 1) << height_log2));
    remap_block_row(job, j, row - first, next - first, out);
    out += (size_t)(next - row) * job->out_stride;
    row = next;
  }
}

/* Where the ring's rows are. */
static void find_ring(const rg_image* image, remap_job* job) {
  const uint32_t log2 = job->map.lattice->log2_y;
  const uint32_t first = image->first_row;
  job->ring_start = 0;
  job->ring_rows = job->map.height;
  if (image->ring_rows == 0) return;
  job->ring_rows = (uint16_t)(image->ring_rows >> log2);
  job->ring_start =
      (uint16_t)((first - remainder_of(first, image->ring_rows)) >> log2);
}

static void remap_lattice(const uint8_t* section, const rg_image* image,
                          const rg_target* target, const rg_lattice* lattice) {
  const uint32_t plane = lattice->plane;
  const uint32_t stride = image->planes[plane].stride;
  const uint32_t out_stride = target->planes[plane].stride;
  remap_job job;
  rg_lattice_map_open(&job.map, section, lattice, image->width, image->height);
  job.data = image->planes[plane].data + lattice->first_row * (size_t)stride;
  job.stride = stride * lattice->row_step;
  find_ring(image, &job);
  job.border = (uint8_t)target->border;
  job.sampling = (uint8_t)target->sampling;
  job.border_values = target->border_values + lattice->first_border;
  job.out =
      target->planes[plane].data + lattice->first_row * (size_t)out_stride;
  job.out_stride = out_stride * lattice->row_step;
  const uint32_t row = (uint32_t)target->first_row >> lattice->log2_y;
  remap_rows(&job, row, row + ((uint32_t)target->num_rows >> lattice->log2_y));
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

rg_status rg_remap(const rg_camera* camera, const rg_image* image,
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
  const rg_status status = check_ring(camera, image, target);
  if (status != RG_OK) return status;
  for (uint32_t k = 0; k < num_lattices; ++k)
    remap_lattice(section, image, target, &lattices[k]);
  return RG_OK;
}

rg_status rg_remap_grey(const rg_camera* camera, const rg_frame* frame,
                        const rg_band* band) {
  const uint8_t* const section = camera->remap;
  if (!section) return RG_ERR_NO_REMAP;
  if (frame->width != camera->width || frame->height != camera->height ||
      frame->stride < frame->width || band->stride < rg_load_u16(section))
    return RG_ERR_FRAME_SIZE;
  const uint32_t end_row = (uint32_t)band->first_row + band->num_rows;
  if (end_row > rg_load_u16(section + 2)) return RG_ERR_ROWS;
  const uint16_t border = band->border;
  const rg_lattice* lattice = 0;
  rg_format_lattices(RG_FORMAT_GREY8, &lattice);
  remap_job job;
  rg_lattice_map_open(&job.map, section, lattice, frame->width, frame->height);
  job.data = frame->data;
  job.stride = frame->stride;
  job.ring_start = 0;
  job.ring_rows = frame->height;
  job.border = RG_BORDER_VALUE;
  job.sampling = RG_SAMPLING_BILINEAR;
  job.border_values = &border;
  job.out = band->data;
  job.out_stride = band->stride;
  remap_rows(&job, band->first_row, end_row);
  return RG_OK;
}
