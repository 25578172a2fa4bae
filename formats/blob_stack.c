/* The operating-point model, with full validation; see SPEC.md, "Operating
 * points". */
#include "blob_stack.h"

#include <string.h>

#include "bytes.h"
#include "rg_blob.h"

/* Traverses those sections of the blob that have a counterpart in each sample,
 * in the order of the section table. */
typedef struct section_traversal {
  const uint8_t* bytes; /* bytes of the blob */
  const uint8_t* grid;  /* the central grid's section, the first one */
  uint32_t index;       /* index of the next entry of the section table */
  uint32_t type;        /* type of the current section */
  const uint8_t* own;   /* the current section */
  uint32_t size;        /* size of the section and of its counterpart */
} section_traversal;

static int go_to_next_section(section_traversal* traversal) {
  const uint32_t num = rg_load_u16(traversal->bytes + RG_HEADER_SECTION_COUNT);
  while (traversal->index != num) {
    const uint8_t* const entry = traversal->bytes + RG_HEADER_SIZE +
                                 traversal->index++ * RG_SECTION_ENTRY_SIZE;
    traversal->type = rg_load_u16(entry + RG_ENTRY_TYPE);
    traversal->own = traversal->bytes + rg_load_u32(entry + RG_ENTRY_OFFSET);
    traversal->size = rg_load_u32(entry + RG_ENTRY_SIZE);
    if (traversal->type == RG_SECTION_CENTRAL_GRID)
      traversal->grid = traversal->own;
    if (traversal->type == RG_SECTION_CENTRAL_GRID ||
        traversal->type == RG_SECTION_INVERSE ||
        traversal->type == RG_SECTION_REMAP)
      return 1;
  }
  return 0;
}

static section_traversal start_traversal(const uint8_t* bytes) {
  const section_traversal traversal = {bytes, 0, 0, 0, 0, 0};
  return traversal;
}

/* The total size of the sections that have a counterpart in a sample; 0 if they
 * are not contiguous from the central grid to the operating-point model. */
static uint32_t sum_part_sizes(const uint8_t* bytes, const uint8_t* stack) {
  uint32_t size = 0;
  section_traversal traversal = start_traversal(bytes);
  while (go_to_next_section(&traversal)) {
    if (traversal.grid == 0 || traversal.own != traversal.grid + size) return 0;
    size += traversal.size;
  }
  return traversal.grid + size == stack ? size : 0;
}

/* Whether a table in a sample equals the blob's own table in the bytes before
 * its arrays, except for the measured error, and in its mask. The table has
 * already been checked. */
static int matches_own_table(const uint8_t* part,
                             const section_traversal* traversal) {
  const uint8_t* const own = traversal->own;
  const uint32_t data = rg_load_u32(part + RG_REMAP_DATA_OFFSET);
  const uint32_t rest = RG_REMAP_DATA_OFFSET;
  if (memcmp(part, own, RG_REMAP_MAX_ERROR_UPX) != 0 ||
      memcmp(part + rest, own + rest, data - rest) != 0)
    return 0;
  const uint32_t mask = data + rg_vertex_size(part) *
                                   rg_load_u16(part + RG_REMAP_COLUMNS) *
                                   rg_load_u16(part + RG_REMAP_ROWS);
  return memcmp(part + mask, own + mask, traversal->size - mask) == 0;
}

static int matches_own_section(const uint8_t* part,
                               const section_traversal* traversal) {
  return traversal->type == RG_SECTION_REMAP
             ? matches_own_table(part, traversal)
             : memcmp(part, traversal->own,
                      rg_load_u32(part + RG_GRID_DATA_OFFSET)) == 0;
}

int32_t rg_stack_sample_value(const rg_stack_section* stack, uint32_t sample) {
  return rg_load_i32(stack->samples + (sample + 1) * stack->sample_size -
                     RG_STACK_SAMPLE_VALUE_SIZE);
}

static rg_stack_section read_stack(const uint8_t* section,
                                   uint32_t parts_size) {
  const rg_stack_section stack = {rg_load_u16(section + RG_STACK_CONDITION),
                                  rg_load_u16(section + RG_STACK_KNOTS),
                                  section + RG_STACK_FIELDS_SIZE,
                                  parts_size + RG_STACK_SAMPLE_VALUE_SIZE};
  return stack;
}

static int are_values_in_order(const rg_stack_section* stack) {
  int64_t last = -(int64_t)RG_OPERATING_POINT_LIMIT_Q16 - 1;
  for (uint32_t k = 0; k < stack->num_samples; ++k) {
    const int32_t value_q16 = rg_stack_sample_value(stack, k);
    if (value_q16 <= last || value_q16 > RG_OPERATING_POINT_LIMIT_Q16) return 0;
    last = value_q16;
  }
  return 1;
}

rg_status rg_validate_stack(const uint8_t* bytes, const uint8_t* section,
                            uint32_t size, const rg_sections* sections,
                            rg_part_check* check) {
  const uint32_t parts_size = sum_part_sizes(bytes, section);
  const rg_stack_section stack = read_stack(section, parts_size);
  if (stack.condition - 1u >= RG_OPERATING_PARAMETER_TEMPERATURE ||
      stack.num_samples < RG_MIN_STACK_SAMPLES ||
      stack.num_samples > RG_MAX_STACK_SAMPLES ||
      sections->of[RG_SECTION_LINE_POINTS].bytes || parts_size == 0 ||
      section + size != bytes + rg_load_u32(bytes + RG_HEADER_TOTAL_SIZE))
    return RG_ERR_STACK;
  if (size !=
      RG_STACK_FIELDS_SIZE + (uint64_t)stack.num_samples * stack.sample_size)
    return RG_ERR_SECTION_SIZE;
  if (!are_values_in_order(&stack)) return RG_ERR_STACK;
  const uint8_t* part = stack.samples;
  for (uint32_t k = 0; k < stack.num_samples; ++k) {
    section_traversal traversal = start_traversal(bytes);
    while (go_to_next_section(&traversal)) {
      const rg_status status =
          check(bytes, traversal.type, part, traversal.size,
                sections->of[RG_SECTION_CAMERA].bytes);
      if (status != RG_OK) return status;
      if (!matches_own_section(part, &traversal)) return RG_ERR_STACK;
      part += traversal.size;
    }
    part += RG_STACK_SAMPLE_VALUE_SIZE;
  }
  return RG_OK;
}

void rg_blob_stack(const rg_blob* blob, rg_stack_section* stack) {
  *stack = read_stack(blob->bytes + blob->stack, blob->stack - blob->grid);
}
