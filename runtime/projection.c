/* Direction -> pixel: a start from the table or the middle of the area, then
 * Newton's method. */
#include "bytes.h"
#include "fixed_point.h"
#include "inverse.h"
#include "surface.h"

#define MAX_STEPS 12

/* A step below 1/16 px is the last where its product with the distance that the
 * derivative comes from is below 1/256 px^2: that times the surface's relative
 * curvature is what remains. */
#define LAST_STEP_Q16 4096u
#define LAST_PRODUCT_Q24 65536u

/* After a step below 2 px, the next one keeps the derivative. */
#define SHORT_STEP_Q16 0x20000u

/* Rounding may lead out of the area by this: 0.002 px. */
#define EDGE_TOLERANCE_Q16 128

#define STEP_LIMIT_Q16 ((INT32_C(1) << 30) - 1)

/* value 2^exponent for |value| < 2^30, at most STEP_LIMIT_Q16 in magnitude. */
static int32_t scale_step(int32_t value, int exponent) {
  if (exponent < -30) return 0;
  if (exponent < 0)
    return (value + (INT32_C(1) << (-exponent - 1))) >> -exponent;
  const int32_t limit = exponent > 30 ? 0 : STEP_LIMIT_Q16 >> exponent;
  if (value > limit) return STEP_LIMIT_Q16;
  if (value < -limit) return -STEP_LIMIT_Q16;
  return (int32_t)((uint32_t)value << exponent);
}

/* Left shift that brings the largest magnitude to [2^29, 2^30). */
static int normalizing_shift(uint32_t magnitudes) {
  return rg_leading_zeros(magnitudes) - 2;
}

static int32_t shift_left(int32_t value, int shift) {
  return shift >= 0 ? (int32_t)((uint32_t)value << shift) : value >> -shift;
}

/* The inverse of a derivative that was scaled to 30 bits: its adjugate, and the
 * reciprocal of its determinant. */
typedef struct inverse_map {
  int32_t d00, d01, d10, d11;
  int32_t reciprocal_q30; /* with the determinant's sign */
  int exponent;
} inverse_map;

/* 0 if the derivative is singular. */
static int invert(const int32_t derivative_q26[2][2], inverse_map* map) {
  const uint32_t magnitude =
      rg_magnitude(derivative_q26[0][0]) | rg_magnitude(derivative_q26[0][1]) |
      rg_magnitude(derivative_q26[1][0]) | rg_magnitude(derivative_q26[1][1]);
  if (magnitude == 0) return 0;
  const int k = normalizing_shift(magnitude);
  map->d00 = shift_left(derivative_q26[0][0], k);
  map->d01 = shift_left(derivative_q26[0][1], k);
  map->d10 = shift_left(derivative_q26[1][0], k);
  map->d11 = shift_left(derivative_q26[1][1], k);
  /* Each product below 2^28, their difference below 2^29. */
  const int32_t determinant = rg_multiply_high(map->d00, map->d11) -
                              rg_multiply_high(map->d01, map->d10);
  const uint32_t size = rg_magnitude(determinant);
  if (size < UINT32_C(1) << 18) return 0;
  const int n = rg_leading_zeros(size);
  const int32_t r_q30 = rg_reciprocal(size << n);
  map->reciprocal_q30 = determinant < 0 ? -r_q30 : r_q30;
  /* 1 / determinant = r 2^(n - 62), and the derivative was scaled by
   * 2^(26 + k). */
  map->exponent = n + k;
  return 1;
}

/* Solves derivative * step = error; returns the step's size. */
static uint32_t find_step(const inverse_map* map, const int32_t error_q28[2],
                          int32_t step_q16[2]) {
  const uint32_t magnitude =
      rg_magnitude(error_q28[0]) | rg_magnitude(error_q28[1]);
  step_q16[0] = step_q16[1] = 0;
  if (magnitude == 0) return 0;
  const int m = normalizing_shift(magnitude);
  const int32_t e0 = shift_left(error_q28[0], m);
  const int32_t e1 = shift_left(error_q28[1], m);
  const int32_t numerators[2] = {
      rg_multiply_high(e0, map->d11) - rg_multiply_high(e1, map->d01),
      rg_multiply_high(e1, map->d00) - rg_multiply_high(e0, map->d10)};
  /* The error was scaled by 2^(28 + m), each product's upper word by 2^-32. */
  for (int c = 0; c < 2; ++c)
    step_q16[c] =
        scale_step(rg_multiply_high(numerators[c], map->reciprocal_q30),
                   map->exponent - m - 16);
  const uint32_t x = rg_magnitude(step_q16[0]), y = rg_magnitude(step_q16[1]);
  return x > y ? x : y;
}

static int32_t clamp(int32_t value, int32_t low, int32_t high) {
  return value < low ? low : value > high ? high : value;
}

/* Moves the pixel, at most to the area's edge; returns by how much it would
 * have left the area. */
static int32_t move_pixel(const rg_camera* camera, const int32_t step_q16[2],
                          rg_pixel* pixel) {
  const int32_t x = pixel->x_q16 + step_q16[0];
  const int32_t y = pixel->y_q16 + step_q16[1];
  pixel->x_q16 = clamp(x, camera->x0_q16, camera->x1_q16);
  pixel->y_q16 = clamp(y, camera->y0_q16, camera->y1_q16);
  const uint32_t beyond_x = rg_magnitude(x - pixel->x_q16);
  const uint32_t beyond_y = rg_magnitude(y - pixel->y_q16);
  return (int32_t)(beyond_x > beyond_y ? beyond_x : beyond_y);
}

/* From q1 corners, weights in q8 each: q17, then q16. */
static int32_t blend(const int32_t corners_q1[4], int32_t tx, int32_t ty) {
  const int32_t upper = corners_q1[0] * (256 - tx) + corners_q1[1] * tx;
  const int32_t lower = corners_q1[2] * (256 - tx) + corners_q1[3] * tx;
  return (upper * (256 - ty) + lower * ty) >> 1;
}

/* The table's pixel for a chart position; 0 where it says that none is. */
static int look_up_start(const uint8_t* section, const rg_chart_point* target,
                         rg_pixel* pixel) {
  rg_cell_position cells[2];
  for (int c = 0; c < 2; ++c) {
    const int32_t low_q28 = rg_load_i32(section + 4 * c);
    if (target->q28[c] < low_q28 ||
        target->q28[c] > rg_load_i32(section + 8 + 4 * c))
      return 0;
    cells[c] = rg_find_cell((uint32_t)target->q28[c] - (uint32_t)low_q28,
                            rg_load_u32(section + 20 + 4 * c),
                            rg_load_u16(section + 16 + 2 * c) - 1u);
  }
  const uint32_t columns = rg_load_u16(section + 16);
  const uint8_t* vertex = section + rg_load_u32(section + 32) +
                          4 * (cells[1].cell * columns + cells[0].cell);
  int32_t x_q1[4], y_q1[4];
  for (uint32_t k = 0; k < 4; ++k) {
    const uint8_t* corner = vertex + 4 * ((k & 1) + (k >> 1) * columns);
    x_q1[k] = rg_load_i16(corner);
    y_q1[k] = rg_load_i16(corner + 2);
    if (x_q1[k] == INT16_MIN) return 0;
  }
  const int32_t tx = (int32_t)(cells[0].t_q32 >> 24);
  const int32_t ty = (int32_t)(cells[1].t_q32 >> 24);
  pixel->x_q16 = blend(x_q1, tx, ty);
  pixel->y_q16 = blend(y_q1, tx, ty);
  return 1;
}

static int find_start(const rg_camera* camera, const rg_chart_point* target,
                      rg_pixel* pixel) {
  const int32_t stay[2] = {0, 0};
  if (!camera->start) {
    pixel->x_q16 = camera->x0_q16 + (camera->x1_q16 - camera->x0_q16) / 2;
    pixel->y_q16 = camera->y0_q16 + (camera->y1_q16 - camera->y0_q16) / 2;
    return 1;
  }
  if (!look_up_start(camera->blob + camera->start, target, pixel)) return 0;
  move_pixel(camera, stay, pixel);
  return 1;
}

static void subtract(const rg_chart_point* target,
                     const rg_chart_point* position, int32_t error_q28[2]) {
  error_q28[0] = target->q28[0] - position->q28[0];
  error_q28[1] = target->q28[1] - position->q28[1];
}

/* How a step left things. */
typedef enum progress { GOES_ON, FOUND, NOT_SEEN } progress;

/* Takes the step. What remains then is about its size times the distance from
 * where the derivative was taken, times the surface's relative curvature. */
static progress take_step(const rg_camera* camera, const int32_t step_q16[2],
                          uint32_t size_q16, uint32_t distance_q16,
                          rg_pixel* pixel) {
  const rg_pixel before = *pixel;
  const int32_t beyond_q16 = move_pixel(camera, step_q16, pixel);
  if (size_q16 < LAST_STEP_Q16 &&
      (distance_q16 >> 8) * size_q16 <= LAST_PRODUCT_Q24)
    return beyond_q16 <= EDGE_TOLERANCE_Q16 ? FOUND : NOT_SEEN;
  /* Stuck at the edge: the direction is seen beyond it, if at all. */
  return pixel->x_q16 == before.x_q16 && pixel->y_q16 == before.y_q16 ? NOT_SEEN
                                                                      : GOES_ON;
}

/* From a start in the area to the solution. After a short step, the next one
 * keeps the derivative. */
static int solve(const rg_camera* camera, const rg_chart_point* target,
                 rg_pixel* pixel) {
  progress status = GOES_ON;
  for (int i = 0; i < MAX_STEPS && status == GOES_ON; ++i) {
    rg_tangent tangent;
    inverse_map map;
    int32_t error_q28[2], step_q16[2];
    rg_surface_tangent(camera, *pixel, &tangent);
    if (!invert(tangent.by_pixel_q26, &map)) return 0;
    subtract(target, &tangent.position, error_q28);
    const uint32_t first_q16 = find_step(&map, error_q28, step_q16);
    status = take_step(camera, step_q16, first_q16, first_q16, pixel);
    if (status != GOES_ON || first_q16 >= SHORT_STEP_Q16) continue;
    rg_surface_position(camera, *pixel, &tangent.position);
    subtract(target, &tangent.position, error_q28);
    const uint32_t second_q16 = find_step(&map, error_q28, step_q16);
    status = take_step(camera, step_q16, second_q16, first_q16, pixel);
  }
  return status == FOUND;
}

rg_status rg_project(const rg_camera* camera, const rg_ray* direction,
                     rg_pixel* pixel) {
  rg_chart_point target;
  rg_pixel found;
  if (camera->line_points) return RG_ERR_NONCENTRAL;
  const int32_t limit_q30 = camera->start
                                ? rg_load_i32(camera->blob + camera->start + 28)
                                : -(INT32_C(1) << 30);
  if (!rg_chart_point_of(direction, limit_q30, &target) ||
      !find_start(camera, &target, &found) || !solve(camera, &target, &found))
    return RG_ERR_NOT_SEEN;
  *pixel = found;
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
