/* How a virtual camera shows directions: SPEC.md, "Views". */
#ifndef RAYGRID_RG_PROJECTION_H
#define RAYGRID_RG_PROJECTION_H

/* Pixel = (fx a + cx, fy b + cy), of a direction (x, y, z) of length 1 in axes
 * of the view, x right, y down, z forward: */
typedef enum rg_projection {
  RG_PROJECTION_PINHOLE,         /* (a, b) = (x, y) / z */
  RG_PROJECTION_CYLINDRICAL,     /* a = atan2(x, z), b = y / hypot(x, z) */
  RG_PROJECTION_EQUIRECTANGULAR, /* a = atan2(x, z), b = asin(y) */
  RG_PROJECTION_STEREOGRAPHIC,   /* (a, b) = 2 (x, y) / (1 + z) */
  RG_PROJECTION_EQUIDISTANT,     /* (a, b) = acos(z) (x, y) / hypot(x, y) */
  RG_NUM_PROJECTIONS
} rg_projection;

#endif /* RAYGRID_RG_PROJECTION_H */
