/* 32 x 32 -> 64 bit products as two words, without a 64-bit type if the core
 * lacks such a multiplication: for Armv6-M and some Xtensas, compilers would
 * call a library function. Both versions are bit-identical. */
#ifndef RAYGRID_WIDE_MULTIPLY_H
#define RAYGRID_WIDE_MULTIPLY_H

#include <stdint.h>

#if !defined(RG_MULTIPLY_IN_PARTS)
#if defined(__ARM_ARCH_6M__) || defined(__ARM_ARCH_8M_BASE__)
#define RG_MULTIPLY_IN_PARTS 1
#elif defined(__XTENSA__) && !defined(__XCHAL_HAVE_MUL32_HIGH)
#define RG_MULTIPLY_IN_PARTS 1 /* not predefined up to GCC 12 */
#elif defined(__XTENSA__)
#define RG_MULTIPLY_IN_PARTS (!__XCHAL_HAVE_MUL32_HIGH)
#else
#define RG_MULTIPLY_IN_PARTS 0
#endif
#endif

/* Returns the high word of a * b; sets *low to the low word. */
static inline uint32_t rg_multiply_unsigned(uint32_t a, uint32_t b,
                                            uint32_t* low) {
#if RG_MULTIPLY_IN_PARTS
  const uint32_t a0 = a & 0xffffu, a1 = a >> 16;
  const uint32_t b0 = b & 0xffffu, b1 = b >> 16;
  const uint32_t p00 = a0 * b0;
  const uint32_t middle = a1 * b0 + (p00 >> 16); /* <= 2^32 - 2^16 */
  const uint32_t carry = (middle & 0xffffu) + a0 * b1;
  *low = (carry << 16) | (p00 & 0xffffu);
  return a1 * b1 + (middle >> 16) + (carry >> 16);
#else
  const uint64_t product = (uint64_t)a * b;
  *low = (uint32_t)product;
  return (uint32_t)(product >> 32);
#endif
}

/* Returns the high word of a * b; sets *low to the low word. */
static inline int32_t rg_multiply_signed(int32_t a, int32_t b, uint32_t* low) {
#if RG_MULTIPLY_IN_PARTS
  const int32_t a0 = a & 0xffff, a1 = a >> 16;
  const int32_t b0 = b & 0xffff, b1 = b >> 16;
  const uint32_t p00 = (uint32_t)a0 * (uint32_t)b0;
  /* |a1 b0| <= 2^15 (2^16 - 1), plus less than 2^16: fits. */
  const int32_t middle = a1 * b0 + (int32_t)(p00 >> 16);
  const int32_t carry = (middle & 0xffff) + a0 * b1;
  *low = ((uint32_t)carry << 16) | (p00 & 0xffffu);
  return a1 * b1 + (middle >> 16) + (carry >> 16);
#else
  const int64_t product = (int64_t)a * b;
  *low = (uint32_t)product;
  return (int32_t)(product >> 32);
#endif
}

#endif /* RAYGRID_WIDE_MULTIPLY_H */
