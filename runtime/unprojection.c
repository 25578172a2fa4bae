/* Pixel -> direction. Error budget in runtime/README.md. */
#include "bspline.h"
#include "bytes.h"
#include "fixed_point.h"
#include "raygrid.h"

/* A position on one axis of the grid: in which cell, and how far into it. */
typedef struct cell_position {
  uint32_t cell;
  uint32_t t_q32;
} cell_position;

/* offset_q16 is from the area's edge, at most its extent; the last cell owns
 * its far edge. */
static cell_position find_cell(uint32_t offset_q16, uint32_t scale_q32,
                               uint32_t num_cells) {
  uint32_t low;
  const uint32_t high = rg_multiply_unsigned(offset_q16, scale_q32, &low);
  cell_position position = {high >> 16, (high << 16) | (low >> 16)}; /* q48 */
  if (position.cell >= num_cells) {
    position.cell = num_cells - 1;
    position.t_q32 = 0xffffffffu;
  }
  return position;
}

/* Stereographic coordinates (a, b) = tan(theta / 2) (cos phi, sin phi). */
typedef struct chart_point {
  int32_t a_q28, b_q28;
} chart_point;

/* The spline surface: 16 control points, weighted first along the rows. */
static chart_point interpolate(const rg_camera* camera, cell_position x,
                               cell_position y) {
  int32_t wx_q31[4], wy_q31[4];
  rg_bspline_weights(x.t_q32, wx_q31);
  rg_bspline_weights(y.t_q32, wy_q31);

  const uint32_t row_bytes = 8u * camera->columns;
  const uint8_t* row = camera->control_points + y.cell * row_bytes + 8 * x.cell;
  chart_point sum = {0, 0};
  for (int j = 0; j < 4; ++j, row += row_bytes) {
    int32_t a_q28 = 0, b_q28 = 0; /* q29 q31 >> 32; |a| < 4 */
    for (int i = 0; i < 4; ++i) {
      a_q28 = rg_multiply_high_add(a_q28, rg_load_i32(row + 8 * i), wx_q31[i]);
      b_q28 =
          rg_multiply_high_add(b_q28, rg_load_i32(row + 8 * i + 4), wx_q31[i]);
    }
    sum.a_q28 = rg_multiply_high_add(sum.a_q28, 2 * a_q28, wy_q31[j]);
    sum.b_q28 = rg_multiply_high_add(sum.b_q28, 2 * b_q28, wy_q31[j]);
  }
  return sum;
}

/* 1 / (1 + s) in q30, for s_q26 <= 2^31. Newton's iteration r <- r + r (1 - d
 * r) on 1 + s scaled to d in [1/2, 1): relative error 1/17, 4e-3, 1.2e-5,
 * 2^-32. */
static int32_t reciprocal_of_one_plus(uint32_t s_q26) {
  uint32_t d_q32 = s_q26 + (UINT32_C(1) << 26);
  int doublings = 0; /* at most 5, as 1 + s >= 1 */
  if (d_q32 < UINT32_C(1) << 28) {
    d_q32 <<= 4;
    doublings = 4;
  } else if (d_q32 < UINT32_C(1) << 30) {
    d_q32 <<= 2;
    doublings = 2;
  }
  if (d_q32 < UINT32_C(1) << 31) {
    d_q32 <<= 1;
    ++doublings;
  }

  /* 48/17 - 32/17 d */
  int32_t r_q30 = (int32_t)(UINT32_C(3031741621) -
                            rg_multiply_high_unsigned(d_q32, 2021161081));
  for (int i = 0; i < 3; ++i) {
    const int32_t error_q30 =
        (int32_t)((UINT32_C(1) << 30) -
                  rg_multiply_high_unsigned(d_q32, (uint32_t)r_q30));
    r_q30 += rg_multiply_shift(r_q30, error_q30, 30);
  }
  /* 1 / (1 + s) = r 2^(doublings - 6) */
  const int shift = 6 - doublings;
  return (int32_t)(((uint32_t)r_q30 + (UINT32_C(1) << (shift - 1))) >> shift);
}

/* (2a, 2b, 1 - s) / (1 + s) with s = a^2 + b^2. */
static void direction_of(chart_point point, rg_ray* ray) {
  const int32_t a_q29 = 2 * point.a_q28, b_q29 = 2 * point.b_q28;
  const uint32_t s_q26 = (uint32_t)rg_multiply_high(a_q29, a_q29) +
                         (uint32_t)rg_multiply_high(b_q29, b_q29);
  const int32_t r_q30 = reciprocal_of_one_plus(s_q26);
  ray->x_q30 = rg_multiply_shift(point.a_q28, r_q30, 27);
  ray->y_q30 = rg_multiply_shift(point.b_q28, r_q30, 27);
  ray->z_q30 = 2 * r_q30 - (INT32_C(1) << 30); /* (1 - s) r = 2r - 1 */
}

rg_status rg_unproject(const rg_camera* camera, rg_pixel pixel, rg_ray* ray) {
  if (pixel.x_q16 < camera->x0_q16 || pixel.x_q16 > camera->x1_q16 ||
      pixel.y_q16 < camera->y0_q16 || pixel.y_q16 > camera->y1_q16)
    return RG_ERR_OUTSIDE_AREA;
  const cell_position x = find_cell((uint32_t)(pixel.x_q16 - camera->x0_q16),
                                    camera->scale_x_q32, camera->columns - 3u);
  const cell_position y = find_cell((uint32_t)(pixel.y_q16 - camera->y0_q16),
                                    camera->scale_y_q32, camera->rows - 3u);
  direction_of(interpolate(camera, x, y), ray);
  return RG_OK;
}

uint32_t rg_unproject_batch(const rg_camera* camera, const rg_pixel* pixels,
                            rg_ray* rays, uint32_t num_pixels) {
  uint32_t num_inside = 0;
  for (uint32_t i = 0; i < num_pixels; ++i) {
    if (rg_unproject(camera, pixels[i], &rays[i]) == RG_OK)
      ++num_inside;
    else
      rays[i].x_q30 = rays[i].y_q30 = rays[i].z_q30 = 0;
  }
  return num_inside;
}
