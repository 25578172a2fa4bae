/** @file
 * Projections of the virtual cameras of undistorted images (formats/SPEC.md,
 * "Views"). */
#ifndef RAYGRID_RG_PROJECTION_H
#define RAYGRID_RG_PROJECTION_H

/** How a virtual camera projects a direction: pixel = (fx a + cx, fy b + cy).
 *
 * (x, y, z) is the unit direction in axes of the view: x right, y down, z
 * forward. Angles are in radians. */
typedef enum rg_projection {
  /** (a, b) = (x, y) / z */
  RG_PROJECTION_PINHOLE,
  /** a = atan2(x, z), b = y / hypot(x, z) */
  RG_PROJECTION_CYLINDRICAL,
  /** a = atan2(x, z), b = asin(y) */
  RG_PROJECTION_EQUIRECTANGULAR,
  /** (a, b) = 2 (x, y) / (1 + z) */
  RG_PROJECTION_STEREOGRAPHIC,
  /** (a, b) = acos(z) (x, y) / hypot(x, y) */
  RG_PROJECTION_EQUIDISTANT,
  /** Number of projections; not a projection. */
  RG_NUM_PROJECTIONS
} rg_projection;

#endif /* RAYGRID_RG_PROJECTION_H */
