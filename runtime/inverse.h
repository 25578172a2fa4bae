/* Reciprocals and square roots by Newton's iteration, without division. */
#ifndef RAYGRID_INVERSE_H
#define RAYGRID_INVERSE_H

#include <stdint.h>

/* 1 / d in q29, relative error below 4e-9, for d_q32 from 2^31 on: d in
 * [1/2, 1). */
int32_t rg_reciprocal(uint32_t d_q32);

/* 1 / sqrt(u) in q29, relative error below 8e-9, for u_q32 from 2^30 on: u in
 * [1/4, 1). */
int32_t rg_inverse_root(uint32_t u_q32);

#endif /* RAYGRID_INVERSE_H */
