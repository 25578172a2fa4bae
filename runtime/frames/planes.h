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

/* Whether a stride is valid for rows of row_bytes: a stride of 2^31 or more is
 * rejected, so that two rows fit in 32 bits. */
static inline int rg_is_stride(uint32_t stride, uint32_t row_bytes) {
  return (int32_t)stride >= (int32_t)row_bytes;
}

/* Returns an error if any row of the frame (1 byte per pixel) overlaps a row of
 * the image at data; with different strides, if their address ranges overlap.
 *
 * size  image at data: bytes per row, rows in the upper half */
rg_status rg_check_overlap(const rg_grey_image* frame, const uint8_t* data,
                           uint32_t stride, uint32_t size);

/* a mod b for a / b below 2^17; not every processor has a division. */
#if RG_HAVE_DIVISION
static inline uintptr_t rg_remainder(uintptr_t a, uintptr_t b) { return a % b; }
#else
uintptr_t rg_remainder(uintptr_t a, uintptr_t b);
#endif

#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_PLANES_H */
