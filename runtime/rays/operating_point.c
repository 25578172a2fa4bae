/* Operating-point models: formats/SPEC.md, "Operating points". */
#include "blob_checks.h"
#include "bytes.h"
#include "cortex_m/tile_corners.h"
#include "fixed_point.h"
#include "operating_point_ops.h"
#include "raygrid.h"
#include "rays/surface_choice.h"
#include "rg_blob.h"

/* A blob's operating-point model. From the central grid to its end, the blob
 * consists of pieces of equal size: its own grids and tables with the model's
 * fields, then samples with their values. Nothing follows the model. Therefore,
 * the counterpart of any section of the blob, in any complete sample, is inside
 * the blob. An offset plus a sample's size is at most the blob's size. */
typedef struct operating_point_grid {
  const uint8_t* section;
  uint32_t size;            /* size of the section */
  const uint8_t* base_grid; /* the blob's */
  uint32_t sample_size;     /* from one piece to the next */
} operating_point_grid;

/* Finds the model; 0 if the blob has none. */
static RG_INLINE int find_stack(const rg_camera* camera,
                                operating_point_grid* stack) {
  const uint8_t* const blob = camera->blob;
  const uint8_t* const last_entry =
      blob + RG_HEADER_SIZE - RG_SECTION_ENTRY_SIZE +
      RG_SECTION_ENTRY_SIZE * rg_load_u16(blob + RG_HEADER_SECTION_COUNT);
  if (rg_load_u16(last_entry + RG_ENTRY_TYPE) != RG_SECTION_STACK) return 0;
  stack->section = blob + rg_load_u32(last_entry + RG_ENTRY_OFFSET);
  stack->size = rg_load_u32(last_entry + RG_ENTRY_SIZE);
  stack->base_grid = camera->grid - camera->sample_shift;
  stack->sample_size =
      (uint32_t)(stack->section - stack->base_grid) + RG_STACK_FIELDS_SIZE;
  return 1;
}

/* ---- Evaluation ---------------------------------------------------------- */

/* Evaluates the upper sample first, so that one grid position suffices. */
static RG_NOINLINE rg_status
evaluate_blended_spline(const rg_camera* camera, int32_t x, int32_t y,
                        rg_grid_position* grid_position, const uint8_t* grid) {
  rg_status status = rg_evaluate_in_sample(camera, grid + camera->sample_size,
                                           x, y, grid_position);
  if (status != RG_OK) return status;
  const int32_t upper_q27[2] = {grid_position->value.q27[0],
                                grid_position->value.q27[1]};
  status = rg_evaluate_in_sample(camera, grid, x, y, grid_position);
  const int32_t weight_q31 = camera->weight_q14 << 17;
  for (int c = 0; c < 2; ++c) {
    const int32_t lower = grid_position->value.q27[c];
    grid_position->value.q27[c] = rg_multiply_high_add(
        lower, rg_shift_left(rg_subtract(upper_q27[c], lower), 1), weight_q31);
  }
  return status;
}

static rg_status evaluate_grid(const rg_camera* camera, int32_t x, int32_t y,
                               rg_grid_position* grid_position) {
  return evaluate_blended_spline(camera, x, y, grid_position, camera->grid);
}

static rg_status evaluate_inverse(const rg_camera* camera, int32_t x, int32_t y,
                                  rg_grid_position* grid_position) {
  return evaluate_blended_spline(camera, x, y, grid_position, camera->inverse);
}

#if RG_FAST_TRAVERSAL
static rg_status check_vertices(const rg_camera* camera, const uint8_t* own) {
  operating_point_grid stack;
  if (!find_stack(camera, &stack)) return RG_ERR_NO_STACK;
  rg_status status = RG_OK;
  for (uint32_t shift = stack.sample_size;
       shift < stack.size && status == RG_OK; shift += stack.sample_size)
    status = rg_check_vertices(own, rg_find_vertices(own) + shift);
  return status;
}
#define CHECK_VERTICES check_vertices
#else
#define CHECK_VERTICES 0 /* not checked by rg_select_remap() */
#endif

static const rg_operating_point_ops kOperatingPointOps = {
    evaluate_grid, evaluate_inverse, CHECK_VERTICES, RG_NEXT_BLENDED_TILE};

/* ---- Checks -------------------------------------------------------------- */

/* Whether a grid has the same fields as the blob's own in all samples. */
static RG_NOINLINE int has_same_grid_fields(const uint8_t* own,
                                            uint32_t sample_size,
                                            uint32_t section_size) {
  for (uint32_t shift = sample_size; shift < section_size; shift += sample_size)
    for (uint32_t k = 0; k < RG_GRID_FIELDS_SIZE; k += 4)
      if (rg_load_u32(own + k) != rg_load_u32(own + shift + k)) return 0;
  return 1;
}

/* Checks the complete samples of a model before its first use. The fields of
 * tables in samples are never read. */
static RG_INLINE rg_status check_stack(const rg_camera* camera,
                                       const operating_point_grid* stack) {
  if (!has_same_grid_fields(stack->base_grid, stack->sample_size,
                            stack->size) ||
      (camera->inverse &&
       !has_same_grid_fields(camera->inverse, stack->sample_size, stack->size)))
    return RG_ERR_STACK;
  return RG_FAST_TRAVERSAL && camera->remap
             ? kOperatingPointOps.check_vertices(camera, camera->remap)
             : RG_OK;
}

/* ---- Conditions ---------------------------------------------------------- */

/* floor(part 2^14 / whole), for part < whole < 2^31; always less than 2^14. */
static uint16_t compute_weight(uint32_t part, uint32_t whole) {
  uint32_t weight = 1; /* shifted out when all others are found */
  do {
    part *= 2;
    weight *= 2;
    if (part >= whole) {
      part -= whole;
      ++weight;
    }
  } while (weight >> RG_WEIGHT_BITS == 0);
  return (uint16_t)(weight & RG_WEIGHT_MASK);
}

/* The offset in bytes from the blob's own sections to those of the lower
 * sample. The value of a sample has the same offset from the model's fields. */
static RG_INLINE uint32_t find_lower_sample(const operating_point_grid* stack,
                                            int32_t value_q16) {
  uint32_t shift = stack->sample_size;
  while (stack->size - shift > stack->sample_size &&
         rg_load_i32(stack->section + shift + stack->sample_size) <= value_q16)
    shift += stack->sample_size;
  return shift;
}

/* Moves the camera's sections to a sample, from the current one or the blob's
 * own. */
static RG_INLINE void move_to_sample(rg_camera* camera,
                                     const operating_point_grid* stack,
                                     uint32_t shift) {
  if (camera->inverse)
    camera->inverse += (ptrdiff_t)shift - (ptrdiff_t)camera->sample_shift;
  camera->grid = stack->base_grid + shift;
  camera->sample_shift = shift;
}

rg_status rg_set_operating_point(rg_camera* camera, int32_t value_q16) {
  operating_point_grid stack;
  if (!find_stack(camera, &stack)) return RG_ERR_NO_STACK;
  if (camera->line_points || stack.size <= stack.sample_size)
    return RG_ERR_STACK;
  if (!camera->stack) {
    const rg_status status = check_stack(camera, &stack);
    if (status != RG_OK) return status;
    camera->sample_size = stack.sample_size;
    camera->stack = &kOperatingPointOps;
  }
  const uint32_t shift = find_lower_sample(&stack, value_q16);
  move_to_sample(camera, &stack, shift);

  const uint8_t* const lower = stack.section + shift;
  const int32_t lower_q16 = rg_load_i32(lower);
  const uint32_t part_q16 = (uint32_t)value_q16 - (uint32_t)lower_q16;
  camera->weight_q14 = 0;
  if (value_q16 >= lower_q16 && stack.size - shift > stack.sample_size) {
    camera->weight_q14 = compute_weight(
        part_q16, rg_load_u32(lower + stack.sample_size) - (uint32_t)lower_q16);
    return RG_OK;
  }
  return part_q16 == 0 ? RG_OK : RG_EXTRAPOLATED;
}
