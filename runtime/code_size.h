/* Nudges to compilers. */
#ifndef RAYGRID_CODE_SIZE_H
#define RAYGRID_CODE_SIZE_H

#include <stdint.h>

#include "config.h"

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
#if RG_IS_FAST
#define RG_SHARED RG_INLINE
#define RG_UNROLL_SHARED _Pragma("GCC unroll 4")
#else
#define RG_SHARED RG_NOINLINE
#define RG_UNROLL_SHARED
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
#if RG_HAVE_SIMD32
#define RG_IN_MEMORY(value) __asm__("" : "+m"(value))
#else
#define RG_IN_MEMORY(value) ((void)(value))
#endif

#endif /* RAYGRID_CODE_SIZE_H */
