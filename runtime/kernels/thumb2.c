/* The corners of a part on microcontrollers with the DSP extension, where size
 * matters: with the registers shared out by hand. */
#include "remap_table.h"

#if RG_CORNERS_IN_ASSEMBLER

#include <stddef.h>

/* The vertex above the part's left edge, and whether its block is marked. */
static RG_INLINE const uint8_t* find_vertex(rg_block_walk* walk,
                                            uint32_t vertex_size) {
  const uint8_t* const section = walk->section;
  const uint32_t columns = rg_load_u16(section + 4);
  const uint32_t j = walk->spans[1].before >> 16;
  const uint32_t vertex = j * columns + (walk->spans[0].before >> 16);
  const uint32_t mark = vertex - j;
  const uint8_t* const vertices = section + rg_load_u32(section + 76);
  const uint8_t* const marks =
      vertices + rg_load_u16(section + 6) * columns * vertex_size;
  walk->is_empty = (marks[mark >> 3] >> (mark & 7)) & 1;
  return vertices + vertex * vertex_size;
}

/* What is kept in memory meanwhile. */
typedef struct corner_search {
  rg_block_walk* walk;
  rg_position* corner; /* the left one of the row at hand */
  const uint8_t* above;
  uint32_t vertex_size, size, left;
} corner_search;

void rg_next_corners(rg_block_walk* walk, rg_position corners[4]) {
  const uint8_t* const section = walk->section;
  corner_search search;
  search.vertex_size = rg_vertex_size(section);
  search.walk = walk;
  search.corner = corners;
  search.above = find_vertex(walk, search.vertex_size);
  register uint32_t row_size __asm__("r7") = rg_load_u16(section + 4) * search.vertex_size;
  __asm__ volatile(
      /* r10, r11: shifts of residuals, of bends of edges down; r12: t, as
       * below; r7: size of a row */
      "ldr r0, %[walk]\n\t"
      "ldr r1, [r0]\n\t"
      "ldrb.w r10, [r1, #9]\n\t"
      "ldrb r1, [r0, %[bend_shift]]\n\t"
      "ldrb r2, [r0, %[num_log2]]\n\t"
      "adds r1, r2\n\t"
      "mov r11, r1\n\t"
      "ldrh r1, [r0, %[down]]\n\t"
      "lsls r1, #14\n\t"
      "mov r12, r1\n\t"
      "ldr r1, [r0, %[down] + 4]\n\t"
      "str r1, %[size]\n"
      /* For the line above the part and that below, and for y and x: */
      "1:\n\t"
      "movs r6, #1\n"
      "2:\n\t"
      /* r8 = origin + i column_step + j row_step, r9 = row_step */
      "ldr r4, %[walk]\n\t"
      "ldr r2, [r4]\n\t"
      "add r2, r2, r6, lsl #2\n\t"
      "ldrh r0, [r4, %[across] + 2]\n\t"
      "ldrh r1, [r4, %[down] + 2]\n\t"
      "ldr r3, [r2, #36]\n\t"
      "str r3, %[left]\n\t"
      "muls r0, r3\n\t"
      "ldr r3, [r2, #44]\n\t"
      "mov r9, r3\n\t"
      "muls r1, r3\n\t"
      "ldr r2, [r2, #28]\n\t"
      "adds r0, r1\n\t"
      "adds r0, r2\n\t"
      "mov r8, r0\n\t"
      /* left and right */
      "ldr r5, %[above]\n\t"
      "adds r5, r6\n\t"
      "mov r3, r12\n\t"
      "bl 3f\n\t"
      "ldr r0, %[left]\n\t"
      "add r8, r0\n\t"
      "str r4, %[left]\n\t"
      "ldr r4, %[vertex_size]\n\t"
      "adds r5, r4\n\t"
      "bl 3f\n\t"
      "mov r8, r4\n\t"
      /* bend = along(h10, h11, 0, t) */
      "ldr r4, %[walk]\n\t"
      "ldrb r4, [r4, %[bend_shift]]\n\t"
      "adds r5, #4\n\t"
      "ldrsb r0, [r5]\n\t"
      "ldrsb r1, [r5, r7]\n\t"
      "lsls r0, r4\n\t"
      "lsls r1, r4\n\t"
      "movs r2, #0\n\t"
      "bl 4f\n\t"
      /* corners */
      "ldr r5, %[walk]\n\t"
      "ldrb r2, [r5, %[num_log2]]\n\t"
      "lsl r2, r4, r2\n\t"
      "ldr r0, %[left]\n\t"
      "mov r1, r8\n\t"
      "ldrh r3, [r5, %[across]]\n\t"
      "ldr r4, [r5, %[across] + 4]\n\t"
      "adds r3, r4\n\t"
      "lsls r3, #14\n\t"
      "bl 4f\n\t"
      "ldrh r3, [r5, %[across]]\n\t"
      "ldr r5, %[corner]\n\t"
      "add r5, r5, r6, lsl #2\n\t"
      "str r4, [r5, #8]\n\t"
      "lsls r3, #14\n\t"
      "bl 4f\n\t"
      "str r4, [r5]\n\t"
      "subs r6, #1\n\t"
      "bpl 2b\n\t"
      /* The next row, if not all bits of the size are lost. */
      "adds r5, #16\n\t"
      "str r5, %[corner]\n\t"
      "ldr r1, %[size]\n\t"
      "lsls r1, #14\n\t"
      "str r1, %[size]\n\t"
      "add r12, r1\n\t"
      "bne 1b\n\t"
      "b 5f\n"
      /* An edge down */
      "3:\n\t"
      "ldrsh r0, [r5, r6]\n\t"
      "adds r4, r5, r7\n\t"
      "ldrsh r1, [r4, r6]\n\t"
      "ldrsb r2, [r4, #6]\n\t"
      "mov r4, r10\n\t"
      "lsls r0, r4\n\t"
      "lsls r1, r4\n\t"
      "add r0, r8\n\t"
      "add r1, r8\n\t"
      "add r1, r9\n\t"
      "lsl r2, r2, r11\n"
      /* r4 = along(r0, r1, r2 / 4, t) */
      "4:\n\t"
      "rsb r4, r3, #0x40000000\n\t"
      "smmla r4, r4, r2, r1\n\t"
      "subs r4, r0\n\t"
      "lsls r4, #2\n\t"
      "smmlar r4, r4, r3, r0\n\t"
      "bx lr\n"
      "5:"
      : [walk] "+m"(search.walk), [corner] "+m"(search.corner), [size] "=m"(search.size),
        [left] "=m"(search.left), "+r"(row_size)
      : [above] "m"(search.above), [vertex_size] "m"(search.vertex_size),
        [bend_shift] "i"(offsetof(rg_block_walk, bend_shift)),
        [num_log2] "i"(offsetof(rg_block_walk, num_log2)),
        [across] "i"(offsetof(rg_block_walk, spans)),
        [down] "i"(offsetof(rg_block_walk, spans) + sizeof(rg_span))
      : "r0", "r1", "r2", "r3", "r4", "r5", "r6", "r8", "r9", "r10", "r11",
        "r12", "lr", "cc", "memory");
  search.walk->spans[0].before += search.walk->spans[0].size;
}

#endif
