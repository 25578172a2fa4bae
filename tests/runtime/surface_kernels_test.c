/* rg_evaluate_spline_avx2() and rg_compute_jacobian_avx2() have the bits of the
 * portable code: grids with any control points, even such that no camera has.
 */
#include <string.h>

#include "rays/surface_choice.h"
#include "rg_blob.h"
#include "test_frame.h"
#include "unit_test.h"

#define COLUMNS 7u
#define ROWS 6u
#define SIZE_Q16 ((int32_t)(100u << 16))
#define POINTS 40u /* where wide control points begin */
#define NUM_GRIDS 200
#define NUM_PLACES 200

#if RG_SELECT_SURFACE

/* The control points end where it does. */
typedef struct random_grid {
  uint8_t bytes[POINTS + 8 * COLUMNS * ROWS] __attribute__((aligned(4)));
} random_grid;

static random_grid make_grid(uint32_t fraction_bits, uint32_t* random) {
  random_grid grid;
  uint8_t* const p = grid.bytes;
  for (size_t k = 0; k < sizeof(grid.bytes); ++k)
    p[k] = (uint8_t)(next_random(random) >> 24);
  rg_store_u32(p, 0);
  rg_store_u32(p + 4, 0);
  rg_store_u32(p + 8, (uint32_t)SIZE_Q16);
  rg_store_u32(p + 12, (uint32_t)SIZE_Q16);
  rg_store_u16(p + 16, COLUMNS);
  rg_store_u16(p + 18, ROWS);
  rg_store_u32(p + 20, rg_grid_scale_q32(COLUMNS - 3, SIZE_Q16));
  rg_store_u32(p + 24, rg_grid_scale_q32(ROWS - 3, SIZE_Q16));
  rg_store_u16(p + 30, (uint16_t)fraction_bits);
  rg_store_u32(p + 32, fraction_bits == RG_CONTROL_POINT_BITS
                           ? POINTS
                           : sizeof(grid.bytes) - RG_NARROW_PLANE_SIZE -
                                 4 * COLUMNS * ROWS);
  return grid;
}

static void check_slopes(const uint8_t* inverse,
                         const rg_grid_position* place) {
  int32_t slopes_q5[2][2], expected_q5[2][2];
  rg_compute_jacobian_avx2(inverse, place, slopes_q5);
  rg_compute_jacobian(inverse, place, expected_q5);
  assert_memory_equal(slopes_q5, expected_q5, sizeof(slopes_q5));
}

static void check_places(const random_grid* grid, int is_narrow,
                         uint32_t* random) {
  for (int k = 0; k < NUM_PLACES; ++k) {
    /* A few outside, and the far corner. */
    const int32_t x =
        k == 0 ? SIZE_Q16 : (int32_t)(next_random(random) % 6700000u) - 50000;
    const int32_t y =
        k == 0 ? SIZE_Q16 : (int32_t)(next_random(random) % 6700000u) - 50000;
    rg_grid_position place, expected;
    memset(&place, 0, sizeof(place));
    memset(&expected, 0, sizeof(expected));
    const rg_status status = rg_evaluate_spline_avx2(grid->bytes, x, y, &place);
    assert_int_equal(status, rg_evaluate_spline(grid->bytes, x, y, &expected));
    assert_memory_equal(&place, &expected, sizeof(place));
    if (status == RG_OK && is_narrow) check_slopes(grid->bytes, &place);
  }
}

static void test_has_the_portable_bits(void** state) {
  uint32_t random = 3;
  (void)state;
  if (rg_select_surface() != RG_SURFACE_AVX2) skip(); /* no such processor */
  for (int k = 0; k < NUM_GRIDS; ++k) {
    const random_grid wide = make_grid(RG_CONTROL_POINT_BITS, &random);
    const uint32_t bits =
        RG_NARROW_MIN_BITS +
        next_random(&random) % (RG_NARROW_MAX_BITS - RG_NARROW_MIN_BITS + 1);
    const random_grid narrow = make_grid(bits, &random);
    check_places(&wide, 0, &random);
    check_places(&narrow, 1, &random);
  }
}

#else

static void test_has_the_portable_bits(void** state) {
  (void)state;
  skip(); /* AVX2 is x86-64's */
}

#endif

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_has_the_portable_bits)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
