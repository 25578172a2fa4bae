/* The fields of each section: their limits, and reading them. The offsets are
 * those of SPEC.md, "Sections". */
#include "blob_checks.h"
#include "bytes.h"
#include "rg_blob.h"
#include "wide_multiply.h"

/* Bytes of text, then only zeros, of which there is at least one. */
static int is_padded_text(const uint8_t* text) {
  if (text[RG_TEXT_SIZE - 1] != 0) return 0;
  for (uint32_t i = 1; i < RG_TEXT_SIZE; ++i)
    if (text[i - 1] == 0 && text[i] != 0) return 0;
  return 1;
}

rg_status rg_check_extent(uint32_t size, uint32_t data_offset,
                          uint32_t fields_size, uint32_t data_size) {
  if (data_offset < fields_size || data_offset % 4 != 0)
    return RG_ERR_DATA_OFFSET;
  if (data_offset > size || size - data_offset != data_size)
    return RG_ERR_SECTION_SIZE;
  return RG_OK;
}

rg_status rg_check_camera(const uint8_t* section, uint32_t size) {
  if (size < RG_CAMERA_SIZE) return RG_ERR_SECTION_SIZE;
  const uint32_t width = rg_load_u16(section);
  const uint32_t height = rg_load_u16(section + 2);
  if (width - 1 >= RG_MAX_IMAGE_SIZE || height - 1 >= RG_MAX_IMAGE_SIZE)
    return RG_ERR_IMAGE_SIZE;
  if (rg_load_u32(section + 4) != 0) return RG_ERR_RESERVED;
  if (!is_padded_text(section + 8) || !is_padded_text(section + 40))
    return RG_ERR_TEXT;
  return RG_OK;
}

void rg_blob_camera(const rg_blob* blob, rg_camera_section* camera) {
  const uint8_t* section = blob->bytes + blob->camera;
  camera->width = rg_load_u16(section);
  camera->height = rg_load_u16(section + 2);
  camera->name = (const char*)(section + 8);
  camera->serial = (const char*)(section + 40);
}

/* min < max, both on the image: from -1/2 to size - 1/2. */
static int is_interval_on_image(int32_t min_q16, int32_t max_q16,
                                uint32_t num_pixels) {
  return min_q16 >= -0x8000 && min_q16 < max_q16 &&
         max_q16 <= (int32_t)(num_pixels << 16) - 0x8000;
}

/* The remainder is less than span. */
int rg_is_grid_scale(uint32_t scale_q32, uint32_t cells, uint32_t span) {
  uint32_t low;
  const uint32_t high = rg_multiply_unsigned(scale_q32, span, &low);
  const uint32_t remainder = 0u - low;
  const uint32_t borrow = low != 0;
  return (cells << 16) - high - borrow == 0 && remainder < span;
}

static int are_control_points_in_range(const uint8_t* data, uint32_t count) {
  for (uint32_t i = 0; i < count; ++i) {
    const int32_t value = rg_load_i32(data + 4 * i);
    if (value > RG_CONTROL_POINT_LIMIT || value < -RG_CONTROL_POINT_LIMIT)
      return 0;
  }
  return 1;
}

/* All but the control points, whose offset may not be checked yet. */
static void load_grid_fields(const uint8_t* section, rg_grid_section* grid) {
  grid->x0_q16 = rg_load_i32(section);
  grid->y0_q16 = rg_load_i32(section + 4);
  grid->x1_q16 = rg_load_i32(section + 8);
  grid->y1_q16 = rg_load_i32(section + 12);
  grid->columns = rg_load_u16(section + 16);
  grid->rows = rg_load_u16(section + 18);
  grid->scale_x_q32 = rg_load_u32(section + 20);
  grid->scale_y_q32 = rg_load_u32(section + 24);
}

rg_status rg_check_grid(const uint8_t* section, uint32_t size,
                        const uint8_t* camera) {
  if (size < RG_GRID_FIELDS_SIZE) return RG_ERR_SECTION_SIZE;
  if (rg_load_u32(section + 36) != 0) return RG_ERR_RESERVED;
  if (rg_load_u16(section + 28) != RG_CHART_STEREOGRAPHIC ||
      rg_load_u16(section + 30) != RG_CONTROL_POINT_BITS)
    return RG_ERR_GRID_CHART;
  rg_grid_section grid;
  load_grid_fields(section, &grid);
  if (grid.columns < RG_MIN_GRID_SIZE || grid.columns > RG_MAX_GRID_SIZE ||
      grid.rows < RG_MIN_GRID_SIZE || grid.rows > RG_MAX_GRID_SIZE)
    return RG_ERR_GRID_SIZE;
  if (!is_interval_on_image(grid.x0_q16, grid.x1_q16, rg_load_u16(camera)) ||
      !is_interval_on_image(grid.y0_q16, grid.y1_q16, rg_load_u16(camera + 2)))
    return RG_ERR_AREA;
  if (!rg_is_grid_scale(grid.scale_x_q32, grid.columns - 3u,
                        (uint32_t)(grid.x1_q16 - grid.x0_q16)) ||
      !rg_is_grid_scale(grid.scale_y_q32, grid.rows - 3u,
                        (uint32_t)(grid.y1_q16 - grid.y0_q16)))
    return RG_ERR_GRID_SCALE;

  const uint32_t data_offset = rg_load_u32(section + 32);
  const uint32_t count = 2u * grid.columns * grid.rows;
  const rg_status status =
      rg_check_extent(size, data_offset, RG_GRID_FIELDS_SIZE, 4 * count);
  if (status != RG_OK) return status;
  if (!are_control_points_in_range(section + data_offset, count))
    return RG_ERR_CONTROL_POINT;
  return RG_OK;
}

void rg_blob_grid(const rg_blob* blob, rg_grid_section* grid) {
  const uint8_t* section = blob->bytes + blob->grid;
  load_grid_fields(section, grid);
  grid->control_points = section + rg_load_u32(section + 32);
}

void rg_read_remap(const uint8_t* section, rg_remap_section* remap) {
  remap->width = rg_load_u16(section);
  remap->height = rg_load_u16(section + 2);
  remap->columns = rg_load_u16(section + 4);
  remap->rows = rg_load_u16(section + 6);
  remap->block_log2 = section[8];
  remap->residual_shift = section[9];
  remap->min_x_q12 = rg_load_i32(section + 12);
  remap->min_y_q12 = rg_load_i32(section + 16);
  remap->max_x_q12 = rg_load_i32(section + 20);
  remap->max_y_q12 = rg_load_i32(section + 24);
  remap->origin_x_q12 = rg_load_i32(section + 28);
  remap->origin_y_q12 = rg_load_i32(section + 32);
  remap->column_step_x_q12 = rg_load_i32(section + 36);
  remap->column_step_y_q12 = rg_load_i32(section + 40);
  remap->row_step_x_q12 = rg_load_i32(section + 44);
  remap->row_step_y_q12 = rg_load_i32(section + 48);
  remap->fx_q16 = rg_load_u32(section + 52);
  remap->fy_q16 = rg_load_u32(section + 56);
  remap->cx_q16 = rg_load_i32(section + 60);
  remap->cy_q16 = rg_load_i32(section + 64);
  remap->bound_upx = rg_load_u32(section + 68);
  remap->max_error_upx = rg_load_u32(section + 72);
  remap->vertices = section + rg_load_u32(section + 76);
  remap->empty_blocks =
      remap->vertices + 4 * (uint32_t)remap->columns * remap->rows;
}

static int is_source_interval(int32_t min_q12, int32_t max_q12,
                              uint32_t num_pixels) {
  return min_q12 >= 0 && min_q12 <= max_q12 &&
         max_q12 <= (int32_t)((num_pixels - 1) << 12);
}

/* -limit < value < limit */
static int is_within(uint32_t value, int32_t limit) {
  return value + (uint32_t)limit - 1 < 2 * (uint32_t)limit - 1;
}

/* One coordinate of all vertices, 0 for x and 1 for y: the second of every pair
 * lies behind the first. Sums are modulo 2^32, as the spec says. */
static int are_vertices_in_range(const uint8_t* section, uint32_t coordinate) {
  const uint8_t* const fields = section + 4 * coordinate;
  const uint8_t* residual =
      section + rg_load_u32(section + 76) + 2 * coordinate;
  uint32_t row_start = rg_load_u32(fields + 28);
  for (uint32_t rows = rg_load_u16(section + 6); rows > 0; --rows) {
    uint32_t affine = row_start;
    for (uint32_t columns = rg_load_u16(section + 4); columns > 0; --columns) {
      const uint32_t offset = (uint32_t)rg_load_i16(residual) << section[9];
      if (!is_within(affine + offset, RG_VERTEX_LIMIT_Q12)) return 0;
      affine += rg_load_u32(fields + 36);
      residual += 4;
    }
    row_start += rg_load_u32(fields + 44);
  }
  return 1;
}

int rg_is_mask_padded(const uint8_t* mask, uint32_t num_bits) {
  const uint32_t padded = (num_bits + 31) / 32 * 32;
  for (uint32_t bit = num_bits; bit < padded; ++bit)
    if ((mask[bit / 8] >> (bit % 8)) & 1) return 0;
  return 1;
}

rg_status rg_check_remap(const uint8_t* section, uint32_t size,
                         const uint8_t* camera) {
  if (size < RG_REMAP_FIELDS_SIZE) return RG_ERR_SECTION_SIZE;
  if (rg_load_u16(section + 10) != 0) return RG_ERR_RESERVED;
  const uint32_t source_width = rg_load_u16(camera);
  const uint32_t source_height = rg_load_u16(camera + 2);
  const uint32_t width = rg_load_u16(section);
  const uint32_t height = rg_load_u16(section + 2);
  if (width - 1 >= RG_MAX_REMAP_SIZE || height - 1 >= RG_MAX_REMAP_SIZE ||
      source_width > RG_MAX_REMAP_SIZE || source_height > RG_MAX_REMAP_SIZE)
    return RG_ERR_REMAP_SIZE;
  const uint32_t block_log2 = section[8];
  if (block_log2 < 3 || block_log2 > 5) return RG_ERR_REMAP_BLOCK;
  const uint32_t columns = ((width - 1) >> block_log2) + 2;
  const uint32_t rows = ((height - 1) >> block_log2) + 2;
  if (rg_load_u16(section + 4) != columns || rg_load_u16(section + 6) != rows)
    return RG_ERR_REMAP_BLOCK;
  if (section[9] > RG_MAX_RESIDUAL_SHIFT) return RG_ERR_REMAP_SHIFT;
  if (!is_source_interval(rg_load_i32(section + 12), rg_load_i32(section + 20),
                          source_width) ||
      !is_source_interval(rg_load_i32(section + 16), rg_load_i32(section + 24),
                          source_height))
    return RG_ERR_REMAP_SOURCE;
  if (rg_load_u32(section + 52) == 0 || rg_load_u32(section + 56) == 0)
    return RG_ERR_REMAP_CAMERA;

  const uint32_t num_blocks = (columns - 1) * (rows - 1);
  const rg_status status =
      rg_check_extent(size, rg_load_u32(section + 76), RG_REMAP_FIELDS_SIZE,
                      4 * columns * rows + (num_blocks + 31) / 32 * 4);
  if (status != RG_OK) return status;
  if (!are_vertices_in_range(section, 0) || !are_vertices_in_range(section, 1))
    return RG_ERR_REMAP_VERTEX;
  const uint8_t* const mask =
      section + rg_load_u32(section + 76) + 4 * columns * rows;
  return rg_is_mask_padded(mask, num_blocks) ? RG_OK : RG_ERR_RESERVED;
}

rg_status rg_check_quality(const uint8_t* section, uint32_t size) {
  (void)section; /* every figure may take any value */
  return size >= RG_QUALITY_SIZE ? RG_OK : RG_ERR_SECTION_SIZE;
}

void rg_blob_quality(const rg_blob* blob, rg_quality_section* quality) {
  const uint8_t* section = blob->bytes + blob->quality;
  quality->training_median_upx = rg_load_u32(section);
  quality->training_rms_upx = rg_load_u32(section + 4);
  quality->training_max_upx = rg_load_u32(section + 8);
  quality->training_count = rg_load_u32(section + 12);
  quality->held_out_median_upx = rg_load_u32(section + 16);
  quality->held_out_rms_upx = rg_load_u32(section + 20);
  quality->held_out_max_upx = rg_load_u32(section + 24);
  quality->held_out_count = rg_load_u32(section + 28);
  quality->packing_error_npx = rg_load_u32(section + 32);
  quality->packing_error_prad = rg_load_u32(section + 36);
}
