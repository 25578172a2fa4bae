#include "bytes.h"
#include "raygrid.h"
#include "rg_blob.h"

/* Fails to compile if the handle outgrows what raygrid.h promises. */
typedef char rg_camera_fits_64_bytes[sizeof(rg_camera) <= 64 ? 1 : -1];

rg_status rg_camera_open(rg_camera* camera, const void* bytes,
                         uint32_t num_bytes) {
  if (!camera) return RG_ERR_ARGUMENT;
  const rg_status status = rg_blob_check(bytes, num_bytes);
  if (status != RG_OK) return status;
  const uint8_t* const blob = bytes;
  const uint8_t* const identity = rg_find_section(blob, RG_SECTION_CAMERA, 0);
  camera->blob = blob;
  camera->grid = rg_find_section(blob, RG_SECTION_CENTRAL_GRID, 0);
  camera->control_points = camera->grid + rg_load_u32(camera->grid + 32);
  camera->line_points = rg_find_section(blob, RG_SECTION_LINE_POINTS, 0);
  camera->start = rg_find_section(blob, RG_SECTION_START, 0);
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
