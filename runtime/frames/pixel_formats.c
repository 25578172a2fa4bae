#include "frames/pixel_formats.h"

/* In octal digits, one for each field behind the kind: plane; first sample,
 * step, channels; log2 of x, y; half of x, y; first row, row step. */
static const uint32_t kLattices[] = {
    00011000001,                           /* 0: one sample a pixel */
    00033000001,                           /* 1, 2: three, four interleaved */
    00044000001, 00021000001,              /* 3: YUYV */
    00141101001, 00341101001, 00121000001, /* 6: UYVY */
    00041101001, 00241101001, 00011000001, /* 9: NV12 */
    01022111101, 00011000001,              /* 11: YUV420 */
    01011111101, 02011111101, 00021110002, /* 14: Bayer */
    00121112002, 00021110212, 00121112212};

/* The sample kind and the lattices of each rg_format. */
#define FORMAT(kind, first_lattice, num_lattices) \
  ((kind) << 6 | ((num_lattices)-1) << 4 | (first_lattice))
static const uint8_t kFormats[RG_NUM_FORMATS] = {
    FORMAT(RG_SAMPLE_8, 0, 1),    FORMAT(RG_SAMPLE_16, 0, 1),
    FORMAT(RG_SAMPLE_10P, 0, 1),  FORMAT(RG_SAMPLE_12P, 0, 1),
    FORMAT(RG_SAMPLE_8, 1, 1),    FORMAT(RG_SAMPLE_8, 2, 1),
    FORMAT(RG_SAMPLE_8, 3, 3),    FORMAT(RG_SAMPLE_8, 6, 3),
    FORMAT(RG_SAMPLE_8, 9, 2),    FORMAT(RG_SAMPLE_8, 11, 3),
    FORMAT(RG_SAMPLE_8, 14, 4),   FORMAT(RG_SAMPLE_16, 14, 4),
    FORMAT(RG_SAMPLE_10P, 14, 4), FORMAT(RG_SAMPLE_12P, 14, 4)};

int rg_find_lattice(rg_format format, uint32_t index, rg_lattice* lattice) {
  if ((uint32_t)format >= RG_NUM_FORMATS) return 0;
  const uint32_t found = kFormats[format];
  if (index > (found >> 4 & 3)) return 0;
  uint32_t fields = kLattices[(found & 15) + index];
  uint8_t* const digits = (uint8_t*)lattice;
  for (uint32_t k = 10; k != 0; --k, fields >>= 3) digits[k] = fields & 7;
  lattice->kind = (uint8_t)(found >> 6);
  lattice->index = (uint8_t)index;
  return 1;
}

uint32_t rg_plane_row_bytes(const rg_lattice* lattice, uint32_t width) {
  const uint32_t log2 = lattice->log2[0], kind = lattice->kind;
  const uint32_t num_samples = (width >> log2) * lattice->sample_step;
  if ((width & ((1u << log2) - 1)) != 0) return 0;
  if (kind == RG_SAMPLE_8) return num_samples;
  if (kind == RG_SAMPLE_16) return 2 * num_samples;
  const uint32_t num_groups = num_samples >> kind;
  return num_groups << kind == num_samples ? num_samples + num_groups : 0;
}

void rg_put_sample(uint32_t kind, uint8_t* row, uint32_t index,
                   uint32_t value) {
  rg_store_sample(kind, row, index, value);
}
