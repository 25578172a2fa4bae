/* Where planes of frames lie in memory. */
#ifndef RAYGRID_PLANES_H
#define RAYGRID_PLANES_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct rg_plane {
  const uint8_t* data;
  uint32_t stride, row_bytes, num_rows;
} rg_plane;

/* 1 if a byte of a row of one is a byte of a row of the other. Of planes with
 * different strides: if it lies between their first bytes and last ones. */
int rg_do_planes_overlap(const rg_plane* a, const rg_plane* b);

/* a mod b for a / b below 2^16, without division, which not every core has. */
uintptr_t rg_remainder(uintptr_t a, uintptr_t b);

#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_PLANES_H */
