/* The corners of tiles on Cortex-M with the DSP extension, optimized for size.
 */
#include "cortex_m/tile_corners.h"

#if RG_CORNERS_IN_ASSEMBLER

#include <stddef.h>

/* formats/SPEC.md, "Bends", with t = k / 2^n and bends times 2^n:
 *     along(A, Z, b, t) = A + round(t (Z - A + b (1 - t)))
 * r7 may be the frame pointer. */
void rg_next_tile_in_thumb2(rg_tile_row* tiles, rg_position corners[4]) {
  /* Spilled to the stack: no registers are left. */
  rg_tile_row* kept = tiles;
  rg_position* corner = corners;
  register rg_tile_row* r0 __asm__("r0") = tiles;
  __asm__ volatile(
      /* r10: bytes from a vertex to the one below */
      "ldr r10, [r0, %[row_size]]\n\t"
      /* r12: t along the vertical axis in q16 */
      "ldrh r12, [r0, %[down]]\n"
      /* Outer loop: line above the tile, then below it; inner loop: r6 = 1 for
       * y, then r6 = 0 for x */
      "2:\n\t"
      "movs r6, #1\n"
      "3:\n\t"
      /* r9: row_step; r8: origin + i column_step + j row_step; r11: r8 +
       * column_step */
      "ldr r4, %[walk]\n\t"
      "ldr r2, [r4]\n\t"
      "add r2, r2, r6, lsl #2\n\t"
      "ldr r0, [r2, %[origin]]\n\t"
      "ldr r1, [r2, %[column_step]]\n\t"
      "mov r11, r1\n\t"
      "ldrh r3, [r4, %[across] + 2]\n\t"
      "mla r0, r1, r3, r0\n\t"
      "ldrh r3, [r4, %[down] + 2]\n\t"
      "ldr r9, [r2, %[row_step]]\n\t"
      "mla r8, r9, r3, r0\n\t"
      "add r11, r8\n\t"
      /* r8: left, r11: right */
      "ldr r5, [r4, %[block]]\n\t"
      "adds r5, r6\n\t"
      "lsl r3, r12, #14\n\t"
      "bl 4f\n\t"
      "add r8, r4\n\t"
      "ldr r4, %[walk]\n\t"
      "ldrb r4, [r4, %[vertex_size]]\n\t"
      "adds r5, r4\n\t"
      "bl 4f\n\t"
      "add r11, r4\n\t"
      /* If a block is one tile wide, this line is complete. */
      "ldr r4, %[walk]\n\t"
      "ldrb r2, [r4, %[num_log2]]\n\t"
      "cmp r2, #2\n\t"
      "beq 6f\n\t"
      /* bend = along(h10, h11, 0, t); the third argument may be 1 instead of 0,
       * since t or floor(1 - t) is 0 */
      "movs r2, %[hx]\n\t"
      "ldrsb r0, [r5, r2]\n\t"
      "add r5, r10\n\t"
      "ldrsb r1, [r5, r2]\n\t"
      "ldr r5, %[walk]\n\t"
      "ldrb r4, [r5, %[bend_shift]]\n\t"
      "lsls r0, r4\n\t"
      "lsls r1, r4\n\t"
      "bl 5f\n\t"
      /* along(left, right, bend, t) at the start and at the end of the tile */
      "mov r0, r8\n\t"
      "mov r1, r11\n\t"
      "ldrb r2, [r5, %[num_log2]]\n\t"
      "lsl r2, r4, r2\n\t"
      "ldrh r3, [r5, %[across]]\n\t"
      "lsls r3, r3, #14\n\t"
      "bl 5f\n\t"
      "mov r8, r4\n\t"
      "ldr r5, [r5, %[across] + 4]\n\t"
      "add r3, r3, r5, lsl #14\n\t"
      "bl 5f\n\t"
      "mov r11, r4\n"
      "6:\n\t"
      "ldr r5, %[corner]\n\t"
      "add r5, r5, r6, lsl #2\n\t"
      "str r8, [r5]\n\t"
      "str r11, [r5, #8]\n\t"
      "subs r6, #1\n\t"
      "bpl 3b\n\t"
      "adds r5, #16\n\t"
      "str r5, %[corner]\n\t"
      /* Repeat unless this was the line below the tile. */
      "ldr r0, %[walk]\n\t"
      "ldrh r1, [r0, %[down]]\n\t"
      "ldr r2, [r0, %[down] + 4]\n\t"
      "cmp r12, r1\n\t"
      "add r12, r2\n\t"
      "beq 2b\n\t"
      "b 7f\n"
      /* Subroutine: r4 = along(P0, P1, v1, t) without the plane, for the vertex
       * at r5 - r6 */
      "4:\n\t"
      "ldrsh r0, [r5, r6]\n\t"
      "add r4, r5, r10\n\t"
      "ldrsh r1, [r4, r6]\n\t"
      "ldrsb r2, [r4, %[vx]]\n\t"
      "ldr r4, %[walk]\n\t"
      "ldrh r4, [r4, %[bend_shift]]\n\t"
      "lsls r2, r4\n\t"
      "lsrs r4, r4, #8\n\t"
      "lsls r2, r4\n\t"
      "ldr r4, %[walk]\n\t"
      "ldr r4, [r4]\n\t"
      "ldrb r4, [r4, %[residual_shift]]\n\t"
      "lsls r0, r4\n\t"
      "lsls r1, r4\n\t"
      "add r1, r9\n"
      /* Subroutine: r4 = along(r0, r1, r2 / 4, r3), t in q30 */
      "5:\n\t"
      "rsb r4, r3, #0x40000000\n\t"
      "smmla r4, r4, r2, r1\n\t"
      "subs r4, r0\n\t"
      "lsls r4, r4, #2\n\t"
      "smmlar r4, r4, r3, r0\n\t"
      "bx lr\n"
      "7:"
      : [walk] "+m"(kept), [corner] "+m"(corner), "+r"(r0)
      : [block] "i"(offsetof(rg_tile_row, block)),
        [row_size] "i"(offsetof(rg_tile_row, row_size)),
        [vertex_size] "i"(offsetof(rg_tile_row, vertex_size)),
        [bend_shift] "i"(offsetof(rg_tile_row, bend_shift)),
        [num_log2] "i"(offsetof(rg_tile_row, num_log2)),
        [across] "i"(offsetof(rg_tile_row, extents)),
        [down] "i"(offsetof(rg_tile_row, extents) + sizeof(rg_tile_extent)),
        [residual_shift] "i"(RG_REMAP_RESIDUAL_SHIFT),
        [origin] "i"(RG_REMAP_ORIGIN), [column_step] "i"(RG_REMAP_COLUMN_STEP),
        [row_step] "i"(RG_REMAP_ROW_STEP), [hx] "i"(RG_VERTEX_HX),
        [vx] "i"(RG_VERTEX_VX)
      : "r1", "r2", "r3", "r4", "r5", "r6", "r8", "r9", "r10", "r11", "r12",
        "lr", "cc", "memory");
  r0->extents[0].before += r0->extents[0].size;
}

#endif
