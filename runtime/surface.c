#include "surface.h"

#include "bspline.h"
#include "bytes.h"
#include "fixed_point.h"

/* The first coordinate of four control points that lie step bytes apart,
 * weighted: q31 more than theirs. */
static RG_INLINE int64_t sum_row(const uint8_t* points, uint32_t step,
                                 const int32_t weights_q31[4]) {
  return rg_product(rg_load_i32(points), weights_q31[0]) +
         rg_product(rg_load_i32(points + step), weights_q31[1]) +
         rg_product(rg_load_i32(points + 2 * step), weights_q31[2]) +
         rg_product(rg_load_i32(points + 3 * step), weights_q31[3]);
}

/* Weights of a position on both axes. */
typedef struct position_weights {
  int32_t x_q31[4], y_q31[4];
} position_weights;

/* Returns the number of the first of the 16 control points around a pixel. */
static uint32_t find_position(const rg_camera* camera, rg_pixel pixel,
                              position_weights* weights) {
  rg_cell_position cells[2];
  rg_find_cells(camera, pixel, cells);
  rg_bspline_weights(cells[0].t_q32, weights->x_q31);
  rg_bspline_weights(cells[1].t_q32, weights->y_q31);
  return cells[1].cell * camera->columns + cells[0].cell;
}

void rg_surface_position(const rg_camera* camera, rg_pixel pixel,
                         rg_chart_point* position) {
  position_weights weights;
  const uint8_t* row =
      camera->control_points + 8 * find_position(camera, pixel, &weights);
  int32_t a_q28 = 0, b_q28 = 0;
  for (int j = 0; j < 4; ++j, row += 8u * camera->columns) {
    const int32_t row_a_q28 = rg_upper_word(sum_row(row, 8, weights.x_q31));
    const int32_t row_b_q28 = rg_upper_word(sum_row(row + 4, 8, weights.x_q31));
    a_q28 = rg_multiply_high_add(a_q28, 2 * row_a_q28, weights.y_q31[j]);
    b_q28 = rg_multiply_high_add(b_q28, 2 * row_b_q28, weights.y_q31[j]);
  }
  position->q28[0] = a_q28;
  position->q28[1] = b_q28;
}

void rg_surface_line_point(const rg_camera* camera, rg_pixel pixel,
                           int32_t point_q28[3]) {
  const uint8_t* const section = camera->blob + camera->line_points;
  position_weights weights;
  const uint8_t* points = section + rg_load_u32(section + 4) +
                          12 * find_position(camera, pixel, &weights);
  for (int c = 0; c < 3; ++c, points += 4) {
    const uint8_t* row = points;
    int32_t sum_q27 = 0;
    for (int j = 0; j < 4; ++j, row += 12u * camera->columns)
      sum_q27 = rg_multiply_high_add(
          sum_q27, 2 * rg_upper_word(sum_row(row, 12, weights.x_q31)),
          weights.y_q31[j]);
    point_q28[c] = 2 * sum_q27;
  }
}

/* Weights and slopes on both axes. */
typedef struct tangent_weights {
  int32_t wx_q31[4], wy_q31[4], sx_q31[4], sy_q31[4];
} tangent_weights;

/* One coordinate: its value in q28, its derivatives by x and y in q27 a cell.
 */
static void sum_coordinate(const tangent_weights* weights,
                           const uint8_t* points, uint32_t row_bytes,
                           int32_t sums[3]) {
  sums[0] = sums[1] = sums[2] = 0;
  for (int j = 0; j < 4; ++j, points += row_bytes) {
    /* Below 4, and below 6: the slopes' magnitudes sum to at most 3/2. */
    const int32_t value_q28 =
        rg_upper_word(sum_row(points, 8, weights->wx_q31));
    const int32_t slope_q28 =
        rg_upper_word(sum_row(points, 8, weights->sx_q31));
    const int32_t weight_q31 = weights->wy_q31[j];
    sums[0] = rg_multiply_high_add(sums[0], 2 * value_q28, weight_q31);
    sums[1] = rg_multiply_high_add(sums[1], slope_q28, weight_q31);
    sums[2] = rg_multiply_high_add(sums[2], value_q28, weights->sy_q31[j]);
  }
}

/* Per cell in q27 to per pixel in q26. */
static int32_t per_pixel(int32_t per_cell_q27, uint32_t scale_q32) {
  return rg_multiply_high(per_cell_q27, (int32_t)(scale_q32 >> 1));
}

static const uint8_t* find_weights(const rg_camera* camera, rg_pixel pixel,
                                   tangent_weights* weights) {
  rg_cell_position cells[2];
  rg_find_cells(camera, pixel, cells);
  rg_bspline_weights(cells[0].t_q32, weights->wx_q31);
  rg_bspline_weights(cells[1].t_q32, weights->wy_q31);
  rg_bspline_slopes(cells[0].t_q32, weights->sx_q31);
  rg_bspline_slopes(cells[1].t_q32, weights->sy_q31);
  return camera->control_points +
         8u * (cells[1].cell * camera->columns + cells[0].cell);
}

void rg_surface_tangent(const rg_camera* camera, rg_pixel pixel,
                        rg_tangent* tangent) {
  tangent_weights weights;
  const uint8_t* const points = find_weights(camera, pixel, &weights);
  for (int c = 0; c < 2; ++c) {
    int32_t sums[3];
    sum_coordinate(&weights, points + 4 * c, 8u * camera->columns, sums);
    tangent->position.q28[c] = sums[0];
    tangent->by_pixel_q26[c][0] = per_pixel(sums[1], camera->scale_x_q32);
    tangent->by_pixel_q26[c][1] = per_pixel(sums[2], camera->scale_y_q32);
  }
}
