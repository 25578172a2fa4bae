/* The source positions of a component's pixels, in component pixels:
 * formats/SPEC.md, "Components". */
#ifndef RAYGRID_COMPONENT_MAP_H
#define RAYGRID_COMPONENT_MAP_H

#include <stdint.h>

#include "blob_layout.h"
#include "bytes.h"
#include "kernels/block.h"
#include "kernels/samples.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Converts image coordinate c, q12, to component pixels; bias is added before
 * halving for subsampled components. */
static inline int32_t rg_to_component(const rg_component* component, int c,
                                      int32_t q12, int32_t bias) {
  const uint32_t log2 = component->log2[c]; /* 0 or 1 */
  const uint32_t moved = (uint32_t)q12 - component->half[c] * 2048u;
  return (int32_t)(moved + (uint32_t)bias * log2) >> log2;
}

/* Inclusive range of one coordinate. */
typedef struct rg_range {
  int32_t min_q12, max_q12;
} rg_range;

/* Range of coordinate c in which positions have a source pixel. */
static RG_INLINE rg_range rg_source_range(const uint8_t* section,
                                          const rg_component* component,
                                          int c) {
  const uint8_t* const field = section + RG_REMAP_MIN_X + 4 * c;
  const rg_range range = {
      rg_to_component(component, c, rg_load_i32(field), 1),
      rg_to_component(component, c, rg_load_i32(field + RG_REMAP_MIN_TO_MAX),
                      0)};
  return range;
}

/* log2 of the width (axis 0) or height (1) of tiles in output pixels: as in the
 * table, but at least 16 px for chroma, 8 chroma pixels. */
static inline uint8_t rg_tile_log2(const uint8_t* section,
                                   const rg_component* component, int axis) {
  const uint8_t tile_log2 = section[RG_REMAP_PART_LOG2];
  if (tile_log2 == 0) return section[RG_REMAP_BLOCK_LOG2];
  return tile_log2 < 4 && component->half[axis] == 1 ? 4 : tile_log2;
}

/* Transforms the corners of a tile of the given width in output pixels to
 * component pixels. */
void rg_transform_corners(const rg_component* component,
                          uint32_t tile_width_log2, rg_position corners[4]);

/* Transforms the corners and the size of a tile to component pixels. */
void rg_transform_block(const rg_component* component, rg_block* block);

static inline int32_t rg_clamp(int32_t value, int32_t min, int32_t max) {
  return value < min ? min : value > max ? max : value;
}

#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_COMPONENT_MAP_H */
