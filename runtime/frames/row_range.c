#include "frames/row_range.h"

/* The tolerance of a position in q12: a row's step is rounded by up to 1/2, so
 * its 32nd pixel by up to 16; an interpolated pixel may be rounded in the
 * opposite direction. */
#define SLACK 33

void rg_add_rows(rg_row_range* found, int32_t y_q12, int32_t num_rows,
                 uint32_t log2) {
  int32_t first = (y_q12 - SLACK) >> 12;
  int32_t end = ((y_q12 + SLACK) >> 12) + 2;
  if (first < 0) first = 0;
  if (end > num_rows) end = num_rows;
  first *= 1 << log2;
  end *= 1 << log2;
  if (first < found->first) found->first = (uint16_t)first;
  if (end > found->end) found->end = (uint16_t)end;
}
