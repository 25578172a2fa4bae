/* Nudges to compilers, each with what it saves on a Cortex-M4: DESIGN.md,
 * "Compiler hints". */
#ifndef RAYGRID_CODE_SIZE_H
#define RAYGRID_CODE_SIZE_H

#include <stdint.h>

#include "config.h"

/* RG_NOINLINE keeps the stack of a function from adding up with its caller's:
 * 152 bytes of rg_remap(), 32 of rg_remap_source_rows() in eight places.
 *
 * RG_INLINE is for inner loops, at any level of optimization: 19 instructions
 * of an un-projection, and 12 to 20 bytes of stack. */
#if defined(__GNUC__)
#define RG_NOINLINE __attribute__((noinline))
#define RG_INLINE inline __attribute__((always_inline))
#else
#define RG_NOINLINE
#define RG_INLINE inline
#endif

/* RG_SHARED is for a function, and RG_UNROLL for a loop in it. They are short
 * where size matters, else fast. With -O2, RG_UNROLL saves 14 to 87
 * instructions of a call in most places. With -Os, RG_SHARED saves 16 bytes of
 * stack of rg_project_point(). */
#if RG_IS_FAST
#define RG_SHARED RG_INLINE
#define RG_UNROLL _Pragma("GCC unroll 4")
#else
#define RG_SHARED RG_NOINLINE
#define RG_UNROLL
#endif

/* Whether a loop of four turns goes on. The upper two bits of a length below
 * 2^30 count its turns, so the count needs no register. A shift of the length
 * loses these bits. Saves 12 bytes, 8 instructions of an un-projection with
 * control points of 16 bits, 12 of a line, and 20 bytes of stack in two places.
 */
static RG_INLINE int rg_turn(uint32_t* length) {
  *length += UINT32_C(1) << 30;
  return *length >= UINT32_C(1) << 30;
}

/* A value in a register of its own: else the compiler composes it anew where it
 * is used. With -O2 it saves 20 bytes and 7 instructions of an un-projection in
 * one place. In three others it keeps compilers from calling memset(). */
#if defined(__GNUC__)
#define RG_IN_REGISTER(value) __asm__("" : "+r"(value))
#else
#define RG_IN_REGISTER(value) ((void)(value))
#endif

/* RG_FORGET() makes compilers forget what they know of a value, where size
 * matters. Saves 58 bytes, 8 instructions of a projection, 1 a pixel of YUYV
 * and 24 bytes of stack of rg_remap() in ten places; 8 bytes and 0.2
 * instructions a pixel between knots of a stack in another. */
#if RG_IS_FAST
#define RG_FORGET(value) ((void)(value))
#else
#define RG_FORGET(value) RG_IN_REGISTER(value)
#endif

/* A value that stays in memory until it is used, where registers are scarce.
 * x86-64 has other ways. Saves 8 instructions of a line in two places; with
 * -O2, 40 bytes and 14 instructions of an un-projection in a third. */
#if defined(__GNUC__) && !defined(__x86_64__)
#define RG_IN_MEMORY(value) __asm__("" : "+m"(value))
#else
#define RG_IN_MEMORY(value) ((void)(value))
#endif

#endif /* RAYGRID_CODE_SIZE_H */
