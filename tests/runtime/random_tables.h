/* Random remap tables, and memory of exactly some bytes: where there are pages,
 * one that cannot be read begins where the memory ends, or ends where it
 * begins. Programs define _GNU_SOURCE on Linux, for these. */
#ifndef RAYGRID_RANDOM_TABLES_H
#define RAYGRID_RANDOM_TABLES_H

#include <stdlib.h>
#include <string.h>

#include "blob_checks.h"
#include "raygrid.h"
#include "rg_blob.h"
#include "test_frame.h"
#include "unit_test.h"

#if defined(__linux__)
#include <sys/mman.h>
#include <unistd.h>
#endif

#define MAX_SIZE 120u

static uint32_t state;

static inline uint32_t below(uint32_t limit) {
  return (next_random(&state) >> 8) % limit;
}

static inline int32_t between(int32_t low, int32_t high) {
  return low + (int32_t)below((uint32_t)(high - low) + 1);
}

/* ---- Random tables ------------------------------------------------------- */

static uint32_t section_words[4096];
#define SECTION ((uint8_t*)section_words)

static rg_camera camera;

/* The affine part has these steps a pixel, in q12, and the residuals shake it.
 */
typedef struct table_style {
  int32_t min_x, max_x, min_y, max_y, shake;
} table_style;

static const table_style kStyles[] = {
    {3700, 4500, 0, 200, 300},     /* as a mild lens */
    {2000, 7900, 0, 500, 2000},    /* as a wide one */
    {4096, 4096, 0, 0, 0},         /* none but a shift */
    {1000, 9000, 0, 1300, 8000},   /* too steep for one window or another */
    {8180, 8192, 0, 500, 8},       /* about at the limits of the windows */
    {2000, 4500, 583, 587, 8},     /* likewise */
    {2000, 4500, 1362, 1368, 8},   /* likewise */
    {-20, 4500, 4090, 4098, 8},    /* likewise */
    {-5000, 5000, 0, 5000, 4000},  /* turned and mirrored */
    {-9000, 9000, 0, 9000, 32767}, /* broken */
};
#define NUM_STYLES (sizeof(kStyles) / sizeof(kStyles[0]))

static inline uint16_t random_size(uint32_t multiple) {
  return (uint16_t)(multiple * (1 + below(MAX_SIZE / multiple)));
}

/* Sizes are multiples of what the format wants. */
static inline int make_table(uint32_t style_index, uint32_t size_multiple) {
  static int16_t residuals[2 * 32 * 32];
  static int8_t bends[4 * 32 * 32];
  static uint8_t empty[128];
  const table_style* const style = &kStyles[style_index];
  rg_remap_section table;
  memset(&table, 0, sizeof(table));
  memset(&camera, 0, sizeof(camera));
  camera.frame_width = random_size(size_multiple);
  camera.frame_height = random_size(size_multiple);
  table.width = random_size(size_multiple);
  table.height = random_size(size_multiple);
  table.block_log2 = (uint8_t)(3 + below(3));
  if (below(2) != 0) {
    table.block_log2 = (uint8_t)(4 + below(3));
    table.part_log2 = (uint8_t)(3 + below(table.block_log2 - 3u));
    table.bend_shift = (uint8_t)below(style->shake > 20000 ? 11 : 6);
  }
  table.columns = (uint16_t)(((table.width - 1) >> table.block_log2) + 2);
  table.rows = (uint16_t)(((table.height - 1) >> table.block_log2) + 2);
  const int32_t last_x = (camera.frame_width - 1) << 12;
  const int32_t last_y = (camera.frame_height - 1) << 12;
  table.max_x_q12 = last_x;
  table.max_y_q12 = last_y;
  if (below(2) != 0) { /* a calibrated area within the image */
    table.min_x_q12 = between(0, last_x);
    table.max_x_q12 = between(table.min_x_q12, last_x);
    table.min_y_q12 = between(0, last_y / 2);
    table.max_y_q12 = between(table.min_y_q12, last_y);
    /* a range without positions of the components of half as many pixels */
    if (below(4) == 0) table.max_x_q12 = table.min_x_q12;
    if (below(4) == 0) table.max_y_q12 = table.min_y_q12;
  }
  const int32_t block = 1 << table.block_log2;
  table.column_step_x_q12 = block * between(style->min_x, style->max_x);
  table.column_step_y_q12 =
      block * between(style->min_y, style->max_y) * (below(2) == 0 ? 1 : -1);
  table.row_step_x_q12 = block * between(-style->max_y, style->max_y);
  table.row_step_y_q12 = block * between(style->min_x, style->max_x);
  table.origin_x_q12 = between(-100000, 100000);
  table.origin_y_q12 = between(-100000, 100000);
  table.fx_q16 = table.fy_q16 = 1;
  if (style->shake > 20000) table.residual_shift = (uint8_t)below(9);
  for (uint32_t k = 0; k < 2u * table.columns * table.rows; ++k)
    residuals[k] = (int16_t)between(-style->shake, style->shake);
  for (uint32_t k = 0; k < 4u * table.columns * table.rows; ++k)
    bends[k] = (int8_t)between(-128, 127);
  table.bends = bends;
  memset(empty, 0, sizeof(empty));
  const uint32_t num_blocks = (table.columns - 1u) * (table.rows - 1u);
  for (uint32_t k = 0; k < num_blocks; ++k)
    if (below(16) == 0) empty[k / 8] = (uint8_t)(empty[k / 8] | 1u << k % 8);
  table.empty_blocks = empty;
  const uint32_t size = rg_remap_section_size(&table);
  assert_true(size <= sizeof(section_words));
  rg_write_remap(&table, residuals, SECTION);
  camera.remap = SECTION;
  const uint32_t source_size =
      camera.frame_width | (uint32_t)camera.frame_height << 16;
  return rg_check_remap(SECTION, size, source_size) == 0 &&
         rg_check_vertices(SECTION, rg_find_vertices(SECTION)) == 0;
}

/* ---- Memory of exactly some bytes ---------------------------------------- */

typedef struct exact_memory {
  uint8_t* bytes;
  void* pages;
  size_t num_pages_bytes;
} exact_memory;

static inline exact_memory new_memory(size_t size) {
  exact_memory memory = {NULL, NULL, 0};
#if defined(__linux__) && !defined(RAYGRID_SANITIZED)
  const size_t page = (size_t)sysconf(_SC_PAGESIZE);
  const size_t inner = (size + page - 1) / page * page;
  memory.num_pages_bytes = inner + 2 * page;
  memory.pages = mmap(NULL, memory.num_pages_bytes, PROT_NONE,
                      MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  assert_true(memory.pages != MAP_FAILED);
  uint8_t* const first = (uint8_t*)memory.pages + page;
  assert_int_equal(mprotect(first, inner, PROT_READ | PROT_WRITE), 0);
  memory.bytes = below(2) == 0 ? first : first + inner - size;
#else
  memory.bytes = malloc(size);
  assert_non_null(memory.bytes);
#endif
  return memory;
}

static inline void free_memory(const exact_memory* memory) {
#if defined(__linux__)
  if (memory->pages) {
    munmap(memory->pages, memory->num_pages_bytes);
    return;
  }
#endif
  free(memory->bytes);
}

#endif /* RAYGRID_RANDOM_TABLES_H */
