/* Fixed-point products with rounding. Every product rounds half up (adds half
 * an LSB and shifts arithmetically): truncation would bias the result. */
#ifndef RAYGRID_FIXED_POINT_H
#define RAYGRID_FIXED_POINT_H

#include "code_size.h"
#include "config.h"
#include "wide_multiply.h"

/* Adds modulo 2^32: values of a malformed blob may overflow; the result is then
 * unspecified, but there is no undefined behaviour. */
static inline int32_t rg_add(int32_t a, int32_t b) {
  return (int32_t)((uint32_t)a + (uint32_t)b);
}

static inline int32_t rg_subtract(int32_t a, int32_t b) {
  return (int32_t)((uint32_t)a - (uint32_t)b);
}

static inline uint32_t rg_lesser(uint32_t a, uint32_t b) {
  return a < b ? a : b;
}

/* Shifts modulo 2^32. */
static inline int32_t rg_shift_left(int32_t a, int shift) {
  return (int32_t)((uint32_t)a << shift);
}

/* (a b + 2^31) >> 32 */
static inline int32_t rg_multiply_high(int32_t a, int32_t b) {
#if RG_HAVE_SMMULR
  int32_t result;
  __asm__("smmulr %0, %1, %2" : "=r"(result) : "r"(a), "r"(b));
  return result;
#elif RG_MULTIPLY_IN_PARTS
  uint32_t low;
  const int32_t high = rg_multiply_signed(a, b, &low);
  return high + (int32_t)(low >> 31);
#else
  return (int32_t)(((int64_t)a * b + INT64_C(0x80000000)) >> 32);
#endif
}

/* sum + ((a b + 2^31) >> 32) */
static inline int32_t rg_multiply_high_add(int32_t sum, int32_t a, int32_t b) {
#if RG_HAVE_SMMULR
  int32_t result;
  __asm__("smmlar %0, %1, %2, %3" : "=r"(result) : "r"(a), "r"(b), "r"(sum));
  return result;
#else
  return rg_add(sum, rg_multiply_high(a, b));
#endif
}

/* sum + ((2^31 - a b) >> 32) */
static inline int32_t rg_multiply_high_subtract(int32_t sum, int32_t a,
                                                int32_t b) {
#if RG_HAVE_SMMULR
  int32_t result;
  __asm__("smmlsr %0, %1, %2, %3" : "=r"(result) : "r"(a), "r"(b), "r"(sum));
  return result;
#elif RG_MULTIPLY_IN_PARTS
  uint32_t low;
  const int32_t high = rg_multiply_signed(a, b, &low);
  return rg_subtract(sum, high + (low > 0x80000000u));
#else
  return rg_add(sum, (int32_t)((INT64_C(0x80000000) - (int64_t)a * b) >> 32));
#endif
}

/* (a b) >> 16 */
static inline int32_t rg_multiply_half(int32_t a, int16_t b) {
#if defined(__LP64__) || defined(_WIN64)
  return (int32_t)(((int64_t)a * b) >> 16);
#else
  return (a >> 16) * b + (((a & 0xffff) * b) >> 16);
#endif
}

/* (a b + 2^31) >> 32, unsigned */
static inline uint32_t rg_multiply_high_unsigned(uint32_t a, uint32_t b) {
  uint32_t low;
  const uint32_t high = rg_multiply_unsigned(a, b, &low);
  return high + (low >> 31);
}

/* (a b + 2^(shift - 1)) >> shift for 2 <= shift <= 31; twice the result must
 * fit. */
static inline int32_t rg_multiply_shift(int32_t a, int32_t b, int shift) {
  uint32_t low;
  const int32_t high = rg_multiply_signed(a, b, &low);
  const int32_t twice =
      (int32_t)(((uint32_t)high << (33 - shift)) | (low >> (shift - 1)));
  return (twice >> 1) + (twice & 1);
}

/* a b, for sums of products that rg_upper_word() rounds once. */
static inline int64_t rg_product(int32_t a, int32_t b) {
#if RG_MULTIPLY_IN_PARTS
  uint32_t low;
  const int32_t high = rg_multiply_signed(a, b, &low);
  return (int64_t)(((uint64_t)(uint32_t)high << 32) | low);
#else
  return (int64_t)a * b;
#endif
}

/* (sum + 2^31) >> 32 */
static inline int32_t rg_upper_word(int64_t sum) {
  return (int32_t)((sum + INT64_C(0x80000000)) >> 32);
}

/* |value|; 2^31 for INT32_MIN. */
static inline uint32_t rg_magnitude(int32_t value) {
  return value < 0 ? 0u - (uint32_t)value : (uint32_t)value;
}

/* Number of leading zero bits; value must not be 0. */
static inline int rg_leading_zeros(uint32_t value) {
#if RG_HAVE_CLZ
  return __builtin_clz(value);
#else
  int zeros = 0;
  for (int step = 16; step > 0; step >>= 1) {
    if (value >> (32 - step) != 0) continue;
    value <<= step;
    zeros += step;
  }
  return zeros;
#endif
}

#endif /* RAYGRID_FIXED_POINT_H */
