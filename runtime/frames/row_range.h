/* Ranges of source rows. */
#ifndef RAYGRID_ROW_RANGE_H
#define RAYGRID_ROW_RANGE_H

#include <stdint.h>

/* Rows [first, end). */
typedef struct rg_row_range {
  uint16_t first, end;
} rg_row_range;

/* Output rows, and the range of source rows found for them so far; initially
 * the empty range [UINT16_MAX, 0). */
typedef struct rg_row_search {
  rg_row_range output, source;
} rg_row_search;

/* Extends the range by the image rows needed at a position of a component,
 * whose source has num_rows rows, each of 2^log2 image rows. */
void rg_add_rows(rg_row_range* found, int32_t y_q12, int32_t num_rows,
                 uint32_t log2);

#endif /* RAYGRID_ROW_RANGE_H */
