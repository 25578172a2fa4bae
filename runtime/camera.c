#include "blob_checks.h"
#include "bytes.h"
#include "raygrid.h"
#include "rg_blob.h"
#include "surface.h"

/* Fails to compile if the handle outgrows what raygrid.h promises. */
typedef char rg_camera_fits_64_bytes[sizeof(rg_camera) <= 64 ? 1 : -1];

/* What rays need, in a blob whose table was checked; the camera is written
 * last. */
static rg_fault open_rays(rg_camera* camera, const uint8_t* blob) {
  const uint8_t* const identity = rg_find_entry(blob, RG_SECTION_CAMERA, 0);
  const uint8_t* const grid = rg_find_entry(blob, RG_SECTION_CENTRAL_GRID, 0);
  const uint8_t* const inverse = rg_find_entry(blob, RG_SECTION_INVERSE, 0);
  const uint8_t* const lines = rg_find_entry(blob, RG_SECTION_LINE_POINTS, 0);
  if (!identity || !grid) return -RG_ERR_SECTION_MISSING;
  const uint8_t* const section = blob + rg_load_u32(grid + 4);
  rg_fault fault = rg_check_grid(section, rg_load_u32(grid + 8));
  if (!fault && inverse)
    fault = rg_check_grid(blob + rg_load_u32(inverse + 4),
                          rg_load_u32(inverse + 8));
  if (!fault && lines)
    fault = rg_check_line_points(blob + rg_load_u32(lines + 4),
                                 rg_load_u32(lines + 8), section);
  if (fault) return fault;
  camera->blob = blob;
  camera->control_points = rg_load_u16(section + 30) == RG_CONTROL_POINT_BITS
                               ? section + rg_load_u32(section + 32)
                               : 0;
  camera->remap = 0;
  camera->inverse = inverse ? rg_load_u32(inverse + 4) : 0;
  camera->line_points = lines ? rg_load_u32(lines + 4) : 0;
  for (uint32_t c = 0; c < 2; ++c) {
    rg_read_axis(section, c, &camera->axes[c]);
    camera->last_cell[c] = (uint16_t)(rg_load_u16(section + 16 + 2 * c) - 4);
  }
  camera->width = rg_load_u16(blob + rg_load_u32(identity + 4));
  camera->height = rg_load_u16(blob + rg_load_u32(identity + 4) + 2);
  return 0;
}

rg_status rg_camera_open(rg_camera* camera, const void* bytes,
                         uint32_t num_bytes) {
  if (!camera) return RG_ERR_ARGUMENT;
  rg_fault fault = rg_check_table((const uint8_t*)bytes, num_bytes);
  if (!fault) fault = open_rays(camera, (const uint8_t*)bytes);
  return (rg_status)-fault;
}

rg_status rg_select_remap(rg_camera* camera, uint32_t index) {
  const uint8_t* const entry =
      rg_find_entry(camera->blob, RG_SECTION_REMAP, index);
  if (!entry) return RG_ERR_NO_REMAP;
  const uint8_t* const section = camera->blob + rg_load_u32(entry + 4);
  const rg_fault fault = rg_check_remap(section, rg_load_u32(entry + 8),
                                        camera->width, camera->height);
  if (fault) return (rg_status)-fault;
  camera->remap = section;
  return RG_OK;
}
