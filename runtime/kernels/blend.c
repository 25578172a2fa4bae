#include "kernels/blend.h"

void rg_put_sample(uint32_t kind, uint8_t* row, uint32_t index,
                   uint32_t value) {
  rg_store_sample(kind, row, index, value);
}

uint32_t rg_mix_samples(uint32_t kind, const rg_neighbors* at, uint32_t index) {
  return rg_blend_wide(kind, at, index);
}

void rg_interleave_bytes(const rg_neighbors* at, uint32_t index, uint8_t* out,
                         uint32_t num_channels) {
  do {
    *out++ = (uint8_t)rg_interpolate_bytes(at->upper + index, at->lower + index,
                                           at->right, rg_get_q12(at, 0),
                                           rg_get_q12(at, 1));
    ++index;
  } while (--num_channels != 0);
}
