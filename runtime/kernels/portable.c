/* The kernels that define the others' bits. */
#include <stddef.h>

#include "fixed_point.h"
#include "kernels/grey_row.h"
#include "kernels/remap_kernels.h"

void rg_blend_1(const rg_run* run) {
  if (rg_blend_tiles(run, 1)) return;
  uint8_t* out = run->out + run->out_pixel;
  rg_edges edges;
  rg_start_edges(run, run->block.corners->q12, edges);
  uint32_t rows = run->num_rows;
  const rg_blended rounding = rg_rounding_of(run->num_pixels);
  do {
    rg_block_row row;
    rg_next_row(&run->block, edges, &row);
    rg_move_to_run(run, &row);
    rg_blend_grey_row(run, &row, rounding, out);
    out += run->out_stride;
  } while (--rows != 0);
}

/* ---- Any lattice ----------------------------------------------------------
 */

uint32_t rg_mix_samples(uint32_t kind, const rg_neighbors* at, uint32_t index) {
  return rg_blend_wide(kind, at, index);
}

void rg_mix_bytes(const rg_neighbors* at, uint32_t index, uint8_t* out,
                  uint32_t num_channels) {
  do {
    *out++ = (uint8_t)rg_blend_bytes(at->upper + index, at->lower + index,
                                     at->right, at->x_q12, at->y_q12);
    ++index;
  } while (--num_channels != 0);
}

/* With all that the compiler knows of the lattice. is_copy: all neighbours are
 * the same one. */
static RG_INLINE void do_pixel(const rg_lattice* lattice, uint32_t kind,
                               uint32_t num_channels, const rg_neighbors* at,
                               int is_copy, uint8_t* row, uint32_t out_pixel) {
  uint32_t index = rg_first_sample(lattice, at->x_q12 >> 12);
  uint32_t target = rg_first_sample(lattice, out_pixel);
  for (uint32_t c = 0; c < num_channels; ++c, ++index, ++target)
    rg_store_sample(kind, row, target,
                    is_copy ? rg_load_sample(kind, at->upper, index)
                            : rg_blend_samples(kind, at, index));
}

static RG_INLINE void do_rows(const rg_run* run, const rg_lattice* lattice,
                              uint32_t kind, uint32_t num_channels,
                              int is_copy) {
  rg_edges edges;
#if RG_IS_FAST
  /* A copy of the run, which no byte that is stored can be part of. It is made
   * value by value, as some were stored just now, by themselves. */
  rg_run own;
  own.data = run->data;
  own.stride = run->stride;
  own.out_stride = run->out_stride;
  own.out = run->out;
  own.block.width_log2 = run->block.width_log2;
  own.block.height_log2 = run->block.height_log2;
  own.out_pixel = run->out_pixel;
  own.num_rows = run->num_rows;
  own.first_pixel = run->first_pixel;
  own.first_source_row = run->first_source_row;
  own.num_pixels = run->num_pixels;
  rg_start_edges(run, run->block.corners->q12, edges);
  run = &own;
#else
  (void)edges;
#endif
  const uint32_t below = is_copy ? 0 : run->stride;
  rg_neighbors at;
  at.right = is_copy ? 0 : lattice->sample_step;
  uint8_t* out = run->out;
  uint32_t r = 0;
  do {
    rg_block_row row;
    if (RG_IS_FAST) {
      rg_next_row(&run->block, edges, &row);
    } else {
      rg_find_block_row(&run->block, run->first_row + r, &row);
    }
    rg_move_to_run(run, &row);
    if (!RG_IS_FAST)
      kind = lattice->kind; /* read late: that takes less stack */
    at.x_q12 =
        (uint32_t)row.start.q12[0] + (is_copy ? 2048 : rg_rounding(kind, 0));
    at.y_q12 =
        (uint32_t)row.start.q12[1] + (is_copy ? 2048 : rg_rounding(kind, 1));
    for (uint32_t k = 0; k < run->num_pixels; ++k) {
      at.upper = run->data + (size_t)(at.y_q12 >> 12) * run->stride;
      at.lower = at.upper + below;
      if (RG_IS_FAST)
        do_pixel(lattice, kind, num_channels, &at, is_copy, out,
                 run->out_pixel + k);
      else
        rg_blend_pixel(lattice, &at, out, run->out_pixel + k);
      at.x_q12 += (uint32_t)row.step.q12[0];
      at.y_q12 += (uint32_t)row.step.q12[1];
    }
    out += run->out_stride;
  } while (++r != run->num_rows);
}

/* With lattice and sampling known to the compiler, where speed matters. */
static RG_SHARED void do_lattice(const rg_run* run, const rg_lattice* lattice,
                                 int is_copy) {
  if (!RG_IS_FAST)
    do_rows(run, lattice, lattice->kind, lattice->num_channels, is_copy);
  else if (lattice->kind == RG_SAMPLE_8)
    do_rows(run, lattice, RG_SAMPLE_8, lattice->num_channels, is_copy);
  else
    do_rows(run, lattice, lattice->kind, 1, is_copy);
}

static const rg_lattice kInterleaved[4] = {
    {RG_SAMPLE_8, 0, 0, 1, 1, {0, 0}, {0, 0}, 0, 1, 0},
    {RG_SAMPLE_8, 0, 0, 2, 2, {0, 0}, {0, 0}, 0, 1, 0},
    {RG_SAMPLE_8, 0, 0, 3, 3, {0, 0}, {0, 0}, 0, 1, 0},
    {RG_SAMPLE_8, 0, 0, 4, 4, {0, 0}, {0, 0}, 0, 1, 0}};

void rg_blend_lattice(const rg_run* run, const rg_lattice* lattice) {
  do_lattice(run, lattice, 0);
}

void rg_blend_2(const rg_run* run) {
  if (!rg_blend_tiles(run, 2)) do_lattice(run, &kInterleaved[1], 0);
}

void rg_blend_3(const rg_run* run) {
  if (!rg_blend_tiles(run, 3)) do_lattice(run, &kInterleaved[2], 0);
}

void rg_blend_4(const rg_run* run) {
  if (!rg_blend_tiles(run, 4)) do_lattice(run, &kInterleaved[3], 0);
}

void rg_copy_lattice(const rg_run* run, const rg_lattice* lattice) {
  if (RG_IS_FAST && lattice->kind == RG_SAMPLE_8 && lattice->sample_step == 1) {
    if (!rg_copy_tiles(run)) do_lattice(run, &kInterleaved[0], 1);
  } else {
    do_lattice(run, lattice, 1);
  }
}
