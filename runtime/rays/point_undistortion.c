/* Pixel -> pixel of the virtual pinhole camera that a remap table undistorts
 * to: (fx x / z + cx, fy y / z + cy) of the pixel's direction. */
#include "blob_layout.h"
#include "bytes.h"
#include "fixed_point.h"
#include "raygrid.h"
#include "rays/inverse.h"

#define PIXEL_LIMIT_Q16 (UINT32_C(1) << 30) /* 16384 px */

/* Rays closer to the image plane than 1/1024 rad have no pixel. */
#define MIN_Z_Q30 (INT32_C(1) << 20)

/* focal x / z + center, with 1 / z = reciprocal 2^(doublings - 2); 0 if that
 * lies beyond the limit, or as far from the center. axis: the table's section
 * for x, 4 bytes behind it for y. */
static RG_INLINE int project_coordinate(const uint8_t* axis,
                                        int32_t reciprocal_q29, int doublings,
                                        int32_t x_q30, int32_t* pixel_q16) {
  const uint32_t focal_q16 = rg_load_u32(axis + RG_REMAP_FX);
  const int32_t center_q16 = rg_load_i32(axis + RG_REMAP_CX);
  const int32_t ratio_q28 = 2 * rg_multiply_high(x_q30, reciprocal_q29);
  uint32_t low;
  const uint32_t high =
      rg_multiply_unsigned(rg_magnitude(ratio_q28), focal_q16, &low);
  const int shift = 29 - doublings; /* 18 to 28 */
  if (high >> (shift - 1) != 0) return 0;
  const uint32_t distance_q17 = (high << (32 - shift)) | (low >> shift);
  const int32_t distance_q16 = (int32_t)((distance_q17 + 1) >> 1);
  const int32_t sum_q16 =
      rg_add(center_q16, ratio_q28 < 0 ? -distance_q16 : distance_q16);
  *pixel_q16 = sum_q16;
  return rg_magnitude(sum_q16) < PIXEL_LIMIT_Q16;
}

rg_status rg_undistort_point(const rg_camera* camera, rg_pixel pixel,
                             rg_pixel* undistorted) {
  const uint8_t* const section = camera->remap;
  if (!section) return RG_ERR_NO_REMAP;
  rg_line line;
  const rg_ray* const ray = &line.direction;
  const rg_status status = rg_unproject_line(camera, pixel, &line);
  if (status != RG_OK) return status;
  if (ray->z_q30 < MIN_Z_Q30) return RG_ERR_NOT_SEEN;
  const int doublings = rg_leading_zeros((uint32_t)ray->z_q30); /* 1 to 11 */
  const int32_t r_q29 = rg_reciprocal((uint32_t)ray->z_q30 << doublings);
  int32_t found_q16[2] = {ray->x_q30, ray->y_q30}; /* until projected */
  for (int c = 0; c < 2; ++c)
    if (!project_coordinate(section + 4 * c, r_q29, doublings, found_q16[c],
                            &found_q16[c]))
      return RG_ERR_NOT_SEEN;
  undistorted->x_q16 = found_q16[0];
  undistorted->y_q16 = found_q16[1];
  return RG_OK;
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
