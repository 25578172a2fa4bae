/* The source rows that positions require. */
#ifndef RAYGRID_ROW_RANGE_H
#define RAYGRID_ROW_RANGE_H

#include <stdint.h>

/* Rows in [first, end). */
typedef struct rg_row_range {
  uint16_t first, end;
} rg_row_range;

/* Output rows, and the source rows that they require, as found so far. The
 * empty range is UINT16_MAX, 0. */
typedef struct rg_row_search {
  rg_row_range output, source;
} rg_row_search;

/* Adds the image rows that a position of a component requires. The component's
 * source has num_rows rows, each of 2^log2 image rows. */
void rg_add_rows(rg_row_range* found, int32_t y_q12, int32_t num_rows,
                 uint32_t log2);

#endif /* RAYGRID_ROW_RANGE_H */
