#include "frames/component_map.h"

/* The difference of coordinate c between two positions; modulo 2^32. */
static uint32_t compute_edge(const rg_position* from, const rg_position* to,
                             int c) {
  return (uint32_t)to->q12[c] - (uint32_t)from->q12[c];
}

/* Shifts by (half[0], half[1]) half output pixels, along the adjacent edges of
 * each corner, then converts image to component coordinates. */
void rg_transform_corners(const rg_component* component,
                          uint32_t tile_width_log2, rg_position corners[4]) {
  if ((component->log2[0] | component->log2[1]) == 0) return; /* image pixels */
  const uint32_t shift = tile_width_log2 + 1;
  for (int c = 0; c < 2; ++c) {
    rg_position* corner = corners;
    const uint32_t half_y = component->half[1];
    const uint32_t left = compute_edge(&corner[0], &corner[2], c) * half_y;
    const uint32_t right = compute_edge(&corner[1], &corner[3], c) * half_y;
    for (int k = 0; k < 2; ++k, corner += 2) {
      const int32_t from = corner[0].q12[c], to = corner[1].q12[c];
      const uint32_t edge =
          compute_edge(&corner[0], &corner[1], c) * component->half[0];
      corner[0].q12[c] = rg_to_component(
          component, c, rg_add(from, rg_round_shift(edge + left, shift)), 1);
      corner[1].q12[c] = rg_to_component(
          component, c, rg_add(to, rg_round_shift(edge + right, shift)), 1);
    }
  }
}

void rg_transform_block(const rg_component* component, rg_block* block) {
  rg_transform_corners(component, block->width_log2, block->corners);
  block->width_log2 = (uint8_t)(block->width_log2 - component->log2[0]);
  block->height_log2 = (uint8_t)(block->height_log2 - component->log2[1]);
}
