/* Every switch of the runtime. Each is 0 or 1, the same in all files.
 *
 * | switch                  | says                                | set by    |
 * |-------------------------|-------------------------------------|-----------|
 * | RG_PORTABLE_KERNELS     | only portable kernels are compiled  | you       |
 * | RG_FAST_WALK            | the fast walk, not the small one    | you, or   |
 * |                         |                                     | the target|
 * | RG_MULTIPLY_IN_PARTS    | products of 64 bits from halves     | you, or   |
 * |                         | (formats/wide_multiply.h)           | the target|
 * | RG_HAVE_FRAME_POINTER   | a frame pointer takes a register    | you       |
 * | RG_HAVE_SMMULR          | Arm's rounded upper words           | the target|
 * | RG_HAVE_SIMD32          | Arm's pairs of 16 bits in a word    | the target|
 * | RG_HAVE_HELIUM          | Arm's vectors of Cortex-M           | the target|
 * | RG_HAVE_RVV             | RISC-V's vectors                    | the target|
 * | RG_HAVE_CLZ             | leading zeros in one instruction    | the target|
 * | RG_HAVE_DIVISION        | division in one instruction         | the target|
 * | RG_IS_FAST              | speed before size: -O1 to -O3       | options   |
 * | RG_ROWS_IN_ASSEMBLER    | cortex_m/grid_rows_thumb2.h         | the above |
 * | RG_CORNERS_IN_ASSEMBLER | cortex_m/part_corners_thumb2.c      | the above |
 * | RG_ALL_BUILT_IN         | kernels of Helium or RVV built in   | the above |
 * | RG_GREY_ROW_IN_ASSEMBLER| cortex_m/grey_rows_thumb2.h         | the above |
 * | RG_CHOOSE_KERNELS       | a running program chooses kernels   | the above |
 * | RG_HAS_PART_KERNELS     | kernels that take several parts     | the above |
 * | RG_CHOOSE_SURFACE       | a running program chooses AVX2 for  | the above |
 * |                         | rays                                |           |
 * | RG_HAS_TILES            | kernels/tiles.c                     | the above |
 * | RG_BLENDS_WORDS         | the fields of RGB565 at once        | the above |
 *
 * "You" give a switch to the compiler of all files: -DRG_PORTABLE_KERNELS=1.
 * Only RG_HAVE_FRAME_POINTER is set by another name: -DRG_KEEP_FRAME_POINTER.
 */
#ifndef RAYGRID_CONFIG_H
#define RAYGRID_CONFIG_H

#include "wide_multiply.h"

/* ---- By you ------------------------------------------------------------- */

#if !defined(RG_PORTABLE_KERNELS)
#define RG_PORTABLE_KERNELS 0
#endif

/* The fast walk wants large stacks: it keeps what a block's parts have in
 * common from one to the next, and computes both coordinates of two positions
 * together. */
#if !defined(RG_FAST_WALK)
#if defined(__GNUC__) &&                                            \
    (defined(__linux__) || defined(__LP64__) || defined(_WIN64)) && \
    (!defined(__x86_64__) || defined(__SSE2__))
#define RG_FAST_WALK 1
#else
#define RG_FAST_WALK 0
#endif
#endif

#if defined(RG_KEEP_FRAME_POINTER)
#define RG_HAVE_FRAME_POINTER 1
#else
#define RG_HAVE_FRAME_POINTER 0
#endif

/* ---- By the target ------------------------------------------------------ */

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

/* ---- By the compiler's options ------------------------------------------ */

#if defined(__OPTIMIZE__) && !defined(__OPTIMIZE_SIZE__)
#define RG_IS_FAST 1
#else
#define RG_IS_FAST 0
#endif

/* ---- By the switches above ---------------------------------------------- */

/* In C, compilers load words one by one, and run out of registers. */
#if RG_HAVE_SMMULR && defined(__thumb2__) && defined(__OPTIMIZE__) && \
    !defined(__clang__) && !defined(__ARMEB__)
#define RG_ROWS_IN_ASSEMBLER 1
#else
#define RG_ROWS_IN_ASSEMBLER 0
#endif

/* Helium is faster without this assembler, for tables without bends. */
#if RG_ROWS_IN_ASSEMBLER && !RG_IS_FAST && !RG_FAST_WALK && !RG_HAVE_HELIUM
#define RG_CORNERS_IN_ASSEMBLER 1
#else
#define RG_CORNERS_IN_ASSEMBLER 0
#endif

/* A board's kernels are known when it is compiled. */
#if (RG_HAVE_HELIUM || RG_HAVE_RVV) && !RG_PORTABLE_KERNELS
#define RG_ALL_BUILT_IN 1
#else
#define RG_ALL_BUILT_IN 0
#endif

/* GCC 11 is the first one whose asm goto has results. The assembler uses all
 * registers. */
#if RG_ROWS_IN_ASSEMBLER && !RG_FAST_WALK && !RG_ALL_BUILT_IN &&  \
    defined(__ARM_FEATURE_UNALIGNED) && !RG_HAVE_FRAME_POINTER && \
    __GNUC__ >= 11
#define RG_GREY_ROW_IN_ASSEMBLER 1
#else
#define RG_GREY_ROW_IN_ASSEMBLER 0
#endif

/* The program chooses a kernel when it runs, if there is room for several. Such
 * kernels read spare rows, which the small walk does not know. */
#if RG_FAST_WALK && !RG_PORTABLE_KERNELS &&                                \
    ((defined(__x86_64__) && defined(__SSE2__)) || defined(__aarch64__) || \
     (defined(__linux__) && (defined(__arm__) || defined(__riscv))))
#define RG_CHOOSE_KERNELS 1
#else
#define RG_CHOOSE_KERNELS 0
#endif

/* Only the kernels of AVX-512 take several parts at once: at most
 * RG_PARTS_AT_ONCE. */
#if RG_CHOOSE_KERNELS && defined(__x86_64__)
#define RG_HAS_PART_KERNELS 1
#else
#define RG_HAS_PART_KERNELS 0
#endif
#define RG_PARTS_AT_ONCE 32

/* Whether there is AVX2 is found out when a camera is opened. */
#if defined(__x86_64__) && defined(__SSE2__) && defined(__GNUC__) && \
    !RG_PORTABLE_KERNELS && !RG_MULTIPLY_IN_PARTS
#define RG_CHOOSE_SURFACE 1
#else
#define RG_CHOOSE_SURFACE 0
#endif

/* GCC 12 is the first one that makes vectors of these loops. */
#if RG_IS_FAST && defined(__SSE2__) && defined(__GNUC__) && __GNUC__ >= 12
#define RG_HAS_TILES 1
#else
#define RG_HAS_TILES 0
#endif

/* Other processors with registers of 64 bits could do so, too. */
#if RG_IS_FAST && defined(__x86_64__)
#define RG_BLENDS_WORDS 1
#else
#define RG_BLENDS_WORDS 0
#endif

#endif /* RAYGRID_CONFIG_H */
