/* The samples of a frame, as lattices. A lattice is a regular grid of samples
 * of one kind that is remapped onto itself: the luma of NV12, its chroma pairs,
 * or one of the four colours of a Bayer frame. formats/SPEC.md, "Components".
 */
#ifndef RAYGRID_SAMPLES_H
#define RAYGRID_SAMPLES_H

#include <stdint.h>

#include "bytes.h"

/* The packed kinds (12P, 10P) come in groups of 2^kind samples: a byte of each,
 * and one more with their low bits. */
typedef enum rg_sample_kind {
  RG_SAMPLE_8,
  RG_SAMPLE_12P, /* CSI-2: 2 samples in 3 bytes */
  RG_SAMPLE_10P, /* CSI-2: 4 samples in 5 bytes */
  RG_SAMPLE_16,  /* little-endian */
  RG_SAMPLE_565  /* of each four samples, three are the fields of a
                    little-endian word, from the high bits down; the fourth is
                    none */
} rg_sample_kind;

typedef struct rg_lattice {
  uint8_t kind; /* rg_sample_kind */
  uint8_t plane;
  uint8_t first_sample; /* of a row, counted in samples of the plane */
  uint8_t sample_step;  /* from one lattice pixel to the next */
  uint8_t num_channels; /* consecutive samples of a lattice pixel */
  uint8_t log2[2];      /* image pixels per lattice pixel, as a power: x, y */
  uint8_t half[2];      /* where lattice pixel (0, 0) is: half pixels */
  uint8_t first_row, row_step; /* rows of the plane */
  uint8_t index; /* of the format's lattices; of the first channel's border
                    value, too */
} rg_lattice;

/* The number of a lattice pixel's first sample, in its row of the plane. */
static inline uint32_t rg_first_sample(const rg_lattice* lattice,
                                       uint32_t pixel) {
  return lattice->first_sample + pixel * lattice->sample_step;
}

/* The channels of a lattice of 8 bits that fill the plane; 0 for other
 * lattices. */
static inline uint32_t rg_interleaved(const rg_lattice* lattice) {
  const uint32_t channels = lattice->num_channels;
  return lattice->kind == RG_SAMPLE_8 && lattice->sample_step == channels
             ? channels
             : 0;
}

/* Whether the lattice has one byte in each group of 2 or 4, which fill the
 * plane: luma and chroma of YUYV, a colour of a Bayer frame. */
static inline int rg_is_spread(const rg_lattice* lattice) {
  return lattice->kind == RG_SAMPLE_8 && lattice->num_channels == 1 &&
         (lattice->sample_step == 2 || lattice->sample_step == 4);
}

/* Whether the lattice is a byte a pixel, and fills the plane. */
static inline int rg_is_grey(const rg_lattice* lattice) {
  return lattice->kind == RG_SAMPLE_8 && lattice->sample_step == 1;
}

/* The lowest bit of field k in a word of RG_SAMPLE_565. */
static inline uint32_t rg_field_shift(uint32_t k) {
  return 0x05bu >> 4 * k & 15;
}

/* The bits of field k of RG_SAMPLE_565, when they are shifted down. */
static inline uint32_t rg_field_mask(uint32_t k) { return 31u | (k & 1) << 5; }

/* Sample number index of a row. */
static inline uint32_t rg_load_sample(uint32_t kind, const uint8_t* row,
                                      uint32_t index) {
  if (kind >= RG_SAMPLE_16) {
    if (kind == RG_SAMPLE_16) return rg_load_u16(row + 2 * index);
    const uint32_t word = rg_load_u16(row + 2 * (index >> 2)), k = index & 3;
    return word >> rg_field_shift(k) & rg_field_mask(k);
  }
  if (kind == RG_SAMPLE_8) return row[index];
  const uint32_t size = 1u << kind, low_bits = 8u >> kind;
  row += (size + 1) * (index >> kind);
  index &= size - 1;
  return (uint32_t)row[index] << low_bits |
         ((row[size] >> (low_bits * index)) & ((1u << low_bits) - 1));
}

/* Writes sample number index of a row, and no other bit. */
static inline void rg_store_sample(uint32_t kind, uint8_t* row, uint32_t index,
                                   uint32_t value) {
  if (kind == RG_SAMPLE_16) {
    rg_store_u16(row + 2 * index, (uint16_t)value);
  } else if (kind > RG_SAMPLE_16) {
    const uint32_t shift = rg_field_shift(index & 3);
    const uint32_t mask = rg_field_mask(index & 3);
    row += 2 * (index >> 2);
    rg_store_u16(row, (uint16_t)((rg_load_u16(row) & ~(mask << shift)) |
                                 (value & mask) << shift));
  } else if (kind == RG_SAMPLE_8) {
    row[index] = (uint8_t)value;
  } else {
    const uint32_t size = 1u << kind, low_bits = 8u >> kind;
    row += (size + 1) * (index >> kind);
    index &= size - 1;
    row[index] = (uint8_t)(value >> low_bits);
    const uint32_t mask = (1u << low_bits) - 1, shift = low_bits * index;
    row[size] =
        (uint8_t)((row[size] & ~(mask << shift)) | ((value & mask) << shift));
  }
}

#endif /* RAYGRID_SAMPLES_H */
