/* All switches of the runtime. Each is 0 or 1, the same in all files.
 *
 * | switch                  | meaning                             | set by    |
 * |-------------------------|-------------------------------------|-----------|
 * | RG_PORTABLE_KERNELS     | only portable kernels are compiled  | user      |
 * | RG_FAST_TRAVERSAL       | fast traversal instead of the small | user, or  |
 * |                         | one                                 | target    |
 * | RG_MULTIPLY_IN_PARTS    | 64-bit products from 16-bit halves  | user, or  |
 * |                         | (formats/wide_multiply.h)           | target    |
 * | RG_HAVE_FRAME_POINTER   | a frame pointer occupies a register | user      |
 * | RG_HAVE_SMMULR          | Arm: rounded upper word of products | target    |
 * | RG_HAVE_SIMD32          | Arm: pairs of 16 bits in a word     | target    |
 * | RG_HAVE_HELIUM          | Arm: vectors of Cortex-M            | target    |
 * | RG_HAVE_RVV             | RISC-V: vectors                     | target    |
 * | RG_HAVE_CLZ             | leading zeros in one instruction    | target    |
 * | RG_HAVE_DIVISION        | division in one instruction         | target    |
 * | RG_IS_FAST              | optimized for speed: -O1 to -O3     | options   |
 * | RG_ROWS_IN_ASSEMBLER    | cortex_m/grid_rows_thumb2.h         | the above |
 * | RG_CORNERS_IN_ASSEMBLER | cortex_m/tile_corners_thumb2.c      | the above |
 * | RG_ALL_BUILT_IN         | Helium or RVV kernels are built in  | the above |
 * | RG_GREY_ROW_IN_ASSEMBLER| cortex_m/grey_rows_thumb2.h         | the above |
 * | RG_SELECT_KERNELS       | kernels are selected at run time    | the above |
 * | RG_HAS_TILE_KERNELS     | kernels that process several tiles  | the above |
 * | RG_SELECT_SURFACE       | AVX2 code for rays is selected at   | the above |
 * |                         | run time                            |           |
 * | RG_HAS_TILES            | kernels/tiles.c                     | the above |
 * | RG_BLENDS_WORDS         | RGB565: all fields of a word at once| the above |
 *
 * The user sets a switch by a compiler option for all files, such as
 * -DRG_PORTABLE_KERNELS=1. RG_HAVE_FRAME_POINTER is the exception: it is set by
 * -DRG_KEEP_FRAME_POINTER. */
#ifndef RAYGRID_CONFIG_H
#define RAYGRID_CONFIG_H

#include "wide_multiply.h"

/* ---- Set by the user ---------------------------------------------------- */

#if !defined(RG_PORTABLE_KERNELS)
#define RG_PORTABLE_KERNELS 0
#endif

/* ---- Deprecated names ---------------------------------------------------- */

#if defined(RG_FAST_WALK) && !defined(RG_FAST_TRAVERSAL)
#define RG_FAST_TRAVERSAL RG_FAST_WALK
#endif

/* ---- End of deprecated names --------------------------------------------- */

/* The fast traversal needs a large stack: it keeps values that the tiles of a
 * block share from one tile to the next, and computes both coordinates of two
 * positions in one vector. */
#if !defined(RG_FAST_TRAVERSAL)
#if defined(__GNUC__) &&                                            \
    (defined(__linux__) || defined(__LP64__) || defined(_WIN64)) && \
    (!defined(__x86_64__) || defined(__SSE2__))
#define RG_FAST_TRAVERSAL 1
#else
#define RG_FAST_TRAVERSAL 0
#endif
#endif

#if defined(RG_KEEP_FRAME_POINTER)
#define RG_HAVE_FRAME_POINTER 1
#else
#define RG_HAVE_FRAME_POINTER 0
#endif

/* ---- Target features ---------------------------------------------------- */

#if defined(__ARM_FEATURE_DSP) && defined(__GNUC__) && !defined(__aarch64__)
#define RG_HAVE_SMMULR 1
#else
#define RG_HAVE_SMMULR 0
#endif

#if defined(__ARM_FEATURE_SIMD32)
#define RG_HAVE_SIMD32 1
#else
#define RG_HAVE_SIMD32 0
#endif

#if defined(__ARM_FEATURE_MVE)
#define RG_HAVE_HELIUM 1
#else
#define RG_HAVE_HELIUM 0
#endif

#if defined(__riscv_vector)
#define RG_HAVE_RVV 1
#else
#define RG_HAVE_RVV 0
#endif

#if defined(__GNUC__) &&                                               \
    (defined(__ARM_FEATURE_CLZ) || defined(__aarch64__) ||             \
     defined(__x86_64__) || defined(__i386__) || defined(__s390x__) || \
     defined(__riscv_zbb) || defined(__XTENSA__))
#define RG_HAVE_CLZ 1
#else
#define RG_HAVE_CLZ 0
#endif

#if defined(__ARM_FEATURE_IDIV) || defined(__riscv_div) || \
    defined(__aarch64__) || defined(__x86_64__)
#define RG_HAVE_DIVISION 1
#else
#define RG_HAVE_DIVISION 0
#endif

/* ---- Compiler options --------------------------------------------------- */

#if defined(__OPTIMIZE__) && !defined(__OPTIMIZE_SIZE__)
#define RG_IS_FAST 1
#else
#define RG_IS_FAST 0
#endif

/* ---- Derived macros ----------------------------------------------------- */

/* From C, compilers generate single loads, and run out of registers. */
#if RG_HAVE_SMMULR && defined(__thumb2__) && defined(__OPTIMIZE__) && \
    !defined(__clang__) && !defined(__ARMEB__)
#define RG_ROWS_IN_ASSEMBLER 1
#else
#define RG_ROWS_IN_ASSEMBLER 0
#endif

/* With Helium, C is faster than this assembly for tables without bends. */
#if RG_ROWS_IN_ASSEMBLER && !RG_IS_FAST && !RG_FAST_TRAVERSAL && !RG_HAVE_HELIUM
#define RG_CORNERS_IN_ASSEMBLER 1
#else
#define RG_CORNERS_IN_ASSEMBLER 0
#endif

/* Microcontrollers: the instruction set is fixed when compiling. */
#if (RG_HAVE_HELIUM || RG_HAVE_RVV) && !RG_PORTABLE_KERNELS
#define RG_ALL_BUILT_IN 1
#else
#define RG_ALL_BUILT_IN 0
#endif

/* asm goto with outputs requires GCC 11. The assembly uses all registers. */
#if RG_ROWS_IN_ASSEMBLER && !RG_FAST_TRAVERSAL && !RG_ALL_BUILT_IN && \
    defined(__ARM_FEATURE_UNALIGNED) && !RG_HAVE_FRAME_POINTER &&     \
    __GNUC__ >= 11
#define RG_GREY_ROW_IN_ASSEMBLER 1
#else
#define RG_GREY_ROW_IN_ASSEMBLER 0
#endif

/* Kernels are selected at run time if the target supports several. They read
 * spare rows, which the small traversal does not check for. */
#if RG_FAST_TRAVERSAL && !RG_PORTABLE_KERNELS &&                           \
    ((defined(__x86_64__) && defined(__SSE2__)) || defined(__aarch64__) || \
     (defined(__linux__) && (defined(__arm__) || defined(__riscv))))
#define RG_SELECT_KERNELS 1
#else
#define RG_SELECT_KERNELS 0
#endif

/* Only the AVX-512 kernels process several tiles at once: at most
 * RG_TILES_AT_ONCE. */
#if RG_SELECT_KERNELS && defined(__x86_64__)
#define RG_HAS_TILE_KERNELS 1
#else
#define RG_HAS_TILE_KERNELS 0
#endif
#define RG_TILES_AT_ONCE 32

/* AVX2 is detected when a camera is opened. */
#if defined(__x86_64__) && defined(__SSE2__) && defined(__GNUC__) && \
    !RG_PORTABLE_KERNELS && !RG_MULTIPLY_IN_PARTS
#define RG_SELECT_SURFACE 1
#else
#define RG_SELECT_SURFACE 0
#endif

/* GCC 12 is the first version that vectorizes these loops. */
#if RG_IS_FAST && defined(__SSE2__) && defined(__GNUC__) && __GNUC__ >= 12
#define RG_HAS_TILES 1
#else
#define RG_HAS_TILES 0
#endif

/* Possible on other processors with 64-bit registers, but not implemented. */
#if RG_IS_FAST && defined(__x86_64__)
#define RG_BLENDS_WORDS 1
#else
#define RG_BLENDS_WORDS 0
#endif

#endif /* RAYGRID_CONFIG_H */
