/* The source rows that a band of the output depends on. */
#ifndef RAYGRID_REMAP_SOURCE_ROWS_H
#define RAYGRID_REMAP_SOURCE_ROWS_H

#include "raygrid.h"

/* Checks that the rows are within the output, and that the heights of source
 * and output are valid for the format.
 *
 * Errors: RG_ERR_NO_REMAP, RG_ERR_FORMAT, RG_ERR_ROWS, RG_ERR_FRAME_SIZE */
rg_status rg_check_rows(const rg_camera* camera, rg_format format,
                        uint32_t first_row, uint32_t num_rows);

/* Returns the first source row that the output rows depend on, and the number
 * of source rows in the upper half; or a (negative) status of rg_check_rows().
 */
int32_t rg_find_source_rows(const rg_camera* camera, rg_format format,
                            uint32_t first_row, uint32_t num_rows);

#endif /* RAYGRID_REMAP_SOURCE_ROWS_H */
