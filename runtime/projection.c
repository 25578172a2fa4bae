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
    const int32_t low = camera->axes[c].low;
    const int32_t high = low + (int32_t)camera->axes[c].span;
    const int32_t before = pixel_q16[c];
    const int32_t after = before < low ? low : before > high ? high : before;
    if (rg_magnitude(before - after) > tolerance_q16) return 0;
    pixel_q16[c] = after;
  }
  return 1;
}

/* A step of Newton's method is what the inverse grid changes by where its
 * argument changes by the surface's error. */
static int solve(const rg_camera* camera, const rg_chart_point* target,
                 int32_t pixel_q16[2]) {
  const uint8_t* const inverse = camera->blob + camera->inverse;
  rg_chart_point argument = *target;
  int32_t last_q16[2];
  if (!rg_find_pixel(inverse, &argument, last_q16)) return 0;
  pixel_q16[0] = last_q16[0];
  pixel_q16[1] = last_q16[1];
  for (uint32_t limit_q16 = FIRST_STEP_Q16; limit_q16 >= LAST_STEP_Q16;
       limit_q16 >>= 2) {
    rg_place place;
    int32_t next_q16[2];
    if (!move_inside(camera, limit_q16, pixel_q16)) return 0;
    rg_find_place(camera, pixel_q16[0], pixel_q16[1], &place);
    for (uint32_t c = 0; c < 2; ++c)
      argument.q27[c] += target->q27[c] - place.position.q27[c];
    if (!rg_find_pixel(inverse, &argument, next_q16)) return 0;
    uint32_t size_q16 = 0;
    for (uint32_t c = 0; c < 2; ++c) {
      const int32_t step_q16 = next_q16[c] - last_q16[c];
      size_q16 |= rg_magnitude(step_q16);
      last_q16[c] = next_q16[c];
      pixel_q16[c] = (int32_t)((uint32_t)pixel_q16[c] + (uint32_t)step_q16);
    }
    if (size_q16 < LAST_STEP_Q16)
      return move_inside(camera, EDGE_TOLERANCE_Q16, pixel_q16);
    if (size_q16 > limit_q16) return 0;
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
