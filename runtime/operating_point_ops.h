/* Interpolation between samples of the operating-point stack. The functions are
 * only called through the pointers that rg_set_operating_point() stores in a
 * camera, so that programs without that call do not link them. */
#ifndef RAYGRID_OPERATING_POINT_OPS_H
#define RAYGRID_OPERATING_POINT_OPS_H

#include "code_size.h"
#include "raygrid.h"

#ifdef __cplusplus
extern "C" {
#endif

struct rg_grid_position;
struct rg_tile_row;
struct rg_position;

typedef struct rg_operating_point_ops {
  /* rg_evaluate_spline() in the central and in the inverse grid, interpolated
   * between two samples: if weight_q14 is not 0. */
  rg_status (*evaluate_grid)(const rg_camera* camera, int32_t x, int32_t y,
                             struct rg_grid_position* place);
  rg_status (*evaluate_inverse)(const rg_camera* camera, int32_t x, int32_t y,
                                struct rg_grid_position* place);
  /* rg_check_vertices() of a table of the blob in all samples, for the fast
   * traversal. */
  rg_status (*check_vertices)(const rg_camera* camera, const uint8_t* own);
  /* rg_next_tile() interpolated between two samples, if weight_q14 is not 0;
   * for the small traversal. */
  void (*next_tile)(struct rg_tile_row* parts, struct rg_position* corners,
                    const rg_camera* camera);
} rg_operating_point_ops;

/* Interpolation between stored values of the lower and of the upper sample. */
#define RG_WEIGHT_BITS 14
#define RG_WEIGHT_MASK 0x3fffu
#define RG_HALF_WEIGHT (1 << (RG_WEIGHT_BITS - 1))
#define RG_BLEND_STORED(lower, upper, weight) \
  ((lower) +                                  \
   (((weight) * ((upper) - (lower)) + RG_HALF_WEIGHT) >> RG_WEIGHT_BITS))

#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_OPERATING_POINT_OPS_H */
