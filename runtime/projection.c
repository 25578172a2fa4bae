/* Direction -> pixel: what the inverse grid says, then Newton's method on the
 * spline surface with the inverse grid's derivative. Pairs are x, y. */
#include "bytes.h"
#include "fixed_point.h"
#include "surface.h"

/* The first step may be as long as this, and so far outside the area may the
 * start lie; each further step a quarter of that. */
#define FIRST_STEP_Q16 0x40000u /* 4 px */

/* A step below 1/16 px is the last: what remains is its product with the error
 * of the derivative. */
#define LAST_STEP_Q16 0x1000u

/* Rounding may lead out of the area by this: 0.002 px. */
#define EDGE_TOLERANCE_Q16 128u

/* Moves a pixel into the area; 0 if it lies farther outside. */
static int move_inside(const rg_camera* camera, uint32_t tolerance_q16,
                       int32_t pixel_q16[2]) {
  for (uint32_t c = 0; c < 2; ++c) {
    const rg_axis* const axis = &camera->axes[c];
    const uint32_t offset_q16 =
        (uint32_t)pixel_q16[c] - (uint32_t)axis->low;
    if (offset_q16 <= axis->span) continue;
    const int is_low = pixel_q16[c] < axis->low;
    if ((is_low ? 0 - offset_q16 : offset_q16 - axis->span) > tolerance_q16)
      return 0;
    pixel_q16[c] = axis->low + (is_low ? 0 : (int32_t)axis->span);
  }
  return 1;
}

/* A distance on one axis of the chart, in cells of an inverse grid with that
 * scale; 0 if it is a cell or more. */
static int cells_of(int32_t distance_q27, uint32_t scale, int32_t* cells_q31) {
  const int32_t sign = distance_q27 >> 31; /* branches are hard to predict */
  uint32_t low;
  const uint32_t high = rg_multiply_unsigned(
      (uint32_t)((distance_q27 ^ sign) - sign), scale, &low);
  *cells_q31 = ((int32_t)(high << 15 | low >> 17) ^ sign) - sign;
  return high >> 16 == 0;
}

/* Newton's method from where the inverse grid says, with its derivative. */
static int solve(const rg_camera* camera, const rg_chart_point* target,
                 int32_t pixel_q16[2]) {
  const uint8_t* const inverse = camera->blob + camera->inverse;
  rg_inverse_place start;
  if (!rg_find_inverse(inverse, target, &start)) return 0;
  pixel_q16[0] = start.pixel_q16[0];
  pixel_q16[1] = start.pixel_q16[1];
  for (uint32_t limit_q16 = FIRST_STEP_Q16; limit_q16 >= LAST_STEP_Q16;
       limit_q16 >>= 2) {
    rg_place place;
    int32_t step_q16[2] = {0, 0};
    if (!move_inside(camera, limit_q16, pixel_q16)) return 0;
    rg_find_place(camera, pixel_q16[0], pixel_q16[1], &place);
    for (uint32_t c = 0; c < 2; ++c) {
      int32_t cells_q31;
      if (!cells_of(target->q27[c] - place.position.q27[c],
                    rg_load_u32(inverse + 20 + 4 * c), &cells_q31))
        return 0;
      const int32_t* const by_cells_q17 = start.by_cells_q17[c];
      step_q16[0] =
          rg_multiply_high_add(step_q16[0], by_cells_q17[0], cells_q31);
      step_q16[1] =
          rg_multiply_high_add(step_q16[1], by_cells_q17[1], cells_q31);
    }
    const uint32_t size_q16 =
        rg_magnitude(step_q16[0]) | rg_magnitude(step_q16[1]);
    if (size_q16 > limit_q16) return 0;
    pixel_q16[0] += step_q16[0];
    pixel_q16[1] += step_q16[1];
    if (size_q16 < LAST_STEP_Q16)
      return move_inside(camera, EDGE_TOLERANCE_Q16, pixel_q16);
  }
  return 0;
}

rg_status rg_project(const rg_camera* camera, const rg_ray* direction,
                     rg_pixel* pixel) {
  rg_chart_point target;
  int32_t found_q16[2];
  if (camera->line_points) return RG_ERR_NONCENTRAL;
  if (!camera->inverse) return RG_ERR_NO_INVERSE;
  const int32_t limit_q30 = rg_load_i32(camera->blob + camera->inverse + 36);
  if (!rg_chart_point_of(direction, limit_q30, &target) ||
      !solve(camera, &target, found_q16))
    return RG_ERR_NOT_SEEN;
  pixel->x_q16 = found_q16[0];
  pixel->y_q16 = found_q16[1];
  return RG_OK;
}

uint32_t rg_project_batch(const rg_camera* camera, const rg_ray* directions,
                          rg_pixel* pixels, uint32_t num_points) {
  uint32_t num_seen = 0;
  for (uint32_t i = 0; i < num_points; ++i) {
    if (rg_project(camera, &directions[i], &pixels[i]) == RG_OK)
      ++num_seen;
    else
      pixels[i].x_q16 = pixels[i].y_q16 = RG_NO_PIXEL;
  }
  return num_seen;
}
