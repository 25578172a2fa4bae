/* Traversal of the rows of a span of grey pixels: either blends them with the
 * kernel, or returns their positions for processing pixel by pixel. In C
 * (grey_rows_c.h), and in Thumb-2 assembly (grey_rows_thumb2.h). */
#ifndef RAYGRID_GREY_ROWS_H
#define RAYGRID_GREY_ROWS_H

#include "config.h"
#include "cortex_m/grey_rows_c.h"
#include "cortex_m/grey_rows_thumb2.h"

#if RG_GREY_ROW_IN_ASSEMBLER
#define RG_FIRST_ROUNDING rg_pack_rounding_and_count
#define RG_PROCESS_GREY_ROWS rg_process_grey_rows_in_thumb2
#else
#define RG_FIRST_ROUNDING rg_first_rounding_in_c
#define RG_PROCESS_GREY_ROWS rg_process_grey_rows_in_c
#endif

#endif /* RAYGRID_GREY_ROWS_H */
