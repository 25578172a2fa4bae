/* Undistortion of grey frames: formats/SPEC.md, "Remap arithmetic". */
#include <stddef.h>

#include "bytes.h"
#include "raygrid.h"
#include "remap_table.h"

/* What every block of a band needs. */
typedef struct remap_job {
  const uint8_t* section;
  const rg_frame* frame;
  int32_t min_x_q12, min_y_q12, max_x_q12, max_y_q12;
  uint8_t border;
} remap_job;

static int is_inside(const remap_job* job, rg_position p) {
  return p.q12[0] >= job->min_x_q12 && p.q12[0] <= job->max_x_q12 &&
         p.q12[1] >= job->min_y_q12 && p.q12[1] <= job->max_y_q12;
}

/* Bilinear: 7-bit weights across in 16 bits, then down with a rounding
 * multiply-high of 15 bits. p must be inside the source rectangle. */
static uint8_t fetch(const rg_frame* frame, rg_position p) {
  const int32_t x_q12 = p.q12[0] + 16; /* rounds the weight to 7 bits */
  const uint32_t column = (uint32_t)x_q12 >> 12;
  const uint32_t row = (uint32_t)p.q12[1] >> 12;
  const int32_t wx_q7 = (x_q12 >> 5) & 127;
  const int32_t wy_q15 = (p.q12[1] & 4095) << 3;
  /* A neighbour beyond the last column or row has weight zero. */
  const uint32_t right = column + 1 < frame->width;
  const uint32_t below = row + 1 < frame->height ? frame->stride : 0;

  const uint8_t* pixel = frame->data + (size_t)row * frame->stride + column;
  const int32_t upper_q7 = pixel[0] * (128 - wx_q7) + pixel[right] * wx_q7;
  pixel += below;
  const int32_t lower_q7 = pixel[0] * (128 - wx_q7) + pixel[right] * wx_q7;
  const int32_t value_q7 =
      upper_q7 + (((lower_q7 - upper_q7) * wy_q15 + 0x4000) >> 15);
  return (uint8_t)((value_q7 + 64) >> 7);
}

/* Eight pixels, or fewer at the right edge: positions in equal steps. */
static void remap_segment(const remap_job* job, rg_position start,
                          rg_position step, uint32_t num_pixels, uint8_t* out) {
  for (uint32_t k = 0; k < num_pixels; ++k) {
    out[k] = is_inside(job, start) ? fetch(job->frame, start) : job->border;
    start.q12[0] += step.q12[0];
    start.q12[1] += step.q12[1];
  }
}

/* Row r of block (i, j): num_pixels of them. */
static void remap_block_row(const remap_job* job, uint32_t i, uint32_t j,
                            uint32_t r, uint32_t num_pixels, uint8_t* out) {
  rg_block_row row;
  rg_remap_block_row(job->section, i, j, r, &row);
  for (uint32_t k = 0; k < num_pixels; k += RG_SEGMENT_SIZE) {
    const uint32_t rest = num_pixels - k;
    remap_segment(job, rg_remap_segment(job->section, &row, k), row.step,
                  rest < RG_SEGMENT_SIZE ? rest : RG_SEGMENT_SIZE, out + k);
  }
}

static void fill(uint8_t* out, uint32_t num_pixels, uint8_t value) {
  /* volatile: or the compiler would turn the loop into a call of memset. */
  for (volatile uint8_t* p = out; p < out + num_pixels; ++p) *p = value;
}

/* Where the empty-block mask begins: behind the vertices. */
static const uint8_t* find_mask(const uint8_t* section) {
  const uint32_t num_vertices =
      (uint32_t)rg_load_u16(section + 4) * rg_load_u16(section + 6);
  return section + rg_load_u32(section + 76) + 4 * num_vertices;
}

static void remap_row(const remap_job* job, uint32_t y, uint8_t* out) {
  const uint32_t width = rg_load_u16(job->section);
  const uint32_t num_blocks = rg_load_u16(job->section + 4) - 1u;
  const uint32_t block_log2 = job->section[8];
  const uint32_t block_size = UINT32_C(1) << block_log2;
  const uint32_t j = y >> block_log2;
  const uint8_t* const mask = find_mask(job->section);
  for (uint32_t i = 0; i < num_blocks; ++i) {
    const uint32_t x = i << block_log2;
    const uint32_t num_pixels = width - x < block_size ? width - x : block_size;
    const uint32_t block = j * num_blocks + i;
    if ((mask[block >> 3] >> (block & 7)) & 1)
      fill(out + x, num_pixels, job->border);
    else
      remap_block_row(job, i, j, y & (block_size - 1), num_pixels, out + x);
  }
}

rg_status rg_remap_size(const rg_camera* camera, uint16_t* width,
                        uint16_t* height) {
  if (!camera->remap) return RG_ERR_NO_REMAP;
  *width = rg_load_u16(camera->remap);
  *height = rg_load_u16(camera->remap + 2);
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

  const remap_job job = {section,
                         frame,
                         rg_load_i32(section + 12),
                         rg_load_i32(section + 16),
                         rg_load_i32(section + 20),
                         rg_load_i32(section + 24),
                         band->border};
  uint8_t* out = band->data;
  for (uint32_t y = band->first_row; y < end_row; ++y, out += band->stride)
    remap_row(&job, y, out);
  return RG_OK;
}
