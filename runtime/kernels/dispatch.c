/* The kernels that this processor has. */
#include "kernel_name.h"
#include "kernels/kernel.h"

#if RG_CHOOSE_KERNELS

static const rg_kernels kPortable = {
    "portable",
    {rg_blend_1, rg_blend_2, rg_blend_3, rg_blend_4},
    {0, 0, 0, 0},
    RG_HAS_TILES ? RG_HAS_VECTORS : 0};

#if defined(__x86_64__)

#include "x86_features.h"

static const rg_kernels kSse4 = {
    "sse4",
    {rg_blend_1_sse4, rg_blend_2_sse4, rg_blend_3_sse4, rg_blend_4_sse4},
    {0, 0, 0, 0},
    RG_HAS_VECTORS};

static const rg_kernels kAvx2 = {
    "avx2",
    {rg_blend_1_avx2, rg_blend_2_avx2, rg_blend_3_avx2, rg_blend_4_avx2},
    {0, 0, 0, 0},
    RG_HAS_VECTORS | RG_HAS_WORDS};

static const rg_kernels kAvx512 = {
    "avx512",
    {rg_blend_1_avx512, rg_blend_2_avx512, rg_blend_3_avx512,
     rg_blend_4_avx512},
    {rg_blend_parts_1_avx512, rg_blend_parts_2_avx512, rg_blend_parts_3_avx512,
     rg_blend_parts_4_avx512},
    RG_HAS_VECTORS | RG_HAS_WORDS};

static int has_sse4(void) {
  uint32_t a, b, c, d;
  return __get_cpuid(1, &a, &b, &c, &d) && (c & bit_SSE4_1) != 0 &&
         (c & bit_SSSE3) != 0;
}

/* Whether there is all that kernels/avx512.c is compiled for, and AVX2, which
 * it falls back on. */
static int has_avx512(void) {
  const uint32_t needed =
      bit_AVX512F | bit_AVX512DQ | bit_AVX512BW | bit_AVX512VL;
  uint32_t a, b, c, d;
  return rg_has_avx2() && rg_keeps_registers(RG_MASKS_ZMM) &&
         __get_cpuid_count(7, 0, &a, &b, &c, &d) && (b & needed) == needed &&
         (c & bit_AVX512VBMI) != 0 && (c & bit_AVX512VBMI2) != 0;
}

#endif

#if defined(__aarch64__) || defined(__ARM_NEON)
static const rg_kernels kNeon = {
    "neon",
    {rg_blend_1_neon, rg_blend_2_neon, rg_blend_3_neon, rg_blend_4_neon},
    {0, 0, 0, 0},
    RG_HAS_VECTORS};
#endif

#if RG_HAVE_RVV
static const rg_kernels kRvv = {
    "rvv",
    {rg_blend_1_rvv, rg_blend_2_rvv, rg_blend_3_rvv, rg_blend_4_rvv},
    {0, 0, 0, 0},
    RG_HAS_VECTORS};
#endif

const rg_kernels* rg_find_kernels(const char* name) {
#if defined(__x86_64__)
  if ((!name || rg_is_name(name, kAvx512.name)) && has_avx512())
    return &kAvx512;
  if ((!name || rg_is_name(name, kAvx2.name)) && rg_has_avx2()) return &kAvx2;
  if ((!name || rg_is_name(name, kSse4.name)) && has_sse4()) return &kSse4;
#elif defined(__aarch64__) || defined(__ARM_NEON)
  if (!name || rg_is_name(name, kNeon.name)) return &kNeon;
#elif RG_HAVE_RVV
  if (!name || rg_is_name(name, kRvv.name)) return &kRvv;
#endif
  return !name || rg_is_name(name, kPortable.name) ? &kPortable : 0;
}

#else

const rg_kernels* rg_find_kernels(const char* name) {
  (void)name;
  return 0;
}

#endif
