/* The interface between the functions that undistort frames and the traversal
 * of a frame's components tile by tile. traversal_fast.c and traversal_small.c
 * each implement all of its functions, with identical output. RG_FAST_TRAVERSAL
 * in config.h selects the file that is built. runtime/DESIGN.md, "Two
 * traversals".
 *
 * The callers check all arguments, so that no function here fails. Functions
 * with a status always return RG_OK, so that callers can end with a tail call,
 * which frees their stack. */
#ifndef RAYGRID_TRAVERSAL_H
#define RAYGRID_TRAVERSAL_H

#include "frames/row_range.h"
#include "raygrid.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Implements rg_remap_grey(): undistorts a band of a grey frame. A separate
 * function, so that programs for grey frames only do not link the others. */
rg_status rg_traverse_grey(const rg_camera* camera, const rg_grey_image* frame,
                           const rg_grey_target* band);

/* Implements rg_remap(): undistorts all components of the target's rows. */
rg_status rg_traverse_image(const rg_camera* camera, const rg_image* image,
                            const rg_target* target);

/* Implements rg_remap_source_rows(): extends search->source by the image rows
 * that the output rows depend on, in all components of the format. */
void rg_traverse_source_rows(const rg_camera* camera, rg_format format,
                             rg_row_search* search);

#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_TRAVERSAL_H */
