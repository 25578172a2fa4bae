#include "raygrid.h"
#include "rg_blob.h"

/* Fails to compile if the handle outgrows what raygrid.h promises. */
typedef char rg_camera_fits_64_bytes[sizeof(rg_camera) <= 64 ? 1 : -1];

rg_status rg_camera_open(rg_camera* camera, const void* bytes,
                         uint32_t num_bytes) {
  if (!camera) return RG_ERR_ARGUMENT;
  rg_blob blob;
  const rg_status status = rg_blob_open(bytes, num_bytes, &blob);
  if (status != RG_OK) return status;

  rg_camera_section identity;
  rg_grid_section grid;
  rg_blob_camera(&blob, &identity);
  rg_blob_grid(&blob, &grid);
  camera->blob = blob.bytes;
  camera->control_points = grid.control_points;
  camera->remap = blob.remap ? blob.bytes + blob.remap : 0;
  camera->start = blob.start;
  camera->line_points = blob.line_points;
  camera->x0_q16 = grid.x0_q16;
  camera->y0_q16 = grid.y0_q16;
  camera->x1_q16 = grid.x1_q16;
  camera->y1_q16 = grid.y1_q16;
  camera->scale_x_q32 = grid.scale_x_q32;
  camera->scale_y_q32 = grid.scale_y_q32;
  camera->columns = grid.columns;
  camera->rows = grid.rows;
  camera->width = identity.width;
  camera->height = identity.height;
  return RG_OK;
}

rg_status rg_select_remap(rg_camera* camera, uint32_t index) {
  const uint8_t* const remap =
      rg_find_section(camera->blob, RG_SECTION_REMAP, index);
  if (!remap) return RG_ERR_NO_REMAP;
  camera->remap = remap;
  return RG_OK;
}
