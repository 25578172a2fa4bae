/* The kernels by instruction set, the fastest first, and the list for each
 * target. Declarations, the selection at run time, tests, fuzz targets and
 * benchmarks are generated from these lists; users define the macro that a list
 * calls. */
#ifndef RAYGRID_KERNEL_LIST_H
#define RAYGRID_KERNEL_LIST_H

#include "config.h"

/* RG_KERNEL(name, kernels of several tiles: RG_PARTS or RG_NO_PARTS, abilities,
 * expression: whether this processor supports it) */
/* clang-format off */
#define RG_X86_KERNELS \
  RG_KERNEL(avx512, RG_PARTS, RG_HAS_VECTORS | RG_HAS_WORDS, rg_has_avx512()) \
  RG_KERNEL(avx2, RG_NO_PARTS, RG_HAS_VECTORS | RG_HAS_WORDS, rg_has_avx2()) \
  RG_KERNEL(sse4, RG_NO_PARTS, RG_HAS_VECTORS, rg_has_sse4())
#define RG_NEON_KERNELS RG_KERNEL(neon, RG_NO_PARTS, RG_HAS_VECTORS, 1)
#define RG_RVV_KERNELS RG_KERNEL(rvv, RG_NO_PARTS, RG_HAS_VECTORS, 1)
#define RG_HELIUM_KERNELS RG_KERNEL(helium, RG_NO_PARTS, RG_HAS_VECTORS, 1)

#define RG_ALL_KERNELS \
  RG_X86_KERNELS RG_NEON_KERNELS RG_RVV_KERNELS RG_HELIUM_KERNELS
/* clang-format on */

/* RG_KERNELS is the target's list. RG_BUILT_IN() names the kernels that are
 * always available: on microcontrollers the kernels of the list, which are
 * fixed when compiling and need no spare rows. */
#if defined(__x86_64__)
#define RG_KERNELS RG_X86_KERNELS
#elif defined(__aarch64__) || defined(__ARM_NEON)
#define RG_KERNELS RG_NEON_KERNELS
#elif RG_HAVE_RVV
#define RG_KERNELS RG_RVV_KERNELS
#define RG_BOARD_KERNEL(channels) rg_blend_##channels##_rvv
#elif RG_HAVE_HELIUM
#define RG_KERNELS RG_HELIUM_KERNELS
#define RG_BOARD_KERNEL(channels) rg_blend_##channels##_helium
#else
#define RG_KERNELS
#endif

#if RG_ALL_BUILT_IN
#define RG_BUILT_IN(channels) RG_BOARD_KERNEL(channels)
#else
#define RG_BUILT_IN(channels) rg_blend_##channels
#endif

#endif /* RAYGRID_KERNEL_LIST_H */
