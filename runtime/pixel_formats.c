#include "pixel_formats.h"

/* plane, kind, first sample, sample step, channels, log2 x y, half x y, first
 * row, row step, first border */
static const rg_lattice kLattices[] = {
    /* 0: one sample a pixel */
    {0, RG_SAMPLE_8, 0, 1, 1, {0, 0}, {0, 0}, 0, 1, 0},
    {0, RG_SAMPLE_16, 0, 1, 1, {0, 0}, {0, 0}, 0, 1, 0},
    {0, RG_SAMPLE_10P, 0, 1, 1, {0, 0}, {0, 0}, 0, 1, 0},
    {0, RG_SAMPLE_12P, 0, 1, 1, {0, 0}, {0, 0}, 0, 1, 0},
    /* 4: three, four interleaved */
    {0, RG_SAMPLE_8, 0, 3, 3, {0, 0}, {0, 0}, 0, 1, 0},
    {0, RG_SAMPLE_8, 0, 4, 4, {0, 0}, {0, 0}, 0, 1, 0},
    /* 6: YUYV */
    {0, RG_SAMPLE_8, 0, 2, 1, {0, 0}, {0, 0}, 0, 1, 0},
    {0, RG_SAMPLE_8, 1, 4, 1, {1, 0}, {1, 0}, 0, 1, 1},
    {0, RG_SAMPLE_8, 3, 4, 1, {1, 0}, {1, 0}, 0, 1, 2},
    /* 9: UYVY */
    {0, RG_SAMPLE_8, 1, 2, 1, {0, 0}, {0, 0}, 0, 1, 0},
    {0, RG_SAMPLE_8, 0, 4, 1, {1, 0}, {1, 0}, 0, 1, 1},
    {0, RG_SAMPLE_8, 2, 4, 1, {1, 0}, {1, 0}, 0, 1, 2},
    /* 12: NV12 */
    {0, RG_SAMPLE_8, 0, 1, 1, {0, 0}, {0, 0}, 0, 1, 0},
    {1, RG_SAMPLE_8, 0, 2, 2, {1, 1}, {1, 1}, 0, 1, 1},
    /* 14: YUV420 */
    {0, RG_SAMPLE_8, 0, 1, 1, {0, 0}, {0, 0}, 0, 1, 0},
    {1, RG_SAMPLE_8, 0, 1, 1, {1, 1}, {1, 1}, 0, 1, 1},
    {2, RG_SAMPLE_8, 0, 1, 1, {1, 1}, {1, 1}, 0, 1, 2},
#define BAYER(kind)                                  \
  {0, kind, 0, 2, 1, {1, 1}, {0, 0}, 0, 2, 0},       \
      {0, kind, 1, 2, 1, {1, 1}, {2, 0}, 0, 2, 1},   \
      {0, kind, 0, 2, 1, {1, 1}, {0, 2}, 1, 2, 2}, { \
    0, kind, 1, 2, 1, {1, 1}, {2, 2}, 1, 2, 3        \
  }
    /* 17: Bayer */
    BAYER(RG_SAMPLE_8),
    BAYER(RG_SAMPLE_16),
    BAYER(RG_SAMPLE_10P),
    BAYER(RG_SAMPLE_12P)};

/* Of each rg_format. */
static const uint8_t kFirstLattice[RG_NUM_FORMATS + 1] = {
    0, 1, 2, 3, 4, 5, 6, 9, 12, 14, 17, 21, 25, 29, 33};

uint32_t rg_format_lattices(rg_format format, const rg_lattice** lattices) {
  if ((uint32_t)format >= RG_NUM_FORMATS) return 0;
  const uint32_t first = kFirstLattice[format];
  *lattices = &kLattices[first];
  return kFirstLattice[format + 1] - first;
}

uint32_t rg_plane_row_bytes(const rg_lattice* lattice, uint32_t width) {
  const uint32_t num_samples =
      (width >> lattice->log2[0]) * lattice->sample_step;
  if ((width & ((1u << lattice->log2[0]) - 1)) != 0) return 0;
  if (lattice->kind == RG_SAMPLE_8) return num_samples;
  if (lattice->kind == RG_SAMPLE_16) return 2 * num_samples;
  if (lattice->kind == RG_SAMPLE_10P)
    return num_samples % 4 != 0 ? 0 : num_samples / 4 * 5;
  return num_samples % 2 != 0 ? 0 : num_samples / 2 * 3;
}

void rg_put_sample(uint32_t kind, uint8_t* row, uint32_t index,
                   uint32_t value) {
  rg_store_sample(kind, row, index, value);
}
