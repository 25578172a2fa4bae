/* Detection of x86-64 features that both the processor and the system support,
 * and macros to compile functions for them. */
#ifndef RAYGRID_X86_FEATURES_H
#define RAYGRID_X86_FEATURES_H

#if defined(__x86_64__)

#include <cpuid.h>
#include <stdint.h>

/* Bits of XCR0: registers that the system saves. */
#define RG_XMM_YMM 0x06u
#define RG_MASKS_ZMM 0xe0u

static inline int rg_keeps_registers(uint32_t wanted) {
  uint32_t a, b, c, d, enabled, high;
  if (!__get_cpuid(1, &a, &b, &c, &d) || (c & bit_OSXSAVE) == 0) return 0;
  __asm__("xgetbv" : "=a"(enabled), "=d"(high) : "c"(0));
  return (enabled & wanted) == wanted;
}

static inline int rg_has_avx2(void) {
  uint32_t a, b, c, d;
  return rg_keeps_registers(RG_XMM_YMM) &&
         __get_cpuid_count(7, 0, &a, &b, &c, &d) && (b & bit_AVX2) != 0;
}

static inline int rg_has_sse4(void) {
  uint32_t a, b, c, d;
  return __get_cpuid(1, &a, &b, &c, &d) && (c & bit_SSE4_1) != 0 &&
         (c & bit_SSSE3) != 0;
}

/* Whether the processor and system support AVX-512 F/DQ/BW/VL, required by
 * kernels/avx512.c, and AVX2, its fallback. */
static inline int rg_has_avx512(void) {
  const uint32_t needed =
      bit_AVX512F | bit_AVX512DQ | bit_AVX512BW | bit_AVX512VL;
  uint32_t a, b, c, d;
  return rg_has_avx2() && rg_keeps_registers(RG_MASKS_ZMM) &&
         __get_cpuid_count(7, 0, &a, &b, &c, &d) && (b & needed) == needed &&
         (c & bit_AVX512VBMI) != 0 && (c & bit_AVX512VBMI2) != 0;
}

/* Functions between these macros are compiled for the named features. */
#define RG_PRAGMA(text) _Pragma(#text)
#if defined(__clang__)
#define RG_BEGIN_FEATURES(names)                                 \
  RG_PRAGMA(clang attribute push(__attribute__((target(names))), \
                                 apply_to = function))
#define RG_END_FEATURES RG_PRAGMA(clang attribute pop)
#else
#define RG_BEGIN_FEATURES(names) \
  RG_PRAGMA(GCC push_options) RG_PRAGMA(GCC target(names))
#define RG_END_FEATURES RG_PRAGMA(GCC pop_options)
#endif

#endif

#endif /* RAYGRID_X86_FEATURES_H */
