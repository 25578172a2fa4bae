#include "blob_checks.h"
#include "bytes.h"
#include "fixed_point.h"
#include "operating_point_ops.h"
#include "raygrid.h"
#include "rays/surface_choice.h"
#include "rg_blob.h"

/* Compilation fails if the handle exceeds the size stated in raygrid.h. */
typedef char rg_camera_fits_64_bytes[sizeof(rg_camera) <= 64 ? 1 : -1];

/* Checks the sections that rays require. */
static rg_status check_rays(const rg_sections* sections) {
  const rg_section* const grid = &sections->of[RG_SECTION_CENTRAL_GRID];
  const rg_section* const inverse = &sections->of[RG_SECTION_INVERSE];
  const rg_section* const line_points = &sections->of[RG_SECTION_LINE_POINTS];
  if (!sections->of[RG_SECTION_CAMERA].bytes || !grid->bytes)
    return RG_ERR_SECTION_MISSING;
  rg_status status =
      rg_check_grid(grid->bytes, grid->size, RG_CONTROL_POINT_BITS);
  if (status == RG_OK)
    status = rg_check_grid(inverse->bytes, inverse->size, RG_NARROW_MAX_BITS);
  if (status == RG_OK)
    status = rg_check_line_points(line_points->bytes, line_points->size,
                                  grid->bytes);
  return status;
}

/* size: width, and height times 2^16. */
static void set_frame_size(rg_camera* camera, uint32_t size) {
  camera->frame_width = (uint16_t)size;
  camera->frame_height = (uint16_t)(size >> 16);
}

rg_status rg_camera_open(rg_camera* camera, const void* bytes,
                         uint32_t num_bytes) {
  const uint8_t* const blob = (const uint8_t*)bytes;
  rg_sections sections;
  rg_status status = RG_ERR_ARGUMENT;
  if (camera && blob) status = rg_check_table(blob, num_bytes, &sections);
  if (status == RG_OK) status = check_rays(&sections);
  if (status != RG_OK) return status;
  camera->blob = blob;
  camera->grid = sections.of[RG_SECTION_CENTRAL_GRID].bytes;
  camera->inverse = sections.of[RG_SECTION_INVERSE].bytes;
  const uint8_t* line_points = sections.of[RG_SECTION_LINE_POINTS].bytes;
  if (line_points)
    line_points += rg_load_u32(line_points + RG_LINE_POINTS_DATA_OFFSET);
  camera->line_points = line_points;
  camera->remap = 0;
  camera->stack = 0;
  camera->sample_shift = 0;
  camera->weight_q14 = 0;
  if (RG_SELECT_SURFACE) camera->surface = rg_select_surface();
  set_frame_size(camera, rg_load_u32(sections.of[RG_SECTION_CAMERA].bytes +
                                     RG_CAMERA_WIDTH));
  return RG_OK;
}

rg_status rg_select_remap(rg_camera* camera, uint32_t index) {
  const uint8_t* const entry =
      rg_find_entry(camera->blob, RG_SECTION_REMAP, index);
  if (!entry) return RG_ERR_NO_REMAP;
  const uint8_t* section = camera->blob + rg_load_u32(entry + RG_ENTRY_OFFSET);
  const uint32_t size = rg_load_u32(entry + RG_ENTRY_SIZE);
  const uint32_t frame_size =
      rg_source_size(section, size, rg_camera_size(camera->blob));
  rg_status status = rg_check_remap(section, size, frame_size);
  /* The small traversal processes any vertices safely. */
  if (RG_FAST_TRAVERSAL && status == RG_OK)
    status = rg_check_vertices(section, rg_find_vertices(section));
  if (RG_FAST_TRAVERSAL && camera->stack && status == RG_OK)
    status = camera->stack->check_vertices(camera, section);
  if (status == RG_OK) {
    camera->remap = section;
    set_frame_size(camera, frame_size);
  }
  return status;
}
