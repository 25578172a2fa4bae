#include "plain_remap.h"

#include "bytes.h"

/* x, y: q12 source pixels. */
typedef struct point {
  int64_t c[2];
} point;

static int64_t rounded(int64_t value, uint32_t n) {
  return n == 0 ? value : (value + ((int64_t)1 << (n - 1))) >> n;
}

static int64_t clamp(int64_t value, int64_t low, int64_t high) {
  return value < low ? low : value > high ? high : value;
}

/* ---- Where corners come from --------------------------------------------- */

static int has_bends(const rg_remap_section* table) {
  return table->part_log2 != 0;
}

/* The residuals of vertex (i, j), two i16, and its four bends behind them. */
static const uint8_t* vertex_bytes(const rg_remap_section* table, uint32_t i,
                                   uint32_t j) {
  const uint32_t size = has_bends(table) ? 8 : 4;
  return table->vertices + size * (j * table->columns + i);
}

static point vertex(const rg_remap_section* table, uint32_t i, uint32_t j) {
  const rg_remap_section* const t = table;
  const uint8_t* const residual = vertex_bytes(table, i, j);
  const int64_t unit = (int64_t)1 << t->residual_shift;
  const point p = {
      {(int64_t)t->origin_x_q12 + (int64_t)i * t->column_step_x_q12 +
           (int64_t)j * t->row_step_x_q12 + rg_load_i16(residual) * unit,
       (int64_t)t->origin_y_q12 + (int64_t)i * t->column_step_y_q12 +
           (int64_t)j * t->row_step_y_q12 + rg_load_i16(residual + 2) * unit}};
  return p;
}

/* The bend of the edge that leads to vertex (i, j) from the left, or from
 * above, with 2^n tiles along it. */
static point bend(const rg_remap_section* table, uint32_t i, uint32_t j,
                  int from_above, uint32_t n) {
  const int8_t* const bytes =
      (const int8_t*)(vertex_bytes(table, i, j) + (from_above ? 6 : 4));
  const int64_t unit = (int64_t)1 << (table->bend_shift + table->block_log2 -
                                      n - table->part_log2);
  const point p = {{bytes[0] * unit, bytes[1] * unit}};
  return p;
}

/* Part k of 2^n of the way along a bent edge. */
static int64_t along(int64_t from, int64_t to, int64_t bend, int64_t k,
                     uint32_t n) {
  const int64_t rest = ((int64_t)1 << n) - k;
  return from + rounded((to - from + bend * rest) * k, n);
}

/* The corner common to tiles (i - 1, j - 1) and (i, j), with 2^n tiles along a
 * block's edge. Blocks without bends are their only tile. */
static point node(const rg_remap_section* table, uint32_t i, uint32_t j,
                  uint32_t n) {
  if (!has_bends(table)) return vertex(table, i, j);
  const uint32_t column = i == 0 ? 0 : (i - 1) >> n;
  const uint32_t row = j == 0 ? 0 : (j - 1) >> n;
  const uint32_t across = i - (column << n), down = j - (row << n);
  point p;
  for (int c = 0; c < 2; ++c) {
    int64_t ends[2];
    for (uint32_t k = 0; k < 2; ++k)
      ends[k] = along(vertex(table, column + k, row).c[c],
                      vertex(table, column + k, row + 1).c[c],
                      bend(table, column + k, row + 1, 1, n).c[c], down, n);
    const int64_t h =
        along(bend(table, column + 1, row, 0, n).c[c],
              bend(table, column + 1, row + 1, 0, n).c[c], 0, down, n);
    p.c[c] = along(ends[0], ends[1], h, across, n);
  }
  return p;
}

/* ---- From corners to a pixel's position ---------------------------------- */

/* log2 of a tile's size in output pixels. */
static uint32_t part_log2(const rg_remap_section* table,
                          plane_lattice component) {
  if (!has_bends(table)) return table->block_log2;
  return component.h == 1 && table->part_log2 == 3 ? 4 : table->part_log2;
}

/* Corner k of tile (i, j), in pixels of the component: k is 0 at the top left,
 * 1 at the top right, 2 and 3 below. */
static point corner(const rg_remap_section* table, plane_lattice component,
                    uint32_t i, uint32_t j, uint32_t k) {
  const uint32_t log2 = part_log2(table, component),
                 n = table->block_log2 - log2;
  const uint32_t x = i + (k & 1), y = j + (k >> 1);
  const point here = node(table, x, y, n);
  const point left = node(table, i, y, n), right = node(table, i + 1, y, n);
  const point top = node(table, x, j, n), bottom = node(table, x, j + 1, n);
  point q;
  for (int c = 0; c < 2; ++c) {
    const int64_t half_pixels = (right.c[c] - left.c[c]) * component.h +
                                (bottom.c[c] - top.c[c]) * component.h;
    q.c[c] = rounded(here.c[c] + rounded(half_pixels, log2 + 1) -
                         2048 * (int64_t)component.h,
                     component.l);
  }
  return q;
}

/* The source position of pixel (x, y) of a part of 2^log2 component pixels with
 * these corners. */
static point position(const point* q, uint32_t x, uint32_t y, uint32_t log2) {
  point p;
  for (int c = 0; c < 2; ++c) {
    const int64_t left = q[0].c[c] + rounded((q[2].c[c] - q[0].c[c]) * y, log2);
    const int64_t right =
        q[1].c[c] + rounded((q[3].c[c] - q[1].c[c]) * y, log2);
    p.c[c] = left + x * rounded(right - left, log2);
  }
  return p;
}

/* ---- From a position to a value ------------------------------------------ */

/* The positions that have a source, and the component's last pixel. */
typedef struct limits {
  int64_t min[2], max[2], last[2];
} limits;

static limits find_limits(const rg_remap_section* table,
                          plane_lattice component, const plain_source* source) {
  const int64_t half = 2048 * (int64_t)component.h;
  const limits found = {{rounded(table->min_x_q12 - half, component.l),
                         rounded(table->min_y_q12 - half, component.l)},
                        {(table->max_x_q12 - half) >> component.l,
                         (table->max_y_q12 - half) >> component.l},
                        {(source->width >> component.l) - 1,
                         (source->height >> component.l) - 1}};
  return found;
}

static int is_within(const limits* within, point p) {
  return p.c[0] >= within->min[0] && p.c[0] <= within->max[0] &&
         p.c[1] >= within->min[1] && p.c[1] <= within->max[1];
}

static point clamp_position(const limits* within, point p,
                            rg_sampling sampling) {
  for (int c = 0; c < 2; ++c) {
    p.c[c] = clamp(p.c[c], within->min[c], within->max[c]);
    p.c[c] = clamp(p.c[c], 0, within->last[c] * 4096);
    if (sampling == RG_SAMPLING_NEAREST) p.c[c] = (p.c[c] + 2048) / 4096 * 4096;
  }
  return p;
}

/* Blends four neighbours. Those beyond the last column or row are not read. */
static void blend(const plain_source* source, uint32_t channels,
                  const limits* within, point p, uint8_t* pixel) {
  const int64_t column = (p.c[0] + 16) >> 12, row = p.c[1] >> 12;
  const int64_t wx = ((p.c[0] + 16) >> 5) & 127, wy = p.c[1] & 4095;
  const int64_t right = column < within->last[0] ? channels : 0;
  const int64_t below = row < within->last[1] ? source->stride : 0;
  for (uint32_t c = 0; c < channels; ++c) {
    const uint8_t* const i =
        source->data + row * source->stride + column * channels + c;
    const int64_t h0 = i[0] * (128 - wx) + i[right] * wx;
    const int64_t h1 = i[below] * (128 - wx) + i[below + right] * wx;
    const int64_t v = h0 - (((h0 - h1) * wy * 8 + 16384) >> 15);
    pixel[c] = (uint8_t)((v + 64) >> 7);
  }
}

/* ---- The plane ----------------------------------------------------------- */

static int is_empty(const rg_remap_section* table, plane_lattice component,
                    uint32_t x, uint32_t y) {
  const uint32_t log2 = table->block_log2 - component.l;
  const uint32_t block = (y >> log2) * (table->columns - 1u) + (x >> log2);
  return (table->empty_blocks[block / 8] >> block % 8) & 1;
}

void remap_plainly(const rg_remap_section* table, plane_lattice component,
                   const plain_source* source, const plain_target* target) {
  const uint32_t n = component.channels;
  const limits within = find_limits(table, component, source);
  const uint32_t part = part_log2(table, component) - component.l;
  const uint32_t mask = (1u << part) - 1;
  point corners[4];
  for (uint32_t y = 0; y < (uint32_t)table->height >> component.l; ++y) {
    for (uint32_t x = 0; x < (uint32_t)table->width >> component.l; ++x) {
      uint8_t* const pixel = target->data + y * target->stride + n * x;
      for (uint32_t k = 0; k < 4 && (x & mask) == 0; ++k)
        corners[k] = corner(table, component, x >> part, y >> part, k);
      const point p = position(corners, x & mask, y & mask, part);
      const int has_source =
          !is_empty(table, component, x, y) && is_within(&within, p);
      if (has_source || target->mode == RG_BORDER_CLAMP)
        blend(source, n, &within, clamp_position(&within, p, target->sampling),
              pixel);
      else if (target->mode == RG_BORDER_VALUE)
        for (uint32_t c = 0; c < n; ++c) pixel[c] = (uint8_t)target->border[c];
    }
  }
}
