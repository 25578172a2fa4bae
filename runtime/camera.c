#include "blob_checks.h"
#include "bytes.h"
#include "fixed_point.h"
#include "raygrid.h"
#include "rg_blob.h"
#include "surface.h"

/* Fails to compile if the handle outgrows what raygrid.h promises. */
typedef char rg_camera_fits_64_bytes[sizeof(rg_camera) <= 64 ? 1 : -1];

/* The sections that rays need; the camera is written last. */
static rg_fault open_rays(rg_camera* camera, const uint8_t* blob,
                          const rg_entries* entries) {
  const uint8_t* const identity = entries->of[RG_SECTION_CAMERA];
  const uint8_t* entry = entries->of[RG_SECTION_CENTRAL_GRID];
  if (!identity || !entry) return -RG_ERR_SECTION_MISSING;
  const uint8_t* const grid = blob + rg_load_u32(entry + 4);
  rg_fault fault =
      rg_check_grid(grid, rg_load_u32(entry + 8), RG_CONTROL_POINT_BITS);
  if (fault) return fault;
  const uint8_t* inverse = 0;
  entry = entries->of[RG_SECTION_INVERSE];
  if (entry) {
    inverse = blob + rg_load_u32(entry + 4);
    fault = rg_check_grid(inverse, rg_load_u32(entry + 8), RG_NARROW_MAX_BITS);
    if (fault) return fault;
  }
  const uint8_t* line_points = 0;
  entry = entries->of[RG_SECTION_LINE_POINTS];
  if (entry) {
    line_points = blob + rg_load_u32(entry + 4);
    fault = rg_check_line_points(line_points, rg_load_u32(entry + 8), grid);
    if (fault) return fault;
    line_points += rg_load_u32(line_points + 4);
  }
  camera->blob = blob;
  camera->grid = grid;
  camera->inverse = inverse;
  camera->line_points = line_points;
  camera->remap = 0;
  camera->surface = rg_best_surface();
  const uint8_t* const size = blob + rg_load_u32(identity + 4);
  camera->width = rg_load_u16(size);
  camera->height = rg_load_u16(size + 2);
  return 0;
}

rg_status rg_camera_open(rg_camera* camera, const void* bytes,
                         uint32_t num_bytes) {
  const uint8_t* const blob = (const uint8_t*)bytes;
  rg_entries entries;
  rg_fault fault =
      camera ? rg_check_table(blob, num_bytes, &entries) : -RG_ERR_ARGUMENT;
  if (!fault) fault = open_rays(camera, blob, &entries);
  return (rg_status)-fault;
}

rg_status rg_select_remap(rg_camera* camera, uint32_t index) {
  const uint8_t* const entry =
      rg_find_entry(camera->blob, RG_SECTION_REMAP, index);
  if (!entry) return RG_ERR_NO_REMAP;
  const uint8_t* const section = camera->blob + rg_load_u32(entry + 4);
  rg_fault fault = rg_check_remap(section, rg_load_u32(entry + 8),
                                  camera->width, camera->height);
  /* Elsewhere, what is done with any harms nothing. */
  if (RG_KEEP_LINES && fault == 0) fault = rg_check_vertices(section);
  if (fault) return (rg_status)-fault;
  camera->remap = section;
  return RG_OK;
}
