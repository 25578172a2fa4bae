/* The MicroPython module raygrid: the functions of raygrid.h for buffers. No
 * call that processes frames or points allocates memory. */
#include <string.h>

#include "py/binary.h"
#include "py/objtuple.h"
#include "py/runtime.h"
#include "raygrid.h"

typedef struct camera_object {
  mp_obj_base_t base;
  mp_obj_t blob; /* keeps the bytes alive, which camera reads in place */
  rg_camera camera;
} camera_object;

static void check(rg_status status) {
  if (status != RG_OK)
    mp_raise_msg_varg(&mp_type_ValueError, MP_ERROR_TEXT("%s"),
                      rg_status_text(status));
}

static rg_camera* camera_of(mp_obj_t self) {
  return &((camera_object*)MP_OBJ_TO_PTR(self))->camera;
}

/* ---- Numbers ------------------------------------------------------------- */

/* An array('i') of fixed-point numbers, or an array('f'). */
typedef struct numbers {
  void* data;
  size_t count;
  bool is_float;
} numbers;

static numbers get_numbers(mp_obj_t object, mp_uint_t flags, size_t group) {
  mp_buffer_info_t buffer;
  mp_get_buffer_raise(object, &buffer, flags);
  const bool is_float = MICROPY_PY_BUILTINS_FLOAT && buffer.typecode == 'f';
  if (!is_float && buffer.typecode != 'i')
    mp_raise_msg(&mp_type_TypeError,
                 MP_ERROR_TEXT("expected array('f') or array('i')"));
  const numbers found = {buffer.buf, buffer.len / 4, is_float};
  if (found.count % group != 0)
    mp_raise_msg(
        &mp_type_ValueError,
        MP_ERROR_TEXT("expected 2 numbers per pixel, 3 per ray or point"));
  return found;
}

static numbers get_output(mp_obj_t object, size_t num_items, size_t group) {
  const numbers found = get_numbers(object, MP_BUFFER_WRITE, group);
  if (found.count != num_items * group)
    mp_raise_msg(&mp_type_ValueError,
                 MP_ERROR_TEXT("output has the wrong length"));
  return found;
}

/* Converts NaN and numbers that are too large to a value outside every area. */
static int32_t to_fixed(float value, uint32_t bits) {
  const float scaled = value * (float)((uint32_t)1 << bits);
  if (scaled > -2147483520.0f && scaled < 2147483520.0f)
    return (int32_t)(scaled + (scaled < 0 ? -0.5f : 0.5f));
  return scaled > 0 ? INT32_MAX : -INT32_MAX;
}

static int32_t get_number(const numbers* in, size_t k, uint32_t bits) {
  return in->is_float ? to_fixed(((const float*)in->data)[k], bits)
                      : ((const int32_t*)in->data)[k];
}

static void set_number(const numbers* out, size_t k, int32_t value,
                       uint32_t bits) {
  if (out->is_float)
    ((float*)out->data)[k] = (float)value / (float)((uint32_t)1 << bits);
  else
    ((int32_t*)out->data)[k] = value;
}

static rg_pixel get_pixel(const numbers* in, size_t k) {
  const rg_pixel pixel = {get_number(in, 2 * k, 16),
                          get_number(in, 2 * k + 1, 16)};
  return pixel;
}

/* A point without a projection has RG_NO_PIXEL in both coordinates, -32768 as
 * floats. */
static void set_pixel(const numbers* out, size_t k, rg_pixel pixel) {
  set_number(out, 2 * k, pixel.x_q16, 16);
  set_number(out, 2 * k + 1, pixel.y_q16, 16);
}

/* ---- Points -------------------------------------------------------------- */

static mp_obj_t unproject(mp_obj_t self, mp_obj_t pixels, mp_obj_t rays) {
  const numbers in = get_numbers(pixels, MP_BUFFER_READ, 2);
  const numbers out = get_output(rays, in.count / 2, 3);
  mp_int_t num_inside = 0;
  for (size_t k = 0; k < in.count / 2; ++k) {
    rg_line line;
    memset(&line, 0, sizeof(line));
    if (rg_unproject_line(camera_of(self), get_pixel(&in, k), &line) == RG_OK)
      ++num_inside;
    set_number(&out, 3 * k, line.direction.x_q30, 30);
    set_number(&out, 3 * k + 1, line.direction.y_q30, 30);
    set_number(&out, 3 * k + 2, line.direction.z_q30, 30);
  }
  return MP_OBJ_NEW_SMALL_INT(num_inside);
}
static MP_DEFINE_CONST_FUN_OBJ_3(unproject_object, unproject);

/* Converts a point to fixed point below 2^30, with its fraction bits; if a
 * number is not finite, to zeros, which do not project. */
static uint32_t get_point(const numbers* in, size_t k, int32_t point[3]) {
  uint32_t bits = RG_POINT_MAX_BITS;
  float values[3], largest = 0;
  if (!in->is_float) {
    memcpy(point, (const int32_t*)in->data + 3 * k, 3 * sizeof(*point));
    return 20;
  }
  memcpy(values, (const float*)in->data + 3 * k, sizeof(values));
  memset(point, 0, 3 * sizeof(*point));
  for (int i = 0; i < 3; ++i) {
    const float size = values[i] < 0 ? -values[i] : values[i];
    if (!(size < 1e30f)) return 0;
    if (size > largest) largest = size;
  }
  if (largest > 5e8f) /* distant points: only the direction is kept */
    for (int i = 0; i < 3; ++i) values[i] *= 5e8f / largest;
  while (bits > 0 && largest * (float)((uint32_t)1 << bits) >= 1e9f) --bits;
  for (int i = 0; i < 3; ++i) point[i] = to_fixed(values[i], bits);
  return bits;
}

static mp_obj_t project(mp_obj_t self, mp_obj_t points, mp_obj_t pixels) {
  const numbers in = get_numbers(points, MP_BUFFER_READ, 3);
  const numbers out = get_output(pixels, in.count / 3, 2);
  mp_int_t num_seen = 0;
  for (size_t k = 0; k < in.count / 3; ++k) {
    int32_t point[3];
    rg_pixel pixel = {RG_NO_PIXEL, RG_NO_PIXEL};
    const uint32_t bits = get_point(&in, k, point);
    const rg_ray ray = {point[0], point[1], point[2]};
    rg_status status = rg_project(camera_of(self), &ray, &pixel);
    if (status == RG_ERR_NONCENTRAL)
      status = rg_project_point(camera_of(self), point, bits, &pixel);
    if (status != RG_ERR_NOT_SEEN) check(status);
    num_seen += status == RG_OK;
    set_pixel(&out, k, pixel);
  }
  return MP_OBJ_NEW_SMALL_INT(num_seen);
}
static MP_DEFINE_CONST_FUN_OBJ_3(project_object, project);

static mp_obj_t undistort_points(mp_obj_t self, mp_obj_t pixels,
                                 mp_obj_t undistorted) {
  const numbers in = get_numbers(pixels, MP_BUFFER_READ, 2);
  const numbers out = get_output(undistorted, in.count / 2, 2);
  mp_int_t num_shown = 0;
  for (size_t k = 0; k < in.count / 2; ++k) {
    rg_pixel pixel = {RG_NO_PIXEL, RG_NO_PIXEL};
    const rg_status status =
        rg_undistort_point(camera_of(self), get_pixel(&in, k), &pixel);
    if (status == RG_ERR_NO_REMAP) check(status);
    num_shown += status == RG_OK;
    set_pixel(&out, k, pixel);
  }
  return MP_OBJ_NEW_SMALL_INT(num_shown);
}
static MP_DEFINE_CONST_FUN_OBJ_3(undistort_points_object, undistort_points);

/* ---- Tables -------------------------------------------------------------- */

static mp_obj_t select_remap(mp_obj_t self, mp_obj_t index) {
  const mp_int_t value = mp_obj_get_int(index);
  check(value < 0 || value > 16
            ? RG_ERR_NO_REMAP
            : rg_select_remap(camera_of(self), (uint32_t)value));
  return mp_const_none;
}
static MP_DEFINE_CONST_FUN_OBJ_2(select_remap_object, select_remap);

/* The operating point in q16; in builds without floats, the argument is already
 * in q16. */
static int32_t get_condition(mp_obj_t value) {
#if MICROPY_PY_BUILTINS_FLOAT
  return to_fixed(mp_obj_get_float_to_f(value), 16);
#else
  return (int32_t)mp_obj_get_int(value);
#endif
}

/* Returns False if the value is outside the model's range; the nearest end is
 * then used. */
static mp_obj_t set_condition(mp_obj_t self, mp_obj_t value) {
  const int32_t value_q16 = get_condition(value);
  const rg_status status = rg_set_operating_point(camera_of(self), value_q16);
  if (status != RG_EXTRAPOLATED) check(status);
  return mp_obj_new_bool(status == RG_OK);
}
static MP_DEFINE_CONST_FUN_OBJ_2(set_condition_object, set_condition);

static mp_obj_t size_tuple(uint16_t width, uint16_t height) {
  mp_obj_t items[2] = {MP_OBJ_NEW_SMALL_INT(width),
                       MP_OBJ_NEW_SMALL_INT(height)};
  return mp_obj_new_tuple(2, items);
}

static mp_obj_t calibrated_size(mp_obj_t self) {
  uint16_t width = 0, height = 0;
  rg_calibrated_size(camera_of(self), &width, &height);
  return size_tuple(width, height);
}
static MP_DEFINE_CONST_FUN_OBJ_1(calibrated_size_object, calibrated_size);

static mp_obj_t frame_size(mp_obj_t self) {
  uint16_t width = 0, height = 0;
  rg_frame_size(camera_of(self), &width, &height);
  return size_tuple(width, height);
}
static MP_DEFINE_CONST_FUN_OBJ_1(frame_size_object, frame_size);

static mp_obj_t remap_size(mp_obj_t self) {
  uint16_t width = 0, height = 0;
  check(rg_remap_size(camera_of(self), &width, &height));
  return size_tuple(width, height);
}
static MP_DEFINE_CONST_FUN_OBJ_1(remap_size_object, remap_size);

/* fx, fy, cx, cy in q16. */
static mp_obj_t view(mp_obj_t self) {
  rg_view found;
  check(rg_remap_view(camera_of(self), &found));
  mp_obj_t items[5] = {MP_OBJ_NEW_SMALL_INT(found.projection),
                       mp_obj_new_int_from_uint(found.fx_q16),
                       mp_obj_new_int_from_uint(found.fy_q16),
                       mp_obj_new_int(found.cx_q16),
                       mp_obj_new_int(found.cy_q16)};
  return mp_obj_new_tuple(5, items);
}
static MP_DEFINE_CONST_FUN_OBJ_1(view_object, view);

/* ---- Frames -------------------------------------------------------------- */

/* Bytes of a plane for 8 image pixels, and image rows per row. */
typedef struct plane_size {
  uint8_t bytes_per_8, rows_per_row;
} plane_size;

/* Formats by name and planes; generated by tools/pixel_formats. */
/* clang-format off */
#define FORMATS(X) \
  X(GREY8, {8, 1}) \
  X(GREY16, {16, 1}) \
  X(GREY10P, {10, 1}) \
  X(GREY12P, {12, 1}) \
  X(RGB24, {24, 1}) \
  X(RGB32, {32, 1}) \
  X(YUYV, {16, 1}) \
  X(UYVY, {16, 1}) \
  X(NV12, {8, 1}, {8, 2}) \
  X(YUV420, {8, 1}, {4, 2}, {4, 2}) \
  X(BAYER8, {8, 1}) \
  X(BAYER16, {16, 1}) \
  X(BAYER10P, {10, 1}) \
  X(BAYER12P, {12, 1}) \
  X(RGB565, {16, 1})
/* clang-format on */
#define PLANES(name, ...) [RG_FORMAT_##name] = {__VA_ARGS__},
static const plane_size kPlanes[RG_NUM_FORMATS][3] = {FORMATS(PLANES)};

static size_t get_stride(rg_format format, int plane, uint32_t width) {
  return (size_t)width * kPlanes[format][plane].bytes_per_8 / 8;
}

static size_t plane_bytes(rg_format format, int plane, uint32_t width,
                          uint32_t height) {
  const uint32_t rows = kPlanes[format][plane].rows_per_row;
  return rows == 0 ? 0 : get_stride(format, plane, width) * (height / rows);
}

static uint8_t* get_frame(mp_obj_t object, mp_uint_t flags, rg_format format,
                          uint32_t width, uint32_t height) {
  mp_buffer_info_t buffer;
  size_t wanted = 0;
  mp_get_buffer_raise(object, &buffer, flags);
  for (int plane = 0; plane < 3; ++plane)
    wanted += plane_bytes(format, plane, width, height);
  if (buffer.len != wanted)
    mp_raise_msg_varg(&mp_type_ValueError,
                      MP_ERROR_TEXT("expected %u bytes, not %u"),
                      (unsigned)wanted, (unsigned)buffer.len);
  return buffer.buf;
}

static mp_int_t get_below(mp_int_t value, mp_int_t limit) {
  if (value < 0 || value >= limit)
    mp_raise_msg_varg(&mp_type_ValueError,
                      MP_ERROR_TEXT("%d is out of range (0 to %d)"), (int)value,
                      (int)limit - 1);
  return value;
}

enum { IMAGE, OUT, FORMAT, BORDER, FIRST_ROW, NUM_ROWS, NUM_ARGUMENTS };

/* num_rows: None for all remaining rows. */
static const mp_arg_t kUndistortArguments[NUM_ARGUMENTS] = {
    [IMAGE] = {MP_QSTR_image, MP_ARG_REQUIRED | MP_ARG_OBJ, {0}},
    [OUT] = {MP_QSTR_out, MP_ARG_REQUIRED | MP_ARG_OBJ, {0}},
    [FORMAT] = {MP_QSTR_format, MP_ARG_INT, {.u_int = RG_FORMAT_GREY8}},
    [BORDER] = {MP_QSTR_border, MP_ARG_INT, {.u_int = 0}},
    [FIRST_ROW] = {MP_QSTR_first_row, MP_ARG_INT, {.u_int = 0}},
    [NUM_ROWS] = {MP_QSTR_num_rows, MP_ARG_OBJ, {.u_rom_obj = MP_ROM_NONE}}};

static mp_obj_t undistort(size_t num_positional, const mp_obj_t* positional,
                          mp_map_t* keywords) {
  const rg_camera* const camera = camera_of(positional[0]);
  mp_arg_val_t arguments[NUM_ARGUMENTS];
  mp_arg_parse_all(num_positional - 1, positional + 1, keywords, NUM_ARGUMENTS,
                   kUndistortArguments, arguments);
  rg_image image;
  rg_target target;
  uint16_t width = 0, height = 0;
  memset(&image, 0, sizeof(image));
  memset(&target, 0, sizeof(target));
  check(rg_remap_size(camera, &width, &height));
  rg_frame_size(camera, &image.width, &image.height);
  image.format = (rg_format)get_below(arguments[FORMAT].u_int, RG_NUM_FORMATS);
  const mp_int_t border = get_below(arguments[BORDER].u_int, 65536);
  const mp_int_t first = get_below(arguments[FIRST_ROW].u_int, height + 1);
  const mp_obj_t rows = arguments[NUM_ROWS].u_obj;
  target.first_row = (uint16_t)first;
  target.num_rows = (uint16_t)get_below(
      rows == mp_const_none ? height - first : mp_obj_get_int(rows),
      height - first + 1);
  for (int k = 0; k < 4; ++k) target.border_values[k] = (uint16_t)border;
  const uint8_t* source = get_frame(arguments[IMAGE].u_obj, MP_BUFFER_READ,
                                    image.format, image.width, image.height);
  uint8_t* out = get_frame(arguments[OUT].u_obj, MP_BUFFER_WRITE, image.format,
                           width, target.num_rows);
  for (int k = 0; k < 3 && kPlanes[image.format][k].rows_per_row != 0; ++k) {
    image.planes[k].data = source;
    image.planes[k].stride = (uint32_t)get_stride(image.format, k, image.width);
    target.planes[k].data = out;
    target.planes[k].stride = (uint32_t)get_stride(image.format, k, width);
    source += plane_bytes(image.format, k, image.width, image.height);
    out += plane_bytes(image.format, k, width, target.num_rows);
  }
  check(rg_remap(camera, &image, &target));
  return mp_const_none;
}
static MP_DEFINE_CONST_FUN_OBJ_KW(undistort_object, 1, undistort);

/* ---- The module ---------------------------------------------------------- */

/* Selects the first table, if the blob has any. */
static mp_obj_t make_camera(const mp_obj_type_t* type, size_t num_arguments,
                            size_t num_keywords, const mp_obj_t* arguments) {
  mp_buffer_info_t buffer;
  mp_arg_check_num(num_arguments, num_keywords, 1, 1, false);
  mp_get_buffer_raise(arguments[0], &buffer, MP_BUFFER_READ);
  if (buffer.len > UINT32_MAX) check(RG_ERR_HEADER);
  camera_object* const self = mp_obj_malloc(camera_object, type);
  self->blob = arguments[0];
  check(rg_camera_open(&self->camera, buffer.buf, (uint32_t)buffer.len));
  const rg_status status = rg_select_remap(&self->camera, 0);
  if (status != RG_ERR_NO_REMAP) check(status);
  return MP_OBJ_FROM_PTR(self);
}

static const mp_rom_map_elem_t kCameraNames[] = {
    {MP_ROM_QSTR(MP_QSTR_unproject), MP_ROM_PTR(&unproject_object)},
    {MP_ROM_QSTR(MP_QSTR_project), MP_ROM_PTR(&project_object)},
    {MP_ROM_QSTR(MP_QSTR_undistort), MP_ROM_PTR(&undistort_object)},
    {MP_ROM_QSTR(MP_QSTR_undistort_points),
     MP_ROM_PTR(&undistort_points_object)},
    {MP_ROM_QSTR(MP_QSTR_select_remap), MP_ROM_PTR(&select_remap_object)},
    {MP_ROM_QSTR(MP_QSTR_set_condition), MP_ROM_PTR(&set_condition_object)},
    {MP_ROM_QSTR(MP_QSTR_calibrated_size), MP_ROM_PTR(&calibrated_size_object)},
    {MP_ROM_QSTR(MP_QSTR_frame_size), MP_ROM_PTR(&frame_size_object)},
    {MP_ROM_QSTR(MP_QSTR_remap_size), MP_ROM_PTR(&remap_size_object)},
    {MP_ROM_QSTR(MP_QSTR_view), MP_ROM_PTR(&view_object)},
};
static MP_DEFINE_CONST_DICT(camera_names, kCameraNames);

MP_DEFINE_CONST_OBJ_TYPE(camera_type, MP_QSTR_Camera, MP_TYPE_FLAG_NONE,
                         make_new, make_camera, locals_dict, &camera_names);

#define FORMAT_NAME(name, ...) \
  {MP_ROM_QSTR(MP_QSTR_##name), MP_ROM_INT(RG_FORMAT_##name)},
static const mp_rom_map_elem_t kModuleNames[] = {
    {MP_ROM_QSTR(MP_QSTR___name__), MP_ROM_QSTR(MP_QSTR_raygrid)},
    {MP_ROM_QSTR(MP_QSTR_Camera), MP_ROM_PTR(&camera_type)},
    FORMATS(FORMAT_NAME)};
static MP_DEFINE_CONST_DICT(module_names, kModuleNames);

const mp_obj_module_t raygrid_module = {
    .base = {&mp_type_module},
    .globals = (mp_obj_dict_t*)&module_names,
};
MP_REGISTER_MODULE(MP_QSTR_raygrid, raygrid_module);
