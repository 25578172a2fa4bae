/* Pixel -> direction. Error budget in runtime/DESIGN.md. */
#include "blob_layout.h"
#include "bytes.h"
#include "fixed_point.h"
#include "raygrid.h"
#include "rays/surface_choice.h"

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

/* The B-spline of a row of four points of a line, and the column of four rows.
 * Each product is rounded, q28 to q27 and to q26. Returns the row's last point.
 */
static RG_INLINE const uint8_t* add_line_row(const uint8_t* points,
                                             const int32_t w_q31[4],
                                             const int32_t** row_weight_q31,
                                             int32_t sums_q26[3]) {
#if RG_ROWS_IN_ASSEMBLER
  int32_t x, y, z, w0, w1;
  __asm__(
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
      "smmlar %[x], r0, %[w1], %[x]\n\t"
      "smmlar %[y], r1, %[w1], %[y]\n\t"
      "smmlar %[z], r2, %[w1], %[z]\n\t"
      "ldr %[w0], [%[row_weight]], #4\n\t"
      "smmlar %[sum_x], %[x], %[w0], %[sum_x]\n\t"
      "smmlar %[sum_y], %[y], %[w0], %[sum_y]\n\t"
      "smmlar %[sum_z], %[z], %[w0], %[sum_z]"
      : [points] "+r"(points), [row_weight] "+r"(*row_weight_q31),
        [sum_x] "+r"(sums_q26[0]), [sum_y] "+r"(sums_q26[1]),
        [sum_z] "+r"(sums_q26[2]), [x] "=&r"(x), [y] "=&r"(y), [z] "=&r"(z),
        [w0] "=&r"(w0), [w1] "=&r"(w1)
      : [first_weights] "m"(*(const int32_t(*)[2])w_q31),
        [last_weights] "m"(*(const int32_t(*)[2])(w_q31 + 2)),
        "m"(**row_weight_q31),
        "m"(*(const uint8_t(*)[4 * RG_LINE_POINT_SIZE]) points)
      : "r0", "r1", "r2");
  return points;
#else
  int32_t x = rg_multiply_high(rg_load_i32(points + RG_LINE_POINT_X), w_q31[0]);
  int32_t y = rg_multiply_high(rg_load_i32(points + RG_LINE_POINT_Y), w_q31[0]);
  int32_t z = rg_multiply_high(rg_load_i32(points + RG_LINE_POINT_Z), w_q31[0]);
  RG_UNROLL_SHARED
  for (int k = 1; k < 4; ++k) {
    points += RG_LINE_POINT_SIZE;
    x = rg_multiply_high_add(x, rg_load_i32(points + RG_LINE_POINT_X),
                             w_q31[k]);
    y = rg_multiply_high_add(y, rg_load_i32(points + RG_LINE_POINT_Y),
                             w_q31[k]);
    z = rg_multiply_high_add(z, rg_load_i32(points + RG_LINE_POINT_Z),
                             w_q31[k]);
  }
  const int32_t weight_q31 = *(*row_weight_q31)++;
  sums_q26[0] = rg_multiply_high_add(sums_q26[0], x, weight_q31);
  sums_q26[1] = rg_multiply_high_add(sums_q26[1], y, weight_q31);
  sums_q26[2] = rg_multiply_high_add(sums_q26[2], z, weight_q31);
  return points;
#endif
}

/* (0, 0, 0) of a central camera. */
static RG_INLINE void find_line_point(const rg_camera* camera,
                                      const rg_place* place,
                                      int32_t point_q28[3]) {
  int32_t sums_q26[3] = {0, 0, 0};
  if (camera->line_points) {
    const uint8_t* points =
        camera->line_points + RG_LINE_POINT_SIZE * place->first;
    const int32_t* row_weight = place->weights_q31[1];
    uint32_t rest_of_row =
        3 * (rg_load_u16(camera->grid + RG_GRID_COLUMNS) - 3u); /* words */
    RG_UNROLL_SHARED
    do
      points =
          add_line_row(points, place->weights_q31[0], &row_weight, sums_q26) +
          4 * rest_of_row;
    while (rg_turn(&rest_of_row));
  }
  RG_IN_MEMORY(point_q28);
  point_q28[0] = rg_shift_left(sums_q26[0], 2);
  point_q28[1] = rg_shift_left(sums_q26[1], 2);
  point_q28[2] = rg_shift_left(sums_q26[2], 2);
}

rg_status rg_unproject_line(const rg_camera* camera, rg_pixel pixel,
                            rg_line* line) {
  rg_place place;
  rg_status status =
      rg_find_in_grid(camera, camera->grid, pixel.x_q16, pixel.y_q16, &place);
  if (status == RG_OK) {
    find_direction(place.value.q27[0], place.value.q27[1], &line->direction);
    RG_IN_MEMORY(status);
    find_line_point(camera, &place, line->point_q28);
  }
  return status;
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
