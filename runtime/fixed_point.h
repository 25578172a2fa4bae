/* Fixed-point products with rounding. Every product rounds half up (adds half
 * an LSB and shifts arithmetically): truncation would bias the result. */
#ifndef RAYGRID_FIXED_POINT_H
#define RAYGRID_FIXED_POINT_H

#include "wide_multiply.h"

/* Defined as 1, all files are compiled for the portable kernels alone. */
#if !defined(RG_PORTABLE_KERNELS)
#define RG_PORTABLE_KERNELS 0
#endif

/* RG_KEEP_LINES is 1 where stacks are large. What a block's parts have in
 * common is then kept from one to the next, and both coordinates of two
 * positions are computed together. Where it is defined as 0, all files are
 * compiled for the small walk. */
#if !defined(RG_KEEP_LINES)
#if defined(__GNUC__) &&                                            \
    (defined(__linux__) || defined(__LP64__) || defined(_WIN64)) && \
    (!defined(__x86_64__) || defined(__SSE2__))
#define RG_KEEP_LINES 1
#else
#define RG_KEEP_LINES 0
#endif
#endif

#if defined(__ARM_FEATURE_DSP) && defined(__GNUC__) && !defined(__aarch64__)
#define RG_HAVE_SMMULR 1
#else
#define RG_HAVE_SMMULR 0
#endif

/* Modulo 2^32: values of a forged blob may add up to more than 32 bits, which
 * then gives any result, but no undefined behaviour. */
static inline int32_t rg_add(int32_t a, int32_t b) {
  return (int32_t)((uint32_t)a + (uint32_t)b);
}

static inline int32_t rg_subtract(int32_t a, int32_t b) {
  return (int32_t)((uint32_t)a - (uint32_t)b);
}

static inline uint32_t rg_lesser(uint32_t a, uint32_t b) {
  return a < b ? a : b;
}

/* Modulo 2^32, too. */
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

/* a b. Sums of products are rounded once, by rg_upper_word(). */
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

/* Inlining every function into its caller would add up their stacks; the inner
 * loops want it at any level of optimization. */
#if defined(__GNUC__)
#define RG_NOINLINE __attribute__((noinline))
#define RG_INLINE inline __attribute__((always_inline))
#else
#define RG_NOINLINE
#define RG_INLINE inline
#endif

/* A function, and a loop in it, that are short rather than fast where size
 * matters. */
#if defined(__OPTIMIZE__) && !defined(__OPTIMIZE_SIZE__)
#define RG_IS_FAST 1
#define RG_SHARED RG_INLINE
#define RG_UNROLL_SHARED _Pragma("GCC unroll 4")
#else
#define RG_IS_FAST 0
#define RG_SHARED RG_NOINLINE
#define RG_UNROLL_SHARED
#endif

/* Rows of four points in assembler: compilers would load words one by one, and
 * run out of registers. */
#if RG_HAVE_SMMULR && defined(__thumb2__) && defined(__OPTIMIZE__) && \
    !defined(__clang__) && !defined(__ARMEB__)
#define RG_ROWS_IN_ASSEMBLER 1
#else
#define RG_ROWS_IN_ASSEMBLER 0
#endif

/* Whether a loop goes on that has four turns, counted in bits of a length below
 * 2^30 which are lost when that is shifted: no register is needed for it. */
static RG_INLINE int rg_turn(uint32_t* length) {
  *length += UINT32_C(1) << 30;
  return *length >= UINT32_C(1) << 30;
}

/* In front of the loop over four rows, in which half of the instructions are:
 * one after the other where a row is short, or size does not matter. */
#if RG_HAVE_SMMULR || RG_IS_FAST
#define RG_UNROLL_ROWS _Pragma("GCC unroll 4")
#else
#define RG_UNROLL_ROWS
#endif

/* A number above 0 that compilers do not know, so that a loop remains one where
 * size matters. */
static RG_INLINE uint32_t rg_times(uint32_t number) {
#if defined(__GNUC__) && defined(__OPTIMIZE_SIZE__)
  __asm__ volatile("" : "+r"(number));
  if (number == 0) __builtin_unreachable();
#endif
  return number;
}

/* An address in a register of its own: loads of pairs want that. */
static RG_INLINE const uint8_t* rg_keep_address(const uint8_t* p) {
#if defined(__GNUC__) && !defined(__x86_64__)
  __asm__("" : "+r"(p));
#endif
  return p;
}

/* A value that is read where it is used: registers are scarce there. */
static RG_INLINE int32_t rg_read_late(int32_t* value) {
#if defined(__GNUC__) && !defined(__x86_64__)
  __asm__("" : "+m"(*value));
#endif
  return *value;
}

/* A value in a register: else the compiler composes it anew where it is used.
 */
#if defined(__GNUC__)
#define RG_IN_REGISTER(value) __asm__("" : "+r"(value))
#else
#define RG_IN_REGISTER(value) ((void)(value))
#endif

/* A value that a loop before does not keep in a register. */
#if defined(__ARM_FEATURE_SIMD32)
#define RG_IN_MEMORY(value) __asm__("" : "+m"(value))
#else
#define RG_IN_MEMORY(value) ((void)(value))
#endif

/* |value|, 2^31 for the lowest. */
static inline uint32_t rg_magnitude(int32_t value) {
  return value < 0 ? 0u - (uint32_t)value : (uint32_t)value;
}

#if defined(__GNUC__) &&                                               \
    (defined(__ARM_FEATURE_CLZ) || defined(__aarch64__) ||             \
     defined(__x86_64__) || defined(__i386__) || defined(__s390x__) || \
     defined(__riscv_zbb))
#define RG_HAVE_CLZ 1 /* an instruction, not a call */
#else
#define RG_HAVE_CLZ 0
#endif

/* Zero bits above the highest one; value must not be 0. */
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
