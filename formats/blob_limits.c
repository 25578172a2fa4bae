/* rg_blob_open(): checks all limits of SPEC.md, "Sections", including those
 * that the runtime does not rely on. */
#include "blob_checks.h"
#include "blob_stack.h"
#include "bytes.h"
#include "rg_blob.h"
#include "wide_multiply.h"

/* Checks the flags, and that types that must be unique occur once. */
static rg_status check_entry(const uint8_t* bytes, const uint8_t* entry,
                             const rg_sections* sections) {
  const uint32_t type = rg_load_u16(entry + RG_ENTRY_TYPE);
  const uint32_t flags = rg_load_u16(entry + RG_ENTRY_FLAGS);
  if (flags > RG_SECTION_CRITICAL) return RG_ERR_SECTION_FLAGS;
  if (type < RG_NUM_SECTION_TYPES && sections->of[type].bytes &&
      flags != (RG_CRITICAL_TYPES >> type & 1u))
    return RG_ERR_SECTION_FLAGS;
  return type < 32 && (RG_SINGLE_TYPES >> type & 1u) != 0 &&
                 rg_find_entry(bytes, type, 0) != entry
             ? RG_ERR_SECTION_DUPLICATE
             : RG_OK;
}

static rg_status check_camera(const uint8_t* section) {
  if (rg_load_u16(section + RG_CAMERA_WIDTH) - 1u >= RG_MAX_IMAGE_SIZE ||
      rg_load_u16(section + RG_CAMERA_HEIGHT) - 1u >= RG_MAX_IMAGE_SIZE)
    return RG_ERR_IMAGE_SIZE;
  if (rg_load_u32(section + RG_CAMERA_RESERVED) != 0) return RG_ERR_RESERVED;
  /* The padding bytes of name and serial. */
  return (section[RG_CAMERA_NAME + RG_TEXT_SIZE - 1] |
          section[RG_CAMERA_SERIAL + RG_TEXT_SIZE - 1]) != 0
             ? RG_ERR_TEXT
             : RG_OK;
}

/* Whether a grid's area is within the camera's image or, without a camera,
 * within the chart. axis: the grid section. */
static int are_ends_in_range(const uint8_t* axis, const uint8_t* camera) {
  for (uint32_t c = 0; c < 2; ++c, axis += 4) {
    const int32_t lowest = camera ? -0x8000 : -RG_CHART_LIMIT_Q27;
    const uint32_t range =
        camera ? (uint32_t)rg_load_u16(camera + RG_CAMERA_WIDTH + 2 * c) << 16
               : 2u * RG_CHART_LIMIT_Q27;
    const int32_t low = rg_load_i32(axis + RG_GRID_X0);
    const int32_t high = rg_load_i32(axis + RG_GRID_X1);
    if (low < lowest || low >= high ||
        (uint32_t)high - (uint32_t)lowest > range)
      return 0;
  }
  return 1;
}

/* Control points and line points have the same limit. */
static int are_points_in_range(const uint8_t* points, const uint8_t* end) {
  for (; points != end; points += 4)
    if (rg_load_u32(points) + RG_CONTROL_POINT_LIMIT >
        2u * RG_CONTROL_POINT_LIMIT)
      return 0;
  return 1;
}

/* step * (count - 1), with the u16 stored at count */
static int64_t multiply(int32_t step, const uint8_t* count) {
  uint32_t low;
  const int32_t high = rg_multiply_signed(step, rg_load_u16(count) - 1, &low);
  return (int64_t)(((uint64_t)(uint32_t)high << 32) | low);
}

/* Whether the plane at the grid's corners, plus the largest residual that the
 * fraction bits allow, is within the limit for control points. */
static int is_plane_in_range(const uint8_t* plane, const uint8_t* section,
                             uint32_t fraction_bits) {
  const int32_t limit =
      RG_CONTROL_POINT_LIMIT - (int32_t)(UINT32_C(1) << (44 - fraction_bits));
  for (uint32_t k = 0; k < 8; ++k) {
    const uint8_t* const axis = plane + 4 * (k & 1);
    int64_t value = rg_load_i32(axis + RG_PLANE_ORIGIN);
    if (k & 2)
      value += multiply(rg_load_i32(axis + RG_PLANE_COLUMN_STEP),
                        section + RG_GRID_COLUMNS);
    if (k & 4)
      value += multiply(rg_load_i32(axis + RG_PLANE_ROW_STEP),
                        section + RG_GRID_ROWS);
    if (value > limit || value < -limit) return 0;
  }
  return 1;
}

/* Checks the central grid or, if camera is NULL, the inverse grid. */
static rg_status check_grid(const uint8_t* section, uint32_t size,
                            const uint8_t* camera) {
  const uint32_t fraction_bits = rg_load_u16(section + RG_GRID_FRACTION_BITS);
  const int is_wide = fraction_bits == RG_CONTROL_POINT_BITS;
  if (camera && rg_load_u32(section + RG_GRID_RESERVED) != 0)
    return RG_ERR_RESERVED;
  if (!are_ends_in_range(section, camera)) return RG_ERR_AREA;
  const rg_status status = rg_check_grid(
      section, size, camera ? RG_CONTROL_POINT_BITS : RG_NARROW_MAX_BITS);
  if (status != RG_OK) return status;
  const uint8_t* const data =
      section + rg_load_u32(section + RG_GRID_DATA_OFFSET);
  return (is_wide ? are_points_in_range(data, section + size)
                  : is_plane_in_range(data, section, fraction_bits))
             ? RG_OK
             : RG_ERR_CONTROL_POINT;
}

/* The grid may be located after this section and not have been checked yet: the
 * product of its counts may then wrap, but the loop ends at the section's end.
 */
static rg_status check_line_points(const uint8_t* section, uint32_t size,
                                   const uint8_t* grid) {
  const rg_status status = rg_check_line_points(section, size, grid);
  if (status != RG_OK) return status;
  if (rg_load_u16(section + RG_LINE_POINTS_RESERVED) != 0)
    return RG_ERR_RESERVED;
  return are_points_in_range(
             section + rg_load_u32(section + RG_LINE_POINTS_DATA_OFFSET),
             section + size)
             ? RG_OK
             : RG_ERR_LINE_POINT;
}

/* Checks the uncertainty section, whose area is that of the central grid. */
static rg_status check_uncertainty(const uint8_t* section, uint32_t size,
                                   const uint8_t* grid) {
  for (uint32_t c = 0; c < 2; ++c) {
    const uint8_t* const axis = grid + 4 * c;
    const uint32_t intervals =
        rg_load_u16(section + RG_UNCERTAINTY_COLUMNS + 2 * c) - 1u;
    if (intervals - 1 >= RG_MAX_UNCERTAINTY_SIZE - 1 ||
        !rg_is_scale(
            rg_load_u32(section + RG_UNCERTAINTY_SCALE_X + 4 * c), intervals,
            rg_load_u32(axis + RG_GRID_X1) - rg_load_u32(axis + RG_GRID_X0)))
      return RG_ERR_UNCERTAINTY;
  }
  const uint32_t num_values =
      (uint32_t)rg_load_u16(section + RG_UNCERTAINTY_COLUMNS) *
      rg_load_u16(section + RG_UNCERTAINTY_ROWS);
  return rg_check_extent(section + RG_UNCERTAINTY_DATA_OFFSET, size,
                         RG_UNCERTAINTY_FIELDS_SIZE, (num_values + 1) / 2 * 4);
}

static rg_status check_mask(const uint8_t* section, uint32_t size,
                            const uint8_t* camera) {
  const uint32_t log2 = section[RG_MASK_CELL_LOG2];
  /* The reserved fields are the remaining bytes of this word. */
  if ((rg_load_u32(section + RG_MASK_CELL_LOG2) >> 8) != 0)
    return RG_ERR_RESERVED;
  if (log2 - RG_MIN_MASK_CELL_LOG2 >
      RG_MAX_MASK_CELL_LOG2 - RG_MIN_MASK_CELL_LOG2)
    return RG_ERR_MASK;
  uint32_t num_cells = 1;
  for (uint32_t c = 0; c < 4; c += 2) {
    const uint32_t count = rg_load_u16(section + RG_MASK_COLUMNS + c);
    if (count != ((rg_load_u16(camera + RG_CAMERA_WIDTH + c) - 1u) >> log2) + 1)
      return RG_ERR_MASK;
    num_cells *= count;
  }
  return rg_check_extent(section + RG_MASK_DATA_OFFSET, size,
                         RG_MASK_FIELDS_SIZE, rg_mask_size(num_cells));
}

/* The rows of a rotation are orthonormal within a tolerance; reflections are
 * rejected. */
static int is_rotation(const uint8_t* rotation) {
  int64_t r[3][3];
  for (uint32_t k = 0; k < 9; ++k)
    r[k / 3][k % 3] = rg_load_i32(rotation + 4 * k);
  const int64_t one = INT64_C(1) << 30;
  for (uint32_t k = 0; k < 9; ++k)
    if (r[k / 3][k % 3] > one || r[k / 3][k % 3] < -one) return 0;
  for (uint32_t i = 0; i < 3; ++i) {
    for (uint32_t j = i; j < 3; ++j) {
      const int64_t product =
          (r[i][0] * r[j][0] + r[i][1] * r[j][1] + r[i][2] * r[j][2]) / one -
          (i == j ? one : 0);
      if (product > RG_ROTATION_TOLERANCE_Q30 ||
          product < -RG_ROTATION_TOLERANCE_Q30)
        return 0;
    }
  }
  /* The third row is the cross product of the others; its negative would be a
   * reflection. */
  const int64_t z = (r[0][0] * r[1][1] - r[0][1] * r[1][0]) / one;
  const int64_t x = (r[0][1] * r[1][2] - r[0][2] * r[1][1]) / one;
  const int64_t y = (r[0][2] * r[1][0] - r[0][0] * r[1][2]) / one;
  return (x * r[2][0] + y * r[2][1] + z * r[2][2]) / one > 0;
}

/* The real frames, on one side of the table, have the size of the mode that the
 * table refers to, or of the camera. Both structures begin with width and
 * height. */
static rg_status check_real_size(const uint8_t* bytes, const uint8_t* section,
                                 const uint8_t* camera) {
  const uint32_t mode = section[RG_VIEW_MODE];
  const uint8_t* const real = mode != 0 ? rg_find_mode(bytes, mode) : camera;
  if (!real) return RG_ERR_MODE;
  const uint8_t* const size = section[RG_VIEW_DIRECTION] == RG_DISTORT
                                  ? section + RG_REMAP_WIDTH
                                  : section + RG_VIEW_SOURCE_WIDTH;
  return rg_load_u32(size) == rg_load_u32(real) ? RG_OK : RG_ERR_REMAP_SIZE;
}

static rg_status check_view(const uint8_t* bytes, const uint8_t* section,
                            const uint8_t* camera) {
  if (section[RG_VIEW_RESERVED] != 0 || section[RG_VIEW_DIRECTION] > RG_DISTORT)
    return RG_ERR_RESERVED;
  if (section[RG_VIEW_PROJECTION] >= RG_NUM_PROJECTIONS ||
      !is_rotation(section + RG_VIEW_ROTATION))
    return RG_ERR_REMAP_CAMERA;
  return check_real_size(bytes, section, camera);
}

static rg_status check_mode(const uint8_t* mode) {
  if ((rg_load_u16(mode + RG_MODE_RESERVED) |
       rg_load_u32(mode + RG_MODE_RESERVED + 2) |
       rg_load_u32(mode + RG_MODE_RESERVED + 6)) != 0)
    return RG_ERR_RESERVED;
  if (mode[RG_MODE_NAME + RG_TEXT_SIZE - 1] != 0) return RG_ERR_TEXT;
  for (uint32_t c = 0; c < 2; ++c) {
    const int32_t offset_q16 = rg_load_i32(mode + RG_MODE_OFFSET_X + 4 * c);
    const uint32_t scale_q16 = rg_load_u32(mode + RG_MODE_SCALE_X + 4 * c);
    if (rg_load_u16(mode + RG_MODE_WIDTH + 2 * c) - 1u >= RG_MAX_IMAGE_SIZE ||
        scale_q16 < RG_MIN_MODE_SCALE_Q16 ||
        scale_q16 > RG_MAX_MODE_SCALE_Q16 ||
        offset_q16 >= RG_MODE_OFFSET_LIMIT_Q16 ||
        offset_q16 <= -RG_MODE_OFFSET_LIMIT_Q16 || mode[RG_MODE_FLIP_X + c] > 1)
      return RG_ERR_MODE;
  }
  return RG_OK;
}

static rg_status check_modes(const uint8_t* section, uint32_t size) {
  if (size % RG_MODE_SIZE != 0 || size / RG_MODE_SIZE > RG_MAX_MODES)
    return RG_ERR_SECTION_SIZE;
  rg_status status = RG_OK;
  for (uint32_t at = 0; at < size && status == RG_OK; at += RG_MODE_SIZE)
    status = check_mode(section + at);
  return status;
}

/* Whether values are in range if they are known, and otherwise 0. */
static int is_lens_position(const uint8_t* section, int is_known) {
  const int32_t position_q16 = rg_load_i32(section + RG_CAPTURE_LENS_POSITION);
  const uint32_t tolerance_q16 =
      rg_load_u32(section + RG_CAPTURE_LENS_TOLERANCE);
  const int32_t limit_q16 = is_known ? RG_LENS_POSITION_LIMIT_Q16 : 0;
  return position_q16 <= limit_q16 && position_q16 >= -limit_q16 &&
         tolerance_q16 <= (uint32_t)limit_q16;
}

/* Whether start and length of a crop along one image axis are in range. */
static int is_crop_axis(int32_t start, uint32_t span, uint32_t image) {
  return start <= (int32_t)RG_CROP_LIMIT && start >= -(int32_t)RG_CROP_LIMIT &&
         span - 1 < RG_CROP_LIMIT && span <= RG_MAX_CROP_SCALE * image &&
         image <= RG_MAX_CROP_SCALE * span;
}

static int is_crop(const uint8_t* section, int is_known,
                   const uint8_t* camera) {
  for (uint32_t c = 0; c < 2; ++c) {
    const int32_t start = rg_load_i32(section + RG_CAPTURE_CROP_X + 4 * c);
    const uint32_t span = rg_load_u32(section + RG_CAPTURE_CROP_WIDTH + 4 * c);
    const uint32_t image = rg_load_u16(camera + RG_CAMERA_WIDTH + 2 * c);
    const int is_good = is_known ? is_crop_axis(start, span, image)
                                 : ((uint32_t)start | span) == 0;
    if (!is_good) return 0;
  }
  return 1;
}

static int is_zoom(uint32_t zoom_q16, int is_known) {
  return is_known ? zoom_q16 >= RG_MIN_ZOOM_Q16 && zoom_q16 <= RG_MAX_ZOOM_Q16
                  : zoom_q16 == 0;
}

static int is_orientation(uint32_t orientation, int is_known) {
  return is_known ? orientation - 1 < RG_MAX_ORIENTATION : orientation == 0;
}

static int is_temperature(int32_t degrees_q16, int is_known) {
  const int32_t limit_q16 = is_known ? RG_TEMPERATURE_LIMIT_Q16 : 0;
  return degrees_q16 <= limit_q16 && degrees_q16 >= -limit_q16;
}

/* A value from 1 to the limit, or 0 if it is unknown. */
static int is_up_to(uint32_t limit, uint32_t value, int is_known) {
  return is_known ? value - 1 < limit : value == 0;
}

static rg_status check_capture(const uint8_t* section, uint32_t size,
                               const uint8_t* camera) {
  if (size < RG_CAPTURE_SIZE) return RG_ERR_SECTION_SIZE;
  if (rg_load_u16(section + RG_CAPTURE_RESERVED) != 0) return RG_ERR_RESERVED;
  const uint32_t known = section[RG_CAPTURE_KNOWN];
  return known - 1 < 2 * RG_CAPTURE_HAS_GAIN - 1 &&
                 is_lens_position(
                     section, (known & RG_CAPTURE_HAS_LENS_POSITION) != 0) &&
                 is_crop(section, (known & RG_CAPTURE_HAS_CROP) != 0, camera) &&
                 is_zoom(rg_load_u32(section + RG_CAPTURE_ZOOM),
                         (known & RG_CAPTURE_HAS_ZOOM) != 0) &&
                 is_orientation(section[RG_CAPTURE_ORIENTATION],
                                (known & RG_CAPTURE_HAS_ORIENTATION) != 0) &&
                 is_temperature(rg_load_i32(section + RG_CAPTURE_TEMPERATURE),
                                (known & RG_CAPTURE_HAS_TEMPERATURE) != 0) &&
                 is_up_to(RG_MAX_EXPOSURE_US,
                          rg_load_u32(section + RG_CAPTURE_EXPOSURE),
                          (known & RG_CAPTURE_HAS_EXPOSURE) != 0) &&
                 is_up_to(RG_MAX_ANALOGUE_GAIN_Q16,
                          rg_load_u32(section + RG_CAPTURE_ANALOGUE_GAIN),
                          (known & RG_CAPTURE_HAS_GAIN) != 0)
             ? RG_OK
             : RG_ERR_CAPTURE;
}

static rg_status check_remap(const uint8_t* bytes, const uint8_t* section,
                             uint32_t size, const uint8_t* camera) {
  if (section[RG_REMAP_PART_LOG2] == 0 && rg_bend_shift(section) != 0)
    return RG_ERR_RESERVED;
  rg_status status = rg_check_remap(
      section, size,
      rg_source_size(section, size, rg_load_u32(camera + RG_CAMERA_WIDTH)));
  if (status == RG_OK)
    status = rg_check_vertices(section, rg_find_vertices(section));
  if (status != RG_OK) return status;
  if (rg_load_u32(section + RG_REMAP_FX) == 0 ||
      rg_load_u32(section + RG_REMAP_FY) == 0)
    return RG_ERR_REMAP_CAMERA;
  return rg_has_view(section) ? check_view(bytes, section, camera) : RG_OK;
}

static rg_status check_part(const uint8_t* bytes, uint32_t type,
                            const uint8_t* section, uint32_t size,
                            const uint8_t* camera) {
  return type == RG_SECTION_REMAP
             ? check_remap(bytes, section, size, camera)
             : check_grid(section, size,
                          type == RG_SECTION_CENTRAL_GRID ? camera : 0);
}

/* Checks a section's fields and arrays against the camera and the grid, which
 * may not have been checked yet. */
static rg_status check_section(const uint8_t* bytes, const uint8_t* entry,
                               const rg_sections* sections) {
  const uint8_t* const section = bytes + rg_load_u32(entry + RG_ENTRY_OFFSET);
  const uint32_t size = rg_load_u32(entry + RG_ENTRY_SIZE);
  const uint8_t* const camera = sections->of[RG_SECTION_CAMERA].bytes;
  const uint8_t* const grid = sections->of[RG_SECTION_CENTRAL_GRID].bytes;
  const uint32_t type = rg_load_u16(entry + RG_ENTRY_TYPE);
  switch (type) {
    case RG_SECTION_CAMERA:
      return check_camera(section);
    case RG_SECTION_CENTRAL_GRID:
    case RG_SECTION_REMAP:
    case RG_SECTION_INVERSE:
      return check_part(bytes, type, section, size, camera);
    case RG_SECTION_LINE_POINTS:
      return check_line_points(section, size, grid);
    case RG_SECTION_MASK:
      return check_mask(section, size, camera);
    case RG_SECTION_UNCERTAINTY:
      return check_uncertainty(section, size, grid);
    case RG_SECTION_MODES:
      return check_modes(section, size);
    case RG_SECTION_CAPTURE:
      return check_capture(section, size, camera);
    case RG_SECTION_STACK:
      return rg_validate_stack(bytes, section, size, sections, check_part);
    case RG_SECTION_ROW_TIME:
      return rg_check_row_time(section, size);
    default:
      return RG_OK;
  }
}

static rg_status check_blob(const uint8_t* bytes, uint32_t num_bytes) {
  rg_sections sections;
  rg_status status = rg_check_table(bytes, num_bytes, &sections);
  if (status != RG_OK) return status;
  if ((rg_load_u32(bytes + RG_HEADER_RESERVED) |
       rg_load_u32(bytes + RG_HEADER_RESERVED + 4)) != 0)
    return RG_ERR_RESERVED;
  const uint8_t* const table = bytes + RG_HEADER_SIZE;
  const uint8_t* const end =
      table +
      rg_load_u16(bytes + RG_HEADER_SECTION_COUNT) * RG_SECTION_ENTRY_SIZE;
  const uint8_t* entry;
  for (entry = table; entry != end && status == RG_OK;
       entry += RG_SECTION_ENTRY_SIZE)
    status = check_entry(bytes, entry, &sections);
  if (status == RG_OK && (!sections.of[RG_SECTION_CAMERA].bytes ||
                          !sections.of[RG_SECTION_CENTRAL_GRID].bytes))
    status = RG_ERR_SECTION_MISSING;
  for (entry = table; entry != end && status == RG_OK;
       entry += RG_SECTION_ENTRY_SIZE)
    status = check_section(bytes, entry, &sections);
  return status;
}

const uint8_t* rg_find_section(const uint8_t* bytes, uint32_t type,
                               uint32_t index) {
  const uint8_t* const entry = rg_find_entry(bytes, type, index);
  return entry ? bytes + rg_load_u32(entry + RG_ENTRY_OFFSET) : 0;
}

/* The offset of the section with this type; 0 if there is none. */
static uint32_t get_section_offset(const uint8_t* bytes, uint32_t type) {
  const uint8_t* const entry = rg_find_entry(bytes, type, 0);
  return entry ? rg_load_u32(entry + RG_ENTRY_OFFSET) : 0;
}

rg_status rg_blob_open(const void* bytes, uint32_t num_bytes, rg_blob* blob) {
  if (!blob || !bytes) return RG_ERR_ARGUMENT;
  const uint8_t* const first = (const uint8_t*)bytes;
  const rg_status status = check_blob(first, num_bytes);
  if (status != RG_OK) return status;
  blob->bytes = first;
  blob->size = rg_load_u32(first + RG_HEADER_TOTAL_SIZE);
  blob->camera = get_section_offset(first, RG_SECTION_CAMERA);
  blob->grid = get_section_offset(first, RG_SECTION_CENTRAL_GRID);
  blob->remap = get_section_offset(first, RG_SECTION_REMAP);
  blob->quality = get_section_offset(first, RG_SECTION_QUALITY);
  blob->inverse = get_section_offset(first, RG_SECTION_INVERSE);
  blob->line_points = get_section_offset(first, RG_SECTION_LINE_POINTS);
  blob->mask = get_section_offset(first, RG_SECTION_MASK);
  blob->uncertainty = get_section_offset(first, RG_SECTION_UNCERTAINTY);
  blob->modes = get_section_offset(first, RG_SECTION_MODES);
  blob->capture = get_section_offset(first, RG_SECTION_CAPTURE);
  blob->stack = get_section_offset(first, RG_SECTION_STACK);
  blob->row_time = get_section_offset(first, RG_SECTION_ROW_TIME);
  return RG_OK;
}
