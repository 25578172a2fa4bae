/* The assembler of runtime/cortex_m/ gives the bits of the C code beside it, on
 * random input. Skipped on processors without it. */
#if defined(__linux__)
#define _GNU_SOURCE
#endif
#include <stdio.h>

#include "cortex_m/grey_rows.h"
#include "cortex_m/grid_rows.h"
#include "cortex_m/tile_corners.h"
#include "random_tables.h"

#define NUM_CASES 2000u
#define SIZE 64u

/* ---- Rows of grids ------------------------------------------------------- */

#if RG_ROWS_IN_ASSEMBLER

static uint32_t words[4 * SIZE * 4];

static int32_t random_bits(void) { return (int32_t)next_random(&state); }

static void fill_words(void) {
  for (uint32_t k = 0; k < sizeof(words) / sizeof(words[0]); ++k)
    words[k] = (uint32_t)random_bits();
}

static void fill_weights(int32_t weights_q31[2][4]) {
  for (uint32_t k = 0; k < 8; ++k) weights_q31[k / 4][k % 4] = random_bits();
}

static void check_sums(const int32_t* a, const int32_t* b, uint32_t num) {
  for (uint32_t c = 0; c < num; ++c) assert_int_equal(a[c], b[c]);
}

static void rows_of_grids_have_the_same_sums(void** unused) {
  (void)unused;
  state = 1;
  const uint8_t* const points = (const uint8_t*)words;
  for (uint32_t k = 0; k < NUM_CASES; ++k) {
    int32_t weights[2][4], a[3] = {0, 0, 0}, b[3] = {0, 0, 0};
    const uint32_t columns = 4 + below(SIZE / 2 - 4);
    fill_words();
    fill_weights(weights);
    rg_sum_points_in_c(points, columns, weights, a);
    rg_sum_points_in_thumb2(points, columns, weights, b);
    check_sums(a, b, 2);

    const int32_t half = 1 << below(12);
    rg_sum_residuals_in_c(points, columns, half, weights, a);
    rg_sum_residuals_in_thumb2(points, columns, half, weights, b);
    check_sums(a, b, 2);

    const int32_t* weight_of_a = weights[1];
    const int32_t* weight_of_b = weights[1];
    for (uint32_t c = 0; c < 3; ++c) a[c] = b[c] = random_bits();
    assert_ptr_equal(
        rg_add_line_row_in_c(points, weights[0], &weight_of_a, a),
        rg_add_line_row_in_thumb2(points, weights[0], &weight_of_b, b));
    assert_ptr_equal(weight_of_a, weight_of_b);
    check_sums(a, b, 3);
  }
}

#else

static void rows_of_grids_have_the_same_sums(void** unused) {
  (void)unused;
  skip(); /* no DSP extension, or not GCC: RG_ROWS_IN_ASSEMBLER */
}

#endif

/* ---- Corners of tiles ---------------------------------------------------- */

#if RG_CORNERS_IN_ASSEMBLER

static void check_row(uint32_t log2, uint32_t j, uint32_t num_parts) {
  rg_tile_row a, b;
  memset(&a, 0, sizeof(a));
  rg_init_tile_row(SECTION, log2, log2, j, &a);
  b = a;
  for (uint32_t k = 0; k < num_parts; ++k) {
    rg_position in_c[4], in_thumb2[4];
    rg_find_tile_block(&a, 0);
    rg_next_tile_in_c(&a, in_c);
    rg_find_tile_block(&b, 0);
    rg_next_tile_in_thumb2(&b, in_thumb2);
    assert_memory_equal(in_c, in_thumb2, sizeof(in_c));
    assert_int_equal(a.extents[0].before, b.extents[0].before);
  }
}

static void corners_of_parts_are_the_same(void** unused) {
  (void)unused;
  uint32_t num_checked = 0;
  for (uint32_t k = 0; k < NUM_CASES / 10; ++k) {
    state = 777 + 31 * k;
    if (!make_table(k % NUM_STYLES, 1)) continue;
    const uint32_t part = SECTION[RG_REMAP_PART_LOG2];
    const uint32_t log2 = part != 0 ? part : SECTION[RG_REMAP_BLOCK_LOG2];
    const uint32_t height = rg_load_u16(SECTION + RG_REMAP_HEIGHT);
    const uint32_t width = rg_load_u16(SECTION + RG_REMAP_WIDTH);
    for (uint32_t j = 0; j << log2 < height; ++j)
      check_row(log2, j, ((width - 1) >> log2) + 1);
    ++num_checked;
  }
  printf("%u tables\n", (unsigned)num_checked);
  assert_true(num_checked > NUM_CASES / 40);
}

#else

static void corners_of_parts_are_the_same(void** unused) {
  (void)unused;
  skip(); /* no such assembler here: RG_CORNERS_IN_ASSEMBLER */
}

#endif

/* ---- Rows of grey pixels ------------------------------------------------- */

#if RG_GREY_ROW_IN_ASSEMBLER

static uint8_t source[SIZE * SIZE];

static int32_t random_place(void) {
  return between(2 << 12, (int32_t)(SIZE - 4) << 12);
}

/* A part of 32 x 32 pixels or less, all of which have their neighbours in the
 * source. */
static rg_span random_run(void) {
  rg_span span;
  memset(&span, 0, sizeof(span));
  span.block.width_log2 = (uint8_t)(3 + below(3));
  span.block.height_log2 = (uint8_t)(3 + below(3));
  const uint32_t height = 1u << span.block.height_log2;
  span.first_row = (uint16_t)below(height);
  span.num_rows = (uint16_t)(1 + below(height - span.first_row));
  span.num_pixels = (uint16_t)(1 + below(1u << span.block.width_log2));
  span.data = source;
  span.stride = SIZE;
  span.out_stride = 33 + below(7);
  for (uint32_t k = 0; k < 4; ++k)
    for (int c = 0; c < 2; ++c) span.block.corners[k].q12[c] = random_place();
  return span;
}

static rg_grey_rows start_rows(rg_span* span, uint32_t rounding) {
  rg_grey_rows rows;
  rows.corners = span->block.corners;
  rows.rounding = rounding;
  rows.rest = span->num_rows;
  rows.out = span->out;
  rg_start_edges(span, rows.corners->q12, (uint32_t*)rows.corners->q12);
  return rows;
}

static void check_blended_rows(const rg_span* span) {
  static uint8_t in_c[40 * 40], in_thumb2[40 * 40];
  rg_span a = *span, b = *span;
  rg_block_row row;
  memset(in_c, 0xc3, sizeof(in_c));
  memset(in_thumb2, 0xc3, sizeof(in_thumb2));
  a.out = in_c;
  b.out = in_thumb2;
  rg_grey_rows rows_of_a = start_rows(&a, rg_first_rounding_in_c(&a));
  assert_int_equal(rg_process_grey_rows_in_c(&rows_of_a, &row), 0);
  rg_grey_rows rows_of_b = start_rows(&b, rg_pack_rounding_and_count(&b));
  assert_int_equal(rg_process_grey_rows_in_thumb2(&rows_of_b, &row), 0);
  assert_memory_equal(in_c, in_thumb2, sizeof(in_c));
  assert_int_equal(rows_of_a.out - in_c, rows_of_b.out - in_thumb2);
}

static void check_found_rows(const rg_span* span) {
  rg_span a = *span, b = *span;
  rg_grey_rows rows_of_a = start_rows(&a, 0), rows_of_b = start_rows(&b, 0);
  for (uint32_t r = 0; r < span->num_rows; ++r) {
    rg_block_row in_c, in_thumb2;
    assert_int_equal(rg_process_grey_rows_in_c(&rows_of_a, &in_c), 1);
    assert_int_equal(rg_process_grey_rows_in_thumb2(&rows_of_b, &in_thumb2), 1);
    assert_memory_equal(&in_c, &in_thumb2, sizeof(in_c));
  }
}

static void rows_of_grey_pixels_are_the_same(void** unused) {
  (void)unused;
  state = 4711;
  for (uint32_t k = 0; k < sizeof(source); ++k)
    source[k] = (uint8_t)(below(3) == 0 ? 255 * below(2) : below(256));
  for (uint32_t k = 0; k < NUM_CASES; ++k) {
    const rg_span span = random_run();
    check_blended_rows(&span);
    check_found_rows(&span);
  }
}

#else

static void rows_of_grey_pixels_are_the_same(void** unused) {
  (void)unused;
  skip(); /* no such assembler here: RG_GREY_ROW_IN_ASSEMBLER */
}

#endif

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(rows_of_grids_have_the_same_sums),
      cmocka_unit_test(corners_of_parts_are_the_same),
      cmocka_unit_test(rows_of_grey_pixels_are_the_same)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
