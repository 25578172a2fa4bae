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
    const uint32_t offset_q16 = (uint32_t)pixel_q16[c] - (uint32_t)axis->low;
    if (offset_q16 <= axis->span) continue;
    const int is_low = pixel_q16[c] < axis->low;
    const uint32_t beyond_q16 =
        is_low ? (uint32_t)axis->low - (uint32_t)pixel_q16[c]
               : offset_q16 - axis->span;
    if (beyond_q16 > tolerance_q16) return 0;
    pixel_q16[c] = rg_add(axis->low, is_low ? 0 : (int32_t)axis->span);
  }
  return 1;
}

/* A distance on one axis of the chart, in cells of an inverse grid with that
 * scale; 0 if it is a cell or more. */
static int cells_of(int32_t distance_q27, uint32_t scale, int32_t* cells_q31) {
  const int32_t sign = distance_q27 >> 31; /* branches are hard to predict */
  uint32_t low;
  const uint32_t high = rg_multiply_unsigned(
      (uint32_t)rg_subtract(distance_q27 ^ sign, sign), scale, &low);
  *cells_q31 = ((int32_t)(high << 15 | low >> 17) ^ sign) - sign;
  return high >> 16 == 0;
}

/* Newton's step at a pixel of the area, with the inverse grid's derivative. */
static RG_NOINLINE int find_step(const rg_camera* camera,
                                 const rg_chart_point* target,
                                 const rg_inverse_place* from,
                                 int32_t step_q16[2]) {
  const uint8_t* const inverse = camera->blob + camera->inverse;
  rg_place place;
  rg_find_place(camera, from->pixel_q16[0], from->pixel_q16[1], &place);
  step_q16[0] = step_q16[1] = 0;
  for (uint32_t c = 0; c < 2; ++c) {
    int32_t cells_q31;
    if (!cells_of(rg_subtract(target->q27[c], place.position.q27[c]),
                  rg_load_u32(inverse + 20 + 4 * c), &cells_q31))
      return 0;
    for (int k = 0; k < 2; ++k)
      step_q16[k] = rg_multiply_high_add(step_q16[k], from->by_cells_q17[c][k],
                                         cells_q31);
  }
  return 1;
}

/* Newton's method from where the inverse grid says; place ends at the pixel. */
static RG_INLINE int solve(const rg_camera* camera,
                           const rg_chart_point* target,
                           rg_inverse_place* place) {
  if (!rg_find_inverse(camera->blob + camera->inverse, target, place)) return 0;
  for (uint32_t limit_q16 = FIRST_STEP_Q16; limit_q16 >= LAST_STEP_Q16;
       limit_q16 >>= 2) {
    int32_t step_q16[2];
    if (!move_inside(camera, limit_q16, place->pixel_q16) ||
        !find_step(camera, target, place, step_q16))
      return 0;
    const uint32_t size_q16 =
        rg_magnitude(step_q16[0]) | rg_magnitude(step_q16[1]);
    if (size_q16 > limit_q16) return 0;
    for (int k = 0; k < 2; ++k)
      place->pixel_q16[k] = rg_add(place->pixel_q16[k], step_q16[k]);
    if (size_q16 < LAST_STEP_Q16)
      return move_inside(camera, EDGE_TOLERANCE_Q16, place->pixel_q16);
  }
  return 0;
}

/* Whether rays can be projected. */
static rg_status check_camera(const rg_camera* camera) {
  if (camera->line_points) return RG_ERR_NONCENTRAL;
  return camera->inverse ? RG_OK : RG_ERR_NO_INVERSE;
}

/* The camera must have an inverse grid. */
static int find_target(const rg_camera* camera, const rg_ray* direction,
                       rg_chart_point* target) {
  const uint8_t* const inverse = camera->blob + camera->inverse;
  return rg_chart_point_of(direction, rg_load_i32(inverse + 36), target);
}

rg_status rg_project(const rg_camera* camera, const rg_ray* direction,
                     rg_pixel* pixel) {
  rg_chart_point target;
  rg_inverse_place place;
  const rg_status status = check_camera(camera);
  if (status != RG_OK) return status;
  if (!find_target(camera, direction, &target) ||
      !solve(camera, &target, &place))
    return RG_ERR_NOT_SEEN;
  pixel->x_q16 = place.pixel_q16[0];
  pixel->y_q16 = place.pixel_q16[1];
  return RG_OK;
}

/* One thing for several points and then the next: fast processors work on
 * several points at once. */
#define BLOCK_SIZE 8u

/* Returns how many of up to BLOCK_SIZE points are seen. */
static uint32_t project_block(const rg_camera* camera, const rg_ray* directions,
                              rg_pixel* pixels, uint32_t num_points) {
  rg_chart_point targets[BLOCK_SIZE];
  int is_seen[BLOCK_SIZE];
  uint32_t num_seen = 0;
  for (uint32_t i = 0; i < num_points; ++i)
    is_seen[i] = find_target(camera, &directions[i], &targets[i]);
  for (uint32_t i = 0; i < num_points; ++i) {
    rg_inverse_place place;
    if (is_seen[i] && solve(camera, &targets[i], &place)) {
      pixels[i].x_q16 = place.pixel_q16[0];
      pixels[i].y_q16 = place.pixel_q16[1];
      ++num_seen;
    } else {
      pixels[i].x_q16 = pixels[i].y_q16 = RG_NO_PIXEL;
    }
  }
  return num_seen;
}

uint32_t rg_project_batch(const rg_camera* camera, const rg_ray* directions,
                          rg_pixel* pixels, uint32_t num_points) {
  uint32_t num_seen = 0;
  if (check_camera(camera) != RG_OK) {
    for (uint32_t i = 0; i < num_points; ++i)
      pixels[i].x_q16 = pixels[i].y_q16 = RG_NO_PIXEL;
    return 0;
  }
  for (; num_points > BLOCK_SIZE; num_points -= BLOCK_SIZE) {
    num_seen += project_block(camera, directions, pixels, BLOCK_SIZE);
    directions += BLOCK_SIZE;
    pixels += BLOCK_SIZE;
  }
  return num_seen + project_block(camera, directions, pixels, num_points);
}
