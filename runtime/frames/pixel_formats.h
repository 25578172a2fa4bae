/* The lattices of each pixel format: formats/SPEC.md, "Components". */
#ifndef RAYGRID_PIXEL_FORMATS_H
#define RAYGRID_PIXEL_FORMATS_H

#include <stdint.h>

#include "kernels/samples.h"
#include "raygrid.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The lattice of a format with an index, from 0 on. 0, and no lattice, where it
 * has fewer, or is no format. */
int rg_find_lattice(rg_format format, uint32_t index, rg_lattice* lattice);

/* 1 where the rows of a format come in pairs, else 0. The format is below
 * RG_NUM_FORMATS. */
uint32_t rg_row_pairs(rg_format format);

/* Bytes that a row of the lattice's plane takes; 0 where the width is not a
 * whole number of lattice pixels or of packed groups. */
uint32_t rg_plane_row_bytes(const rg_lattice* lattice, uint32_t width);

#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_PIXEL_FORMATS_H */
