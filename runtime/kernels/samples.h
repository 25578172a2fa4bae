/* The samples of a frame, grouped into components. A component is a
 * regular grid of samples of one kind that is remapped onto itself: the luma of
 * NV12, its chroma pairs, or one of the four colours of a Bayer frame.
 * formats/SPEC.md, "Components". */
#ifndef RAYGRID_SAMPLES_H
#define RAYGRID_SAMPLES_H

#include <stdint.h>

#include "bytes.h"

/* Packed kinds (12P, 10P) have groups of 2^kind samples: the high byte of each,
 * and one byte with the low bits of all. */
typedef enum rg_sample_kind {
  RG_SAMPLE_8,
  RG_SAMPLE_12P, /* CSI-2: 2 samples in 3 bytes */
  RG_SAMPLE_10P, /* CSI-2: 4 samples in 5 bytes */
  RG_SAMPLE_16,  /* little-endian */
  RG_SAMPLE_565  /* three of each four samples are the fields of a
                    little-endian word, from the high bits down; the fourth is
                    unused */
} rg_sample_kind;

typedef struct rg_component {
  uint8_t kind; /* rg_sample_kind */
  uint8_t plane;
  uint8_t first_sample; /* in a row, in samples of the plane */
  uint8_t sample_step;  /* from one component pixel to the next */
  uint8_t num_channels; /* consecutive samples of a component pixel */
  uint8_t log2[2];      /* image pixels per component pixel, log2: x, y */
  uint8_t half[2];      /* position of component pixel (0, 0), half pixels */
  uint8_t first_row, row_step; /* rows of the plane */
  uint8_t index; /* index of the component in the format, and of its first
                    channel's border value */
} rg_component;

/* Returns the index of a component pixel's first sample in its plane row. */
static inline uint32_t rg_first_sample(const rg_component* component,
                                       uint32_t pixel) {
  return component->first_sample + pixel * component->sample_step;
}

/* Returns the number of channels of an 8-bit component that fills the plane; 0
 * for other components. */
static inline uint32_t rg_interleaved(const rg_component* component) {
  const uint32_t channels = component->num_channels;
  return component->kind == RG_SAMPLE_8 && component->sample_step == channels
             ? channels
             : 0;
}

/* Whether the component is strided: one byte in each group of 2 or 4, such as
 * luma and chroma of YUYV, or a colour of a Bayer frame. */
static inline int rg_is_strided(const rg_component* component) {
  return component->kind == RG_SAMPLE_8 && component->num_channels == 1 &&
         (component->sample_step == 2 || component->sample_step == 4);
}

/* Whether the component has one byte per pixel, and fills the plane. */
static inline int rg_is_grey(const rg_component* component) {
  return component->kind == RG_SAMPLE_8 && component->sample_step == 1;
}

/* Returns the lowest bit of field k in a word of RG_SAMPLE_565. */
static inline uint32_t rg_field_shift(uint32_t k) {
  return 0x05bu >> 4 * k & 15;
}

/* Returns the mask of field k of RG_SAMPLE_565, shifted down. */
static inline uint32_t rg_field_mask(uint32_t k) { return 31u | (k & 1) << 5; }

/* Loads sample `index` of a row. */
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

/* Stores sample `index` of a row, and changes no other bit. */
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
