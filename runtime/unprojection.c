/* Pixel -> direction. Error budget in runtime/README.md. */
#include "raygrid.h"
#include "surface.h"

rg_status rg_unproject(const rg_camera* camera, rg_pixel pixel, rg_ray* ray) {
  rg_place place;
  if (camera->line_points) return RG_ERR_NONCENTRAL;
  if (!rg_find_place(camera, pixel.x_q16, pixel.y_q16, &place))
    return RG_ERR_OUTSIDE_AREA;
  rg_direction_of(&place.position, ray);
  return RG_OK;
}

rg_status rg_unproject_line(const rg_camera* camera, rg_pixel pixel,
                            rg_line* line) {
  rg_place place;
  if (!rg_find_place(camera, pixel.x_q16, pixel.y_q16, &place))
    return RG_ERR_OUTSIDE_AREA;
  rg_direction_of(&place.position, &line->direction);
  line->point_q28[0] = line->point_q28[1] = line->point_q28[2] = 0;
  if (camera->line_points)
    rg_surface_line_point(camera, &place, line->point_q28);
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
