/* B-spline sums of rows of a grid's control points. In C (grid_rows_c.h), and
 * in Thumb-2 assembly (grid_rows_thumb2.h). */
#ifndef RAYGRID_GRID_ROWS_H
#define RAYGRID_GRID_ROWS_H

#include "cortex_m/grid_rows_c.h"
#include "cortex_m/grid_rows_thumb2.h"

#if RG_ROWS_IN_ASSEMBLER
#define RG_SUM_RESIDUALS rg_sum_residuals_in_thumb2
#define RG_ADD_LINE_ROW rg_add_line_row_in_thumb2
#else
#define RG_SUM_RESIDUALS rg_sum_residuals_in_c
#define RG_ADD_LINE_ROW rg_add_line_row_in_c
#endif

/* When optimizing for speed, the unrolled C code is faster. */
#if RG_ROWS_IN_ASSEMBLER && !RG_IS_FAST
#define RG_SUM_POINTS rg_sum_points_in_thumb2
#else
#define RG_SUM_POINTS rg_sum_points_in_c
#endif

#endif /* RAYGRID_GRID_ROWS_H */
