/* Full validation of the operating-point stack: SPEC.md, "Operating points". */
#ifndef RAYGRID_BLOB_STACK_H
#define RAYGRID_BLOB_STACK_H

#include "blob_checks.h"

/* Checks a grid or remap table of the blob or of a sample, by its type. */
typedef rg_status rg_part_check(const uint8_t* bytes, uint32_t type,
                                const uint8_t* section, uint32_t size,
                                const uint8_t* camera);

/* Checks the operating-point stack with all samples. The blob's other sections
 * must be as long as their fields, but may be unchecked. */
rg_status rg_validate_stack(const uint8_t* bytes, const uint8_t* section,
                            uint32_t size, const rg_sections* sections,
                            rg_part_check* check);

#endif /* RAYGRID_BLOB_STACK_H */
