/* The memory layout of frame planes. */
#ifndef RAYGRID_PLANES_H
#define RAYGRID_PLANES_H

#include <stdint.h>

#include "blob_checks.h"
#include "config.h"
#include "raygrid.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Whether a stride is valid for rows of row_bytes: the bytes of two rows must
 * fit 32 bits. A stride of 2^31 or more is negative here. */
static inline int rg_is_stride(uint32_t stride, uint32_t row_bytes) {
  return (int32_t)stride >= (int32_t)row_bytes;
}

/* Returns an error if a row of the frame, at one byte per pixel, overlaps a row
 * at data. If the strides differ: if it overlaps the memory between the first
 * and the last row of the other.
 *
 * size  of the image at data: bytes per row, and rows times 2^16 */
rg_status rg_check_overlap(const rg_frame* frame, const uint8_t* data,
                           uint32_t stride, uint32_t size);

/* a mod b for a / b below 2^17: not every processor can divide. */
#if RG_HAVE_DIVISION
static inline uintptr_t rg_remainder(uintptr_t a, uintptr_t b) { return a % b; }
#else
uintptr_t rg_remainder(uintptr_t a, uintptr_t b);
#endif

#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_PLANES_H */
