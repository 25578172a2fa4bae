#include "surface.h"

#include "bspline.h"
#include "bytes.h"
#include "fixed_point.h"

/* The first coordinate of four control points, weighted: q60, below 4. */
static int64_t sum_row(const uint8_t* points, const int32_t weights_q31[4]) {
  return rg_product(rg_load_i32(points), weights_q31[0]) +
         rg_product(rg_load_i32(points + 8), weights_q31[1]) +
         rg_product(rg_load_i32(points + 16), weights_q31[2]) +
         rg_product(rg_load_i32(points + 24), weights_q31[3]);
}

/* The first of the 16 control points around a position. */
static const uint8_t* first_point(const rg_camera* camera,
                                  const rg_cell_position cells[2]) {
  return camera->control_points +
         8u * (cells[1].cell * camera->columns + cells[0].cell);
}

void rg_surface_position(const rg_camera* camera, rg_pixel pixel,
                         rg_chart_point* position) {
  rg_cell_position cells[2];
  rg_find_cells(camera, pixel, cells);
  int32_t wx_q31[4], wy_q31[4];
  rg_bspline_weights(cells[0].t_q32, wx_q31);
  rg_bspline_weights(cells[1].t_q32, wy_q31);
  const uint32_t row_bytes = 8u * camera->columns;
  const uint8_t* const first = first_point(camera, cells);
  for (int c = 0; c < 2; ++c) {
    const uint8_t* points = first + 4 * c;
    int32_t sum_q28 = 0;
    for (int j = 0; j < 4; ++j, points += row_bytes)
      sum_q28 = rg_multiply_high_add(
          sum_q28, 2 * rg_upper_word(sum_row(points, wx_q31)), wy_q31[j]);
    position->q28[c] = sum_q28;
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
    const int32_t value_q28 = rg_upper_word(sum_row(points, weights->wx_q31));
    const int32_t slope_q28 = rg_upper_word(sum_row(points, weights->sx_q31));
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
  return first_point(camera, cells);
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
