/* Stacks of cameras over a condition: formats/SPEC.md, "Stack". */
#include "blob_checks.h"
#include "bytes.h"
#include "cortex_m/part_corners.h"
#include "fixed_point.h"
#include "raygrid.h"
#include "rays/surface_choice.h"
#include "rg_blob.h"
#include "stack_code.h"

/* The blob's stack, or NULL. */
static const uint8_t* find_stack(const rg_camera* camera, uint32_t* size) {
  const uint8_t* const entry = rg_find_entry(camera->blob, RG_SECTION_STACK, 0);
  if (!entry) return 0;
  *size = rg_load_u32(entry + RG_ENTRY_SIZE);
  return camera->blob + rg_load_u32(entry + RG_ENTRY_OFFSET);
}

static RG_INLINE const uint8_t* knots_of(const uint8_t* stack) {
  return stack + rg_load_u32(stack + RG_STACK_DATA_OFFSET);
}

/* ---- Use ----------------------------------------------------------------- */

/* The upper knot's value first: then one place will do. */
static RG_NOINLINE rg_status find_blended_place(const rg_camera* camera,
                                                int32_t x, int32_t y,
                                                rg_place* place,
                                                const uint8_t* grid) {
  rg_status status =
      rg_find_in_knot(camera, grid + camera->knot_size, x, y, place);
  if (status != RG_OK) return status;
  const int32_t upper_q27[2] = {place->value.q27[0], place->value.q27[1]};
  status = rg_find_in_knot(camera, grid, x, y, place);
  const int32_t weight_q31 = camera->weight_q14 << 17;
  for (int c = 0; c < 2; ++c) {
    const int32_t lower = place->value.q27[c];
    place->value.q27[c] = rg_multiply_high_add(
        lower, rg_shift_left(rg_subtract(upper_q27[c], lower), 1), weight_q31);
  }
  return status;
}

static rg_status find_in_grid(const rg_camera* camera, int32_t x, int32_t y,
                              rg_place* place) {
  return find_blended_place(camera, x, y, place, camera->grid);
}

static rg_status find_in_inverse(const rg_camera* camera, int32_t x, int32_t y,
                                 rg_place* place) {
  return find_blended_place(camera, x, y, place, camera->inverse);
}

#if RG_FAST_WALK
static rg_status check_vertices(const rg_camera* camera, const uint8_t* own) {
  uint32_t size;
  const uint8_t* const stack = find_stack(camera, &size);
  uint32_t rest = rg_load_u16(stack + RG_STACK_KNOTS);
  const uint8_t* table =
      knots_of(stack) + (own + (int32_t)camera->knot_shift - camera->grid);
  rg_status status;
  do {
    status = rg_check_vertices(table);
    table += camera->knot_size;
  } while (--rest != 0 && status == RG_OK);
  return status;
}
#define CHECK_VERTICES check_vertices
#else
#define CHECK_VERTICES 0 /* rg_select_remap() checks none */
#endif

static const rg_stack_code kStackCode = {find_in_grid, find_in_inverse,
                                         CHECK_VERTICES, RG_PASS_BLENDED_PART};

/* ---- Checks -------------------------------------------------------------- */

/* The types of sections that a knot has its like of, as bits of a word. Others
 * from 32 on are no such. */
#define LIKE_TYPES                                          \
  (1u << RG_SECTION_CENTRAL_GRID | 1u << RG_SECTION_REMAP | \
   1u << RG_SECTION_INVERSE)

/* Whether the bytes in front of the arrays of a section's like in each knot are
 * the section's own, but for a table's measured error.
 *
 * like  in the first knot */
static RG_INLINE int have_own_fields(const uint8_t* own, uint32_t num_bytes,
                                     const uint8_t* like, uint32_t num_knots,
                                     uint32_t knot_size) {
  do {
    for (uint32_t k = 0; k < num_bytes; k += 4)
      if (k != RG_REMAP_MAX_ERROR_UPX &&
          rg_load_u32(own + k) != rg_load_u32(like + k))
        return 0;
    like += knot_size;
  } while (--num_knots != 0);
  return 1;
}

/* Whether each knot has its like of the blob's sections. */
static RG_INLINE int are_knots_like_blob(const rg_camera* camera,
                                         const uint8_t* knots,
                                         uint32_t num_knots,
                                         uint32_t knot_size) {
  const uint8_t* entry = camera->blob + RG_HEADER_SIZE;
  uint32_t rest = rg_load_u16(camera->blob + RG_HEADER_SECTION_COUNT);
  do {
    const uint32_t type = rg_load_u16(entry + RG_ENTRY_TYPE);
    if (type < 32 && (LIKE_TYPES >> type & 1) != 0) {
      const uint8_t* const own =
          camera->blob + rg_load_u32(entry + RG_ENTRY_OFFSET);
      const uint32_t size = rg_load_u32(entry + RG_ENTRY_SIZE);
      const uint32_t place = (uint32_t)(own - camera->grid);
      const uint32_t data_offset =
          rg_load_u32(own + (type == RG_SECTION_REMAP ? RG_REMAP_DATA_OFFSET
                                                      : RG_GRID_DATA_OFFSET));
      if (place > knot_size || size > knot_size - place ||
          !have_own_fields(own, rg_lesser(data_offset, size), knots + place,
                           num_knots, knot_size))
        return 0;
    }
    entry += RG_SECTION_ENTRY_SIZE;
  } while (--rest != 0);
  return 1;
}

/* Checks the stack of a camera that was at no condition yet. */
static RG_INLINE rg_status check_stack(const rg_camera* camera,
                                       const uint8_t* stack, uint32_t size) {
  if (size < RG_STACK_FIELDS_SIZE) return RG_ERR_SECTION_SIZE;
  const uint32_t num_knots = rg_load_u16(stack + RG_STACK_KNOTS);
  if (num_knots - RG_MIN_KNOTS > RG_MAX_KNOTS - RG_MIN_KNOTS)
    return RG_ERR_STACK;
  const uint32_t knot_size = rg_load_u32(stack + RG_STACK_KNOT_SIZE);
  /* Distances are of 31 bits, which only matters to processors of 64. */
  if (knot_size % 4 != 0 ||
      (sizeof(stack) > 4 &&
       (uint32_t)(stack - camera->blob) + size > INT32_MAX))
    return RG_ERR_STACK;
  uint32_t knots_size;
  if (rg_multiply_unsigned(num_knots, knot_size, &knots_size) != 0)
    return RG_ERR_SECTION_SIZE;
  const rg_status status =
      rg_check_extent(stack + RG_STACK_DATA_OFFSET, size,
                      RG_STACK_FIELDS_SIZE + 4 * num_knots, knots_size);
  if (status != RG_OK) return status;
  return are_knots_like_blob(camera, knots_of(stack), num_knots, knot_size)
             ? RG_OK
             : RG_ERR_STACK;
}

/* ---- Conditions ---------------------------------------------------------- */

/* floor(part 2^14 / whole), for part < whole < 2^31; less than 2^14 in any
 * case. */
static uint16_t find_weight(uint32_t part, uint32_t whole) {
  uint32_t weight = 1; /* a bit that leaves it when all others are found */
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

rg_status rg_set_condition(rg_camera* camera, int32_t value_q16) {
  uint32_t size;
  const uint8_t* const stack = find_stack(camera, &size);
  if (!stack) return RG_ERR_NO_STACK;
  if (camera->line_points) return RG_ERR_NONCENTRAL;
  if (!camera->stack) {
    rg_status status = check_stack(camera, stack, size);
    if (status != RG_OK) return status;
    camera->knot_size = rg_load_u32(stack + RG_STACK_KNOT_SIZE);
    if (RG_FAST_WALK && camera->remap)
      status = kStackCode.check_vertices(camera, camera->remap);
    if (status != RG_OK) return status;
    camera->stack = &kStackCode;
  }
  const uint8_t* grid = knots_of(stack);
  const uint8_t* value = stack + RG_STACK_FIELDS_SIZE;
  uint32_t num_above = rg_load_u16(stack + RG_STACK_KNOTS) - 1u;
  while (num_above != 0 && rg_load_i32(value + 4) <= value_q16) {
    value += 4;
    grid += camera->knot_size;
    --num_above;
  }
  const int32_t moved = (int32_t)(grid - camera->grid);
  camera->knot_shift += (uint32_t)moved;
  camera->grid = grid;
  if (camera->inverse) camera->inverse += moved;
  if (camera->remap) camera->remap += moved;

  const int32_t lower_q16 = rg_load_i32(value);
  const uint32_t part_q16 = (uint32_t)value_q16 - (uint32_t)lower_q16;
  camera->weight_q14 = 0;
  if (part_q16 == 0) return RG_OK;
  if (value_q16 < lower_q16 || num_above == 0) return RG_EXTRAPOLATED;
  camera->weight_q14 =
      find_weight(part_q16, rg_load_u32(value + 4) - (uint32_t)lower_q16);
  return RG_OK;
}
