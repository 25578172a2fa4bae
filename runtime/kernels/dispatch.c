/* Selects the kernels that the processor supports. */
#include "kernel_name.h"
#include "kernels/kernel.h"
#include "x86_features.h"

#if RG_SELECT_KERNELS

static const rg_kernels kPortable = {
    "portable",
    {rg_blend_1, rg_blend_2, rg_blend_3, rg_blend_4},
    {0, 0, 0, 0},
    RG_HAS_TILES ? RG_HAS_VECTORS : 0};

#define RG_NO_PARTS(name) \
  { 0, 0, 0, 0 }
#define RG_PARTS(name)                                         \
  {                                                            \
    rg_blend_tile_row_1_##name, rg_blend_tile_row_2_##name,    \
        rg_blend_tile_row_3_##name, rg_blend_tile_row_4_##name \
  }
#define RG_KERNEL(name, parts, abilities, spans)                              \
  static const rg_kernels k_##name = {#name,                                  \
                                      {rg_blend_1_##name, rg_blend_2_##name,  \
                                       rg_blend_3_##name, rg_blend_4_##name}, \
                                      parts(name),                            \
                                      abilities};
RG_KERNELS
#undef RG_KERNEL

const rg_kernels* rg_find_kernels(const char* name) {
#define RG_KERNEL(kernel, parts, abilities, spans)             \
  if ((!name || rg_is_name(name, k_##kernel.name)) && (spans)) \
    return &k_##kernel;
  RG_KERNELS
#undef RG_KERNEL
  return !name || rg_is_name(name, kPortable.name) ? &kPortable : 0;
}

#else

const rg_kernels* rg_find_kernels(const char* name) {
  (void)name;
  return 0;
}

#endif
