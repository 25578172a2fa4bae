/* Former names of raygrid.h, which RAYGRID_NO_DEPRECATED removes. */
#include <stddef.h>

#include "raygrid.h"
#include "unit_test.h"

#if defined(RAYGRID_NO_DEPRECATED)

#if defined(rg_band) || defined(rg_frame) || defined(rg_set_condition) || \
    defined(rg_row_time) || defined(rg_choose_ray_kernels) ||             \
    defined(rg_choose_slot)
#error "RAYGRID_NO_DEPRECATED leaves deprecated names"
#endif

static void former_names_are_absent(void** state) { (void)state; }

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(former_names_are_absent)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}

#else

static void former_types_are_the_present_ones(void** state) {
  (void)state;
  const rg_frame frame = {NULL, 8, 7, 6};
  const rg_grey_image* const image = &frame;
  assert_int_equal(image->width, 7);
  const rg_band band = {NULL, 8, 5, 4, 3};
  const rg_grey_target* const target = &band;
  assert_int_equal(target->num_rows, 4);
}

static void former_functions_are_the_present_ones(void** state) {
  (void)state;
  rg_status (*const set)(rg_camera*, int32_t) = rg_set_condition;
  rg_status (*const get)(const rg_camera*, int32_t*, uint32_t*) = rg_row_time;
  rg_status (*const select)(rg_camera*, const char*) = rg_choose_ray_kernels;
  rg_status (*const find)(const void*, const void*, uint32_t, rg_slot*) =
      rg_choose_slot;
  assert_true(set == rg_set_operating_point);
  assert_true(get == rg_line_delay);
  assert_true(select == rg_select_ray_kernels);
  assert_true(find == rg_select_slot);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(former_types_are_the_present_ones),
      cmocka_unit_test(former_functions_are_the_present_ones),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

#endif
