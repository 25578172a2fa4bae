/* A remap that is to be read, not to be fast: formats/SPEC.md, "Remap
 * arithmetic", one pixel after the other, in 64 bits. The runtime's traversals
 * and kernels are compared with it. plain_remap.c is read from its end upwards.
 */
#ifndef RAYGRID_PLAIN_REMAP_H
#define RAYGRID_PLAIN_REMAP_H

#include <stdint.h>

#include "raygrid.h"
#include "rg_blob.h"

/* A component of 8-bit samples: interleaved channels; a component pixel is 2^l
 * image pixels wide and high, and stands h half pixels right of and below the
 * first of them. NV12's chroma: {2, 1, 1}. */
typedef struct plane_lattice {
  uint32_t channels, l, h;
} plane_lattice;

/* A plane of the source image. width and height are the image's, in pixels,
 * also where the component is coarser. */
typedef struct plain_source {
  const uint8_t* data;
  uint32_t stride; /* bytes */
  uint32_t width, height;
} plain_source;

/* A plane of the target image, and the values of pixels without a source:
 * border has one for each channel. */
typedef struct plain_target {
  uint8_t* data;
  uint32_t stride; /* bytes */
  rg_border mode;
  rg_sampling sampling;
  const uint16_t* border;
} plain_target;

/* Remaps one plane by a valid table, without or with bends. Nothing is checked.
 */
void remap_plainly(const rg_remap_section* table, plane_lattice component,
                   const plain_source* source, const plain_target* target);

#endif /* RAYGRID_PLAIN_REMAP_H */
