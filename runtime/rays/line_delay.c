/* The line delay of a rolling shutter, as stored in the blob. */
#include "blob_checks.h"
#include "bytes.h"
#include "raygrid.h"
#include "rg_blob.h"

rg_status rg_line_delay(const rg_camera* camera, int32_t* line_delay_ns_q10,
                        uint32_t* std_dev_ns_q10) {
  const uint8_t* const entry =
      rg_find_entry(camera->blob, RG_SECTION_ROW_TIME, 0);
  if (!entry) return RG_ERR_UNKNOWN;
  const uint8_t* const section =
      camera->blob + rg_load_u32(entry + RG_ENTRY_OFFSET);
  /* Checked here, not when opening the blob. */
  const rg_status status =
      rg_check_row_time(section, rg_load_u32(entry + RG_ENTRY_SIZE));
  if (status != RG_OK) return status;
  *line_delay_ns_q10 = rg_load_i32(section + RG_ROW_TIME_ROW_TIME);
  if (std_dev_ns_q10)
    *std_dev_ns_q10 = rg_load_u32(section + RG_ROW_TIME_DEVIATION);
  return RG_OK;
}
