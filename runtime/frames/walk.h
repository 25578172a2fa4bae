/* The seam between the calls that undistort frames and the walk, which goes
 * over the lattices of a frame part by part. walk_fast.c and walk_small.c each
 * have all functions of the seam, and give the same bytes. RG_FAST_WALK in
 * config.h says which file the build takes. runtime/DESIGN.md, "Two
 * traversals".
 *
 * The calls have checked everything, so that no function here fails. Those that
 * return a status always return RG_OK: so a call can end with one of them, and
 * its stack is free by then. */
#ifndef RAYGRID_WALK_H
#define RAYGRID_WALK_H

#include "frames/row_range.h"
#include "raygrid.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Undistorts a band of a grey frame: rg_remap_grey(). A function of its own, so
 * that a program with grey frames alone has no code of the others. */
rg_status rg_walk_grey(const rg_camera* camera, const rg_frame* frame,
                       const rg_band* band);

/* Undistorts all lattices of a frame's rows: rg_remap(). */
rg_status rg_walk_image(const rg_camera* camera, const rg_image* image,
                        const rg_target* target);

/* Adds the image rows that the output's rows need, in all lattices of the
 * format: rg_remap_source_rows(). */
void rg_walk_source_rows(const rg_camera* camera, rg_format format,
                         rg_row_search* search);

#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_WALK_H */
