/* For rg_blob_check(). */
#ifndef RAYGRID_BLOB_CHECKS_H
#define RAYGRID_BLOB_CHECKS_H

#include <stdint.h>

#include "rg_status.h"

/* 0, or the status of a fault times -1: small constants make short code. */
typedef int rg_fault;

/* Checks the fields and arrays of a section that is as long as its fields, by
 * those of the camera and the grid among the sections, which may not have been
 * checked yet. */
rg_fault rg_check_section(uint32_t type, const uint8_t* section, uint32_t size,
                          const uint8_t* const* sections);

#endif /* RAYGRID_BLOB_CHECKS_H */
