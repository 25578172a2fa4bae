#include "bytes.h"
#include "raygrid.h"
#include "rg_blob.h"
#include "surface.h"

/* Fails to compile if the handle outgrows what raygrid.h promises. */
typedef char rg_camera_fits_64_bytes[sizeof(rg_camera) <= 64 ? 1 : -1];

/* 0 if there is no section. */
static uint32_t offset_in(const uint8_t* blob, const uint8_t* section) {
  return section ? (uint32_t)(section - blob) : 0;
}

rg_status rg_camera_open(rg_camera* camera, const void* bytes,
                         uint32_t num_bytes) {
  const uint8_t* sections[RG_NUM_SECTION_TYPES];
  if (!camera) return RG_ERR_ARGUMENT;
  const rg_status status = rg_blob_check(bytes, num_bytes, sections);
  if (status != RG_OK) return status;
  const uint8_t* const grid = sections[RG_SECTION_CENTRAL_GRID];
  camera->blob = (const uint8_t*)bytes;
  camera->control_points = rg_load_u16(grid + 30) == RG_CONTROL_POINT_BITS
                               ? grid + rg_load_u32(grid + 32)
                               : 0;
  camera->remap = sections[RG_SECTION_REMAP];
  camera->inverse = offset_in(bytes, sections[RG_SECTION_INVERSE]);
  camera->line_points = offset_in(bytes, sections[RG_SECTION_LINE_POINTS]);
  for (uint32_t c = 0; c < 2; ++c) {
    rg_read_axis(grid, c, &camera->axes[c]);
    camera->last_cell[c] = (uint16_t)(rg_load_u16(grid + 16 + 2 * c) - 4);
  }
  camera->width = rg_load_u16(sections[RG_SECTION_CAMERA]);
  camera->height = rg_load_u16(sections[RG_SECTION_CAMERA] + 2);
  return RG_OK;
}

rg_status rg_select_remap(rg_camera* camera, uint32_t index) {
  const uint8_t* const remap =
      rg_find_section(camera->blob, RG_SECTION_REMAP, index);
  if (!remap) return RG_ERR_NO_REMAP;
  camera->remap = remap;
  return RG_OK;
}
