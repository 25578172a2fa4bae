/* The rows of the source that positions need. */
#ifndef RAYGRID_ROW_RANGE_H
#define RAYGRID_ROW_RANGE_H

#include <stdint.h>

/* Rows from first on, before end. */
typedef struct rg_row_range {
  uint16_t first, end;
} rg_row_range;

/* Rows of the output, and the rows of the source that they need, as far as
 * these are found. None are UINT16_MAX, 0. */
typedef struct rg_row_search {
  rg_row_range output, source;
} rg_row_search;

/* Adds the image rows that a position of a lattice needs. The lattice's source
 * has so many rows, each of 2^log2 image rows. */
void rg_add_rows(rg_row_range* found, int32_t y_q12, int32_t num_rows,
                 uint32_t log2);

#endif /* RAYGRID_ROW_RANGE_H */
