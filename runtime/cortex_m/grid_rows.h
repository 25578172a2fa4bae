/* Rows of control points of a grid, summed with the weights of a B-spline. In C
 * (grid_rows_c.h), and for Thumb-2 in assembler (grid_rows_thumb2.h). */
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

/* C that is written out four times is faster where speed matters. */
#if RG_ROWS_IN_ASSEMBLER && !RG_IS_FAST
#define RG_SUM_POINTS rg_sum_points_in_thumb2
#else
#define RG_SUM_POINTS rg_sum_points_in_c
#endif

#endif /* RAYGRID_GRID_ROWS_H */
