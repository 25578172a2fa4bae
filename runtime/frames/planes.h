/* The places of frames' planes in memory. */
#ifndef RAYGRID_PLANES_H
#define RAYGRID_PLANES_H

#include <stdint.h>

#include "blob_checks.h"
#include "config.h"
#include "raygrid.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Whether rows of row_bytes may lie a stride apart: the bytes of two rows
 * are counted in 32 bits. A stride of 2^31 or more is negative here. */
static inline int rg_is_stride(uint32_t stride, uint32_t row_bytes) {
  return (int32_t)stride >= (int32_t)row_bytes;
}

/* A fault if a byte of a row of the frame, of one byte a pixel, is one of a row
 * at data. Where the strides differ: if such a byte lies between the first and
 * the last of the other.
 *
 * size  of what is at data: bytes of a row, and rows times 2^16 */
rg_status rg_check_overlap(const rg_frame* frame, const uint8_t* data,
                           uint32_t stride, uint32_t size);

/* a mod b for a / b below 2^17: not every core has division. */
#if RG_HAVE_DIVISION
static inline uintptr_t rg_remainder(uintptr_t a, uintptr_t b) { return a % b; }
#else
uintptr_t rg_remainder(uintptr_t a, uintptr_t b);
#endif

#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_PLANES_H */
