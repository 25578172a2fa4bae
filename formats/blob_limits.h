/* Full validation (rg_blob_open()): all limits of SPEC.md, "Sections". */
#ifndef RAYGRID_BLOB_LIMITS_H
#define RAYGRID_BLOB_LIMITS_H

#include "blob_checks.h"

/* Checks the central grid or, if camera is NULL, the inverse grid. */
rg_status rg_check_whole_grid(const uint8_t* section, uint32_t size,
                              const uint8_t* camera);

/* Checks a remap table of the blob with its vertices and its view. */
rg_status rg_check_whole_remap(const uint8_t* bytes, const uint8_t* section,
                               uint32_t size, const uint8_t* camera);

/* Checks the operating-point stack with all samples. The blob's other sections
 * must be as long as their fields, but may be unchecked. */
rg_status rg_check_stack(const uint8_t* bytes, const uint8_t* section,
                         uint32_t size, const rg_sections* sections);

#endif /* RAYGRID_BLOB_LIMITS_H */
