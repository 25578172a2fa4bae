#include "frames/planes.h"

#if !RG_HAVE_DIVISION
uintptr_t rg_remainder(uintptr_t a, uintptr_t b) {
  for (int shift = 16; shift >= 0; --shift)
    if (a >> shift >= b) a -= b << shift;
  return a;
}
#endif

static uintptr_t address_of(const uint8_t* data) { return (uintptr_t)data; }

/* Two intervals overlap if the end of one is less than the sum of lengths,
 * minus 1, after the start of the other; this may wrap. First, the interval
 * is all bytes from the first to the last row, then, modulo the stride, one
 * row. */
rg_status rg_check_overlap(const rg_grey_image* frame, const uint8_t* data,
                           uint32_t stride, uint32_t size) {
  const uint32_t row_bytes = size & 0xffff, num_rows = size >> 16;
  if (num_rows == 0) return RG_OK;
  const uintptr_t length = (uintptr_t)frame->width + row_bytes - 1;
  const uintptr_t to_last = (uintptr_t)(num_rows - 1u) * stride + row_bytes - 1;
  const uintptr_t distance =
      address_of(data) - address_of(frame->data) + to_last;
  const uintptr_t lengths =
      (uintptr_t)(frame->height - 1u) * frame->stride + frame->width + to_last;
  rg_status status = RG_ERR_OVERLAP;
  if (distance >= lengths) status = RG_OK;
  /* Rows may be side by side. (For separate planes, the remainder is
   * irrelevant.) */
  if (frame->stride == stride && rg_remainder(distance, stride) >= length)
    status = RG_OK;
  return status;
}
