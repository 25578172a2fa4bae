/* The kernels that define the others' bits. */
#include <stddef.h>

#include "fixed_point.h"
#include "remap_kernels.h"

/* Two neighbours, the left one in the low byte. */
static inline uint32_t load_pair(const uint8_t* p) {
  return p[0] | (uint32_t)p[1] << 8;
}

/* ---- Grey pixels --------------------------------------------------------- */

/* From one pixel of a row to the next: three ways, by what registers hold. */
#if defined(__ARM_FEATURE_SIMD32)

/* x is mirrored, 4095 - (x + 16): its fraction is the left samples' weight
 * less one. */
#define ORIGIN_X (4095 - 16)

typedef uint32_t blended;
typedef struct row_walk {
  const uint8_t* data;
  uint32_t stride;
  uint32_t x_q12, y_q12, step_x, step_y;
  uint32_t factor, one, apart; /* constants */
} row_walk;

static RG_INLINE void start_walk(const rg_run* run, const rg_block_row* row,
                                 row_walk* walk) {
  walk->data = run->data;
  walk->stride = run->stride;
  walk->x_q12 = 0u - (uint32_t)row->start.q12[0];
  walk->y_q12 = (uint32_t)row->start.q12[1];
  walk->step_x = 0u - (uint32_t)row->step.q12[0];
  walk->step_y = (uint32_t)row->step.q12[1];
  walk->factor = 65535;
  walk->one = 4096;
  walk->apart = 257;
  RG_IN_REGISTER(walk->factor);
  RG_IN_REGISTER(walk->one);
  RG_IN_REGISTER(walk->apart);
}

static RG_INLINE void step_on(row_walk* walk) {
  walk->x_q12 += walk->step_x;
  walk->y_q12 += walk->step_y;
  RG_IN_REGISTER(walk->x_q12); /* else more sums than two */
  RG_IN_REGISTER(walk->y_q12);
}

static RG_INLINE uint32_t blend_pixel(const row_walk* walk, blended rounding) {
  const uint8_t* upper = walk->data + (walk->y_q12 >> 12) * walk->stride;
  RG_IN_REGISTER(upper); /* likewise */
  upper -= (int32_t)walk->x_q12 >> 12;
  RG_IN_REGISTER(upper);
  const uint32_t pixels = load_pair(upper) | load_pair(upper + walk->stride)
                                                 << 16;
  const uint32_t right = rg_odd_bytes(pixels);
  const uint32_t difference = pixels - right * walk->apart; /* left - right */
  const uint32_t h_q7 =
      difference * ((walk->x_q12 >> 5) & 127) + (difference + (right << 7));
  const uint32_t weights = (walk->y_q12 & 4095) * walk->factor + walk->one;
  return (uint32_t)__smlad((int16x2_t)h_q7, (int16x2_t)weights,
                           (int32_t)rounding) >>
         19;
}

#elif defined(__LP64__) || defined(_WIN64)

#define ORIGIN_X (-16)

typedef uint64_t blended; /* in the upper half */
typedef struct row_walk {
  const uint8_t* data;
  uint64_t stride;
  uint64_t position, step; /* x in the upper half */
  uint64_t factor;         /* 1 - 2^32 */
} row_walk;

static RG_INLINE void start_walk(const rg_run* run, const rg_block_row* row,
                                 row_walk* walk) {
  walk->data = run->data;
  walk->stride = run->stride;
  walk->position = ((uint64_t)(uint32_t)row->start.q12[0] << 32) +
                   (uint64_t)(int64_t)row->start.q12[1];
  walk->step = ((uint64_t)(uint32_t)row->step.q12[0] << 32) +
               (uint64_t)(int64_t)row->step.q12[1];
  walk->factor = 1 - (UINT64_C(1) << 32);
  RG_IN_REGISTER(walk->factor);
}

static RG_INLINE void step_on(row_walk* walk) { walk->position += walk->step; }

/* h0 (4096 - wy) + h1 wy is the upper half of one product. */
static RG_INLINE uint64_t blend_pixel(const row_walk* walk, blended rounding) {
  const uint64_t position = walk->position, stride = walk->stride;
  const uint8_t* const upper =
      walk->data + ((position & UINT32_MAX) >> 12) * stride + (position >> 44);
  const uint64_t bytes = UINT64_C(0x000000ff000000ff);
  const uint64_t pixels = load_pair(upper) | (uint64_t)load_pair(upper + stride)
                                                 << 32;
  const uint64_t left = pixels & bytes, right = (pixels >> 8) & bytes;
  const uint64_t h_q7 = (right - left) * ((position >> 37) & 127) + (left << 7);
  const uint64_t weights =
      (position & 4095) * walk->factor + (UINT64_C(4096) << 32);
  return (h_q7 * weights + rounding) >> 51;
}

#else

#define ORIGIN_X (-16)

typedef uint32_t blended;
typedef struct row_walk {
  const uint8_t* data;
  uint32_t stride;
  uint32_t x_q12, y_q12, step_x, step_y;
} row_walk;

static RG_INLINE void start_walk(const rg_run* run, const rg_block_row* row,
                                 row_walk* walk) {
  walk->data = run->data;
  walk->stride = run->stride;
  walk->x_q12 = (uint32_t)row->start.q12[0];
  walk->y_q12 = (uint32_t)row->start.q12[1];
  walk->step_x = (uint32_t)row->step.q12[0];
  walk->step_y = (uint32_t)row->step.q12[1];
}

static RG_INLINE void step_on(row_walk* walk) {
  walk->x_q12 += walk->step_x;
  walk->y_q12 += walk->step_y;
  RG_IN_REGISTER(walk->x_q12); /* else more sums than two */
  RG_IN_REGISTER(walk->y_q12);
}

static RG_INLINE uint32_t blend_pixel(const row_walk* walk, blended rounding) {
  const uint8_t* const upper =
      walk->data + (walk->y_q12 >> 12) * walk->stride + (walk->x_q12 >> 12);
  const uint32_t pixels = load_pair(upper) | load_pair(upper + walk->stride)
                                                 << 16;
  return rg_blend_8(rg_even_bytes(pixels), rg_odd_bytes(pixels), walk->x_q12,
                    walk->y_q12, rounding);
}

#endif

/* ---- Rows ---------------------------------------------------------------- */

/* A coordinate of an edge of a block, row by row: sum >> height_log2. Two of
 * the left edge, and two of the right one with what rounds a step. */
typedef struct edge_walk {
  int32_t sum, height;
} edge_walk;

static RG_INLINE void start_edges(const rg_run* run, int32_t origin_x,
                                  edge_walk edges[4]) {
  const uint32_t log2 = run->block.height_log2;
  const int32_t half_step = INT32_C(1) << run->block.width_log2 >> 1;
  int32_t origin = origin_x;
  for (uint32_t c = 0; c < 2; ++c, ++edges) {
    for (uint32_t k = 0; k < 2; ++k) {
      const int32_t top = run->block.corners[k].q12[c];
      const int32_t height = run->block.corners[2 + k].q12[c] - top;
      edges[2 * k].height = height;
      edges[2 * k].sum =
          (top - origin + (k == 0 ? 0 : half_step)) * (1 << log2) +
          height * run->first_row + (1 << log2 >> 1);
    }
    origin = (int32_t)run->first_source_row << 12;
  }
}

static inline int32_t next_position(edge_walk* edge, uint32_t log2) {
  const int32_t sum = edge->sum;
  edge->sum = sum + edge->height;
  return sum >> log2;
}

static RG_INLINE void next_row(const rg_run* run, edge_walk edges[4],
                               rg_block_row* row) {
  for (uint32_t c = 0; c < 2; ++c) {
    const int32_t left = next_position(&edges[c], run->block.height_log2);
    const int32_t right = next_position(&edges[2 + c], run->block.height_log2);
    const int32_t step = (right - left) >> run->block.width_log2;
    row->start.q12[c] = left + step * run->first_pixel;
    row->step.q12[c] = step;
  }
}

/* Two pixels a turn; the turns that are left, 16 at most, are counted in the
 * bits above a blended pixel. */
#define ROUNDING ((blended)RG_ROUNDING_8 << (8 * sizeof(blended) - 32))
#define TURN ((blended)1 << (8 * sizeof(blended) - 5))

static RG_INLINE int has_turns(blended rounding) {
  return rounding >> (8 * sizeof(blended) - 1) != 0;
}

/* Where an odd row enters the loop at its middle. */
#define IS_SHORT (!RG_IS_FAST && !RG_KEEP_LINES)

static RG_INLINE void blend_row_1(const rg_run* run, edge_walk edges[4],
                                  uint8_t* out) {
  rg_block_row row;
  next_row(run, edges, &row);
  const uint32_t num_pixels = run->num_pixels;
  blended rounding = ROUNDING - ((num_pixels + 1) >> 1) * TURN;
  row_walk walk;
  start_walk(run, &row, &walk);
  if ((num_pixels & 1) != 0) { /* half a turn */
    if (IS_SHORT) goto second;
    *out++ = (uint8_t)blend_pixel(&walk, rounding);
    step_on(&walk);
    rounding += TURN;
    if (!has_turns(rounding)) return;
  }
  do {
    *out++ = (uint8_t)blend_pixel(&walk, rounding);
    step_on(&walk);
    RG_IN_REGISTER(out);
  second:
    *out++ = (uint8_t)blend_pixel(&walk, rounding);
    step_on(&walk);
    if (IS_SHORT) RG_IN_REGISTER(out);
    rounding += TURN;
  } while (has_turns(rounding));
}

void rg_blend_1(const rg_run* run) {
  if (rg_blend_tiles(run, 1)) return;
  uint8_t* out = run->out + run->out_pixel;
  edge_walk edges[4];
  start_edges(run, ORIGIN_X, edges);
  uint32_t rows = run->num_rows;
  do {
    uint8_t* const row = out;
    RG_IN_MEMORY(out);
    RG_IN_MEMORY(rows);
    blend_row_1(run, edges, row);
    RG_IN_MEMORY(run);
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
  edge_walk edges[4];
#if RG_IS_FAST
  /* Of its own, which no byte that is stored can be part of. Value by value:
   * some were stored just now, by themselves. */
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
  own.num_pixels = run->num_pixels;
  start_edges(run, 0, edges);
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
      next_row(run, edges, &row);
    } else {
      rg_find_block_row(&run->block, run->first_row + r, &row);
      rg_move_to_run(run, &row);
    }
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
