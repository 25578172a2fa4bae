/* Which rows of the source a band of the output needs. */
#ifndef RAYGRID_REMAP_SOURCE_ROWS_H
#define RAYGRID_REMAP_SOURCE_ROWS_H

#include "raygrid.h"

/* Whether the output has such rows, and the heights of source and output suit
 * the format.
 *
 * RG_ERR_NO_REMAP, RG_ERR_FORMAT, RG_ERR_ROWS, RG_ERR_FRAME_SIZE */
rg_status rg_check_rows(const rg_camera* camera, rg_format format,
                        uint32_t first_row, uint32_t num_rows);

/* The first row of the source that rows of the output need, and in the upper
 * half how many there are; or a status of rg_check_rows(), which is negative.
 */
int32_t rg_find_source_rows(const rg_camera* camera, rg_format format,
                            uint32_t first_row, uint32_t num_rows);

#endif /* RAYGRID_REMAP_SOURCE_ROWS_H */
