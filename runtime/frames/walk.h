/* The interface between the functions that undistort frames and the traversal
 * of a frame's components tile by tile. walk_fast.c and walk_small.c each
 * implement all of its functions, with identical output. RG_FAST_WALK in
 * config.h selects the file that is built. runtime/DESIGN.md, "Two traversals".
 *
 * The callers have checked all arguments, so that no function here fails. Those
 * with a status always return RG_OK, so that callers can end with a tail call,
 * which frees their stack. */
#ifndef RAYGRID_WALK_H
#define RAYGRID_WALK_H

#include "frames/row_range.h"
#include "raygrid.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Undistorts a band of a grey frame: rg_remap_grey(). A separate function, so
 * that a program with grey frames only does not link the others. */
rg_status rg_walk_grey(const rg_camera* camera, const rg_frame* frame,
                       const rg_band* band);

/* Undistorts all components of a frame's rows: rg_remap(). */
rg_status rg_walk_image(const rg_camera* camera, const rg_image* image,
                        const rg_target* target);

/* Adds the image rows that the output's rows require, in all components of the
 * format: rg_remap_source_rows(). */
void rg_walk_source_rows(const rg_camera* camera, rg_format format,
                         rg_row_search* search);

#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_WALK_H */
