/* Strided components, whose samples are interleaved with others: luma and
 * chroma of YUYV, the colours of a Bayer frame. Their groups of 2 or 4 bytes
 * are interpolated as pixels with as many channels into a local buffer, and the
 * component's own bytes are copied to the output. The result of the other bytes
 * is discarded, which is still several times as fast as one sample at a time.
 *
 * Two chroma samples in a group of 4 have the same position, so their
 * components have the same spans: those of the first component process both,
 * and those of the second do nothing. */
#include "kernels/kernel.h"

#if RG_SELECT_KERNELS

#include <stddef.h>

/* The groups that are interpolated at once. */
#define STRIDED_ROWS 8u
#define STRIDED_ROW_BYTES (64u * 4u)

/* Copies every second byte. */
static RG_INLINE void copy_row(const uint8_t* from, uint32_t count,
                               uint8_t* to) {
  for (uint32_t k = 0; k < 2 * count; k += 2) to[k] = from[k];
}

/* Copies the span, except for its output and its rows; value by value, since
 * the compiler would otherwise call memcpy(). */
static RG_INLINE void copy_source(const rg_span* span, rg_span* slice) {
  slice->first_pixel = span->first_pixel;
  slice->first_source_row = span->first_source_row;
  slice->num_pixels = span->num_pixels;
  slice->first_row = span->first_row;
  slice->data = span->data;
  slice->stride = span->stride;
  slice->block.width_log2 = span->block.width_log2;
  slice->block.height_log2 = span->block.height_log2;
  const int32_t* const from = span->block.corners->q12;
  int32_t* const to = slice->block.corners->q12;
  for (uint32_t k = 0; k < 8; ++k) {
    int32_t q12 = from[k];
    RG_IN_REGISTER(q12);
    to[k] = q12;
  }
}

void rg_blend_strided(const rg_kernels* kernels, const rg_span* span,
                      const rg_component* component) {
  uint8_t groups[STRIDED_ROWS * STRIDED_ROW_BYTES] __attribute__((aligned(16)));
  const uint32_t step = component->sample_step, first = component->first_sample;
  if (first >= 2) return;
  const uint32_t row_bytes = span->num_pixels * step;
  uint8_t* out = span->out + span->out_pixel * step;
  rg_span slice;
  copy_source(span, &slice);
  slice.out = groups;
  slice.out_stride = row_bytes;
  slice.out_pixel = 0;
  uint32_t left = span->num_rows;
  for (;;) {
    const uint32_t rows = left < STRIDED_ROWS ? left : STRIDED_ROWS;
    slice.num_rows = (uint16_t)rows;
    kernels->blend[step - 1](&slice);
    for (uint32_t r = 0; r < rows; ++r, out += span->out_stride)
      copy_row(groups + r * row_bytes + first, row_bytes / 2, out + first);
    left -= rows;
    if (left == 0) return;
    slice.first_row = (uint16_t)(slice.first_row + rows);
  }
}

#endif
