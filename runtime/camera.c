#include "bytes.h"
#include "raygrid.h"
#include "rg_blob.h"
#include "surface.h"

/* Fails to compile if the handle outgrows what raygrid.h promises. */
typedef char rg_camera_fits_64_bytes[sizeof(rg_camera) <= 64 ? 1 : -1];

static uint32_t offset_of(const uint8_t* blob, uint32_t type) {
  const uint8_t* const section = rg_find_section(blob, type, 0);
  return section ? (uint32_t)(section - blob) : 0;
}

rg_status rg_camera_open(rg_camera* camera, const void* bytes,
                         uint32_t num_bytes) {
  if (!camera) return RG_ERR_ARGUMENT;
  const rg_status status = rg_blob_check(bytes, num_bytes);
  if (status != RG_OK) return status;
  const uint8_t* const blob = bytes;
  const uint8_t* const identity = rg_find_section(blob, RG_SECTION_CAMERA, 0);
  camera->blob = blob;
  const uint8_t* const grid = rg_find_section(blob, RG_SECTION_CENTRAL_GRID, 0);
  camera->line_points = offset_of(blob, RG_SECTION_LINE_POINTS);
  camera->start = offset_of(blob, RG_SECTION_START);
  camera->control_points = grid + rg_load_u32(grid + 32);
  for (uint32_t c = 0; c < 2; ++c) {
    rg_read_axis(grid, c, &camera->axes[c]);
    camera->last_cell[c] = (uint16_t)(rg_load_u16(grid + 16 + 2 * c) - 4);
  }
  camera->remap = rg_find_section(blob, RG_SECTION_REMAP, 0);
  camera->width = rg_load_u16(identity);
  camera->height = rg_load_u16(identity + 2);
  return RG_OK;
}

rg_status rg_select_remap(rg_camera* camera, uint32_t index) {
  const uint8_t* const remap =
      rg_find_section(camera->blob, RG_SECTION_REMAP, index);
  if (!remap) return RG_ERR_NO_REMAP;
  camera->remap = remap;
  return RG_OK;
}
