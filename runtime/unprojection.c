/* Pixel -> direction. Error budget in runtime/README.md. */
#include "bytes.h"
#include "fixed_point.h"
#include "raygrid.h"
#include "surface.h"

/* rg_direction_of(), once where size matters. */
static RG_SHARED void find_direction(int32_t a_q27, int32_t b_q27,
                                     rg_ray* ray) {
  const rg_chart_point point = {{a_q27, b_q27}};
  rg_direction_of(&point, ray);
}

rg_status rg_unproject(const rg_camera* camera, rg_pixel pixel, rg_ray* ray) {
  rg_place place;
  if (camera->line_points) return RG_ERR_NONCENTRAL;
  const rg_status status =
      rg_find_in_grid(camera, camera->grid, pixel.x_q16, pixel.y_q16, &place);
  if (status == RG_OK)
    find_direction(place.value.q27[0], place.value.q27[1], ray);
  return status;
}

#if RG_HAVE_SMMULR && defined(__thumb2__) && defined(__OPTIMIZE__) && \
    !defined(__clang__)

/* The B-spline of 4 x 4 points of a line, from the first on, rows so many words
 * apart. Compilers would load pairs, of which there are more, and run out of
 * registers. The loop's turns are counted in the bits of rest_of_row that
 * become 2^32 and more. */
static RG_INLINE void add_line_rows(const uint8_t* points, uint32_t rest_of_row,
                                    const rg_place* place,
                                    int32_t sums_q26[3]) {
  const int32_t* row_weight_q31 = place->weights_q31[1];
  int32_t x, y, z, w0, w1;
  __asm__(
      "1:\n\t"
      "ldmia %[points]!, {r0, r1, r2}\n\t"
      "ldrd %[w0], %[w1], %[first_weights]\n\t"
      "smmulr %[x], r0, %[w0]\n\t"
      "smmulr %[y], r1, %[w0]\n\t"
      "smmulr %[z], r2, %[w0]\n\t"
      "ldmia %[points]!, {r0, r1, r2}\n\t"
      "smmlar %[x], r0, %[w1], %[x]\n\t"
      "smmlar %[y], r1, %[w1], %[y]\n\t"
      "smmlar %[z], r2, %[w1], %[z]\n\t"
      "ldmia %[points]!, {r0, r1, r2}\n\t"
      "ldrd %[w0], %[w1], %[last_weights]\n\t"
      "smmlar %[x], r0, %[w0], %[x]\n\t"
      "smmlar %[y], r1, %[w0], %[y]\n\t"
      "smmlar %[z], r2, %[w0], %[z]\n\t"
      "ldmia %[points], {r0, r1, r2}\n\t"
      "add %[points], %[points], %[rest_of_row], lsl #2\n\t"
      "smmlar %[x], r0, %[w1], %[x]\n\t"
      "smmlar %[y], r1, %[w1], %[y]\n\t"
      "smmlar %[z], r2, %[w1], %[z]\n\t"
      "ldr %[w0], [%[row_weight]], #4\n\t"
      "smmlar %[sum_x], %[x], %[w0], %[sum_x]\n\t"
      "smmlar %[sum_y], %[y], %[w0], %[sum_y]\n\t"
      "smmlar %[sum_z], %[z], %[w0], %[sum_z]\n\t"
      "adds %[rest_of_row], %[rest_of_row], #0x40000000\n\t"
      "bcc 1b"
      : [points] "+r"(points), [row_weight] "+r"(row_weight_q31),
        [rest_of_row] "+r"(rest_of_row), [sum_x] "+r"(sums_q26[0]),
        [sum_y] "+r"(sums_q26[1]), [sum_z] "+r"(sums_q26[2]), [x] "=&r"(x),
        [y] "=&r"(y), [z] "=&r"(z), [w0] "=&r"(w0), [w1] "=&r"(w1)
      : [first_weights] "m"(*(const int32_t(*)[2])place->weights_q31[0]),
        [last_weights] "m"(*(const int32_t(*)[2])(place->weights_q31[0] + 2))
      : "r0", "r1", "r2", "cc", "memory");
}

#else

static RG_INLINE void add_line_rows(const uint8_t* points, uint32_t rest_of_row,
                                    const rg_place* place,
                                    int32_t sums_q26[3]) {
  const int32_t* const w_q31 = place->weights_q31[0];
  RG_UNROLL_SHARED
  for (int j = 0; j < 4; ++j, points += 4 * rest_of_row) {
    int32_t x = rg_multiply_high(rg_load_i32(points), w_q31[0]);
    int32_t y = rg_multiply_high(rg_load_i32(points + 4), w_q31[0]);
    int32_t z = rg_multiply_high(rg_load_i32(points + 8), w_q31[0]);
    RG_UNROLL_SHARED
    for (int k = 1; k < 4; ++k) {
      points += 12;
      x = rg_multiply_high_add(x, rg_load_i32(points), w_q31[k]);
      y = rg_multiply_high_add(y, rg_load_i32(points + 4), w_q31[k]);
      z = rg_multiply_high_add(z, rg_load_i32(points + 8), w_q31[k]);
    }
    const int32_t weight_q31 = place->weights_q31[1][j];
    sums_q26[0] = rg_multiply_high_add(sums_q26[0], x, weight_q31);
    sums_q26[1] = rg_multiply_high_add(sums_q26[1], y, weight_q31);
    sums_q26[2] = rg_multiply_high_add(sums_q26[2], z, weight_q31);
  }
}

#endif

/* The camera must have line points. */
static RG_INLINE void find_line_point(const rg_camera* camera,
                                      const rg_place* place,
                                      int32_t point_q28[3]) {
  int32_t sums_q26[3] = {0, 0, 0};
  add_line_rows(camera->line_points + 12 * place->first,
                3u * (rg_load_u16(camera->grid + 16) - 3u), place, sums_q26);
  RG_IN_MEMORY(point_q28);
  point_q28[0] = rg_shift_left(sums_q26[0], 2);
  point_q28[1] = rg_shift_left(sums_q26[1], 2);
  point_q28[2] = rg_shift_left(sums_q26[2], 2);
}

rg_status rg_unproject_line(const rg_camera* camera, rg_pixel pixel,
                            rg_line* line) {
  rg_place place;
  const rg_status status =
      rg_find_in_grid(camera, camera->grid, pixel.x_q16, pixel.y_q16, &place);
  if (status != RG_OK) return status;
  find_direction(place.value.q27[0], place.value.q27[1], &line->direction);
  if (camera->line_points)
    find_line_point(camera, &place, line->point_q28);
  else
    line->point_q28[0] = line->point_q28[1] = line->point_q28[2] = 0;
  return RG_OK;
}

uint32_t rg_unproject_batch(const rg_camera* camera, const rg_pixel* pixels,
                            rg_ray* rays, uint32_t num_pixels) {
  uint32_t num_inside = 0;
  for (; num_pixels > 0; --num_pixels, ++pixels, ++rays) {
    if (rg_unproject(camera, *pixels, rays) == RG_OK)
      ++num_inside;
    else
      rays->x_q30 = rays->y_q30 = rays->z_q30 = 0;
  }
  return num_inside;
}

uint32_t rg_unproject_row(const rg_camera* camera, rg_pixel first, rg_ray* rays,
                          uint32_t num_pixels) {
  uint32_t num_inside = 0;
  for (; num_pixels > 0; --num_pixels, ++rays) {
    num_inside += rg_unproject_batch(camera, &first, rays, 1);
    first.x_q16 = rg_add(first.x_q16, RG_PIXEL(1));
  }
  return num_inside;
}

uint32_t rg_unproject_lines(const rg_camera* camera, const rg_pixel* pixels,
                            rg_line* lines, uint32_t num_pixels) {
  uint32_t num_inside = 0;
  for (; num_pixels > 0; --num_pixels, ++pixels, ++lines) {
    if (rg_unproject_line(camera, *pixels, lines) == RG_OK) {
      ++num_inside;
    } else {
      lines->direction.x_q30 = lines->direction.y_q30 = lines->direction.z_q30 =
          0;
      lines->point_q28[0] = lines->point_q28[1] = lines->point_q28[2] = 0;
    }
  }
  return num_inside;
}
