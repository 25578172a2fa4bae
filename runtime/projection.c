/* Direction -> pixel: a start from the table or the middle of the area, then
 * Newton's method on differences of the spline surface. Pairs are x, y. */
#include "bytes.h"
#include "fixed_point.h"
#include "inverse.h"
#include "surface.h"

#define MAX_STEPS 24

/* The derivative is a difference over half a pixel. */
#define HALF_PIXEL_Q16 0x8000

/* A derivative is kept for 2 px around where it was taken. */
#define SHORT_DISTANCE_Q16 0x20000u

/* A step below 1/16 px is the last where its product with the distance that the
 * derivative comes from is below 1/32 px^2: that times the surface's relative
 * curvature is what remains. */
#define LAST_STEP_Q16 4096u
#define LAST_PRODUCT_Q24 0x80000u

/* Rounding may lead out of the area by this: 0.002 px. */
#define EDGE_TOLERANCE_Q16 128

/* Scales values so that the largest magnitude is in [2^29, 2^30]; returns by
 * which power of 2. */
static int normalize(int32_t* values, int num_values) {
  uint32_t bits = 1;
  for (int k = 0; k < num_values; ++k)
    bits |= (uint32_t)(values[k] ^ (values[k] >> 31));
  const int shift = rg_leading_zeros(bits) - 1;
  for (int k = 0; k < num_values; ++k)
    values[k] = (int32_t)((uint32_t)values[k] << shift) >> 1;
  return shift - 1;
}

/* a d - b c, by 2^-32 */
static int32_t cross(int32_t a, int32_t b, int32_t c, int32_t d) {
  return rg_multiply_high(a, d) - rg_multiply_high(b, c);
}

/* The inverse of a derivative: by half a pixel in x, by half a pixel in y. */
typedef struct inverse_map {
  int32_t derivative[4];  /* normalized */
  int32_t reciprocal_q29; /* of the determinant, with its sign */
  int exponent;
} inverse_map;

/* 0 if the derivative is singular. */
static int invert(inverse_map* map) {
  int32_t* const d = map->derivative;
  const int scale = normalize(d, 4);
  const int32_t determinant = cross(d[0], d[1], d[2], d[3]);
  const uint32_t size = rg_magnitude(determinant);
  if (size < UINT32_C(1) << 18) return 0;
  const int zeros = rg_leading_zeros(size);
  const int32_t r_q29 = rg_reciprocal(size << zeros);
  map->reciprocal_q29 = determinant < 0 ? -r_q29 : r_q29;
  /* 1 / determinant = r 2^(zeros - 61). */
  map->exponent = zeros + scale;
  return 1;
}

/* Replaces an error by the step that solves derivative * step = error. A step
 * too large for its format becomes shorter, in the same direction. */
static void find_step(const inverse_map* map, int32_t pair[2]) {
  const int32_t* const d = map->derivative;
  const int scale = normalize(pair, 2);
  int shift = 17 - map->exponent + scale;
  if (shift < 0) shift = 0;
  if (shift > 31) shift = 31;
  const int32_t x = cross(pair[0], pair[1], d[2], d[3]);
  const int32_t y = cross(d[0], d[1], pair[0], pair[1]);
  /* Each upper word is below 2^27. */
  pair[0] = 8 * rg_multiply_high(x, map->reciprocal_q29) >> shift;
  pair[1] = 8 * rg_multiply_high(y, map->reciprocal_q29) >> shift;
}

/* The table's pixel for a chart position; 0 where it says that none is. */
static int look_up_start(const uint8_t* section, const rg_chart_point* target,
                         int32_t pixel_q16[2]) {
  rg_cell_position cells[2];
  for (uint32_t c = 0; c < 2; ++c) {
    rg_axis axis;
    rg_read_axis(section, c, &axis);
    if (!rg_find_on_axis(&axis, rg_load_u16(section + 16 + 2 * c) - 2u,
                         2 * target->q27[c], &cells[c]))
      return 0;
  }
  const uint32_t columns = rg_load_u16(section + 16);
  const uint8_t* const vertex = section + rg_load_u32(section + 32) +
                                4 * (cells[1].cell * columns + cells[0].cell);
  const int32_t tx = cells[0].t_q30 >> 22;
  const int32_t ty = cells[1].t_q30 >> 22;
  int32_t x_q17 = 0, y_q17 = 0;
  for (uint32_t k = 0; k < 4; ++k) {
    const uint8_t* const corner = vertex + 4 * ((k & 1) + (k >> 1) * columns);
    const int32_t weight_q16 =
        (k & 1 ? tx : 256 - tx) * (k & 2 ? ty : 256 - ty);
    if (rg_load_i16(corner) == INT16_MIN) return 0;
    x_q17 += rg_load_i16(corner) * weight_q16;
    y_q17 += rg_load_i16(corner + 2) * weight_q16;
  }
  pixel_q16[0] = x_q17 >> 1;
  pixel_q16[1] = y_q17 >> 1;
  return 1;
}

/* Puts one coordinate between the area's edges, margin away from the far one;
 * returns by how much it was outside. */
static RG_NOINLINE uint32_t clamp_to_axis(const rg_axis* axis,
                                          int32_t margin_q16,
                                          int32_t* value_q16) {
  const int32_t before = *value_q16;
  const int32_t high = axis->low + (int32_t)axis->span - margin_q16;
  if (before < axis->low) *value_q16 = axis->low;
  if (before > high) *value_q16 = high;
  return rg_magnitude(before - *value_q16);
}

/* The surface at a pixel of the area, less the target. */
static void find_error(const rg_camera* camera, const int32_t pixel_q16[2],
                       const rg_chart_point* target, int32_t error_q27[2]) {
  rg_place place;
  rg_find_place(camera, pixel_q16[0], pixel_q16[1], &place);
  error_q27[0] = place.position.q27[0] - target->q27[0];
  error_q27[1] = place.position.q27[1] - target->q27[1];
}

/* The inverse derivative at a pixel half a pixel or more away from the area's
 * far edges, of which the error is known; 0 if it is singular. */
static int find_inverse(const rg_camera* camera, const rg_chart_point* target,
                        int32_t pixel_q16[2], const int32_t error_q27[2],
                        inverse_map* map) {
  int32_t* by_axis = map->derivative;
  for (uint32_t c = 0; c < 2; ++c, by_axis += 2) {
    pixel_q16[c] += HALF_PIXEL_Q16;
    find_error(camera, pixel_q16, target, by_axis);
    pixel_q16[c] -= HALF_PIXEL_Q16;
    by_axis[0] -= error_q27[0];
    by_axis[1] -= error_q27[1];
  }
  return invert(map);
}

/* From a start to the solution. What remains after a step is about its size
 * times the distance from where the derivative was taken, times the surface's
 * relative curvature. */
static int solve(const rg_camera* camera, const rg_chart_point* target,
                 int32_t pixel_q16[2]) {
  inverse_map map;
  uint32_t distance_q16 = SHORT_DISTANCE_Q16;
  for (int i = 0; i < MAX_STEPS; ++i) {
    const int is_far = distance_q16 >= SHORT_DISTANCE_Q16;
    int32_t pair[2]; /* the error in q27, then the step in q16 */
    for (uint32_t c = 0; c < 2; ++c)
      clamp_to_axis(&camera->axes[c], is_far ? HALF_PIXEL_Q16 : 0,
                    &pixel_q16[c]);
    find_error(camera, pixel_q16, target, pair);
    if (is_far) {
      if (!find_inverse(camera, target, pixel_q16, pair, &map)) return 0;
      distance_q16 = HALF_PIXEL_Q16;
    }
    find_step(&map, pair);
    uint32_t size_q16 = 0, beyond_q16 = 0, moved = 0;
    for (uint32_t c = 0; c < 2; ++c) {
      const int32_t before = pixel_q16[c];
      pixel_q16[c] -= pair[c];
      beyond_q16 |= clamp_to_axis(&camera->axes[c], 0, &pixel_q16[c]);
      size_q16 |= rg_magnitude(pair[c]);
      moved |= (uint32_t)(pixel_q16[c] ^ before);
    }
    distance_q16 += size_q16;
    if (size_q16 < LAST_STEP_Q16 &&
        (distance_q16 >> 8) * size_q16 <= LAST_PRODUCT_Q24)
      return beyond_q16 < EDGE_TOLERANCE_Q16;
    /* Stuck at the edge: the direction is seen beyond it, if at all. */
    if (!moved) return 0;
  }
  return 0;
}

static int find_start(const rg_camera* camera, const rg_chart_point* target,
                      int32_t pixel_q16[2]) {
  if (camera->start)
    return look_up_start(camera->blob + camera->start, target, pixel_q16);
  for (uint32_t c = 0; c < 2; ++c)
    pixel_q16[c] = camera->axes[c].low + (int32_t)(camera->axes[c].span >> 1);
  return 1;
}

rg_status rg_project(const rg_camera* camera, const rg_ray* direction,
                     rg_pixel* pixel) {
  rg_chart_point target;
  int32_t found_q16[2];
  if (camera->line_points) return RG_ERR_NONCENTRAL;
  const int32_t limit_q30 = camera->start
                                ? rg_load_i32(camera->blob + camera->start + 28)
                                : -(INT32_C(1) << 30);
  if (!rg_chart_point_of(direction, limit_q30, &target) ||
      !find_start(camera, &target, found_q16) ||
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
