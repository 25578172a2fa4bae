/* Prints structures and constants of raygrid.h, as they are compiled here, for
 * modules in languages that must repeat them:
 *   struct NAME SIZE
 *   field NAME FIELD OFFSET SIZE
 *   constant NAME VALUE */
#include <stddef.h>
#include <stdio.h>

#include "frames/pixel_format_list.h"
#include "raygrid.h"

#define STRUCT(type) printf("struct %s %u\n", #type, (unsigned)sizeof(type))
#define FIELD_AT(name, field, offset, size)                      \
  printf("field %s %s %u %u\n", name, field, (unsigned)(offset), \
         (unsigned)(size))
#define FIELD(type, field)                       \
  FIELD_AT(#type, #field, offsetof(type, field), \
           sizeof(((const type*)0)->field))
/* Planes have no name of their own in C. */
#define PLANE_FIELD(type, field)                                     \
  FIELD_AT("rg_plane", #field,                                       \
           offsetof(type, planes[0].field) - offsetof(type, planes), \
           sizeof(((const type*)0)->planes[0].field))
#define CONSTANT(name) printf("constant %s %ld\n", #name, (long)(name))

static void print_points(void) {
  STRUCT(rg_pixel);
  FIELD(rg_pixel, x_q16);
  FIELD(rg_pixel, y_q16);
  STRUCT(rg_ray);
  FIELD(rg_ray, x_q30);
  FIELD(rg_ray, y_q30);
  FIELD(rg_ray, z_q30);
  STRUCT(rg_line);
  FIELD(rg_line, point_q28);
  FIELD(rg_line, direction);
}

static void print_views(void) {
  STRUCT(rg_view);
  FIELD(rg_view, width);
  FIELD(rg_view, height);
  FIELD(rg_view, projection);
  FIELD(rg_view, fx_q16);
  FIELD(rg_view, fy_q16);
  FIELD(rg_view, cx_q16);
  FIELD(rg_view, cy_q16);
  FIELD(rg_view, rotation_q30);
  FIELD(rg_view, distorts);
  STRUCT(rg_mode);
  FIELD(rg_mode, width);
  FIELD(rg_mode, height);
  FIELD(rg_mode, offset_x_q16);
  FIELD(rg_mode, offset_y_q16);
  FIELD(rg_mode, scale_x_q16);
  FIELD(rg_mode, scale_y_q16);
  FIELD(rg_mode, flip_x);
  FIELD(rg_mode, flip_y);
}

static void print_frames(void) {
  printf("struct rg_plane %u\n", (unsigned)sizeof(((rg_image*)0)->planes[0]));
  PLANE_FIELD(rg_image, data);
  PLANE_FIELD(rg_image, stride);
  PLANE_FIELD(rg_target, data);
  PLANE_FIELD(rg_target, stride);
  STRUCT(rg_image);
  FIELD(rg_image, format);
  FIELD(rg_image, width);
  FIELD(rg_image, height);
  FIELD(rg_image, ring_rows);
  FIELD(rg_image, first_row);
  FIELD(rg_image, num_rows);
  FIELD(rg_image, planes);
  STRUCT(rg_target);
  FIELD(rg_target, planes);
  FIELD(rg_target, first_row);
  FIELD(rg_target, num_rows);
  FIELD(rg_target, border);
  FIELD(rg_target, sampling);
  FIELD(rg_target, border_values);
  FIELD(rg_target, kernels);
}

static void print_formats(void) {
#define RG_PIXEL_FORMAT(name, ...) CONSTANT(RG_FORMAT_##name);
  RG_PIXEL_FORMATS
  CONSTANT(RG_NUM_FORMATS);
}

static void print_choices(void) {
  CONSTANT(RG_PROJECTION_PINHOLE);
  CONSTANT(RG_PROJECTION_CYLINDRICAL);
  CONSTANT(RG_PROJECTION_EQUIRECTANGULAR);
  CONSTANT(RG_PROJECTION_STEREOGRAPHIC);
  CONSTANT(RG_PROJECTION_EQUIDISTANT);
  CONSTANT(RG_BORDER_VALUE);
  CONSTANT(RG_BORDER_CLAMP);
  CONSTANT(RG_BORDER_KEEP);
  CONSTANT(RG_SAMPLING_BILINEAR);
  CONSTANT(RG_SAMPLING_NEAREST);
}

static void print_statuses(void) {
  CONSTANT(RG_OK);
  CONSTANT(RG_ERR_OUTSIDE_AREA);
  CONSTANT(RG_ERR_NO_REMAP);
  CONSTANT(RG_ERR_NOT_SEEN);
  CONSTANT(RG_ERR_NONCENTRAL);
  CONSTANT(RG_ERR_UNKNOWN);
  CONSTANT(RG_ERR_NO_INVERSE);
  CONSTANT(RG_EXTRAPOLATED);
  CONSTANT(RG_NO_PIXEL);
  CONSTANT(RG_POINT_MAX_BITS);
}

int main(void) {
  STRUCT(rg_camera);
  print_points();
  print_views();
  print_frames();
  print_formats();
  print_choices();
  print_statuses();
  return 0;
}
