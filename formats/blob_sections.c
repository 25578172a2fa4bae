/* What keeps the use of each section within its bounds: SPEC.md, "Sections". */
#include "blob_checks.h"
#include "bytes.h"
#include "rg_blob.h"
#include "wide_multiply.h"

rg_fault rg_check_extent(uint32_t size, uint32_t data_offset,
                         uint32_t fields_size, uint32_t data_size) {
  if (data_offset < fields_size || data_offset % 4 != 0)
    return -RG_ERR_DATA_OFFSET;
  if (data_offset > size || size - data_offset != data_size)
    return -RG_ERR_SECTION_SIZE;
  return 0;
}

static uint32_t num_control_points(const uint8_t* grid) {
  return (uint32_t)rg_load_u16(grid + 16) * rg_load_u16(grid + 18);
}

rg_fault rg_check_grid(const uint8_t* section, uint32_t size,
                       uint32_t max_fraction_bits) {
  const uint32_t fraction_bits = rg_load_u16(section + 30);
  if (rg_load_u16(section + 28) != RG_CHART_STEREOGRAPHIC ||
      fraction_bits - RG_NARROW_MIN_BITS >
          max_fraction_bits - RG_NARROW_MIN_BITS)
    return -RG_ERR_GRID_CHART;
  for (uint32_t axis = 0; axis < 2; ++axis) {
    RG_KEEP_LOOP(axis);
    const uint8_t* const ends = section + 4 * axis;
    const uint32_t cells = rg_load_u16(section + 16 + 2 * axis) - 3u;
    if (cells - 1 >= RG_MAX_GRID_SIZE - 3) return -RG_ERR_GRID_SIZE;
    if (!rg_is_scale(rg_load_u32(ends + 20), cells,
                     rg_load_u32(ends + 8) - rg_load_u32(ends)))
      return -RG_ERR_GRID_SCALE;
  }
  const uint32_t count = num_control_points(section);
  return rg_check_extent(size, rg_load_u32(section + 32), RG_GRID_FIELDS_SIZE,
                         fraction_bits == RG_CONTROL_POINT_BITS
                             ? 8 * count
                             : RG_NARROW_PLANE_SIZE + 4 * count);
}

rg_fault rg_check_line_points(const uint8_t* section, uint32_t size,
                              const uint8_t* grid) {
  if (rg_load_u16(section) != RG_LINE_POINT_BITS) return -RG_ERR_LINE_POINT;
  return rg_check_extent(size, rg_load_u32(section + 4),
                         RG_LINE_POINTS_FIELDS_SIZE,
                         12 * num_control_points(grid));
}

/* One axis of a remap: sizes and source. */
static rg_fault check_remap_axis(const uint8_t* section, uint32_t axis,
                                 uint32_t source_size) {
  const uint32_t size = rg_load_u16(section + 2 * axis);
  const uint32_t num_vertices = rg_load_u16(section + 4 + 2 * axis);
  const uint8_t* const fields = section + 4 * axis;
  const int32_t low = rg_load_i32(fields + 12), high = rg_load_i32(fields + 20);
  if (size - 1 >= RG_MAX_REMAP_SIZE || source_size > RG_MAX_REMAP_SIZE)
    return -RG_ERR_REMAP_SIZE;
  if (num_vertices != ((size - 1) >> section[8]) + 2)
    return -RG_ERR_REMAP_BLOCK;
  if (low < 0 || low > high || high > (int32_t)((source_size - 1) << 12))
    return -RG_ERR_REMAP_SOURCE;
  return 0;
}

rg_fault rg_check_remap(const uint8_t* section, uint32_t size, uint32_t width,
                        uint32_t height) {
  const uint32_t block_log2 = section[8], part_log2 = section[10];
  uint32_t vertex_size = RG_VERTEX_SIZE;
  if (part_log2 == 0) {
    if (block_log2 - 3u > 2) return -RG_ERR_REMAP_BLOCK;
  } else {
    vertex_size = RG_BENT_VERTEX_SIZE;
    if (part_log2 < 3 || part_log2 >= block_log2 || block_log2 > 6)
      return -RG_ERR_REMAP_BLOCK;
  }
  if (section[9] > RG_MAX_RESIDUAL_SHIFT || section[11] > RG_MAX_BEND_SHIFT)
    return -RG_ERR_REMAP_SHIFT;
  rg_fault fault = check_remap_axis(section, 0, width);
  if (fault == 0) fault = check_remap_axis(section, 1, height);
  if (fault != 0) return fault;
  const uint32_t columns = rg_load_u16(section + 4);
  const uint32_t rows = rg_load_u16(section + 6);
  const uint32_t data_offset = rg_load_u32(section + 76);
  return rg_check_extent(
      size, data_offset, RG_REMAP_FIELDS_SIZE,
      vertex_size * columns * rows + rg_mask_size((columns - 1) * (rows - 1)));
}

/* One coordinate of all vertices: -limit < vertex < limit. Its fields and
 * residuals lie behind the other's. Sums are modulo 2^32, as the spec says. */
static int are_vertices_in_range(const uint8_t* section, const uint8_t* fields,
                                 const uint8_t* residual) {
  uint32_t vertex_size = RG_VERTEX_SIZE;
  if (section[10] != 0) vertex_size = RG_BENT_VERTEX_SIZE;
  uint32_t row_start = rg_load_u32(fields + 28) + RG_VERTEX_LIMIT_Q12 - 1;
  for (uint32_t rows = rg_load_u16(section + 6); rows > 0; --rows) {
    uint32_t affine = row_start;
    for (uint32_t columns = rg_load_u16(section + 4); columns > 0; --columns) {
      const uint32_t offset = (uint32_t)rg_load_i16(residual) << section[9];
      if (affine + offset >= 2u * RG_VERTEX_LIMIT_Q12 - 1) return 0;
      affine += rg_load_u32(fields + 36);
      residual += vertex_size;
    }
    row_start += rg_load_u32(fields + 44);
  }
  return 1;
}

rg_fault rg_check_vertices(const uint8_t* section) {
  const uint8_t* const residuals = section + rg_load_u32(section + 76);
  for (uint32_t axis = 0; axis < 2; ++axis)
    if (!are_vertices_in_range(section, section + 4 * axis,
                               residuals + 2 * axis))
      return -RG_ERR_REMAP_VERTEX;
  return 0;
}
