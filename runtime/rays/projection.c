/* Direction -> pixel: initial value from the inverse grid, then Newton's method
 * on the spline surface with the inverse grid's Jacobian. Pairs are x, y. */
#include "bytes.h"
#include "fixed_point.h"
#include "rays/surface_choice.h"
#include "rg_blob.h"

/* Limit of the first step, and of the initial value's distance outside the
 * area; a quarter of that for each further step. */
#define FIRST_STEP_Q16 0x40000u /* 4 px */

/* A step below 1/64 px is the last: the remaining error is its product with the
 * error of the Jacobian. */
#define LAST_STEP_Q16 0x400u

/* The tolerance outside the area for rounding: 0.002 px. */
#define EDGE_TOLERANCE_Q16 128u

/* Clamps a pixel to the area of a grid; 0 if it is farther outside. */
static RG_INLINE int clamp_to_area(const uint8_t* axis, uint32_t tolerance_q16,
                                   int32_t* pixel_q16) {
  RG_UNROLL
  for (int axes = 2; axes > 0; --axes, axis += 4) {
    const int32_t low_q16 = rg_load_i32(axis + RG_GRID_X0);
    const int32_t high_q16 = rg_load_i32(axis + RG_GRID_X1);
    int32_t inside_q16 = *pixel_q16;
    if (inside_q16 < low_q16) inside_q16 = low_q16;
    if (inside_q16 > high_q16) inside_q16 = high_q16;
    if (rg_magnitude(rg_subtract(*pixel_q16, inside_q16)) > tolerance_q16)
      return 0;
    *pixel_q16++ = inside_q16;
  }
  return 1;
}

/* A Newton step: the product of slopes and the residual. Returns its length, or
 * more if it is 8 px or more. */
static RG_INLINE uint32_t newton_step(int32_t jacobian_q5[2][2],
                                      const int32_t residual_q27[2],
                                      int32_t* pixel_q16) {
  uint32_t size_q16 = 0;
  RG_UNROLL
  for (int c = 0; c < 2; ++c) {
    const int64_t step_q32 = 0x8000 +
                             rg_product(jacobian_q5[0][c], residual_q27[0]) +
                             rg_product(jacobian_q5[1][c], residual_q27[1]);
    const int32_t step_q16 = (int32_t)(step_q32 >> 16);
    if ((uint32_t)(step_q32 >> 32) + 8 >= 16) return UINT32_MAX;
    size_q16 |= rg_magnitude(step_q16);
    pixel_q16[c] = rg_add(pixel_q16[c], step_q16);
  }
  return size_q16;
}

/* Newton's method from the inverse grid's value, with its Jacobian. */
static RG_INLINE int solve_newton(const rg_camera* camera,
                                  const rg_chart_point* target,
                                  int32_t pixel_q16[2]) {
  rg_grid_position grid_position;
  int32_t jacobian_q5[2][2];
  if (rg_evaluate_inverse(camera, target->q27[0], target->q27[1],
                          &grid_position) != RG_OK)
    return 0;
  rg_compute_inverse_jacobian(camera, &grid_position, jacobian_q5);
  for (int k = 0; k < 2; ++k)
    pixel_q16[k] = rg_shift_left(grid_position.value.q27[k], 1);
  /* Limit of the next step, and of the initial distance outside the area. */
  uint32_t limit_q16 = FIRST_STEP_Q16;
  while (clamp_to_area(camera->grid, limit_q16, pixel_q16)) {
    if (limit_q16 < LAST_STEP_Q16) return limit_q16 == EDGE_TOLERANCE_Q16;
    rg_evaluate_grid(camera, pixel_q16[0], pixel_q16[1], &grid_position);
    int32_t residual_q27[2];
    for (int c = 0; c < 2; ++c)
      residual_q27[c] = rg_subtract(target->q27[c], grid_position.value.q27[c]);
    const uint32_t size_q16 = newton_step(jacobian_q5, residual_q27, pixel_q16);
    if (size_q16 > limit_q16) return 0;
    limit_q16 = size_q16 < LAST_STEP_Q16 ? EDGE_TOLERANCE_Q16 : limit_q16 >> 2;
  }
  return 0;
}

/* The camera must have an inverse grid. */
static int find_target(const rg_camera* camera, const rg_ray* direction,
                       rg_chart_point* target) {
  return rg_direction_to_chart(
      direction, rg_load_i32(camera->inverse + RG_INVERSE_COS_LIMIT), target);
}

/* rg_project(), also for lines: the pixel whose line has the direction. */
static RG_SHARED rg_status find_pixel(const rg_camera* camera,
                                      const rg_ray* direction,
                                      rg_pixel* pixel) {
  rg_chart_point target;
  int32_t found_q16[2];
  if (!camera->inverse) return RG_ERR_NO_INVERSE;
  if (!find_target(camera, direction, &target) ||
      !solve_newton(camera, &target, found_q16))
    return RG_ERR_NOT_SEEN;
  pixel->x_q16 = found_q16[0];
  pixel->y_q16 = found_q16[1];
  return RG_OK;
}

rg_status rg_project(const rg_camera* camera, const rg_ray* direction,
                     rg_pixel* pixel) {
  if (camera->line_points) return RG_ERR_NONCENTRAL;
  return find_pixel(camera, direction, pixel);
}

/* Processes blocks of points step by step, so that fast processors work on
 * several points in parallel. */
#define BLOCK_SIZE 8u

/* Returns how many of BLOCK_SIZE points project; needs an inverse grid. */
static uint32_t project_block(const rg_camera* camera, const rg_ray* directions,
                              rg_pixel* pixels) {
  rg_chart_point targets[BLOCK_SIZE];
  int is_seen[BLOCK_SIZE];
  uint32_t num_seen = 0;
  for (uint32_t i = 0; i < BLOCK_SIZE; ++i)
    is_seen[i] = find_target(camera, &directions[i], &targets[i]);
  for (uint32_t i = 0; i < BLOCK_SIZE; ++i) {
    int32_t found_q16[2];
    if (is_seen[i] && solve_newton(camera, &targets[i], found_q16))
      ++num_seen;
    else
      found_q16[0] = found_q16[1] = RG_NO_PIXEL;
    pixels[i].x_q16 = found_q16[0];
    pixels[i].y_q16 = found_q16[1];
  }
  return num_seen;
}

uint32_t rg_project_batch(const rg_camera* camera, const rg_ray* directions,
                          rg_pixel* pixels, uint32_t num_points) {
  uint32_t num_seen = 0;
  if (RG_IS_FAST && camera->inverse && !camera->line_points)
    for (; num_points >= BLOCK_SIZE; num_points -= BLOCK_SIZE,
                                     pixels += BLOCK_SIZE,
                                     directions += BLOCK_SIZE)
      num_seen += project_block(camera, directions, pixels);
  for (; num_points > 0; --num_points, ++pixels, ++directions) {
    if (rg_project(camera, directions, pixels) == RG_OK)
      ++num_seen;
    else
      pixels->x_q16 = pixels->y_q16 = RG_NO_PIXEL;
  }
  return num_seen;
}

/* ---- Points observed along observation lines ----------------------------- */

/* Pixels closer than this have the same line. */
#define SAME_LINE_Q16 0x80u /* 1/512 px */

static RG_INLINE int is_near(rg_pixel pixel, rg_pixel other) {
  const uint32_t x = (uint32_t)pixel.x_q16 - (uint32_t)other.x_q16;
  const uint32_t y = (uint32_t)pixel.y_q16 - (uint32_t)other.y_q16;
  return ((x + SAME_LINE_Q16) | (y + SAME_LINE_Q16)) < 2 * SAME_LINE_Q16;
}

/* The closeness of the last line: its pixel is accepted, since further
 * iterations would only repeat the rounding of the point's format. */
#define LAST_CLOSENESS 22u

/* Between one and two times the largest coordinate's magnitude. */
static RG_INLINE uint32_t size_of(const rg_ray* direction) {
  return rg_magnitude_bits(direction->x_q30) |
         rg_magnitude_bits(direction->y_q30) |
         rg_magnitude_bits(direction->z_q30);
}

/* A line; to reduce the stack, its direction is also used for a point's
 * direction, and its point for the pixel found for that direction. */
typedef union rg_line_words {
  rg_line line;
  int32_t words[6];
  rg_pixel pixel;
} rg_line_words;

/* Replaces the direction of the line by that of the point from the line's point
 * closest to the camera's centre, o - (o . d) d. */
static RG_SHARED void look_from(rg_line_words* line, const int32_t point[3],
                                uint32_t shift) {
  int32_t* word = line->words;
  int32_t along_q26 = 0;
  RG_UNROLL
  for (int axes = 3; axes > 0; --axes, ++word)
    along_q26 = rg_multiply_high_add(along_q26, word[0], word[3]);
  const int32_t along_q28 = rg_shift_left(along_q26, 2);
  word = line->words;
  RG_UNROLL
  for (int axes = 3; axes > 0; --axes, ++word) {
    const int32_t part_q26 = rg_multiply_high(along_q28, word[3]);
    const int32_t nearest_q28 = rg_subtract(*word, rg_shift_left(part_q26, 2));
    word[3] = rg_subtract(*point++, nearest_q28 >> shift);
  }
}

/* Iterates over lines nearly through the point: each is the line of the pixel
 * that observes the point's direction from the previous line. If there is none,
 * the previous line may be the cause: the direction is moved towards the z
 * axis, by about 2^-closeness sin(theta), and by a quarter of that for the next
 * line. */
rg_status rg_project_point(const rg_camera* camera, const int32_t point[3],
                           uint32_t fraction_bits, rg_pixel* pixel) {
  rg_line_words found;
  rg_pixel last = {RG_NO_PIXEL, RG_NO_PIXEL};
  if (fraction_bits > RG_POINT_MAX_BITS) return RG_ERR_ARGUMENT;
  for (int c = 0; c < 3; ++c) found.words[3 + c] = point[c];
  /* closeness, above the shift to fraction_bits, in one register. */
  uint32_t closeness_and_shift = RG_LINE_POINT_BITS - fraction_bits;
  do {
    rg_status status = find_pixel(camera, &found.line.direction, &found.pixel);
    if (!camera->line_points ||
        (status == RG_OK && (is_near(found.pixel, last) ||
                             closeness_and_shift >= LAST_CLOSENESS << 8))) {
      if (status == RG_OK) *pixel = found.pixel;
      return status;
    }
    if (status != RG_OK) {
      const uint32_t pull =
          size_of(&found.line.direction) >> (closeness_and_shift >> 8);
      found.words[5] = rg_add(found.words[5], (int32_t)pull);
      status = find_pixel(camera, &found.line.direction, &found.pixel);
      if (status != RG_OK) return status;
    }
    last = found.pixel;
    rg_unproject_line(camera, found.pixel, &found.line);
    look_from(&found, point, (uint8_t)closeness_and_shift);
    closeness_and_shift += 2 << 8;
  } while (closeness_and_shift < (LAST_CLOSENESS + 2) << 8);
  return RG_ERR_NOT_SEEN;
}
