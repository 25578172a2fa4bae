/* Dispatch of surface functions to the code selected for a camera. */
#ifndef RAYGRID_SURFACE_CHOICE_H
#define RAYGRID_SURFACE_CHOICE_H

#include "operating_point_ops.h"
#include "rays/surface.h"
#include "rays/surface_avx2.h"

/* The values of rg_camera.surface. */
#define RG_SURFACE_PORTABLE 0
#define RG_SURFACE_AVX2 1

/* Returns the fastest code that the processor supports. */
static RG_INLINE uint16_t rg_select_surface(void) {
  return RG_SELECT_SURFACE && rg_has_avx2_surface() ? RG_SURFACE_AVX2
                                                    : RG_SURFACE_PORTABLE;
}

/* rg_evaluate_spline() in a grid, without interpolation between samples. */
static RG_INLINE rg_status
rg_evaluate_in_sample(const rg_camera* camera, const uint8_t* grid, int32_t x,
                      int32_t y, rg_grid_position* grid_position) {
  if (RG_SELECT_SURFACE && camera->surface == RG_SURFACE_AVX2)
    return rg_evaluate_spline_avx2(grid, x, y, grid_position);
  return rg_evaluate_spline(grid, x, y, grid_position);
}

/* rg_evaluate_spline() in the camera's central grid, at its operating point. */
static RG_INLINE rg_status rg_evaluate_grid(const rg_camera* camera, int32_t x,
                                            int32_t y,
                                            rg_grid_position* grid_position) {
  if (camera->weight_q14 != 0)
    return camera->stack->evaluate_grid(camera, x, y, grid_position);
  return rg_evaluate_in_sample(camera, camera->grid, x, y, grid_position);
}

/* rg_evaluate_spline() in the camera's inverse grid, at its operating point. */
static RG_INLINE rg_status
rg_evaluate_inverse(const rg_camera* camera, int32_t x, int32_t y,
                    rg_grid_position* grid_position) {
  if (camera->weight_q14 != 0)
    return camera->stack->evaluate_inverse(camera, x, y, grid_position);
  return rg_evaluate_in_sample(camera, camera->inverse, x, y, grid_position);
}

/* rg_compute_jacobian() in the camera's inverse grid. */
static RG_INLINE void rg_compute_inverse_jacobian(
    const rg_camera* camera, const rg_grid_position* grid_position,
    int32_t jacobian_q5[2][2]) {
  if (RG_SELECT_SURFACE && camera->surface == RG_SURFACE_AVX2)
    rg_compute_jacobian_avx2(camera->inverse, grid_position, jacobian_q5);
  else
    rg_compute_jacobian(camera->inverse, grid_position, jacobian_q5);
}

#endif /* RAYGRID_SURFACE_CHOICE_H */
