/* The reference kernels, with which all others agree bit for bit. */
#include <stddef.h>

#include "fixed_point.h"
#include "kernels/blend.h"
#include "kernels/grey_row.h"
#include "kernels/kernel.h"
#include "kernels/segments.h"
#include "kernels/tiles.h"

void rg_blend_1(const rg_span* span) {
  if (RG_HAS_TILES && rg_blend_tiles(span, 1)) return;
  uint8_t* out = span->out + span->out_pixel;
  rg_edges edges;
  rg_start_edges(span, span->block.corners->q12, edges);
  uint32_t rows = span->num_rows;
  do {
    rg_block_row row;
    rg_next_row(&span->block, edges, &row);
    rg_move_to_span(span, &row);
    rg_blend_grey_row(span, &row, out);
    out += span->out_stride;
  } while (--rows != 0);
}

/* ---- Words of RGB565 ----------------------------------------------------- */

/* Separates the fields of a word, with 16 more bits each: green at bit 0, blue
 * at bit 22, red at bit 43. Each sum of 4 samples, with weights whose sum is
 * 2^16, fits: 63 2^16 + 2^15 is below 2^22, 31 2^16 + 2^15 below 2^21. */
static RG_INLINE uint64_t stride_fields(uint32_t word) {
  return (word >> 5 & 63) | (uint64_t)(word & 31) << 22 |
         (uint64_t)(word >> 11) << 43;
}

static RG_INLINE uint32_t join_fields(uint64_t sums_q16) {
  return (uint32_t)(sums_q16 >> 59) << 11 |
         ((uint32_t)(sums_q16 >> 16) & 63) << 5 |
         ((uint32_t)(sums_q16 >> 38) & 31);
}

/* Interpolates two adjacent words with 8-bit weights. */
static RG_INLINE uint64_t blend_words_across(const uint8_t* words,
                                             uint32_t wx_q8) {
  return stride_fields(rg_load_u16(words)) * (256 - wx_q8) +
         stride_fields(rg_load_u16(words + 2)) * wx_q8;
}

/* rg_blend_samples() for all fields of a pixel, or a copy of its word. */
static RG_INLINE void process_word(const rg_neighbors* at, int is_copy,
                                   uint8_t* out) {
  const uint64_t rounding =
      0x8000u | UINT64_C(0x8000) << 22 | UINT64_C(0x8000) << 43;
  const uint32_t first = 2 * (rg_get_q12(at, 0) >> 12);
  if (is_copy) {
    rg_store_u16(out, rg_load_u16(at->upper + first));
    return;
  }
  const uint32_t wx_q8 = rg_get_q12(at, 0) >> 4 & 255;
  const uint32_t wy_q8 = rg_get_q12(at, 1) >> 4 & 255;
  const uint64_t sums_q16 =
      blend_words_across(at->upper + first, wx_q8) * (256 - wy_q8) +
      blend_words_across(at->lower + first, wx_q8) * wy_q8 + rounding;
  rg_store_u16(out, (uint16_t)join_fields(sums_q16));
}

/* ---- Any component ------------------------------------------------------- */

/* Specialized by the compiler for the component. is_copy: all neighbours are
 * the same pixel. */
static RG_INLINE void process_pixel(const rg_component* component,
                                    uint32_t kind, uint32_t num_channels,
                                    const rg_neighbors* at, int is_copy,
                                    uint8_t* row, uint32_t out_pixel) {
  if (RG_BLENDS_WORDS && kind == RG_SAMPLE_565) {
    process_word(at, is_copy, row + 2 * (size_t)out_pixel);
    return;
  }
  uint32_t index = rg_first_sample(component, rg_get_q12(at, 0) >> 12);
  uint32_t target = rg_first_sample(component, out_pixel);
  for (uint32_t c = 0; c < num_channels; ++c, ++index, ++target)
    rg_store_sample(kind, row, target,
                    is_copy ? rg_load_sample(kind, at->upper, index)
                            : rg_blend_samples(kind, at, index));
}

/* Copies the span to a local variable, which stores to the output cannot alias.
 * It is copied value by value, since some values have just been stored
 * separately. The corners are not copied. */
static RG_INLINE void copy_span(const rg_span* span, rg_span* own) {
  own->data = span->data;
  own->stride = span->stride;
  own->out_stride = span->out_stride;
  own->out = span->out;
  own->block.width_log2 = span->block.width_log2;
  own->block.height_log2 = span->block.height_log2;
  own->out_pixel = span->out_pixel;
  own->num_rows = span->num_rows;
  own->first_pixel = span->first_pixel;
  own->first_source_row = span->first_source_row;
  own->num_pixels = span->num_pixels;
}

/* Processes the rows of a span, specialized by the compiler for kind, channels
 * and is_copy (the nearest pixel is copied). */
static RG_INLINE void process_rows(const rg_span* span,
                                   const rg_component* component, uint32_t kind,
                                   uint32_t num_channels, int is_copy) {
  rg_edges edges;
  rg_span own;
  copy_span(span, &own);
  rg_start_edges(span, span->block.corners->q12, edges);
  const uint32_t below = is_copy ? 0 : own.stride;
  rg_neighbors at;
  at.right = is_copy ? 0 : component->sample_step;
  uint8_t* out = own.out;
  for (uint32_t r = own.num_rows; r != 0; --r, out += own.out_stride) {
    rg_block_row row;
    rg_next_row(&own.block, edges, &row);
    rg_move_to_span(&own, &row);
    rg_round_row(kind, is_copy, &row);
    at.position = rg_row_position(&row, 0);
    for (uint32_t k = 0; k < own.num_pixels; ++k) {
      at.upper = own.data + (size_t)(rg_get_q12(&at, 1) >> 12) * own.stride;
      at.lower = at.upper + below;
      process_pixel(component, kind, num_channels, &at, is_copy, out,
                    own.out_pixel + k);
      rg_advance_position(&row.step, &at.position);
    }
  }
}

/* Processes the rows of a span of any component with little code and stack.
 * right: the distance in samples from a pixel to its right neighbour, or 0 if
 * pixels are copied. */
static void process_rows_compactly(const rg_span* span,
                                   const rg_component* component,
                                   uint32_t right) {
  rg_neighbors at;
  rg_block_row row;
  uint32_t r = 0;
  at.out = span->out;
  at.right = right;
  do {
    RG_FORGET(span); /* otherwise its block's address uses another register */
    rg_compute_block_row(&span->block, span->first_row + r, &row);
    rg_move_to_span(span, &row);
    rg_round_row(component->kind, at.right == 0, &row);
    uint32_t pixel = 0;
    do {
      at.position = rg_row_position(&row, pixel);
      at.upper = span->data + (size_t)(rg_get_q12(&at, 1) >> 12) * span->stride;
      at.lower = at.upper;
      if (at.right != 0) at.lower += span->stride;
      rg_blend_pixel(component, &at, span->out_pixel + pixel);
    } while (++pixel != span->num_pixels);
    at.out += span->out_stride;
  } while (++r != span->num_rows);
}

/* Processes all fields of RGB565 together with the first one. The fields have
 * the same spans, so the others are skipped. */
static RG_INLINE void process_first_field(const rg_span* span,
                                          const rg_component* component,
                                          int is_copy) {
  if (component->first_sample == 0)
    process_rows(span, component, RG_SAMPLE_565, 1, is_copy);
}

/* Processes a span, specialized by the compiler for component and sampling if
 * optimized for speed. */
static RG_INLINE void process_component(const rg_span* span,
                                        const rg_component* component,
                                        int is_copy) {
  if (!RG_IS_FAST)
    process_rows_compactly(span, component,
                           is_copy ? 0 : component->sample_step);
  else if (component->kind == RG_SAMPLE_8)
    process_rows(span, component, RG_SAMPLE_8, component->num_channels,
                 is_copy);
  else if (RG_BLENDS_WORDS && component->kind == RG_SAMPLE_565)
    process_first_field(span, component, is_copy);
  else
    process_rows(span, component, component->kind, 1, is_copy);
}

static const rg_component kInterleaved[4] = {
    {RG_SAMPLE_8, 0, 0, 1, 1, {0, 0}, {0, 0}, 0, 1, 0},
    {RG_SAMPLE_8, 0, 0, 2, 2, {0, 0}, {0, 0}, 0, 1, 0},
    {RG_SAMPLE_8, 0, 0, 3, 3, {0, 0}, {0, 0}, 0, 1, 0},
    {RG_SAMPLE_8, 0, 0, 4, 4, {0, 0}, {0, 0}, 0, 1, 0}};

void rg_blend_component(const rg_span* span, const rg_component* component) {
  process_component(span, component, 0);
}

void rg_blend_2(const rg_span* span) {
  if (!RG_HAS_TILES || !rg_blend_tiles(span, 2))
    process_component(span, &kInterleaved[1], 0);
}

void rg_blend_3(const rg_span* span) {
  if (!RG_HAS_TILES || !rg_blend_tiles(span, 3))
    process_component(span, &kInterleaved[2], 0);
}

void rg_blend_4(const rg_span* span) {
  if (!RG_HAS_TILES || !rg_blend_tiles(span, 4))
    process_component(span, &kInterleaved[3], 0);
}

void rg_copy_component(const rg_span* span, const rg_component* component) {
  if (RG_IS_FAST && component->kind == RG_SAMPLE_8 &&
      component->sample_step == 1) {
    if (!RG_HAS_TILES || !rg_copy_tiles(span))
      process_component(span, &kInterleaved[0], 1);
  } else {
    process_component(span, component, 1);
  }
}
