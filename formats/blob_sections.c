/* The limits of each section's fields and values: SPEC.md, "Sections". */
#include "blob_checks.h"
#include "bytes.h"
#include "rg_blob.h"
#include "wide_multiply.h"

/* The section's arrays start behind its fields and fill it to the end. */
static rg_fault check_extent(uint32_t size, uint32_t data_offset,
                             uint32_t fields_size, uint32_t data_size) {
  if (data_offset < fields_size || data_offset % 4 != 0)
    return -RG_ERR_DATA_OFFSET;
  if (data_offset > size || size - data_offset != data_size)
    return -RG_ERR_SECTION_SIZE;
  return 0;
}

/* Bytes of one bit for each of so many, padded to words. */
static uint32_t mask_size(uint32_t num_bits) {
  return (num_bits + 31) / 32 * 4;
}

static rg_fault check_camera(const uint8_t* section) {
  if (rg_load_u16(section) - 1u >= RG_MAX_IMAGE_SIZE ||
      rg_load_u16(section + 2) - 1u >= RG_MAX_IMAGE_SIZE)
    return -RG_ERR_IMAGE_SIZE;
  if (rg_load_u32(section + 4) != 0) return -RG_ERR_RESERVED;
  /* The last bytes of name and serial. */
  return (section[39] | section[71]) != 0 ? -RG_ERR_TEXT : 0;
}

/* scale = floor(cells 2^48 / span): the remainder is less than span. */
static int is_scale(uint32_t scale, uint32_t cells, uint32_t span) {
  uint32_t low;
  const uint32_t high = rg_multiply_unsigned(scale, span, &low);
  const uint64_t remainder =
      ((uint64_t)cells << 48) - (((uint64_t)high << 32) | low);
  return remainder < span;
}

/* What may be wrong with the two axes of a grid. */
enum { ENDS = 1, COUNT, SCALE };

/* ends: two lower ones, two upper ones; counts: two of cells and surplus, then
 * two scales. The ends lie on the camera's image or, without one, in the
 * chart. 0 if all is as it should be. */
static int find_axis_fault(const uint8_t* ends, const uint8_t* counts,
                           uint32_t surplus, uint32_t max_cells,
                           const uint8_t* camera) {
  for (uint32_t c = 0; c < 2; ++c, ends += 4, counts += 2) {
    int32_t lowest = -RG_CHART_LIMIT_Q27, highest = RG_CHART_LIMIT_Q27;
    if (camera) {
      lowest = -0x8000;
      highest = (int32_t)((uint32_t)rg_load_u16(camera + 2 * c) << 16) - 0x8000;
    }
    const int32_t low = rg_load_i32(ends), high = rg_load_i32(ends + 8);
    if (low < lowest || low >= high || high > highest) return ENDS;
    const uint32_t cells = rg_load_u16(counts) - surplus;
    if (cells - 1 >= max_cells) return COUNT;
    if (!is_scale(rg_load_u32(counts + 4 + 2 * c), cells,
                  (uint32_t)high - (uint32_t)low))
      return SCALE;
  }
  return 0;
}

/* Control and line points have the same limit. */
static int are_points_in_range(const uint8_t* points, const uint8_t* end) {
  for (; points != end; points += 4)
    if (rg_load_u32(points) + RG_CONTROL_POINT_LIMIT >
        2u * RG_CONTROL_POINT_LIMIT)
      return 0;
  return 1;
}

static uint32_t num_control_points(const uint8_t* grid) {
  return (uint32_t)rg_load_u16(grid + 16) * rg_load_u16(grid + 18);
}

/* step times the u16 at count, less 1 */
static int64_t multiply(int32_t step, const uint8_t* count) {
  uint32_t low;
  const int32_t high = rg_multiply_signed(step, rg_load_u16(count) - 1, &low);
  return (int64_t)(((uint64_t)(uint32_t)high << 32) | low);
}

/* The limit for all that the plane and residuals of the fraction bits may add
 * up to: what the plane reaches at the corners and the largest residual. */
static int is_plane_in_range(const uint8_t* plane, const uint8_t* section,
                             uint32_t fraction_bits) {
  const int32_t limit =
      RG_CONTROL_POINT_LIMIT - (int32_t)(UINT32_C(1) << (44 - fraction_bits));
  for (uint32_t k = 0; k < 8; ++k) {
    const uint8_t* const at = plane + 4 * (k & 1);
    int64_t value = rg_load_i32(at);
    if (k & 2) value += multiply(rg_load_i32(at + 8), section + 16);
    if (k & 4) value += multiply(rg_load_i32(at + 16), section + 18);
    if (value > limit || value < -limit) return 0;
  }
  return 1;
}

/* The central grid or, without a camera, the inverse one. */
static rg_fault check_grid(const uint8_t* section, uint32_t size,
                           const uint8_t* camera) {
  const uint32_t fraction_bits = rg_load_u16(section + 30);
  const int is_wide = fraction_bits == RG_CONTROL_POINT_BITS;
  if (camera && rg_load_u32(section + 36) != 0) return -RG_ERR_RESERVED;
  if (rg_load_u16(section + 28) != RG_CHART_STEREOGRAPHIC ||
      fraction_bits - RG_NARROW_MIN_BITS >
          RG_CONTROL_POINT_BITS - RG_NARROW_MIN_BITS ||
      (is_wide && !camera))
    return -RG_ERR_GRID_CHART;
  /* RG_ERR_AREA, RG_ERR_GRID_SIZE and RG_ERR_GRID_SCALE follow each other. */
  const int axis_fault =
      find_axis_fault(section, section + 16, 3, RG_MAX_GRID_SIZE - 3, camera);
  if (axis_fault) return axis_fault - ENDS - RG_ERR_AREA;
  const uint32_t data_offset = rg_load_u32(section + 32);
  const uint32_t count = num_control_points(section);
  const rg_fault fault =
      check_extent(size, data_offset, RG_GRID_FIELDS_SIZE,
                   is_wide ? 8 * count : RG_NARROW_PLANE_SIZE + 4 * count);
  if (fault) return fault;
  const uint8_t* const data = section + data_offset;
  return (is_wide ? are_points_in_range(data, section + size)
                  : is_plane_in_range(data, section, fraction_bits))
             ? 0
             : -RG_ERR_CONTROL_POINT;
}

static rg_fault check_line_points(const uint8_t* section, uint32_t size,
                                  const uint8_t* grid) {
  if (rg_load_u16(section) != RG_LINE_POINT_BITS) return -RG_ERR_LINE_POINT;
  if (rg_load_u16(section + 2) != 0) return -RG_ERR_RESERVED;
  const uint32_t data_offset = rg_load_u32(section + 4);
  const rg_fault fault =
      check_extent(size, data_offset, RG_LINE_POINTS_FIELDS_SIZE,
                   12 * num_control_points(grid));
  if (fault != 0) return fault;
  return are_points_in_range(section + data_offset, section + size)
             ? 0
             : -RG_ERR_LINE_POINT;
}

static rg_fault check_uncertainty(const uint8_t* section, uint32_t size,
                                  const uint8_t* camera, const uint8_t* grid) {
  if (find_axis_fault(grid, section, 1, RG_MAX_UNCERTAINTY_SIZE - 1, camera))
    return -RG_ERR_UNCERTAINTY;
  const uint32_t num_values =
      (uint32_t)rg_load_u16(section) * rg_load_u16(section + 2);
  return check_extent(size, rg_load_u32(section + 12),
                      RG_UNCERTAINTY_FIELDS_SIZE, (num_values + 1) / 2 * 4);
}

static rg_fault check_mask(const uint8_t* section, uint32_t size,
                           const uint8_t* camera) {
  const uint32_t log2 = section[4];
  if ((rg_load_u32(section + 4) >> 8) != 0) return -RG_ERR_RESERVED;
  if (log2 - RG_MIN_MASK_CELL_LOG2 >
      RG_MAX_MASK_CELL_LOG2 - RG_MIN_MASK_CELL_LOG2)
    return -RG_ERR_MASK;
  uint32_t num_cells = 1;
  for (uint32_t c = 0; c < 4; c += 2) {
    const uint32_t count = rg_load_u16(section + c);
    if (count != ((rg_load_u16(camera + c) - 1u) >> log2) + 1)
      return -RG_ERR_MASK;
    num_cells *= count;
  }
  return check_extent(size, rg_load_u32(section + 8), RG_MASK_FIELDS_SIZE,
                      mask_size(num_cells));
}

/* One coordinate of all vertices, whose fields and residuals lie behind the
 * other's. Sums are modulo 2^32, as the spec says. */
static int are_vertices_in_range(const uint8_t* section, const uint8_t* fields,
                                 const uint8_t* residual,
                                 uint32_t vertex_size) {
  uint32_t row_start = rg_load_u32(fields + 28);
  for (uint32_t rows = rg_load_u16(section + 6); rows > 0; --rows) {
    uint32_t affine = row_start;
    for (uint32_t columns = rg_load_u16(section + 4); columns > 0; --columns) {
      const uint32_t offset = (uint32_t)rg_load_i16(residual) << section[9];
      /* -limit < vertex < limit */
      if (affine + offset + RG_VERTEX_LIMIT_Q12 - 1u >=
          2u * RG_VERTEX_LIMIT_Q12 - 1)
        return 0;
      affine += rg_load_u32(fields + 36);
      residual += vertex_size;
    }
    row_start += rg_load_u32(fields + 44);
  }
  return 1;
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
  return rg_load_u32(fields + 52) == 0 ? -RG_ERR_REMAP_CAMERA : 0;
}

static rg_fault check_remap(const uint8_t* section, uint32_t size,
                            const uint8_t* camera) {
  const uint32_t block_log2 = section[8], part_log2 = section[10];
  uint32_t vertex_size = RG_VERTEX_SIZE;
  if (part_log2 == 0) {
    if (section[11] != 0) return -RG_ERR_RESERVED;
    if (block_log2 - 3u > 2) return -RG_ERR_REMAP_BLOCK;
  } else {
    vertex_size = RG_BENT_VERTEX_SIZE;
    if (part_log2 < 3 || part_log2 >= block_log2 || block_log2 > 6)
      return -RG_ERR_REMAP_BLOCK;
  }
  if (section[9] > RG_MAX_RESIDUAL_SHIFT || section[11] > RG_MAX_BEND_SHIFT)
    return -RG_ERR_REMAP_SHIFT;
  rg_fault fault = 0;
  for (uint32_t axis = 0; axis < 2 && fault == 0; ++axis)
    fault = check_remap_axis(section, axis, rg_load_u16(camera + 2 * axis));
  if (fault != 0) return fault;
  const uint32_t columns = rg_load_u16(section + 4);
  const uint32_t rows = rg_load_u16(section + 6);
  const uint32_t data_offset = rg_load_u32(section + 76);
  fault = check_extent(
      size, data_offset, RG_REMAP_FIELDS_SIZE,
      vertex_size * columns * rows + mask_size((columns - 1) * (rows - 1)));
  if (fault != 0) return fault;
  const uint8_t* const residuals = section + data_offset;
  return are_vertices_in_range(section, section, residuals, vertex_size) &&
                 are_vertices_in_range(section, section + 4, residuals + 2,
                                       vertex_size)
             ? 0
             : -RG_ERR_REMAP_VERTEX;
}

rg_fault rg_check_section(uint32_t type, const uint8_t* section, uint32_t size,
                          const uint8_t* const* sections) {
  const uint8_t* const camera = sections[RG_SECTION_CAMERA];
  const uint8_t* const grid = sections[RG_SECTION_CENTRAL_GRID];
  if (section == camera) return check_camera(section);
  if (section == grid) return check_grid(section, size, camera);
  if (section == sections[RG_SECTION_LINE_POINTS])
    return check_line_points(section, size, grid);
  if (section == sections[RG_SECTION_INVERSE])
    return check_grid(section, size, 0);
  if (section == sections[RG_SECTION_MASK])
    return check_mask(section, size, camera);
  if (section == sections[RG_SECTION_UNCERTAINTY])
    return check_uncertainty(section, size, camera, grid);
  return type == RG_SECTION_REMAP ? check_remap(section, size, camera) : 0;
}
