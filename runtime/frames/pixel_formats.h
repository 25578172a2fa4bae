/* The components of each pixel format: formats/SPEC.md, "Components". */
#ifndef RAYGRID_PIXEL_FORMATS_H
#define RAYGRID_PIXEL_FORMATS_H

#include <stdint.h>

#include "kernels/samples.h"
#include "raygrid.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Finds the index-th component of a format, 0-based. Returns 0, with *component
 * unchanged, if the index is too large or the format is invalid. */
int rg_get_component(rg_format format, uint32_t index, rg_component* component);

/* 1 if the rows of a format come in pairs, otherwise 0. The format must be
 * below RG_NUM_FORMATS. */
uint32_t rg_row_pairs(rg_format format);

/* Returns the bytes in a row of the component's plane; 0 if the width is not a
 * multiple of component pixels or packed groups. */
uint32_t rg_plane_row_bytes(const rg_component* component, uint32_t width);

#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_PIXEL_FORMATS_H */
