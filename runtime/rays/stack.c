/* Stacks of cameras over a condition: formats/SPEC.md, "Stack". */
#include "blob_checks.h"
#include "bytes.h"
#include "cortex_m/part_corners.h"
#include "fixed_point.h"
#include "raygrid.h"
#include "rays/surface_choice.h"
#include "rg_blob.h"
#include "stack_code.h"

/* ---- Knots --------------------------------------------------------------- */

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

/* The types of sections that a knot has its like of, as bits of a word. Others
 * from 32 on are no such. */
#define LIKE_TYPES                                          \
  (1u << RG_SECTION_CENTRAL_GRID | 1u << RG_SECTION_REMAP | \
   1u << RG_SECTION_INVERSE)

/* Whether the bytes in front of the arrays of a knot's grid or table are those
 * of the blob's own section, but for a table's measured error. */
static int is_part_like_own(const uint8_t* own, const uint8_t* part,
                            uint32_t type, uint32_t size) {
  const uint32_t end = rg_lesser(
      rg_load_u32(own + (type == RG_SECTION_REMAP ? RG_REMAP_DATA_OFFSET
                                                  : RG_GRID_DATA_OFFSET)),
      size);
  for (uint32_t k = 0; k < end; k += 4)
    if (k != RG_REMAP_MAX_ERROR_UPX &&
        rg_load_u32(own + k) != rg_load_u32(part + k))
      return 0;
  return 1;
}

/* Goes over the blob's sections that a knot has its like of, up to the one that
 * begins at an offset. Returns their sizes' sum: where the like of that one
 * lies in a knot. Below 2^32, since they lie in the blob.
 *
 * knots      NULL; or else UINT32_MAX is returned if the fields of one of so
 *            many knots are others
 * knot_size  bytes from one to the next */
static uint32_t find_in_knot(const rg_camera* camera, uint32_t end_offset,
                             const uint8_t* knots, uint32_t num_knots,
                             uint32_t knot_size) {
  const uint8_t* entry = camera->blob + RG_HEADER_SIZE;
  uint32_t rest = rg_load_u16(camera->blob + RG_HEADER_SECTION_COUNT);
  uint32_t place = 0;
  do {
    const uint32_t type = rg_load_u16(entry + RG_ENTRY_TYPE);
    const uint32_t offset = rg_load_u32(entry + RG_ENTRY_OFFSET);
    const uint32_t size = rg_load_u32(entry + RG_ENTRY_SIZE);
    if (offset == end_offset) break;
    if (type < 32 && (LIKE_TYPES >> type & 1) != 0) {
      const uint8_t* part = knots + place;
      for (uint32_t k = 0; k != num_knots; ++k, part += knot_size)
        if (!is_part_like_own(camera->blob + offset, part, type, size))
          return UINT32_MAX;
      place += size;
    }
    entry += RG_SECTION_ENTRY_SIZE;
  } while (--rest != 0);
  return place;
}

/* The like of a section of the blob in a knot. */
static const uint8_t* find_like(const rg_camera* camera, const uint8_t* knot,
                                const uint8_t* section) {
  return knot +
         find_in_knot(camera, (uint32_t)(section - camera->blob), knot, 0, 0);
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

/* The fast walk relies on vertices, the small one does not. */
static rg_status check_vertices(const uint8_t* table, uint32_t num_knots,
                                uint32_t knot_size) {
  rg_status status = RG_OK;
  for (; RG_FAST_WALK && num_knots != 0 && status == RG_OK; --num_knots) {
    status = rg_check_vertices(table);
    table += knot_size;
  }
  return status;
}

static rg_status find_table_of_knot(const rg_camera* camera,
                                    const uint8_t** section) {
  /* A knot begins with the like of the section that stands first: mostly the
   * grid, but perhaps not. */
  uint32_t size;
  const uint8_t* const stack = find_stack(camera, &size);
  const uint8_t* const table = find_like(camera, knots_of(stack), *section);
  *section = table + camera->knot * camera->knot_size;
  return check_vertices(table, rg_load_u16(stack + RG_STACK_KNOTS),
                        camera->knot_size);
}

static const rg_stack_code kStackCode = {
    find_in_grid, find_in_inverse, find_table_of_knot, RG_NEXT_BLENDED_CORNERS};

/* ---- Conditions ---------------------------------------------------------- */

/* Checks the stack, and puts the first knot in use. */
static RG_INLINE rg_status start(rg_camera* camera, const uint8_t* stack,
                                 uint32_t size) {
  if (size < RG_STACK_FIELDS_SIZE) return RG_ERR_SECTION_SIZE;
  const uint32_t num_knots = rg_load_u16(stack + RG_STACK_KNOTS);
  if (num_knots - RG_MIN_KNOTS > RG_MAX_KNOTS - RG_MIN_KNOTS)
    return RG_ERR_STACK;
  const uint32_t knot_size = find_in_knot(camera, 0, stack, 0, 0);
  uint32_t knots_size;
  if (rg_multiply_unsigned(num_knots, knot_size, &knots_size) != 0)
    return RG_ERR_SECTION_SIZE;
  rg_status status =
      rg_check_extent(stack + RG_STACK_DATA_OFFSET, size,
                      RG_STACK_FIELDS_SIZE + 4 * num_knots, knots_size);
  if (status != RG_OK) return status;
  const uint8_t* const knots = knots_of(stack);
  if (find_in_knot(camera, 0, knots, num_knots, knot_size) == UINT32_MAX)
    return RG_ERR_STACK;
  const uint8_t* table = 0;
  if (camera->remap) {
    table = find_like(camera, knots, camera->remap);
    status = check_vertices(table, num_knots, knot_size);
    if (status != RG_OK) return status;
  }
  camera->grid = find_like(camera, knots, camera->grid);
  if (camera->inverse)
    camera->inverse = find_like(camera, knots, camera->inverse);
  camera->remap = table;
  camera->stack = &kStackCode;
  camera->knot_size = knot_size;
  camera->knot = 0;
  return RG_OK;
}

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
    const rg_status status = start(camera, stack, size);
    if (status != RG_OK) return status;
  }
  const uint8_t* value = stack + RG_STACK_FIELDS_SIZE;
  const uint32_t last = rg_load_u16(stack + RG_STACK_KNOTS) - 1u;
  uint32_t knot = 0;
  while (knot != last && rg_load_i32(value + 4) <= value_q16) {
    value += 4;
    ++knot;
  }
  const uint32_t moved = (knot - camera->knot) * camera->knot_size;
  camera->knot = (uint16_t)knot;
  camera->grid += (int32_t)moved;
  if (camera->inverse) camera->inverse += (int32_t)moved;
  if (camera->remap) camera->remap += (int32_t)moved;

  const int32_t lower_q16 = rg_load_i32(value);
  const uint32_t part_q16 = (uint32_t)value_q16 - (uint32_t)lower_q16;
  camera->weight_q14 = 0;
  if (part_q16 == 0) return RG_OK;
  if (value_q16 < lower_q16 || knot == last) return RG_EXTRAPOLATED;
  camera->weight_q14 =
      find_weight(part_q16, rg_load_u32(value + 4) - (uint32_t)lower_q16);
  return RG_OK;
}
