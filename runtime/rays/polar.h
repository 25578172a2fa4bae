/* Angles and lengths of plane vectors by CORDIC, with shifts and additions only
 * (Volder, "The CORDIC Trigonometric Computing Technique", 1959). */
#ifndef RAYGRID_POLAR_H
#define RAYGRID_POLAR_H

#include "fixed_point.h"

#define RG_HALF_PI_Q29 843314857

/* Returns the angle from the x axis to (x, y), in q29 rad, from -pi to pi;
 * error below 3e-8 for a vector of length 1, in proportion more for shorter
 * ones. *length_q30 is the length, at most 1, within 3e-8. */
int32_t rg_compute_angle(int32_t x_q30, int32_t y_q30, int32_t* length_q30);

#endif /* RAYGRID_POLAR_H */
