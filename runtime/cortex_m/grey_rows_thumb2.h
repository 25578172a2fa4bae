/* Rows of a span of grey pixels for Thumb-2 with the DSP extension, in
 * assembly, because compilers do not keep the values of a row in registers:
 * cortex_m/grey_rows.h. */
#ifndef RAYGRID_GREY_ROWS_THUMB2_H
#define RAYGRID_GREY_ROWS_THUMB2_H

#include <stddef.h>

#include "cortex_m/grey_rows_c.h"

#if RG_GREY_ROW_IN_ASSEMBLER
/* x is mirrored, 4079 - x = 4095 - (x + 16): its fraction is the weight of the
 * left samples less one. upper is data + row stride + column; then
 *   pixels = upper[0], upper[1], lower[0], lower[1]
 *   right = upper[1], lower[1] as halves; left - right = pixels - 257 right
 *   h = (left - right) (fraction + 1) + 128 right, both rows at once
 *   weights = 4096 - wy, wy as halves = 65535 wy + 4096 */
#define RG_BLEND_PIXEL          \
  "lsrs r7, r1, #12\n\t"        \
  "mla r7, r5, r7, r4\n\t"      \
  "sub r7, r7, r0, asr #12\n\t" \
  "ldrh ip, [r7, r5]\n\t"       \
  "ldrh r7, [r7]\n\t"           \
  "orr r7, r7, ip, lsl #16\n\t" \
  "uxtb16 ip, r7, ror #8\n\t"   \
  "mls r7, ip, r11, r7\n\t"     \
  "ubfx lr, r0, #5, #7\n\t"     \
  "add ip, r7, ip, lsl #7\n\t"  \
  "mla ip, r7, lr, ip\n\t"      \
  "ubfx r7, r1, #0, #12\n\t"    \
  "mla r7, r7, r9, r10\n\t"     \
  "smlad r7, ip, r7, r8\n\t"    \
  "lsrs r7, r7, #19\n\t"        \
  "strb r7, [r6], #1\n\t"       \
  "subs r0, r0, r2\n\t"         \
  "adds r1, r1, r3\n\t"

/* Offset of a field of rg_span from block.corners, in bytes. */
#define RG_FROM_CORNERS(field) \
  ((int)offsetof(rg_span, field) - (int)offsetof(rg_span, block.corners))

/* A row of n pixels takes ceil(n / 2) iterations, counted in bits 31..28. Bit
 * 27 is set if n is odd; the first iteration then writes one pixel only. */
static RG_INLINE uint32_t rg_pack_rounding_and_count(const rg_span* span) {
  return RG_ROUNDING_8 - ((uint32_t)span->num_pixels << 27);
}

static RG_INLINE int rg_process_grey_rows_in_thumb2(rg_grey_rows* rows,
                                                    rg_block_row* row) {
  register int32_t x __asm__("r0");
  register int32_t y __asm__("r1");
  register int32_t step_x __asm__("r2");
  register int32_t step_y __asm__("r3");
  __asm__ goto(
      /* edges of this row, and of the row below */
      "0:\n\t"
      "ldr lr, %[corners]\n\t"
      "ldm lr, {r0-r7}\n\t"
      "adds r4, r4, r0\n\t"
      "adds r5, r5, r1\n\t"
      "adds r6, r6, r2\n\t"
      "adds r7, r7, r3\n\t"
      "stm lr, {r4-r7}\n\t"
      /* start and step of the row */
      "ldrb r4, [lr, %[height_log2]]\n\t"
      "asrs r0, r0, r4\n\t"
      "asrs r1, r1, r4\n\t"
      "asrs r2, r2, r4\n\t"
      "asrs r3, r3, r4\n\t"
      "ldrb r4, [lr, %[width_log2]]\n\t"
      "subs r2, r2, r0\n\t"
      "subs r3, r3, r1\n\t"
      "asrs r2, r2, r4\n\t"
      "adc r2, r2, #0\n\t" /* the last bit that was shifted out */
      "asrs r3, r3, r4\n\t"
      "adc r3, r3, #0\n\t"
      "ldr r8, %[rounding]\n\t"
      "lsls r7, r8, #4\n\t"
      "beq %l[is_apart]\n\t"
      /* blending of the pixels */
      "movw r4, #4079\n\t"
      "sub r0, r4, r0\n\t"
      "ldr r6, %[out]\n\t"
      "ldr r7, [lr, %[out_stride]]\n\t"
      "add r7, r6\n\t"
      "str r7, %[out]\n\t"
      "ldrd r4, r5, [lr, %[data]]\n\t"
      "movw r9, #65535\n\t"
      "mov r10, #4096\n\t"
      "movw r11, #257\n\t"
      "bmi 2f\n"
      "1:\n\t" RG_BLEND_PIXEL "2:\n\t" RG_BLEND_PIXEL
      "adds r8, r8, #0x10000000\n\t"
      "bcc 1b\n\t"
      "ldr r7, %[rest]\n\t"
      "subs r7, r7, #1\n\t"
      "str r7, %[rest]\n\t"
      "bne 0b"
      : "=&r"(x), "=&r"(y), "=&r"(step_x),
        "=&r"(step_y), [rest] "+m"(rows->rest), [out] "+m"(rows->out)
      : [corners] "m"(rows->corners), [rounding] "m"(rows->rounding),
        [height_log2] "i"(RG_FROM_CORNERS(block.height_log2)),
        [width_log2] "i"(RG_FROM_CORNERS(block.width_log2)),
        [data] "i"(RG_FROM_CORNERS(data)),
        [out_stride] "i"(RG_FROM_CORNERS(out_stride))
      : "r4", "r5", "r6", "r7", "r8", "r9", "r10", "r11", "ip", "lr", "cc",
        "memory"
      : is_apart);
  return 0;
is_apart:
  row->start.q12[0] = x;
  row->start.q12[1] = y;
  row->step.q12[0] = step_x;
  row->step.q12[1] = step_y;
  return 1;
}

#endif /* RG_GREY_ROW_IN_ASSEMBLER */

#endif /* RAYGRID_GREY_ROWS_THUMB2_H */
