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

/* RG_FORGET_COUNT() makes compilers forget what they know of a number above 0,
 * so that a loop remains one where size matters. */
#if defined(__GNUC__) && defined(__OPTIMIZE_SIZE__)
#define RG_FORGET_COUNT(number)                 \
  do {                                          \
    __asm__ volatile("" : "+r"(number));        \
    if ((number) == 0) __builtin_unreachable(); \
  } while (0)
#else
#define RG_FORGET_COUNT(number) ((void)(number))
#endif

/* The number of a loop's turns, which is above 0. */
static RG_INLINE uint32_t rg_times(uint32_t number) {
  RG_FORGET_COUNT(number);
  return number;
}

/* RG_KEEP() leaves an address in a register of its own, and RG_LEAVE() a value
 * in memory until it is used. x86-64 has other ways. */
#if defined(__GNUC__) && !defined(__x86_64__)
#define RG_KEEP(address) __asm__("" : "+r"(address))
#define RG_LEAVE(value) __asm__("" : "+m"(value))
#else
#define RG_KEEP(address) ((void)(address))
#define RG_LEAVE(value) ((void)(value))
#endif

/* An address in a register of its own: loads of pairs want that. */
static RG_INLINE const uint8_t* rg_keep_address(const uint8_t* p) {
  RG_KEEP(p);
  return p;
}

/* A value that is read where it is used: registers are scarce there. */
static RG_INLINE int32_t rg_read_late(int32_t* value) {
  RG_LEAVE(*value);
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

/* A constant that others are made of, so that these are not read from memory.
 */
#if RG_HAVE_SMMULR && defined(__OPTIMIZE_SIZE__)
#define RG_MAKE_OTHERS_OF(constant) __asm__("" : "+r"(constant))
#else
#define RG_MAKE_OTHERS_OF(constant) ((void)(constant))
#endif

#endif /* RAYGRID_CODE_SIZE_H */
