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
#define RG_UNROLL _Pragma("GCC unroll 4")
#else
#define RG_SHARED RG_NOINLINE
#define RG_UNROLL
#endif

/* Whether a loop goes on that has four turns, counted in bits of a length below
 * 2^30 which are lost when that is shifted: no register is needed for it. */
static RG_INLINE int rg_turn(uint32_t* length) {
  *length += UINT32_C(1) << 30;
  return *length >= UINT32_C(1) << 30;
}

/* A value in a register of its own: else the compiler composes it anew where it
 * is used. */
#if defined(__GNUC__)
#define RG_IN_REGISTER(value) __asm__("" : "+r"(value))
#else
#define RG_IN_REGISTER(value) ((void)(value))
#endif

/* RG_FORGET() makes compilers forget what they know of a value, where size
 * matters. */
#if RG_IS_FAST
#define RG_FORGET(value) ((void)(value))
#else
#define RG_FORGET(value) RG_IN_REGISTER(value)
#endif

/* A value that stays in memory until it is used: registers are scarce there.
 * x86-64 has other ways. */
#if defined(__GNUC__) && !defined(__x86_64__)
#define RG_IN_MEMORY(value) __asm__("" : "+m"(value))
#else
#define RG_IN_MEMORY(value) ((void)(value))
#endif

#endif /* RAYGRID_CODE_SIZE_H */
