/* The sections that version 1.1 brought: their limits, and reading them. */
#include "blob_checks.h"
#include "bytes.h"
#include "rg_blob.h"

/* A rectangle within the chart's limits. */
static int is_chart_interval(int32_t min_q28, int32_t max_q28) {
  return min_q28 >= -RG_CHART_LIMIT_Q28 && min_q28 < max_q28 &&
         max_q28 <= RG_CHART_LIMIT_Q28;
}

rg_status rg_check_start(const uint8_t* section, uint32_t size) {
  if (size < RG_START_FIELDS_SIZE) return RG_ERR_SECTION_SIZE;
  for (uint32_t c = 0; c < 2; ++c) {
    const int32_t min_q28 = rg_load_i32(section + 4 * c);
    const int32_t max_q28 = rg_load_i32(section + 8 + 4 * c);
    if (!is_chart_interval(min_q28, max_q28)) return RG_ERR_START_CHART;
    const uint32_t num_vertices = rg_load_u16(section + 16 + 2 * c);
    if (num_vertices < RG_MIN_START_SIZE || num_vertices > RG_MAX_START_SIZE ||
        !rg_is_grid_scale(rg_load_u32(section + 20 + 4 * c), num_vertices - 1,
                          (uint32_t)max_q28 - (uint32_t)min_q28))
      return RG_ERR_START_GRID;
  }
  if (!is_chart_interval(rg_load_i32(section + 28), RG_CHART_LIMIT_Q28))
    return RG_ERR_START_CHART;
  /* Any vertex is a start: projection checks what it finds. */
  return rg_check_extent(
      size, rg_load_u32(section + 32), RG_START_FIELDS_SIZE,
      4u * rg_load_u16(section + 16) * rg_load_u16(section + 18));
}

void rg_blob_start(const rg_blob* blob, rg_start_section* start) {
  const uint8_t* section = blob->bytes + blob->start;
  start->a0_q28 = rg_load_i32(section);
  start->b0_q28 = rg_load_i32(section + 4);
  start->a1_q28 = rg_load_i32(section + 8);
  start->b1_q28 = rg_load_i32(section + 12);
  start->columns = rg_load_u16(section + 16);
  start->rows = rg_load_u16(section + 18);
  start->scale_a_q20 = rg_load_u32(section + 20);
  start->scale_b_q20 = rg_load_u32(section + 24);
  start->cos_limit_q30 = rg_load_i32(section + 28);
  start->vertices = section + rg_load_u32(section + 32);
}

static uint32_t num_control_points(const uint8_t* grid) {
  return (uint32_t)rg_load_u16(grid + 16) * rg_load_u16(grid + 18);
}

rg_status rg_check_line_points(const uint8_t* section, uint32_t size,
                               const uint8_t* grid) {
  if (size < RG_LINE_POINTS_FIELDS_SIZE) return RG_ERR_SECTION_SIZE;
  if (rg_load_u16(section) != RG_LINE_POINT_BITS) return RG_ERR_LINE_POINT;
  if (rg_load_u16(section + 2) != 0) return RG_ERR_RESERVED;
  const uint32_t data_offset = rg_load_u32(section + 4);
  const uint32_t count = 3 * num_control_points(grid);
  const rg_status status =
      rg_check_extent(size, data_offset, RG_LINE_POINTS_FIELDS_SIZE, 4 * count);
  if (status != RG_OK) return status;
  for (uint32_t i = 0; i < count; ++i) {
    const int32_t value = rg_load_i32(section + data_offset + 4 * i);
    if (value > RG_LINE_POINT_LIMIT || value < -RG_LINE_POINT_LIMIT)
      return RG_ERR_LINE_POINT;
  }
  return RG_OK;
}

const uint8_t* rg_blob_line_points(const rg_blob* blob) {
  const uint8_t* const section = blob->bytes + blob->line_points;
  return section + rg_load_u32(section + 4);
}

rg_status rg_check_mask(const uint8_t* section, uint32_t size,
                        const uint8_t* camera) {
  if (size < RG_MASK_FIELDS_SIZE) return RG_ERR_SECTION_SIZE;
  const uint32_t log2 = section[4];
  if (section[5] != 0 || rg_load_u16(section + 6) != 0) return RG_ERR_RESERVED;
  if (log2 < RG_MIN_MASK_CELL_LOG2 || log2 > RG_MAX_MASK_CELL_LOG2)
    return RG_ERR_MASK;
  const uint32_t columns = ((rg_load_u16(camera) - 1u) >> log2) + 1;
  const uint32_t rows = ((rg_load_u16(camera + 2) - 1u) >> log2) + 1;
  if (rg_load_u16(section) != columns || rg_load_u16(section + 2) != rows)
    return RG_ERR_MASK;
  const uint32_t data_offset = rg_load_u32(section + 8);
  const rg_status status = rg_check_extent(
      size, data_offset, RG_MASK_FIELDS_SIZE, (columns * rows + 31) / 32 * 4);
  if (status != RG_OK) return status;
  return rg_is_mask_padded(section + data_offset, columns * rows)
             ? RG_OK
             : RG_ERR_RESERVED;
}

void rg_blob_mask(const rg_blob* blob, rg_mask_section* mask) {
  const uint8_t* const section = blob->bytes + blob->mask;
  mask->columns = rg_load_u16(section);
  mask->rows = rg_load_u16(section + 2);
  mask->cell_log2 = section[4];
  mask->bits = section + rg_load_u32(section + 8);
}

rg_status rg_check_uncertainty(const uint8_t* section, uint32_t size,
                               const uint8_t* grid) {
  if (size < RG_UNCERTAINTY_FIELDS_SIZE) return RG_ERR_SECTION_SIZE;
  for (uint32_t c = 0; c < 2; ++c) {
    const uint32_t count = rg_load_u16(section + 2 * c);
    const uint32_t span =
        rg_load_u32(grid + 8 + 4 * c) - rg_load_u32(grid + 4 * c);
    if (count < 2 || count > RG_MAX_UNCERTAINTY_SIZE ||
        !rg_is_grid_scale(rg_load_u32(section + 4 + 4 * c), count - 1, span))
      return RG_ERR_UNCERTAINTY;
  }
  const uint32_t num_values =
      (uint32_t)rg_load_u16(section) * rg_load_u16(section + 2);
  const uint32_t data_offset = rg_load_u32(section + 12);
  const rg_status status = rg_check_extent(
      size, data_offset, RG_UNCERTAINTY_FIELDS_SIZE, (num_values + 1) / 2 * 4);
  if (status != RG_OK) return status;
  if (num_values % 2 != 0 &&
      rg_load_u16(section + data_offset + 2 * num_values) != 0)
    return RG_ERR_RESERVED;
  return RG_OK;
}

void rg_blob_uncertainty(const rg_blob* blob,
                         rg_uncertainty_section* uncertainty) {
  const uint8_t* const section = blob->bytes + blob->uncertainty;
  uncertainty->columns = rg_load_u16(section);
  uncertainty->rows = rg_load_u16(section + 2);
  uncertainty->scale_x_q32 = rg_load_u32(section + 4);
  uncertainty->scale_y_q32 = rg_load_u32(section + 8);
  uncertainty->values = section + rg_load_u32(section + 12);
}
