#include "rays/surface.h"

#include "bytes.h"
#include "cortex_m/grid_rows.h"
#include "fixed_point.h"
#include "rays/bspline.h"
#include "rg_blob.h"

/* The part of rg_evaluate_spline() that is specific to 32-bit control points.
 */
static RG_INLINE void compute_32_bit_value(const uint8_t* grid,
                                           rg_grid_position* grid_position) {
  int32_t sums_q27[2];
  RG_SUM_POINTS(grid + rg_load_u32(grid + RG_GRID_DATA_OFFSET) +
                    RG_CONTROL_POINT_SIZE * grid_position->first,
                rg_load_u16(grid + RG_GRID_COLUMNS), grid_position->weights_q31,
                sums_q27);
  grid_position->value.q27[0] = sums_q27[0];
  grid_position->value.q27[1] = sums_q27[1];
}

/* The part of rg_evaluate_spline() that is specific to 16-bit control points.
 */
static void compute_16_bit_value(const uint8_t* grid,
                                 rg_grid_position* grid_position) {
  RG_FORGET(grid); /* saves registers in the other branch */
  int32_t sums[2];
  RG_SUM_RESIDUALS(grid + rg_load_u32(grid + RG_GRID_DATA_OFFSET) +
                       RG_NARROW_PLANE_SIZE +
                       RG_NARROW_POINT_SIZE * grid_position->first,
                   rg_load_u16(grid + RG_GRID_COLUMNS),
                   1 << (rg_load_u16(grid + RG_GRID_FRACTION_BITS) - 14),
                   grid_position->weights_q31, sums);
  grid_position->value.q27[0] = sums[0];
  grid_position->value.q27[1] = sums[1];
  const uint8_t* plane = grid + rg_load_u32(grid + RG_GRID_DATA_OFFSET);
  const int shift =
      rg_load_u16(grid + RG_GRID_FRACTION_BITS) - 13; /* from 2^14 to q27 */
  int32_t* value = grid_position->value.q27;
  RG_UNROLL
  for (int c = 0; c < 2; ++c)
    value[c] = rg_add(rg_evaluate_plane(plane + 4 * c, grid_position),
                      value[c] >> shift);
}

rg_status rg_evaluate_spline(const uint8_t* grid, int32_t x, int32_t y,
                             rg_grid_position* grid_position) {
  if (!rg_find_cells(grid, x, y, grid_position)) return RG_ERR_OUTSIDE_AREA;
  rg_bspline_weights(grid_position->t_q30[1], grid_position->weights_q31[1]);
  rg_bspline_weights(grid_position->t_q30[0], grid_position->weights_q31[0]);
  if (rg_load_u16(grid + RG_GRID_FRACTION_BITS) == RG_CONTROL_POINT_BITS)
    compute_32_bit_value(grid, grid_position);
  else
    compute_16_bit_value(grid, grid_position);
  return RG_OK;
}

/* Interpolates from a to b by t_q7 / 128; the result is times 128. */
static RG_INLINE int32_t blend(int32_t a, int32_t b, int32_t t_q7) {
  return 128 * a + t_q7 * (b - a);
}

/* The derivative of one coordinate of the residuals with respect to the cell
 * coordinate, times 2^15: the sum of differences over two cells, bilinear
 * between the four surrounding knots; the residuals are `apart` bytes apart. */
static RG_SHARED int32_t compute_slope(const uint8_t* residual, uint32_t apart,
                                       uint32_t row_bytes,
                                       const rg_grid_position* grid_position) {
  const int32_t x_q7 = grid_position->t_q30[0] >> 23;
  const int32_t y_q7 = grid_position->t_q30[1] >> 23;
  int32_t above = 0, below = 0;
  uint32_t rows = 2;
  RG_FORGET(rows); /* prevents full unrolling */
  RG_UNROLL
  do {
    const uint8_t* const right = residual + RG_NARROW_POINT_SIZE;
    above = below;
    below = blend(rg_load_i16(residual + apart) - rg_load_i16(residual),
                  rg_load_i16(right + apart) - rg_load_i16(right), x_q7);
    residual += row_bytes;
  } while (--rows != 0);
  return blend(above, below, y_q7);
}

void rg_compute_jacobian(const uint8_t* inverse,
                         const rg_grid_position* grid_position,
                         int32_t jacobian_q5[2][2]) {
  const uint8_t* plane =
      inverse + rg_load_u32(inverse + RG_INVERSE_DATA_OFFSET);
  const uint8_t* residual = plane + RG_NARROW_PLANE_SIZE +
                            RG_NARROW_POINT_SIZE * grid_position->first;
  const uint32_t row_bytes =
      RG_NARROW_POINT_SIZE * rg_load_u16(inverse + RG_INVERSE_COLUMNS);
  const uint32_t shift =
      rg_load_u16(inverse + RG_INVERSE_FRACTION_BITS) - RG_NARROW_MIN_BITS;
  const int32_t x_scale_q20 =
      (int32_t)(rg_load_u32(inverse + RG_INVERSE_SCALE_A) >> 1);
  const int32_t y_scale_q20 =
      (int32_t)(rg_load_u32(inverse + RG_INVERSE_SCALE_B) >> 1);
  RG_UNROLL
  for (uint32_t c = 0; c < 2; ++c, plane += 4, residual += 2) {
    const int32_t across =
        compute_slope(residual + row_bytes, 2 * RG_NARROW_POINT_SIZE, row_bytes,
                      grid_position);
    const int32_t down = compute_slope(residual + RG_NARROW_POINT_SIZE,
                                       2 * row_bytes, row_bytes, grid_position);
    jacobian_q5[0][c] = rg_multiply_high(
        rg_add(rg_load_i32(plane + RG_PLANE_COLUMN_STEP), across >> shift),
        x_scale_q20);
    jacobian_q5[1][c] = rg_multiply_high(
        rg_add(rg_load_i32(plane + RG_PLANE_ROW_STEP), down >> shift),
        y_scale_q20);
  }
}
