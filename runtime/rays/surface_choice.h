/* Dispatch of surface functions to the code selected for a camera. */
#ifndef RAYGRID_SURFACE_CHOICE_H
#define RAYGRID_SURFACE_CHOICE_H

#include "rays/surface.h"
#include "rays/surface_avx2.h"
#include "stack_code.h"

/* The values of rg_camera.surface. */
#define RG_SURFACE_PORTABLE 0
#define RG_SURFACE_AVX2 1

/* Returns the fastest code that the processor supports. */
static RG_INLINE uint16_t rg_best_surface(void) {
  return RG_CHOOSE_SURFACE && rg_has_avx2_surface() ? RG_SURFACE_AVX2
                                                    : RG_SURFACE_PORTABLE;
}

/* rg_find_place() in a grid, without interpolation between samples. */
static RG_INLINE rg_status rg_find_in_knot(const rg_camera* camera,
                                           const uint8_t* grid, int32_t x,
                                           int32_t y, rg_place* place) {
  if (RG_CHOOSE_SURFACE && camera->surface == RG_SURFACE_AVX2)
    return rg_find_place_avx2(grid, x, y, place);
  return rg_find_place(grid, x, y, place);
}

/* rg_find_place() in the camera's central grid, at its operating point. */
static RG_INLINE rg_status rg_find_in_grid(const rg_camera* camera, int32_t x,
                                           int32_t y, rg_place* place) {
  if (camera->weight_q14 != 0)
    return camera->stack->find_in_grid(camera, x, y, place);
  return rg_find_in_knot(camera, camera->grid, x, y, place);
}

/* rg_find_place() in the camera's inverse grid, at its operating point. */
static RG_INLINE rg_status rg_find_in_inverse(const rg_camera* camera,
                                              int32_t x, int32_t y,
                                              rg_place* place) {
  if (camera->weight_q14 != 0)
    return camera->stack->find_in_inverse(camera, x, y, place);
  return rg_find_in_knot(camera, camera->inverse, x, y, place);
}

/* rg_find_slopes() in the camera's inverse grid. */
static RG_INLINE void rg_find_inverse_slopes(const rg_camera* camera,
                                             const rg_place* place,
                                             int32_t slopes_q5[2][2]) {
  if (RG_CHOOSE_SURFACE && camera->surface == RG_SURFACE_AVX2)
    rg_find_slopes_avx2(camera->inverse, place, slopes_q5);
  else
    rg_find_slopes(camera->inverse, place, slopes_q5);
}

#endif /* RAYGRID_SURFACE_CHOICE_H */
