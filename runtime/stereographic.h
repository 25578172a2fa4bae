/* Directions and their stereographic coordinates, the chart of the control
 * points: (a, b) = tan(theta / 2) (cos phi, sin phi). */
#ifndef RAYGRID_STEREOGRAPHIC_H
#define RAYGRID_STEREOGRAPHIC_H

#include "raygrid.h"

typedef struct rg_chart_point {
  int32_t q28[2]; /* a, b */
} rg_chart_point;

/* The direction of a chart position, |a| and |b| below 4. */
void rg_direction_of(const rg_chart_point* point, rg_ray* ray);

/* The chart position of a direction of any length, within 1e-8 (1 + a^2 + b^2).
 *
 * limit_q30  c |c|, with c a cosine: directions farther from the z axis than
 *            that are refused at little cost. -2^30: none.
 *
 * 0, and *point untouched, for those, for (0, 0, 0), and where |a| or |b| would
 * reach 4. */
int rg_chart_point_of(const rg_ray* direction, int32_t limit_q30,
                      rg_chart_point* point);

#endif /* RAYGRID_STEREOGRAPHIC_H */
