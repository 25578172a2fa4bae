/* Hints to compilers, each with its savings on a Cortex-M4: DESIGN.md,
 * "Compiler hints". */
#ifndef RAYGRID_CODE_SIZE_H
#define RAYGRID_CODE_SIZE_H

#include <stdint.h>

#include "config.h"

/* RG_NOINLINE keeps the stack of a function from being added to its caller's:
 * 152 bytes of rg_remap(), 32 of rg_remap_source_rows() in eight functions.
 *
 * RG_INLINE is for inner loops, at any level of optimization: 19 instructions
 * of an unprojection, and 12 to 20 bytes of stack. */
#if defined(__GNUC__)
#define RG_NOINLINE __attribute__((noinline))
#define RG_INLINE inline __attribute__((always_inline))
#else
#define RG_NOINLINE
#define RG_INLINE inline
#endif

/* RG_SHARED marks a function, and RG_UNROLL a loop in it: compact when
 * optimizing for size, otherwise fast. With -O2, RG_UNROLL saves 14 to 87
 * instructions per call in most functions. With -Os, RG_SHARED saves 16 bytes
 * of stack of rg_project_point(). */
#if RG_IS_FAST
#define RG_SHARED RG_INLINE
#define RG_UNROLL _Pragma("GCC unroll 4")
#else
#define RG_SHARED RG_NOINLINE
#define RG_UNROLL
#endif

/* Whether a loop of four iterations continues. The upper two bits of a length
 * below 2^30 count its iterations, so the counter needs no register. Shifting
 * the length left discards these bits. Saves 12 bytes, 8 instructions of an
 * unprojection with 16-bit control points, 12 of an observation line, and 20
 * bytes of stack in two functions. */
static RG_INLINE int rg_next_iteration(uint32_t* length) {
  *length += UINT32_C(1) << 30;
  return *length >= UINT32_C(1) << 30;
}

/* Keeps a value in a register; otherwise the compiler recomputes it where it is
 * used. With -O2 it saves 20 bytes and 7 instructions of an unprojection in one
 * function. In three others it keeps compilers from calling memset(). */
#if defined(__GNUC__)
#define RG_IN_REGISTER(value) __asm__("" : "+r"(value))
#else
#define RG_IN_REGISTER(value) ((void)(value))
#endif

/* RG_FORGET() hides the value range of a variable from the optimizer when
 * optimizing for size. Saves 58 bytes, 8 instructions of a projection, 1 per
 * pixel of YUYV and 24 bytes of stack of rg_remap() in ten functions; 8 bytes
 * and 0.2 instructions per pixel of interpolated samples in another. */
#if RG_IS_FAST
#define RG_FORGET(value) ((void)(value))
#else
#define RG_FORGET(value) RG_IN_REGISTER(value)
#endif

/* Keeps a value in memory until it is used, where registers are scarce; no
 * effect on x86-64. Saves 8 instructions of an observation line in two
 * functions; with -O2, 40 bytes and 14 instructions of an unprojection. */
#if defined(__GNUC__) && !defined(__x86_64__)
#define RG_IN_MEMORY(value) __asm__("" : "+m"(value))
#else
#define RG_IN_MEMORY(value) ((void)(value))
#endif

#endif /* RAYGRID_CODE_SIZE_H */
