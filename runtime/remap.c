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
  uint8_t* out;                   /* the next row */
} remap_job;

/* A row of a block, and where it goes. */
typedef struct block_target {
  rg_lattice_row row;
  uint32_t first_pixel, num_pixels; /* of the output's row */
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

/* If all of the row needs no care, how many rows of the ring come before its
 * memory; otherwise -1. */
static int32_t find_run(const remap_job* job, const block_target* block) {
  const uint32_t end = UINT32_C(1) << job->map.block_width_log2;
  const rg_position left = rg_lattice_segment(&job->map, &block->row, 0);
  const rg_position right = rg_lattice_segment(&job->map, &block->row, end);
  if (job->sampling != RG_SAMPLING_BILINEAR || !is_safe(job, &left) ||
      !is_safe(job, &right))
    return -1;
  const uint32_t low =
      (uint32_t)(min_of(left.q12[1], right.q12[1]) - SAFE_MARGIN) >> 12;
  const uint32_t high =
      ((uint32_t)(max_of(left.q12[1], right.q12[1]) + SAFE_MARGIN) >> 12) + 1;
  const uint32_t wrap = (uint32_t)job->ring_start + job->ring_rows;
  if (high < wrap) return (int32_t)job->ring_start;
  return low >= wrap ? (int32_t)wrap : -1;
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
      rg_blend_grey8(&run, job->out + pixel);
    else
      rg_blend_lattice(&run, lattice, job->out, pixel);
  }
}

/* Pixel by pixel. */
static RG_NOINLINE void remap_pixels(const remap_job* job,
                                     const block_target* block) {
  rg_position p = {{0, 0}};
  for (uint32_t k = 0; k < block->num_pixels; ++k) {
    if (k % RG_SEGMENT_SIZE == 0)
      p = rg_lattice_segment(&job->map, &block->row, k);
    remap_pixel(job, p, job->out, block->first_pixel + k);
    rg_next_pixel(&p, &block->row.step);
  }
}

static void fill_block_row(const remap_job* job, const block_target* block) {
  const uint32_t step = job->map.lattice->sample_step;
  uint32_t index = job->map.lattice->first_sample + block->first_pixel * step;
  for (uint32_t k = 0; k < block->num_pixels; ++k, index += step)
    store_border(job, job->out, index);
}

static void remap_block_row(const remap_job* job, uint32_t i, uint32_t y,
                            block_target* block) {
  const uint32_t j = y >> job->map.block_height_log2;
  if (rg_remap_is_empty(job->map.section, i, j) &&
      job->border != RG_BORDER_CLAMP) {
    if (job->border == RG_BORDER_VALUE) fill_block_row(job, block);
    return;
  }
  const uint32_t r = y & ((1u << job->map.block_height_log2) - 1);
  rg_lattice_block_row(&job->map, i, j, r, &block->row);
  const int32_t rows_before = find_run(job, block);
  if (rows_before >= 0)
    blend_row(job, block, (uint32_t)rows_before);
  else
    remap_pixels(job, block);
}

/* Row y of the output's lattice. */
static void remap_row(const remap_job* job, uint32_t y) {
  const uint32_t width =
      (uint32_t)rg_load_u16(job->map.section) >> job->map.lattice->log2_x;
  const uint32_t block_width = UINT32_C(1) << job->map.block_width_log2;
  block_target block;
  block.first_pixel = 0;
  for (uint32_t i = 0; block.first_pixel < width; ++i) {
    block.num_pixels = (uint32_t)min_of((int32_t)(width - block.first_pixel),
                                        (int32_t)block_width);
    remap_block_row(job, i, y, &block);
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

/* Rows [first_row, first_row + num_rows) of the lattice's output, which lie
 * stride bytes apart. */
static void remap_rows(remap_job* job, uint32_t first_row, uint32_t num_rows,
                       uint32_t stride) {
  for (uint32_t y = 0; y < num_rows; ++y, job->out += stride)
    remap_row(job, first_row + y);
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
  remap_rows(&job, (uint32_t)target->first_row >> lattice->log2_y,
             (uint32_t)target->num_rows >> lattice->log2_y,
             out_stride * lattice->row_step);
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
  remap_rows(&job, band->first_row, band->num_rows, band->stride);
  return RG_OK;
}
