/* B-spline sums of rows of control points for Thumb-2 with the DSP extension,
 * in assembly, because compilers generate single loads and run out of
 * registers: cortex_m/grid_rows.h. */
#ifndef RAYGRID_GRID_ROWS_THUMB2_H
#define RAYGRID_GRID_ROWS_THUMB2_H

#include <stdint.h>

#include "blob_layout.h"
#include "bytes.h"
#include "code_size.h"
#include "config.h"
#include "fixed_point.h"

#if RG_ROWS_IN_ASSEMBLER

/* rg_sum_points_in_c(); iterations are counted in bits that are shifted out. */
static RG_INLINE void rg_sum_points_in_thumb2(const uint8_t* points,
                                              uint32_t columns,
                                              int32_t w_q31[2][4],
                                              int32_t sums_q27[2]) {
  const int32_t* weights_q31 = w_q31[0];
  int32_t a_q27 = 0, b_q27 = 0;
  __asm__(
      "ldmia %[weights]!, {r6, r8, r9, r10}\n"
      "1:\n\t"
      "ldmia.w %[points], {r1, r2, r4, r5}\n\t"
      "smmulr r1, r1, r6\n\t"
      "smmulr r2, r2, r6\n\t"
      "smmlar r1, r4, r8, r1\n\t"
      "smmlar r2, r5, r8, r2\n\t"
      "ldrd r4, r5, [%[points], %[size] * 2]\n\t"
      "smmlar r1, r4, r9, r1\n\t"
      "smmlar r2, r5, r9, r2\n\t"
      "ldrd r4, r5, [%[points], %[size] * 3]\n\t"
      "smmlar r1, r4, r10, r1\n\t"
      "smmlar r2, r5, r10, r2\n\t"
      "ldr r4, [%[weights]], #4\n\t"
      "add %[points], %[points], %[columns], lsl #3\n\t"
      "smmlar %[a], r1, r4, %[a]\n\t"
      "smmlar %[b], r2, r4, %[b]\n\t"
      "adds %[columns], %[columns], #0x40000000\n\t"
      "bcc 1b"
      : [points] "+r"(points), [columns] "+r"(columns), [a] "+r"(a_q27),
        [b] "+r"(b_q27), [weights] "+r"(weights_q31)
      : [size] "i"(RG_CONTROL_POINT_SIZE)
      : "r1", "r2", "r4", "r5", "r6", "r8", "r9", "r10", "cc", "memory");
  sums_q27[0] = a_q27;
  sums_q27[1] = b_q27;
}

/* rg_sum_residuals_in_c(). A residual is a word with both coordinates. */
static RG_INLINE void rg_sum_residuals_in_thumb2(const uint8_t* residuals,
                                                 uint32_t columns, int32_t half,
                                                 int32_t w_q31[2][4],
                                                 int32_t sums[2]) {
  const int32_t w0 = w_q31[0][0], w1 = w_q31[0][1];
  const int32_t w2 = w_q31[0][2], w3 = w_q31[0][3];
  const int32_t* row_weight_q31 = w_q31[1];
  int32_t a = half, b = half;
  do {
    __asm__(
        "ldrd r1, r2, [%[residuals]]\n\t"
        "smulwt r5, %[w0], r1\n\t"
        "smulwb r1, %[w0], r1\n\t"
        "smlawt r5, %[w1], r2, r5\n\t"
        "smlawb r1, %[w1], r2, r1\n\t"
        "ldr r2, [%[residuals], %[size] * 2]\n\t"
        "smlawt r5, %[w2], r2, r5\n\t"
        "smlawb r1, %[w2], r2, r1\n\t"
        "ldr r2, [%[residuals], %[size] * 3]\n\t"
        "smlawt r5, %[w3], r2, r5\n\t"
        "smlawb r1, %[w3], r2, r1\n\t"
        "ldr r2, [%[row_weight]], #4\n\t"
        "smmlar %[a], r1, r2, %[a]\n\t"
        "smmlar %[b], r5, r2, %[b]"
        : [a] "+r"(a), [b] "+r"(b), [row_weight] "+r"(row_weight_q31)
        : [residuals] "r"(residuals), [w0] "r"(w0), [w1] "r"(w1), [w2] "r"(w2),
          [w3] "r"(w3), [size] "i"(RG_NARROW_POINT_SIZE)
        : "r1", "r2", "r5", "memory");
    residuals += RG_NARROW_POINT_SIZE * columns;
  } while (rg_next_iteration(&columns));
  sums[0] = a;
  sums[1] = b;
}

/* rg_add_line_row_in_c(). */
static RG_INLINE const uint8_t* rg_add_line_row_in_thumb2(
    const uint8_t* points, const int32_t w_q31[4],
    const int32_t** row_weight_q31, int32_t sums_q26[3]) {
  int32_t x, y, z, w0, w1;
  __asm__(
      "ldmia %[points]!, {r0, r1, r2}\n\t"
      "ldrd %[w0], %[w1], %[first_weights]\n\t"
      "smmulr %[x], r0, %[w0]\n\t"
      "smmulr %[y], r1, %[w0]\n\t"
      "smmulr %[z], r2, %[w0]\n\t"
      "ldmia %[points]!, {r0, r1, r2}\n\t"
      "smmlar %[x], r0, %[w1], %[x]\n\t"
      "smmlar %[y], r1, %[w1], %[y]\n\t"
      "smmlar %[z], r2, %[w1], %[z]\n\t"
      "ldmia %[points]!, {r0, r1, r2}\n\t"
      "ldrd %[w0], %[w1], %[last_weights]\n\t"
      "smmlar %[x], r0, %[w0], %[x]\n\t"
      "smmlar %[y], r1, %[w0], %[y]\n\t"
      "smmlar %[z], r2, %[w0], %[z]\n\t"
      "ldmia %[points], {r0, r1, r2}\n\t"
      "smmlar %[x], r0, %[w1], %[x]\n\t"
      "smmlar %[y], r1, %[w1], %[y]\n\t"
      "smmlar %[z], r2, %[w1], %[z]\n\t"
      "ldr %[w0], [%[row_weight]], #4\n\t"
      "smmlar %[sum_x], %[x], %[w0], %[sum_x]\n\t"
      "smmlar %[sum_y], %[y], %[w0], %[sum_y]\n\t"
      "smmlar %[sum_z], %[z], %[w0], %[sum_z]"
      : [points] "+r"(points), [row_weight] "+r"(*row_weight_q31),
        [sum_x] "+r"(sums_q26[0]), [sum_y] "+r"(sums_q26[1]),
        [sum_z] "+r"(sums_q26[2]), [x] "=&r"(x), [y] "=&r"(y), [z] "=&r"(z),
        [w0] "=&r"(w0), [w1] "=&r"(w1)
      : [first_weights] "m"(*(const int32_t(*)[2])w_q31),
        [last_weights] "m"(*(const int32_t(*)[2])(w_q31 + 2)),
        "m"(**row_weight_q31),
        "m"(*(const uint8_t(*)[4 * RG_LINE_POINT_SIZE]) points)
      : "r0", "r1", "r2");
  return points;
}

#endif /* RG_ROWS_IN_ASSEMBLER */

#endif /* RAYGRID_GRID_ROWS_THUMB2_H */
