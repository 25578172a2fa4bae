/* What the samples of a frame are: lattices. A lattice is a regular grid of
 * samples of one kind that is remapped onto itself: the luma of NV12, its
 * chroma pairs, or one of the four colours of a Bayer frame. formats/SPEC.md,
 * "Lattices". */
#ifndef RAYGRID_PIXEL_FORMATS_H
#define RAYGRID_PIXEL_FORMATS_H

#include <stdint.h>

#include "bytes.h"
#include "raygrid.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum rg_sample_kind {
  RG_SAMPLE_8,
  RG_SAMPLE_16,  /* little-endian */
  RG_SAMPLE_10P, /* CSI-2: 4 samples in 5 bytes */
  RG_SAMPLE_12P  /* CSI-2: 2 samples in 3 bytes */
} rg_sample_kind;

typedef struct rg_lattice {
  uint8_t plane;
  uint8_t kind;         /* rg_sample_kind */
  uint8_t first_sample; /* of a row, counted in samples of the plane */
  uint8_t sample_step;  /* from one lattice pixel to the next */
  uint8_t num_channels; /* consecutive samples of a lattice pixel */
  uint8_t log2[2];      /* image pixels per lattice pixel, as a power: x, y */
  uint8_t half[2];      /* where lattice pixel (0, 0) is: half pixels */
  uint8_t first_row, row_step; /* rows of the plane */
  uint8_t first_border;        /* index of the first channel's border value */
} rg_lattice;

/* The lattices of a format; 0 for a number that is no format. */
uint32_t rg_format_lattices(rg_format format, const rg_lattice** lattices);

/* Bytes that a row of the lattice's plane takes; 0 where the width is not a
 * whole number of lattice pixels or of packed groups. */
uint32_t rg_plane_row_bytes(const rg_lattice* lattice, uint32_t width);

/* Sample number index of a row. No switch: Armv6-M compilers would call their
 * library for it. */
static inline uint32_t rg_load_sample(uint32_t kind, const uint8_t* row,
                                      uint32_t index) {
  if (kind == RG_SAMPLE_8) return row[index];
  if (kind == RG_SAMPLE_16) return rg_load_u16(row + 2 * index);
  if (kind == RG_SAMPLE_10P) {
    row += 5 * (index >> 2);
    index &= 3;
    return (uint32_t)row[index] << 2 | ((row[4] >> (2 * index)) & 3u);
  }
  row += 3 * (index >> 1);
  index &= 1;
  return (uint32_t)row[index] << 4 | ((row[2] >> (4 * index)) & 15u);
}

/* Puts bits of a value into a byte. */
static inline void rg_store_bits(uint8_t* byte, uint32_t shift, uint32_t mask,
                                 uint32_t value) {
  *byte = (uint8_t)((*byte & ~(mask << shift)) | ((value & mask) << shift));
}

static inline void rg_store_sample(uint32_t kind, uint8_t* row, uint32_t index,
                                   uint32_t value) {
  if (kind == RG_SAMPLE_8) {
    row[index] = (uint8_t)value;
  } else if (kind == RG_SAMPLE_16) {
    rg_store_u16(row + 2 * index, (uint16_t)value);
  } else if (kind == RG_SAMPLE_10P) {
    row += 5 * (index >> 2);
    index &= 3;
    row[index] = (uint8_t)(value >> 2);
    rg_store_bits(row + 4, 2 * index, 3, value);
  } else {
    row += 3 * (index >> 1);
    index &= 1;
    row[index] = (uint8_t)(value >> 4);
    rg_store_bits(row + 2, 4 * index, 15, value);
  }
}

/* The same, out of line. */
void rg_put_sample(uint32_t kind, uint8_t* row, uint32_t index, uint32_t value);

#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_PIXEL_FORMATS_H */
