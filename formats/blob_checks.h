/* For rg_blob_check(). */
#ifndef RAYGRID_BLOB_CHECKS_H
#define RAYGRID_BLOB_CHECKS_H

#include <stdint.h>

#include "rg_status.h"

/* Checks the fields and arrays of a section that is as long as its fields, by
 * those of the camera and the grid, which may not have been checked yet. */
rg_status rg_check_section(uint32_t type, const uint8_t* section, uint32_t size,
                           const uint8_t* camera, const uint8_t* grid);

#endif /* RAYGRID_BLOB_CHECKS_H */
