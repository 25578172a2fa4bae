/* Checks of whole readers alone: all limits of SPEC.md, "Sections". */
#ifndef RAYGRID_BLOB_LIMITS_H
#define RAYGRID_BLOB_LIMITS_H

#include "blob_checks.h"

/* The central grid or, without a camera, the inverse one. */
rg_status rg_check_whole_grid(const uint8_t* section, uint32_t size,
                              const uint8_t* camera);

/* A table of the blob with its vertices and its view. */
rg_status rg_check_whole_remap(const uint8_t* bytes, const uint8_t* section,
                               uint32_t size, const uint8_t* camera);

/* The stack, with all of its knots. The blob's other sections are as long as
 * their fields, but need not be checked. */
rg_status rg_check_stack(const uint8_t* bytes, const uint8_t* section,
                         uint32_t size, const rg_sections* sections);

#endif /* RAYGRID_BLOB_LIMITS_H */
