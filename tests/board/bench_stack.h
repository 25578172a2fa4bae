/* The camera of a stack, for the instruction counters. */
#ifndef RAYGRID_BENCH_STACK_H
#define RAYGRID_BENCH_STACK_H

#include "bench_scene.h"
#include "narrow_grid.h"

/* A stack of two knots with the grids of the narrow blob, and a table of parts
 * of a size, whose sources all lie inside: at the first knot, or between. */
static rg_status open_stack(uint8_t part_log2, int is_between,
                            rg_camera* camera) {
  static uint8_t bytes[4096] __attribute__((aligned(4)));
  static int16_t residuals[2][2 * 3 * 3], grid_points[512], back_points[512];
  static int8_t bends[2][4 * 3 * 3];
  static const uint8_t empty[4];
  rg_blob blob;
  rg_camera_section identity;
  rg_grid_section grid;
  rg_inverse_section inverse;
  rg_narrow_grid there, back;
  const rg_remap_section table = {.width = WIDTH,
                                  .height = HEIGHT,
                                  .columns = 3,
                                  .rows = 3,
                                  .block_log2 = 5,
                                  .part_log2 = part_log2,
                                  .max_x_q12 = 159 << 12,
                                  .max_y_q12 = 119 << 12,
                                  .origin_x_q12 = 9000,
                                  .origin_y_q12 = 9000,
                                  .column_step_x_q12 = 118000,
                                  .column_step_y_q12 = 2600,
                                  .row_step_x_q12 = -1200,
                                  .row_step_y_q12 = 70000,
                                  .fx_q16 = 1,
                                  .fy_q16 = 1,
                                  .empty_blocks = empty,
                                  .bends = bends[0]};
  rg_remap_section other = table;
  other.bends = bends[1];
  for (uint32_t k = 0; k < 2 * 3 * 3; ++k) residuals[1][k] = (int16_t)(40 * k);
  for (uint32_t k = 0; k < 4 * 3 * 3; ++k) bends[1][k] = (int8_t)(k % 7);
  rg_status status = rg_blob_open(kNarrowBlob, sizeof(kNarrowBlob), &blob);
  if (status != RG_OK) return status;
  rg_blob_camera(&blob, &identity);
  rg_blob_grid(&blob, &grid);
  rg_blob_inverse(&blob, &inverse);
  read_narrow_grid(blob.bytes + blob.grid, grid_points, &there);
  read_narrow_grid(blob.bytes + blob.inverse, back_points, &back);
  const rg_remap_contents remaps[2] = {{&table, residuals[0]},
                                       {&other, residuals[1]}};
  const rg_stack_sample_contents samples[2] = {
      {0, 0, &there, &back, &remaps[0]},
      {1 << 16, 0, &there, &back, &remaps[1]}};
  const rg_stack_contents stack = {RG_OPERATING_PARAMETER_LENS_POSITION, 2,
                                   samples};
  const rg_blob_contents contents = {.camera = &identity,
                                     .grid = &grid,
                                     .narrow = &there,
                                     .remap = &table,
                                     .residuals = residuals[0],
                                     .inverse = &inverse,
                                     .inverse_points = &back,
                                     .stack = &stack};
  status = rg_blob_write(&contents, bytes, sizeof(bytes));
  if (status == RG_OK) status = rg_camera_open(camera, bytes, sizeof(bytes));
  if (status == RG_OK) status = rg_select_remap(camera, 0);
  if (status != RG_OK) return status;
  return rg_set_operating_point(camera, is_between ? 1 << 15 : 0);
}

#endif /* RAYGRID_BENCH_STACK_H */
