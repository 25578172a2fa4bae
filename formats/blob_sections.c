/* The checks that keep all accesses to a section within its bounds; see
 * SPEC.md, "Sections". */
#include "blob_checks.h"
#include "bytes.h"
#include "rg_blob.h"
#include "wide_multiply.h"

rg_status rg_check_extent(const uint8_t* data_offset, uint32_t size,
                          uint32_t fields_size, uint32_t data_size) {
  const uint32_t offset = rg_load_u32(data_offset);
  if (offset < fields_size || offset % 4 != 0) return RG_ERR_DATA_OFFSET;
  if (offset > size || size - offset != data_size) return RG_ERR_SECTION_SIZE;
  return RG_OK;
}

/* A number in both halves of a word, one for each axis: sizes and counts are
 * stored as such pairs. */
#define BOTH(number) ((number)*0x10001u)

static uint32_t num_control_points(const uint8_t* grid) {
  return (uint32_t)rg_load_u16(grid + RG_GRID_COLUMNS) *
         rg_load_u16(grid + RG_GRID_ROWS);
}

rg_status rg_check_grid(const uint8_t* section, uint32_t size,
                        uint32_t max_fraction_bits) {
  if (!section) return RG_OK;
  const uint32_t fraction_bits = rg_load_u16(section + RG_GRID_FRACTION_BITS);
  if (rg_load_u16(section + RG_GRID_CHART) != RG_CHART_STEREOGRAPHIC ||
      fraction_bits < RG_NARROW_MIN_BITS || fraction_bits > max_fraction_bits)
    return RG_ERR_GRID_CHART;
  uint32_t counts = rg_load_u32(section + RG_GRID_COLUMNS);
  /* Minus 4, counts are below 1024. */
  if (((counts - BOTH(RG_MIN_GRID_SIZE)) &
       ~BOTH(RG_MAX_GRID_SIZE - RG_MIN_GRID_SIZE)) != 0)
    return RG_ERR_GRID_SIZE;
  const uint8_t* axis = section;
  for (; counts != 0; counts >>= 16, axis += 4)
    if (!rg_is_scale(
            rg_load_u32(axis + RG_GRID_SCALE_X), (counts & 0xffff) - 3,
            rg_load_u32(axis + RG_GRID_X1) - rg_load_u32(axis + RG_GRID_X0)))
      return RG_ERR_GRID_SCALE;
  const uint32_t num_points = num_control_points(section);
  return rg_check_extent(
      section + RG_GRID_DATA_OFFSET, size, RG_GRID_FIELDS_SIZE,
      rg_load_u16(section + RG_GRID_FRACTION_BITS) == RG_CONTROL_POINT_BITS
          ? RG_CONTROL_POINT_SIZE * num_points
          : RG_NARROW_PLANE_SIZE + RG_NARROW_POINT_SIZE * num_points);
}

rg_status rg_check_line_points(const uint8_t* section, uint32_t size,
                               const uint8_t* grid) {
  if (!section) return RG_OK;
  if (rg_load_u16(section + RG_LINE_POINTS_FRACTION_BITS) != RG_LINE_POINT_BITS)
    return RG_ERR_LINE_POINT;
  return rg_check_extent(section + RG_LINE_POINTS_DATA_OFFSET, size,
                         RG_LINE_POINTS_FIELDS_SIZE,
                         RG_LINE_POINT_SIZE * num_control_points(grid));
}

rg_status rg_check_row_time(const uint8_t* section, uint32_t size) {
  if (size < RG_ROW_TIME_SIZE) return RG_ERR_SECTION_SIZE;
  /* For values below -limit, the unsigned sum does not wrap, and exceeds the
   * range. */
  return rg_load_u32(section + RG_ROW_TIME_ROW_TIME) + RG_ROW_TIME_LIMIT_Q10 >
                     2u * RG_ROW_TIME_LIMIT_Q10 ||
                 rg_load_u32(section + RG_ROW_TIME_DEVIATION) >
                     (uint32_t)RG_ROW_TIME_LIMIT_Q10
             ? RG_ERR_ROW_TIME
             : RG_OK;
}

rg_status rg_check_remap(const uint8_t* section, uint32_t size,
                         uint32_t source_size) {
  /* Minus 1, all sizes are below 2^13. */
  const uint32_t last = rg_load_u32(section + RG_REMAP_WIDTH) - BOTH(1);
  const uint32_t last_source = source_size - BOTH(1);
  if (((last | last_source | (source_size - BOTH(RG_MIN_REMAP_SOURCE))) &
       ~BOTH(RG_MAX_REMAP_SIZE - 1)) != 0)
    return RG_ERR_REMAP_SIZE;
  const uint32_t max_x = rg_load_u32(section + RG_REMAP_MAX_X);
  const uint32_t max_y = rg_load_u32(section + RG_REMAP_MAX_Y);
  if (rg_load_u32(section + RG_REMAP_MIN_X) > max_x ||
      max_x > last_source << 16 >> 4 ||
      rg_load_u32(section + RG_REMAP_MIN_Y) > max_y ||
      max_y > last_source >> 16 << 12)
    return RG_ERR_REMAP_SOURCE;
  if (section[RG_REMAP_RESIDUAL_SHIFT] > RG_MAX_RESIDUAL_SHIFT ||
      (section[RG_REMAP_BEND_SHIFT] & ~RG_HAS_VIEW) > RG_MAX_BEND_SHIFT)
    return RG_ERR_REMAP_SHIFT;

  /* The smallest block is 8 px without bends, or 16 px with bends; two larger
   * sizes are allowed. */
  const uint32_t block_log2 = section[RG_REMAP_BLOCK_LOG2];
  const uint32_t part_log2 = section[RG_REMAP_PART_LOG2];
  uint32_t above = block_log2 - 3, vertex_size = RG_VERTEX_SIZE;
  if (part_log2 != 0) {
    if (part_log2 - 3 >= above) return RG_ERR_REMAP_BLOCK;
    --above;
    vertex_size = RG_BENT_VERTEX_SIZE;
  }
  if (above > 2) return RG_ERR_REMAP_BLOCK;
  /* Masks the bits shifted in from the other half. */
  const uint32_t last_blocks = (last >> block_log2) & ~0xfc00u;
  if (last_blocks + BOTH(2) != rg_load_u32(section + RG_REMAP_COLUMNS))
    return RG_ERR_REMAP_BLOCK;
  const uint32_t columns = rg_load_u16(section + RG_REMAP_COLUMNS);
  const uint32_t rows = rg_load_u16(section + RG_REMAP_ROWS);
  return rg_check_extent(
      section + RG_REMAP_DATA_OFFSET, size,
      rg_has_view(section) ? RG_VIEW_FIELDS_SIZE : RG_REMAP_FIELDS_SIZE,
      vertex_size * columns * rows + rg_mask_size((columns - 1) * (rows - 1)));
}

/* Whether one coordinate of all vertices is in range: -limit < vertex < limit.
 * axis: the section for x, 4 bytes after it for y. Sums are modulo 2^32, as
 * specified. */
static int are_vertices_in_range(const uint8_t* section, const uint8_t* axis,
                                 const uint8_t* residual) {
  uint32_t vertex_size = RG_VERTEX_SIZE;
  if (section[RG_REMAP_PART_LOG2] != 0) vertex_size = RG_BENT_VERTEX_SIZE;
  uint32_t row_start =
      rg_load_u32(axis + RG_REMAP_ORIGIN) + RG_VERTEX_LIMIT_Q12 - 1;
  for (uint32_t rows = rg_load_u16(section + RG_REMAP_ROWS); rows > 0; --rows) {
    uint32_t affine = row_start;
    for (uint32_t columns = rg_load_u16(section + RG_REMAP_COLUMNS);
         columns > 0; --columns) {
      const uint32_t offset = (uint32_t)rg_load_i16(residual)
                              << section[RG_REMAP_RESIDUAL_SHIFT];
      if (affine + offset >= 2u * RG_VERTEX_LIMIT_Q12 - 1) return 0;
      affine += rg_load_u32(axis + RG_REMAP_COLUMN_STEP);
      residual += vertex_size;
    }
    row_start += rg_load_u32(axis + RG_REMAP_ROW_STEP);
  }
  return 1;
}

rg_status rg_check_vertices(const uint8_t* section, const uint8_t* vertices) {
  for (uint32_t axis = 0; axis < 2; ++axis)
    if (!are_vertices_in_range(section, section + 4 * axis,
                               vertices + 2 * axis))
      return RG_ERR_REMAP_VERTEX;
  return RG_OK;
}
