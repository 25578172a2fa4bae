/* Reads the sections' fields into structures; see SPEC.md, "Sections". */
#include "blob_checks.h"
#include "bytes.h"
#include "rg_blob.h"

#define rg_load_u8(p) (*(p))
#define LOAD_MEMBER(s, kind, offset, member) \
  (s)->member = rg_load_##kind(section + (offset));

void rg_blob_camera(const rg_blob* blob, rg_camera_section* camera) {
  const uint8_t* section = blob->bytes + blob->camera;
  RG_CAMERA_MEMBERS(LOAD_MEMBER, camera)
  camera->name = (const char*)(section + RG_CAMERA_NAME);
  camera->serial = (const char*)(section + RG_CAMERA_SERIAL);
}

void rg_blob_grid(const rg_blob* blob, rg_grid_section* grid) {
  const uint8_t* section = blob->bytes + blob->grid;
  RG_GRID_MEMBERS(LOAD_MEMBER, grid)
  grid->control_points = section + rg_load_u32(section + RG_GRID_DATA_OFFSET);
}

void rg_blob_control_point(const rg_blob* blob, uint32_t column, uint32_t row,
                           int32_t point_q29[2]) {
  const uint8_t* const section = blob->bytes + blob->grid;
  const uint8_t* const data =
      section + rg_load_u32(section + RG_GRID_DATA_OFFSET);
  const uint32_t k = row * rg_load_u16(section + RG_GRID_COLUMNS) + column;
  const uint32_t bits = rg_load_u16(section + RG_GRID_FRACTION_BITS);
  for (uint32_t c = 0; c < 2; ++c) {
    if (bits == RG_CONTROL_POINT_BITS) {
      point_q29[c] = rg_load_i32(data + RG_CONTROL_POINT_SIZE * k + 4 * c);
      continue;
    }
    const uint8_t* const plane = data + 4 * c;
    const uint8_t* const residual =
        data + RG_NARROW_PLANE_SIZE + RG_NARROW_POINT_SIZE * k + 2 * c;
    point_q29[c] =
        (int32_t)(rg_load_u32(plane + RG_PLANE_ORIGIN) +
                  column * rg_load_u32(plane + RG_PLANE_COLUMN_STEP) +
                  row * rg_load_u32(plane + RG_PLANE_ROW_STEP) +
                  ((uint32_t)rg_load_i16(residual)
                   << (RG_CONTROL_POINT_BITS - bits)));
  }
}

void rg_read_remap(const uint8_t* section, rg_remap_section* remap) {
  RG_REMAP_MEMBERS(LOAD_MEMBER, remap)
  remap->bend_shift = (uint8_t)rg_bend_shift(section);
  remap->has_view = (uint8_t)rg_has_view(section);
  remap->projection = RG_PROJECTION_PINHOLE;
  remap->mode = 0;
  remap->direction = RG_UNDISTORT;
  remap->source_width = remap->source_height = 0;
  if (remap->has_view) {
    remap->projection = section[RG_VIEW_PROJECTION];
    remap->mode = section[RG_VIEW_MODE];
    remap->direction = section[RG_VIEW_DIRECTION];
    remap->source_width = rg_load_u16(section + RG_VIEW_SOURCE_WIDTH);
    remap->source_height = rg_load_u16(section + RG_VIEW_SOURCE_HEIGHT);
  }
  for (uint32_t k = 0; k < 9; ++k)
    remap->rotation_q30[k] =
        remap->has_view ? rg_load_i32(section + RG_VIEW_ROTATION + 4 * k)
                        : (int32_t)(k % 4 == 0) * (INT32_C(1) << 30);
  remap->vertices = section + rg_load_u32(section + RG_REMAP_DATA_OFFSET);
  remap->bends = 0;
  remap->empty_blocks =
      remap->vertices +
      (remap->part_log2 != 0 ? RG_BENT_VERTEX_SIZE : RG_VERTEX_SIZE) *
          remap->columns * remap->rows;
}

void rg_blob_quality(const rg_blob* blob, rg_quality_section* quality) {
  const uint8_t* section = blob->bytes + blob->quality;
  RG_QUALITY_MEMBERS(LOAD_MEMBER, quality)
}

void rg_blob_inverse(const rg_blob* blob, rg_inverse_section* inverse) {
  const uint8_t* section = blob->bytes + blob->inverse;
  RG_INVERSE_MEMBERS(LOAD_MEMBER, inverse)
}

const uint8_t* rg_blob_line_points(const rg_blob* blob) {
  const uint8_t* const section = blob->bytes + blob->line_points;
  return section + rg_load_u32(section + RG_LINE_POINTS_DATA_OFFSET);
}

void rg_blob_mask(const rg_blob* blob, rg_mask_section* mask) {
  const uint8_t* const section = blob->bytes + blob->mask;
  RG_MASK_MEMBERS(LOAD_MEMBER, mask)
  mask->bits = section + rg_load_u32(section + RG_MASK_DATA_OFFSET);
}

uint32_t rg_blob_num_modes(const rg_blob* blob) {
  const uint8_t* const entry = rg_find_entry(blob->bytes, RG_SECTION_MODES, 0);
  return entry ? rg_load_u32(entry + RG_ENTRY_SIZE) / RG_MODE_SIZE : 0;
}

void rg_blob_mode(const rg_blob* blob, uint32_t index, rg_mode_section* mode) {
  const uint8_t* const section =
      blob->bytes + blob->modes + index * RG_MODE_SIZE;
  RG_MODE_MEMBERS(LOAD_MEMBER, mode)
  mode->name = (const char*)(section + RG_MODE_NAME);
}

void rg_blob_uncertainty(const rg_blob* blob,
                         rg_uncertainty_section* uncertainty) {
  const uint8_t* const section = blob->bytes + blob->uncertainty;
  RG_UNCERTAINTY_MEMBERS(LOAD_MEMBER, uncertainty)
  uncertainty->values =
      section + rg_load_u32(section + RG_UNCERTAINTY_DATA_OFFSET);
}

void rg_blob_row_time(const rg_blob* blob, rg_row_time_section* row_time) {
  const uint8_t* const section = blob->bytes + blob->row_time;
  RG_ROW_TIME_MEMBERS(LOAD_MEMBER, row_time)
}

void rg_blob_capture(const rg_blob* blob, rg_capture_section* capture) {
  const uint8_t* const section = blob->bytes + blob->capture;
  RG_CAPTURE_MEMBERS(LOAD_MEMBER, capture)
}
