/* The kernels that define the others' bits. */
#include <stddef.h>

#include "fixed_point.h"
#include "remap_kernels.h"

/* Two neighbours, the left one in the low byte. */
static inline uint32_t load_pair(const uint8_t* p) {
  return p[0] | (uint32_t)p[1] << 8;
}

/* The pixel at a position, x + 16. */
static inline uint8_t blend_pixel(const uint8_t* data, uint32_t stride,
                                  uint32_t x_q12, uint32_t y_q12) {
  const uint8_t* upper = data + (size_t)(y_q12 >> 12) * stride;
  RG_IN_REGISTER(upper); /* else a sum more */
  upper += x_q12 >> 12;
  RG_IN_REGISTER(upper);
  const uint32_t pixels = load_pair(upper) | load_pair(upper + stride) << 16;
  return (uint8_t)rg_blend_8(rg_even_bytes(pixels), rg_odd_bytes(pixels), x_q12,
                             y_q12);
}

/* A function of its own, so that the loop has all registers. */
static RG_NOINLINE void blend_row_1(const uint8_t* data, uint32_t stride,
                                    const rg_block_row* row, uint8_t* out,
                                    uint32_t num_pixels) {
  uint8_t* const end = out + num_pixels;
  uint32_t x_q12 = (uint32_t)row->start.q12[0] + 16;
  uint32_t y_q12 = (uint32_t)row->start.q12[1];
  const uint32_t step_x = (uint32_t)row->step.q12[0];
  const uint32_t step_y = (uint32_t)row->step.q12[1];
  do {
    *out++ = blend_pixel(data, stride, x_q12, y_q12);
    x_q12 += step_x;
    y_q12 += step_y;
  } while (out != end);
}

/* One coordinate of an edge of a block, row by row: sum >> height_log2. */
typedef struct edge_walk {
  int32_t sum, height;
} edge_walk;

static inline void start_edge(edge_walk* edge, int32_t top, int32_t bottom,
                              const rg_run* run) {
  const uint32_t log2 = run->block.height_log2;
  edge->height = bottom - top;
  edge->sum =
      top * (1 << log2) + edge->height * run->first_row + (1 << log2 >> 1);
}

static inline int32_t next_row(edge_walk* edge, uint32_t log2) {
  const int32_t position = edge->sum >> log2;
  edge->sum += edge->height;
  return position;
}

void rg_blend_1(const rg_run* run) {
  const rg_position* const p = run->block.corners;
  uint8_t* out = run->out + run->out_pixel;
  edge_walk left_x, left_y, right_x, right_y;
  const int32_t first = (int32_t)run->first_source_row << 12;
  start_edge(&left_x, p[0].q12[0], p[2].q12[0], run);
  start_edge(&left_y, p[0].q12[1] - first, p[2].q12[1] - first, run);
  start_edge(&right_x, p[1].q12[0], p[3].q12[0], run);
  start_edge(&right_y, p[1].q12[1] - first, p[3].q12[1] - first, run);
  for (uint32_t rows = run->num_rows; rows != 0; --rows) {
    const uint32_t width_log2 = run->block.width_log2;
    const uint32_t height_log2 = run->block.height_log2;
    const uint32_t k = run->first_pixel;
    rg_block_row row;
    row.start.q12[0] = next_row(&left_x, height_log2);
    row.start.q12[1] = next_row(&left_y, height_log2);
    row.step.q12[0] = rg_round_shift(
        next_row(&right_x, height_log2) - row.start.q12[0], width_log2);
    row.step.q12[1] = rg_round_shift(
        next_row(&right_y, height_log2) - row.start.q12[1], width_log2);
    row.start = rg_row_position(&row, k);
    blend_row_1(run->data, run->stride, &row, out, run->num_pixels);
    out += run->out_stride;
  }
}

/* With lattice and kind known to the compiler. In locals: stores of bytes might
 * change all else for it. */
static inline void blend(const rg_run* run, const rg_lattice* lattice,
                         uint32_t kind) {
  const uint32_t step = lattice->sample_step;
  const uint32_t num_channels = lattice->num_channels;
  const uint32_t first = lattice->first_sample, stride = run->stride;
  const uint8_t* const data = run->data;
  uint8_t* out = run->out;
  for (uint32_t r = 0; r < run->num_rows; ++r, out += run->out_stride) {
    rg_block_row row;
    rg_find_run_row(run, r, &row);
    uint32_t x_q12 = (uint32_t)row.start.q12[0] + rg_rounding(kind, 0);
    uint32_t y_q12 = (uint32_t)row.start.q12[1] + rg_rounding(kind, 1);
    const uint32_t step_x = (uint32_t)row.step.q12[0];
    const uint32_t step_y = (uint32_t)row.step.q12[1];
    uint32_t target = first + run->out_pixel * step;
    for (uint32_t k = run->num_pixels; k != 0; --k, target += step) {
      const uint8_t* const upper = data + (size_t)(y_q12 >> 12) * stride;
      const uint32_t index = first + (x_q12 >> 12) * step;
      for (uint32_t c = 0; c < num_channels; ++c)
        rg_store_sample(kind, out, target + c,
                        rg_blend_samples(kind, upper, upper + stride, index + c,
                                         step, x_q12, y_q12));
      x_q12 += step_x;
      y_q12 += step_y;
    }
  }
}

void rg_blend_lattice(const rg_run* run, const rg_lattice* lattice) {
  if (lattice->kind == RG_SAMPLE_8)
    blend(run, lattice, RG_SAMPLE_8);
  else
    blend(run, lattice, lattice->kind);
}

static const rg_lattice kInterleaved[3] = {
    {0, RG_SAMPLE_8, 0, 2, 2, 0, 0, 0, 0, 0, 1, 0},
    {0, RG_SAMPLE_8, 0, 3, 3, 0, 0, 0, 0, 0, 1, 0},
    {0, RG_SAMPLE_8, 0, 4, 4, 0, 0, 0, 0, 0, 1, 0}};

void rg_blend_2(const rg_run* run) {
  blend(run, &kInterleaved[0], RG_SAMPLE_8);
}
void rg_blend_3(const rg_run* run) {
  blend(run, &kInterleaved[1], RG_SAMPLE_8);
}
void rg_blend_4(const rg_run* run) {
  blend(run, &kInterleaved[2], RG_SAMPLE_8);
}

static inline void copy(const rg_run* run, const rg_lattice* lattice,
                        uint32_t kind) {
  const uint32_t step = lattice->sample_step;
  const uint32_t num_channels = lattice->num_channels;
  const uint32_t first = lattice->first_sample, stride = run->stride;
  const uint8_t* const data = run->data;
  uint8_t* out = run->out;
  for (uint32_t r = 0; r < run->num_rows; ++r, out += run->out_stride) {
    rg_block_row row;
    rg_find_run_row(run, r, &row);
    uint32_t x_q12 = (uint32_t)row.start.q12[0] + 2048;
    uint32_t y_q12 = (uint32_t)row.start.q12[1] + 2048;
    const uint32_t step_x = (uint32_t)row.step.q12[0];
    const uint32_t step_y = (uint32_t)row.step.q12[1];
    uint32_t target = first + run->out_pixel * step;
    for (uint32_t k = run->num_pixels; k != 0; --k, target += step) {
      const uint8_t* const source = data + (size_t)(y_q12 >> 12) * stride;
      const uint32_t index = first + (x_q12 >> 12) * step;
      for (uint32_t c = 0; c < num_channels; ++c)
        rg_store_sample(kind, out, target + c,
                        rg_load_sample(kind, source, index + c));
      x_q12 += step_x;
      y_q12 += step_y;
    }
  }
}

void rg_copy_lattice(const rg_run* run, const rg_lattice* lattice) {
  static const rg_lattice kGrey = {0, RG_SAMPLE_8, 0, 1, 1, 0,
                                   0, 0,           0, 0, 1, 0};
  if (lattice->kind == RG_SAMPLE_8 && lattice->sample_step == 1)
    copy(run, &kGrey, RG_SAMPLE_8);
  else if (lattice->kind == RG_SAMPLE_8)
    copy(run, lattice, RG_SAMPLE_8);
  else
    copy(run, lattice, lattice->kind);
}
