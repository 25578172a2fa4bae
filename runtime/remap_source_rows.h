/* Whether a ring of rows has what a band of the output needs. */
#ifndef RAYGRID_REMAP_SOURCE_ROWS_H
#define RAYGRID_REMAP_SOURCE_ROWS_H

#include "raygrid.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Of arguments of rg_remap() that have passed its other checks.
 *
 * RG_ERR_ROWS_MISSING */
rg_status rg_check_ring(const rg_camera* camera, const rg_image* image,
                        const rg_target* target);

#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_REMAP_SOURCE_ROWS_H */
