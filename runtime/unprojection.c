/* Pixel -> direction. Error budget in runtime/README.md. */
#include "bytes.h"
#include "fixed_point.h"
#include "raygrid.h"
#include "surface.h"

rg_status rg_unproject(const rg_camera* camera, rg_pixel pixel, rg_ray* ray) {
  rg_place place;
  if (camera->line_points) return RG_ERR_NONCENTRAL;
  if (!rg_find_place(camera->grid, pixel.x_q16, pixel.y_q16, &place))
    return RG_ERR_OUTSIDE_AREA;
  rg_direction_of(&place.value, ray);
  return RG_OK;
}

/* A row of four points of a line, and the column of four rows. Each product is
 * rounded, q28 to q27 and to q26. */
static RG_INLINE void add_line_row(const uint8_t* points,
                                   const int32_t w_q31[4],
                                   int32_t row_weight_q31,
                                   int32_t sums_q26[3]) {
  int32_t b, a = rg_load_i32_pair(points, &b);
  int32_t row_x = rg_multiply_high(a, w_q31[0]);
  int32_t row_y = rg_multiply_high(b, w_q31[0]);
  a = rg_load_i32_pair(points + 8, &b);
  int32_t row_z = rg_multiply_high(a, w_q31[0]);
  row_x = rg_multiply_high_add(row_x, b, w_q31[1]);
  a = rg_load_i32_pair(points + 16, &b);
  row_y = rg_multiply_high_add(row_y, a, w_q31[1]);
  row_z = rg_multiply_high_add(row_z, b, w_q31[1]);
  a = rg_load_i32_pair(points + 24, &b);
  row_x = rg_multiply_high_add(row_x, a, w_q31[2]);
  row_y = rg_multiply_high_add(row_y, b, w_q31[2]);
  a = rg_load_i32_pair(points + 32, &b);
  row_z = rg_multiply_high_add(row_z, a, w_q31[2]);
  row_x = rg_multiply_high_add(row_x, b, w_q31[3]);
  a = rg_load_i32_pair(points + 40, &b);
  row_y = rg_multiply_high_add(row_y, a, w_q31[3]);
  row_z = rg_multiply_high_add(row_z, b, w_q31[3]);
  sums_q26[0] = rg_multiply_high_add(sums_q26[0], row_x, row_weight_q31);
  sums_q26[1] = rg_multiply_high_add(sums_q26[1], row_y, row_weight_q31);
  sums_q26[2] = rg_multiply_high_add(sums_q26[2], row_z, row_weight_q31);
}

/* The camera must have line points. */
static RG_INLINE void find_line_point(const rg_camera* camera, rg_place* place,
                                      int32_t point_q28[3]) {
  const uint8_t* points = camera->line_points + 12 * place->first;
  const uint32_t row_bytes = 12u * rg_load_u16(camera->grid + 16);
  const int32_t* const x_weights = place->weights_q31[0];
  int32_t* const y_weights = place->weights_q31[1];
  int32_t sums_q26[3] = {0, 0, 0};
  RG_UNROLL_ROWS
  for (int j = 0; j < 4; ++j, points = rg_keep_address(points + row_bytes))
    add_line_row(points, x_weights, rg_read_late(y_weights + j), sums_q26);
  for (int c = 0; c < 3; ++c) point_q28[c] = rg_shift_left(sums_q26[c], 2);
}

rg_status rg_unproject_line(const rg_camera* camera, rg_pixel pixel,
                            rg_line* line) {
  rg_place place;
  if (!rg_find_place(camera->grid, pixel.x_q16, pixel.y_q16, &place))
    return RG_ERR_OUTSIDE_AREA;
  rg_direction_of(&place.value, &line->direction);
  if (camera->line_points)
    find_line_point(camera, &place, line->point_q28);
  else
    line->point_q28[0] = line->point_q28[1] = line->point_q28[2] = 0;
  return RG_OK;
}

/* 0 and a ray of zeros for a pixel outside the area. */
static RG_SHARED uint32_t unproject_or_clear(const rg_camera* camera,
                                             rg_pixel pixel, rg_ray* ray) {
  if (rg_unproject(camera, pixel, ray) == RG_OK) return 1;
  ray->x_q30 = ray->y_q30 = ray->z_q30 = 0;
  return 0;
}

uint32_t rg_unproject_batch(const rg_camera* camera, const rg_pixel* pixels,
                            rg_ray* rays, uint32_t num_pixels) {
  uint32_t num_inside = 0;
  for (uint32_t i = 0; i < num_pixels; ++i)
    num_inside += unproject_or_clear(camera, pixels[i], &rays[i]);
  return num_inside;
}

uint32_t rg_unproject_row(const rg_camera* camera, rg_pixel first, rg_ray* rays,
                          uint32_t num_pixels) {
  uint32_t num_inside = 0;
  for (uint32_t i = 0; i < num_pixels; ++i) {
    num_inside += unproject_or_clear(camera, first, &rays[i]);
    first.x_q16 = (int32_t)((uint32_t)first.x_q16 + (uint32_t)RG_PIXEL(1));
  }
  return num_inside;
}

uint32_t rg_unproject_lines(const rg_camera* camera, const rg_pixel* pixels,
                            rg_line* lines, uint32_t num_pixels) {
  uint32_t num_inside = 0;
  for (uint32_t i = 0; i < num_pixels; ++i) {
    rg_line* const line = &lines[i];
    if (rg_unproject_line(camera, pixels[i], line) == RG_OK) {
      ++num_inside;
    } else {
      line->direction.x_q30 = line->direction.y_q30 = line->direction.z_q30 = 0;
      line->point_q28[0] = line->point_q28[1] = line->point_q28[2] = 0;
    }
  }
  return num_inside;
}
