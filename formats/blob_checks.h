/* Checks that sections have in common. */
#ifndef RAYGRID_BLOB_CHECKS_H
#define RAYGRID_BLOB_CHECKS_H

#include <stdint.h>

#include "rg_status.h"

/* The section's arrays start behind its fields and fill it to the end. */
rg_status rg_check_extent(uint32_t size, uint32_t data_offset,
                          uint32_t fields_size, uint32_t data_size);

/* scale = floor(cells 2^48 / span) */
int rg_is_grid_scale(uint32_t scale, uint32_t cells, uint32_t span);

/* The bits from num_bits to the next multiple of 32 are zero. */
int rg_is_mask_padded(const uint8_t* mask, uint32_t num_bits);

#endif /* RAYGRID_BLOB_CHECKS_H */
