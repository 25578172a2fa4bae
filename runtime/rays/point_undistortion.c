/* Pixel -> pixel of the virtual camera of a remap table. The pixel's direction
 * is rotated to view axes, projected to the view's plane, the image of focal
 * length 1, and scaled to a pixel. */
#include "blob_layout.h"
#include "bytes.h"
#include "fixed_point.h"
#include "raygrid.h"
#include "rays/inverse.h"
#include "rays/polar.h"

#define PIXEL_LIMIT_Q16 (UINT32_C(1) << 30) /* 16384 px */

/* The smallest divisor is 1/1024: rays closer to a pinhole's image plane have
 * no pixel. */
#define MIN_DIVISOR_Q30 (INT32_C(1) << 20)

/* Divides x and y; the results have 19 to 29 fraction bits, a number that is
 * returned. 0 if the divisor is too small. */
static RG_SHARED int divide(int32_t xy_q30[2], int32_t divisor_q30) {
  if (divisor_q30 < MIN_DIVISOR_Q30) return 0;
  const int doublings = rg_leading_zeros((uint32_t)divisor_q30); /* 1 to 11 */
  const int32_t r_q29 = rg_reciprocal((uint32_t)divisor_q30 << doublings);
  for (int c = 0; c < 2; ++c)
    xy_q30[c] = 2 * rg_multiply_high(xy_q30[c], r_q29);
  return 30 - doublings;
}

/* The angle about the y axis and, for equirectangular views, along it. */
static RG_INLINE int put_on_cylinder(uint32_t projection, int32_t xyz_q30[3]) {
  int32_t distance_q30, length_q30;
  const int32_t around_q29 =
      rg_compute_angle(xyz_q30[2], xyz_q30[0], &distance_q30);
  int fraction_bits = 29;
  if (projection == RG_PROJECTION_EQUIRECTANGULAR)
    xyz_q30[1] = rg_compute_angle(distance_q30, xyz_q30[1], &length_q30);
  else
    fraction_bits = divide(xyz_q30, distance_q30);
  xyz_q30[0] = around_q29 >> (29 - fraction_bits);
  return fraction_bits;
}

/* Scales x and y, divided by their length, to the angle from the z axis. Near
 * that axis, length and angle are equal within 3e-10: divides by z. */
static RG_INLINE int put_on_disk(int32_t xyz_q30[3]) {
  int32_t radius_q30, length_q30;
  const int32_t z_q30 = xyz_q30[2];
  rg_compute_angle(xyz_q30[0], xyz_q30[1], &radius_q30);
  const int fraction_bits = divide(xyz_q30, radius_q30);
  if (fraction_bits == 0) return divide(xyz_q30, z_q30);
  const int32_t angle_q29 = rg_compute_angle(z_q30, radius_q30, &length_q30);
  for (int c = 0; c < 2; ++c)
    xyz_q30[c] = rg_shift_left(
        rg_multiply_high(rg_shift_left(xyz_q30[c], 29 - fraction_bits),
                         angle_q29),
        3);
  return 29;
}

/* Projects to the view's plane: x and y get 19 to 29 fraction bits, which is
 * returned; see "Views" in SPEC.md. 0 where the projection is undefined.
 */
static RG_INLINE int put_on_plane(uint32_t projection, int32_t xyz_q30[3]) {
  if (projection - RG_PROJECTION_CYLINDRICAL <= 1)
    return put_on_cylinder(projection, xyz_q30);
  if (projection == RG_PROJECTION_EQUIDISTANT) return put_on_disk(xyz_q30);
  int32_t divisor_q30 = xyz_q30[2];
  if (projection == RG_PROJECTION_STEREOGRAPHIC)
    divisor_q30 = (divisor_q30 >> 1) + (INT32_C(1) << 29);
  return divide(xyz_q30, divisor_q30);
}

/* Rotates a ray from camera axes to view axes: the columns of the rotation
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

/* Computes focal * coordinate + center in q16; 0 if the result, or its distance
 * from the center, exceeds the limit. axis: the table's section for x, 4 bytes
 * after it for y. */
static RG_INLINE int find_view_pixel(const uint8_t* axis, int fraction_bits,
                                     int32_t* coordinate) {
  const uint32_t focal_q16 = rg_load_u32(axis + RG_REMAP_FX);
  const int32_t center_q16 = rg_load_i32(axis + RG_REMAP_CX);
  uint32_t low;
  const uint32_t high =
      rg_multiply_unsigned(rg_magnitude(*coordinate), focal_q16, &low);
  const int shift = fraction_bits - 1; /* 18 to 28 */
  if (high >> (shift - 1) != 0) return 0;
  const uint32_t distance_q17 = (high << (32 - shift)) | (low >> shift);
  const int32_t distance_q16 = (int32_t)((distance_q17 + 1) >> 1);
  *coordinate =
      rg_add(center_q16, *coordinate < 0 ? -distance_q16 : distance_q16);
  return rg_magnitude(*coordinate) < PIXEL_LIMIT_Q16;
}

/* A separate stack frame: the stack is less deep than in unprojection. */
static RG_NOINLINE rg_status find_in_view(const uint8_t* section,
                                          const rg_ray* ray,
                                          rg_pixel* undistorted) {
  int32_t xyz_q30[3] = {ray->x_q30, ray->y_q30, ray->z_q30};
  uint32_t projection = RG_PROJECTION_PINHOLE;
  if (rg_has_view(section)) {
    projection = section[RG_VIEW_PROJECTION];
    turn(section + RG_VIEW_ROTATION, ray, xyz_q30);
  }
  const int fraction_bits = put_on_plane(projection, xyz_q30);
  if (fraction_bits == 0) return RG_ERR_NOT_SEEN;
  for (int c = 0; c < 2; ++c)
    if (!find_view_pixel(section + 4 * c, fraction_bits, &xyz_q30[c]))
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
