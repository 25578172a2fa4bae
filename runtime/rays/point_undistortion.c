/* Pixel -> pixel of the virtual camera that a remap table undistorts to. Its
 * direction is turned into axes of the view, put on the view's plane, the image
 * of focal length 1, and becomes a pixel there. */
#include "blob_layout.h"
#include "bytes.h"
#include "fixed_point.h"
#include "raygrid.h"
#include "rays/inverse.h"
#include "rays/polar.h"

#define PIXEL_LIMIT_Q16 (UINT32_C(1) << 30) /* 16384 px */

/* Nothing is divided by less than 1/1024: rays closer to a pinhole's image
 * plane have no pixel. */
#define MIN_DIVISOR_Q30 (INT32_C(1) << 20)

/* A point of the view's plane. */
typedef struct plane_point {
  int32_t xy[2];
  int fraction_bits; /* of both: 19 to 29 */
} plane_point;

/* (x, y) / divisor; 0 if the divisor is too small. */
static RG_INLINE int divide(const int32_t xy_q30[2], int32_t divisor_q30,
                            plane_point* point) {
  if (divisor_q30 < MIN_DIVISOR_Q30) return 0;
  const int doublings = rg_leading_zeros((uint32_t)divisor_q30); /* 1 to 11 */
  const int32_t r_q29 = rg_reciprocal((uint32_t)divisor_q30 << doublings);
  for (int c = 0; c < 2; ++c)
    point->xy[c] = 2 * rg_multiply_high(xy_q30[c], r_q29);
  point->fraction_bits = 30 - doublings;
  return 1;
}

/* 0 where the projection shows nothing. The plane's coordinates are x and y by
 * a divisor, unless angles replace or lengthen them: "Views" in SPEC.md. */
static RG_INLINE int put_on_plane(uint32_t projection, const int32_t xyz_q30[3],
                                  plane_point* point) {
  const int32_t x_q30 = xyz_q30[0], y_q30 = xyz_q30[1], z_q30 = xyz_q30[2];
  const int is_equidistant = projection == RG_PROJECTION_EQUIDISTANT;
  int32_t divisor_q30 = z_q30, first_q29 = 0, second_q29 = 0, length_q30;
  if (projection == RG_PROJECTION_STEREOGRAPHIC)
    divisor_q30 = (z_q30 >> 1) + (INT32_C(1) << 29);
  if (projection != RG_PROJECTION_PINHOLE &&
      projection != RG_PROJECTION_STEREOGRAPHIC) {
    /* Around the z axis and from it, or around the y axis and along it. */
    first_q29 = rg_find_angle(is_equidistant ? x_q30 : z_q30,
                              is_equidistant ? y_q30 : x_q30, &divisor_q30);
    second_q29 =
        rg_find_angle(is_equidistant ? z_q30 : divisor_q30,
                      is_equidistant ? divisor_q30 : y_q30, &length_q30);
    /* So near the z axis, angle and tangent are the same to 3e-10; at the y
     * axis longitude and latitude are not divided. */
    if (is_equidistant && divisor_q30 < MIN_DIVISOR_Q30) {
      divisor_q30 = z_q30;
      projection = RG_PROJECTION_PINHOLE;
    }
    if (projection == RG_PROJECTION_EQUIRECTANGULAR)
      divisor_q30 = INT32_C(1) << 30;
  }
  if (!divide(xyz_q30, divisor_q30, point)) return 0;
  const int to_q29 = 29 - point->fraction_bits;
  if (projection == RG_PROJECTION_EQUIDISTANT) {
    for (int c = 0; c < 2; ++c)
      point->xy[c] = rg_shift_left(
          rg_multiply_high(rg_shift_left(point->xy[c], to_q29), second_q29), 3);
    point->fraction_bits = 29;
  }
  if (projection - RG_PROJECTION_CYLINDRICAL <= 1) {
    point->xy[0] = first_q29 >> to_q29;
    if (projection == RG_PROJECTION_EQUIRECTANGULAR) point->xy[1] = second_q29;
  }
  return 1;
}

/* Camera axes to axes of the view, which is turned: the rotation's columns
 * times the ray. */
static void turn(const uint8_t* rotation, const rg_ray* ray,
                 int32_t xyz_q30[3]) {
  for (uint32_t c = 0; c < 3; ++c) {
    const uint8_t* const column = rotation + 4 * c;
    const int64_t sum = rg_product(rg_load_i32(column), ray->x_q30) +
                        rg_product(rg_load_i32(column + 12), ray->y_q30) +
                        rg_product(rg_load_i32(column + 24), ray->z_q30);
    xyz_q30[c] = rg_shift_left(rg_upper_word(sum), 2);
  }
}

/* focal times the coordinate, and center; 0 if that lies beyond the limit, or
 * as far from the center. axis: the table's section for x, 4 bytes behind it
 * for y. */
static int find_view_pixel(const uint8_t* axis, int32_t coordinate,
                           int fraction_bits, int32_t* pixel_q16) {
  const uint32_t focal_q16 = rg_load_u32(axis + RG_REMAP_FX);
  const int32_t center_q16 = rg_load_i32(axis + RG_REMAP_CX);
  uint32_t low;
  const uint32_t high =
      rg_multiply_unsigned(rg_magnitude(coordinate), focal_q16, &low);
  const int shift = fraction_bits - 1; /* 18 to 28 */
  if (high >> (shift - 1) != 0) return 0;
  const uint32_t distance_q17 = (high << (32 - shift)) | (low >> shift);
  const int32_t distance_q16 = (int32_t)((distance_q17 + 1) >> 1);
  const int32_t sum_q16 =
      rg_add(center_q16, coordinate < 0 ? -distance_q16 : distance_q16);
  *pixel_q16 = sum_q16;
  return rg_magnitude(sum_q16) < PIXEL_LIMIT_Q16;
}

/* A frame of its own: the stack is not as deep as of un-projection. */
static RG_NOINLINE rg_status find_in_view(const uint8_t* section,
                                          const rg_ray* ray,
                                          rg_pixel* undistorted) {
  int32_t xyz_q30[3] = {ray->x_q30, ray->y_q30, ray->z_q30};
  uint32_t projection = RG_PROJECTION_PINHOLE;
  if (rg_has_view(section)) {
    projection = section[RG_VIEW_PROJECTION];
    turn(section + RG_VIEW_ROTATION, ray, xyz_q30);
  }
  plane_point point;
  if (!put_on_plane(projection, xyz_q30, &point)) return RG_ERR_NOT_SEEN;
  for (int c = 0; c < 2; ++c)
    if (!find_view_pixel(section + 4 * c, point.xy[c], point.fraction_bits,
                         &xyz_q30[c]))
      return RG_ERR_NOT_SEEN;
  undistorted->x_q16 = xyz_q30[0];
  undistorted->y_q16 = xyz_q30[1];
  return RG_OK;
}

rg_status rg_undistort_point(const rg_camera* camera, rg_pixel pixel,
                             rg_pixel* undistorted) {
  if (!camera->remap) return RG_ERR_NO_REMAP;
  rg_line line;
  const rg_status status = rg_unproject_line(camera, pixel, &line);
  if (status != RG_OK) return status;
  return find_in_view(camera->remap, &line.direction, undistorted);
}

uint32_t rg_undistort_points(const rg_camera* camera, const rg_pixel* pixels,
                             rg_pixel* undistorted, uint32_t num_points) {
  uint32_t num_seen = 0;
  for (; num_points > 0; --num_points, ++pixels, ++undistorted) {
    if (rg_undistort_point(camera, *pixels, undistorted) == RG_OK)
      ++num_seen;
    else
      undistorted->x_q16 = undistorted->y_q16 = RG_NO_PIXEL;
  }
  return num_seen;
}
