/* Pixel -> direction. Error budget in runtime/DESIGN.md. */
#include "blob_layout.h"
#include "bytes.h"
#include "cortex_m/grid_rows.h"
#include "fixed_point.h"
#include "raygrid.h"
#include "rays/surface_choice.h"

/* rg_chart_to_direction(), not inlined where size matters. */
static RG_SHARED void compute_direction(int32_t a_q27, int32_t b_q27,
                                        rg_ray* ray) {
  const rg_chart_point point = {{a_q27, b_q27}};
  rg_chart_to_direction(&point, ray);
}

rg_status rg_unproject(const rg_camera* camera, rg_pixel pixel, rg_ray* ray) {
  rg_grid_position grid_position;
  if (camera->line_points) return RG_ERR_NONCENTRAL;
  const rg_status status =
      rg_evaluate_grid(camera, pixel.x_q16, pixel.y_q16, &grid_position);
  if (status == RG_OK)
    compute_direction(grid_position.value.q27[0], grid_position.value.q27[1],
                      ray);
  return status;
}

/* (0, 0, 0) of a central camera. */
static RG_INLINE void compute_line_point(const rg_camera* camera,
                                         const rg_grid_position* grid_position,
                                         int32_t point_q28[3]) {
  int32_t sums_q26[3] = {0, 0, 0};
  if (camera->line_points) {
    const uint8_t* points =
        camera->line_points + RG_LINE_POINT_SIZE * grid_position->first;
    const int32_t* row_weight = grid_position->weights_q31[1];
    uint32_t rest_of_row =
        3 * (rg_load_u16(camera->grid + RG_GRID_COLUMNS) - 3u); /* words */
    RG_UNROLL
    do
      points = RG_ADD_LINE_ROW(points, grid_position->weights_q31[0],
                               &row_weight, sums_q26) +
               4 * rest_of_row;
    while (rg_next_iteration(&rest_of_row));
  }
  RG_IN_MEMORY(point_q28);
  point_q28[0] = rg_shift_left(sums_q26[0], 2);
  point_q28[1] = rg_shift_left(sums_q26[1], 2);
  point_q28[2] = rg_shift_left(sums_q26[2], 2);
}

rg_status rg_unproject_line(const rg_camera* camera, rg_pixel pixel,
                            rg_line* line) {
  rg_grid_position grid_position;
  rg_status status =
      rg_evaluate_grid(camera, pixel.x_q16, pixel.y_q16, &grid_position);
  if (status == RG_OK) {
    compute_direction(grid_position.value.q27[0], grid_position.value.q27[1],
                      &line->direction);
    RG_IN_MEMORY(status);
    compute_line_point(camera, &grid_position, line->point_q28);
  }
  return status;
}

uint32_t rg_unproject_batch(const rg_camera* camera, const rg_pixel* pixels,
                            rg_ray* rays, uint32_t num_pixels) {
  uint32_t num_inside = 0;
  for (; num_pixels > 0; --num_pixels, ++pixels, ++rays) {
    if (rg_unproject(camera, *pixels, rays) == RG_OK)
      ++num_inside;
    else
      rays->x_q30 = rays->y_q30 = rays->z_q30 = 0;
  }
  return num_inside;
}

uint32_t rg_unproject_row(const rg_camera* camera, rg_pixel first, rg_ray* rays,
                          uint32_t num_pixels) {
  uint32_t num_inside = 0;
  for (; num_pixels > 0; --num_pixels, ++rays) {
    num_inside += rg_unproject_batch(camera, &first, rays, 1);
    first.x_q16 = rg_add(first.x_q16, RG_PIXEL(1));
  }
  return num_inside;
}

uint32_t rg_unproject_lines(const rg_camera* camera, const rg_pixel* pixels,
                            rg_line* lines, uint32_t num_pixels) {
  uint32_t num_inside = 0;
  for (; num_pixels > 0; --num_pixels, ++pixels, ++lines) {
    if (rg_unproject_line(camera, *pixels, lines) == RG_OK) {
      ++num_inside;
    } else {
      lines->direction.x_q30 = lines->direction.y_q30 = lines->direction.z_q30 =
          0;
      lines->point_q28[0] = lines->point_q28[1] = lines->point_q28[2] = 0;
    }
  }
  return num_inside;
}
