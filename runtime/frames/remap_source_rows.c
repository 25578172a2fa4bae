#include "frames/remap_source_rows.h"

#include "blob_layout.h"
#include "bytes.h"
#include "frames/pixel_formats.h"
#include "frames/traversal.h"

rg_status rg_check_rows(const rg_camera* camera, rg_format format,
                        uint32_t first_row, uint32_t num_rows) {
  if (!camera->remap) return RG_ERR_NO_REMAP;
  if ((uint32_t)format >= RG_NUM_FORMATS) return RG_ERR_FORMAT;
  const uint32_t pairs = rg_row_pairs(format);
  const uint32_t height = rg_load_u16(camera->remap + RG_REMAP_HEIGHT);
  if (((first_row | num_rows) & pairs) != 0 || first_row + num_rows > height)
    return RG_ERR_ROWS;
  return ((camera->frame_height | height) & pairs) != 0 ? RG_ERR_FRAME_SIZE
                                                        : RG_OK;
}

int32_t rg_find_source_rows(const rg_camera* camera, rg_format format,
                            uint32_t first_row, uint32_t num_rows) {
  rg_row_search search; /* set first, to save stack */
  search.output.first = (uint16_t)first_row;
  search.output.end = (uint16_t)(first_row + num_rows);
  search.source.first = UINT16_MAX;
  search.source.end = 0;
  const rg_status status = rg_check_rows(camera, format, first_row, num_rows);
  if (status != RG_OK) return status;
  rg_traverse_source_rows(camera, format, &search);
  /* Rounds to whole pairs of rows if rows come in pairs. */
  const uint32_t pairs = rg_row_pairs(format);
  const uint32_t first = search.source.first & ~pairs;
  const uint32_t end = (search.source.end + pairs) & ~pairs;
  return end == 0 ? 0 : (int32_t)(first | (end - first) << 16);
}

rg_status rg_remap_source_rows(const rg_camera* camera, rg_format format,
                               uint16_t first_row, uint16_t num_rows,
                               uint16_t* first_source, uint16_t* num_source) {
  const int32_t rows = rg_find_source_rows(camera, format, first_row, num_rows);
  if (rows < 0) return (rg_status)rows;
  *first_source = (uint16_t)rows;
  *num_source = (uint16_t)(rows >> 16);
  return RG_OK;
}
