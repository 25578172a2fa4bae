/* The byte layout of a blob: section types, the offset of every field under its
 * name in SPEC.md, and the sizes of structures in bytes.
 *
 * The comment at an offset states the field's type and number format; SPEC.md
 * defines its meaning. Offsets are relative to the first byte of the structure
 * that begins the name: header, entry, section, plane, vertex or point.
 * RESERVED is the first of consecutive reserved fields. A y field immediately
 * follows its x field, at a distance of 4, 2 or 1 bytes, the size of the field;
 * loops over both axes add this distance to the offset of x. Fields of inverse
 * grids have the same offsets as those of central grids: code for both uses the
 * names of central grids.
 *
 * RG_*_MEMBERS(X, s) is X(s, type, offset, member) for each number of a
 * structure of rg_blob.h. */
#ifndef RAYGRID_BLOB_LAYOUT_H
#define RAYGRID_BLOB_LAYOUT_H

#include <stdint.h>

#include "bytes.h"

/* clang-format off */
/* ---- written by tools/blob_format; not for editing ---- */
enum rg_section_type {
  RG_SECTION_CAMERA = 1,
  RG_SECTION_CENTRAL_GRID = 2,
  RG_SECTION_REMAP = 3,
  RG_SECTION_QUALITY = 4,
  RG_SECTION_LINE_POINTS = 5,
  RG_SECTION_MASK = 6,
  RG_SECTION_UNCERTAINTY = 7,
  RG_SECTION_MODES = 8,
  RG_SECTION_INVERSE = 10,
  RG_SECTION_CAPTURE = 11,
  RG_SECTION_STACK = 12,
  RG_SECTION_ROW_TIME = 13,
  RG_NUM_SECTION_TYPES = 11 /* 1 + last type that devices read */
};

/* Bit k is of type k. */
#define RG_CRITICAL_TYPES 0x26u
#define RG_SINGLE_TYPES 0x3df6u

/* By type: size of the fields in bytes (0 if devices skip the type), and the
 * minor version that introduced it. */
#define RG_SECTION_SIZES 0, RG_CAMERA_SIZE, RG_GRID_FIELDS_SIZE, \
  RG_REMAP_FIELDS_SIZE, RG_QUALITY_SIZE, RG_LINE_POINTS_FIELDS_SIZE, \
  RG_MASK_FIELDS_SIZE, RG_UNCERTAINTY_FIELDS_SIZE, RG_MODE_SIZE, 0, \
  RG_INVERSE_FIELDS_SIZE
#define RG_SECTION_MINORS 0, 0, 0, 0, 0, 1, 1, 1, 5, 0, 3, 6, 6, 6

enum rg_header_field {
  RG_HEADER_MAGIC = 0, /* u8[8] */
  RG_HEADER_MAJOR = 8, /* u16 */
  RG_HEADER_MINOR = 10, /* u16 */
  RG_HEADER_TOTAL_SIZE = 12, /* u32 */
  RG_HEADER_SECTION_COUNT = 16, /* u16 */
  RG_HEADER_HEADER_SIZE = 18, /* u16 */
  RG_HEADER_RESERVED = 20, /* u32 */
  RG_HEADER_HEADER_CRC = 28 /* u32 */
};
#define RG_HEADER_SIZE 32u

enum rg_entry_field {
  RG_ENTRY_TYPE = 0, /* u16 */
  RG_ENTRY_FLAGS = 2, /* u16 */
  RG_ENTRY_OFFSET = 4, /* u32 */
  RG_ENTRY_SIZE = 8, /* u32 */
  RG_ENTRY_CRC = 12 /* u32 */
};
#define RG_SECTION_ENTRY_SIZE 16u

enum rg_camera_field {
  RG_CAMERA_WIDTH = 0, /* u16 */
  RG_CAMERA_HEIGHT = 2, /* u16 */
  RG_CAMERA_RESERVED = 4, /* u32 */
  RG_CAMERA_NAME = 8, /* u8[32] */
  RG_CAMERA_SERIAL = 40 /* u8[32] */
};
#define RG_CAMERA_SIZE 72u

#define RG_CAMERA_MEMBERS(X, s) \
  X(s,u16,RG_CAMERA_WIDTH,width) X(s,u16,RG_CAMERA_HEIGHT,height)

#define RG_TEXT_SIZE 32u

enum rg_grid_field {
  RG_GRID_X0 = 0, /* i32, q16 px */
  RG_GRID_Y0 = 4, /* i32, q16 px */
  RG_GRID_X1 = 8, /* i32, q16 px */
  RG_GRID_Y1 = 12, /* i32, q16 px */
  RG_GRID_COLUMNS = 16, /* u16 */
  RG_GRID_ROWS = 18, /* u16 */
  RG_GRID_SCALE_X = 20, /* u32, q32 cells per pixel */
  RG_GRID_SCALE_Y = 24, /* u32, q32 cells per pixel */
  RG_GRID_CHART = 28, /* u16 */
  RG_GRID_FRACTION_BITS = 30, /* u16 */
  RG_GRID_DATA_OFFSET = 32, /* u32 */
  RG_GRID_RESERVED = 36 /* u32 */
};
#define RG_GRID_FIELDS_SIZE 40u

#define RG_GRID_MEMBERS(X, s) \
  X(s,i32,RG_GRID_X0,x0_q16) X(s,i32,RG_GRID_Y0,y0_q16) X(s,i32,RG_GRID_X1,x1_q16) X(s,i32,RG_GRID_Y1,y1_q16) \
  X(s,u16,RG_GRID_COLUMNS,columns) X(s,u16,RG_GRID_ROWS,rows) X(s,u32,RG_GRID_SCALE_X,scale_x_q32) \
  X(s,u32,RG_GRID_SCALE_Y,scale_y_q32)

#define RG_CONTROL_POINT_SIZE 8u

enum rg_plane_field {
  RG_PLANE_ORIGIN = 0, /* i32[2] */
  RG_PLANE_COLUMN_STEP = 8, /* i32[2] */
  RG_PLANE_ROW_STEP = 16 /* i32[2] */
};
#define RG_NARROW_PLANE_SIZE 24u

#define RG_NARROW_POINT_SIZE 4u

enum rg_remap_field {
  RG_REMAP_WIDTH = 0, /* u16 */
  RG_REMAP_HEIGHT = 2, /* u16 */
  RG_REMAP_COLUMNS = 4, /* u16 */
  RG_REMAP_ROWS = 6, /* u16 */
  RG_REMAP_BLOCK_LOG2 = 8, /* u8 */
  RG_REMAP_RESIDUAL_SHIFT = 9, /* u8 */
  RG_REMAP_PART_LOG2 = 10, /* u8 */
  RG_REMAP_BEND_SHIFT = 11, /* u8 */
  RG_REMAP_MIN_X = 12, /* i32, q12 px */
  RG_REMAP_MIN_Y = 16, /* i32, q12 px */
  RG_REMAP_MAX_X = 20, /* i32, q12 px */
  RG_REMAP_MAX_Y = 24, /* i32, q12 px */
  RG_REMAP_ORIGIN = 28, /* i32[2], q12 px */
  RG_REMAP_COLUMN_STEP = 36, /* i32[2], q12 px */
  RG_REMAP_ROW_STEP = 44, /* i32[2], q12 px */
  RG_REMAP_FX = 52, /* u32, q16 px */
  RG_REMAP_FY = 56, /* u32, q16 px */
  RG_REMAP_CX = 60, /* i32, q16 px */
  RG_REMAP_CY = 64, /* i32, q16 px */
  RG_REMAP_BOUND_UPX = 68, /* u32 */
  RG_REMAP_MAX_ERROR_UPX = 72, /* u32 */
  RG_REMAP_DATA_OFFSET = 76 /* u32 */
};
#define RG_REMAP_FIELDS_SIZE 80u

#define RG_REMAP_MEMBERS(X, s) \
  X(s,u16,RG_REMAP_WIDTH,width) X(s,u16,RG_REMAP_HEIGHT,height) X(s,u16,RG_REMAP_COLUMNS,columns) \
  X(s,u16,RG_REMAP_ROWS,rows) X(s,u8,RG_REMAP_BLOCK_LOG2,block_log2) \
  X(s,u8,RG_REMAP_RESIDUAL_SHIFT,residual_shift) X(s,u8,RG_REMAP_PART_LOG2,part_log2) \
  X(s,u8,RG_REMAP_BEND_SHIFT,bend_shift) X(s,i32,RG_REMAP_MIN_X,min_x_q12) X(s,i32,RG_REMAP_MIN_Y,min_y_q12) \
  X(s,i32,RG_REMAP_MAX_X,max_x_q12) X(s,i32,RG_REMAP_MAX_Y,max_y_q12) X(s,i32,RG_REMAP_ORIGIN,origin_x_q12) \
  X(s,i32,RG_REMAP_ORIGIN+4,origin_y_q12) X(s,i32,RG_REMAP_COLUMN_STEP,column_step_x_q12) \
  X(s,i32,RG_REMAP_COLUMN_STEP+4,column_step_y_q12) X(s,i32,RG_REMAP_ROW_STEP,row_step_x_q12) \
  X(s,i32,RG_REMAP_ROW_STEP+4,row_step_y_q12) X(s,u32,RG_REMAP_FX,fx_q16) X(s,u32,RG_REMAP_FY,fy_q16) \
  X(s,i32,RG_REMAP_CX,cx_q16) X(s,i32,RG_REMAP_CY,cy_q16) X(s,u32,RG_REMAP_BOUND_UPX,bound_upx) \
  X(s,u32,RG_REMAP_MAX_ERROR_UPX,max_error_upx)

enum rg_view_field {
  RG_VIEW_PROJECTION = 80, /* u8 */
  RG_VIEW_MODE = 81, /* u8 */
  RG_VIEW_DIRECTION = 82, /* u8 */
  RG_VIEW_RESERVED = 83, /* u8 */
  RG_VIEW_ROTATION = 84, /* i32[9], q30 */
  RG_VIEW_SOURCE_WIDTH = 120, /* u16 */
  RG_VIEW_SOURCE_HEIGHT = 122 /* u16 */
};
#define RG_VIEW_FIELDS_SIZE 124u

#define RG_VIEW_MEMBERS(X, s) \
  X(s,u8,RG_VIEW_PROJECTION,projection) X(s,u8,RG_VIEW_MODE,mode) X(s,u8,RG_VIEW_DIRECTION,direction) \
  X(s,u16,RG_VIEW_SOURCE_WIDTH,source_width) X(s,u16,RG_VIEW_SOURCE_HEIGHT,source_height)

#define RG_VERTEX_SIZE 4u

enum rg_vertex_field {
  RG_VERTEX_X = 0, /* i16 */
  RG_VERTEX_Y = 2, /* i16 */
  RG_VERTEX_HX = 4, /* i8 */
  RG_VERTEX_HY = 5, /* i8 */
  RG_VERTEX_VX = 6, /* i8 */
  RG_VERTEX_VY = 7 /* i8 */
};
#define RG_BENT_VERTEX_SIZE 8u

enum rg_mode_field {
  RG_MODE_WIDTH = 0, /* u16 */
  RG_MODE_HEIGHT = 2, /* u16 */
  RG_MODE_OFFSET_X = 4, /* i32, q16 calibrated px */
  RG_MODE_OFFSET_Y = 8, /* i32, q16 calibrated px */
  RG_MODE_SCALE_X = 12, /* u32, q16 calibrated px */
  RG_MODE_SCALE_Y = 16, /* u32, q16 calibrated px */
  RG_MODE_FLIP_X = 20, /* u8 */
  RG_MODE_FLIP_Y = 21, /* u8 */
  RG_MODE_RESERVED = 22, /* u16 */
  RG_MODE_NAME = 32 /* u8[32] */
};
#define RG_MODE_SIZE 64u

#define RG_MODE_MEMBERS(X, s) \
  X(s,u16,RG_MODE_WIDTH,width) X(s,u16,RG_MODE_HEIGHT,height) X(s,i32,RG_MODE_OFFSET_X,offset_x_q16) \
  X(s,i32,RG_MODE_OFFSET_Y,offset_y_q16) X(s,u32,RG_MODE_SCALE_X,scale_x_q16) \
  X(s,u32,RG_MODE_SCALE_Y,scale_y_q16) X(s,u8,RG_MODE_FLIP_X,flip_x) X(s,u8,RG_MODE_FLIP_Y,flip_y)

enum rg_quality_field {
  RG_QUALITY_TRAINING_MEDIAN_UPX = 0, /* u32 */
  RG_QUALITY_TRAINING_RMS_UPX = 4, /* u32 */
  RG_QUALITY_TRAINING_MAX_UPX = 8, /* u32 */
  RG_QUALITY_TRAINING_COUNT = 12, /* u32 */
  RG_QUALITY_HELD_OUT_MEDIAN_UPX = 16, /* u32 */
  RG_QUALITY_HELD_OUT_RMS_UPX = 20, /* u32 */
  RG_QUALITY_HELD_OUT_MAX_UPX = 24, /* u32 */
  RG_QUALITY_HELD_OUT_COUNT = 28, /* u32 */
  RG_QUALITY_PACKING_ERROR_NPX = 32, /* u32 */
  RG_QUALITY_PACKING_ERROR_PRAD = 36 /* u32 */
};
#define RG_QUALITY_SIZE 40u

#define RG_QUALITY_MEMBERS(X, s) \
  X(s,u32,RG_QUALITY_TRAINING_MEDIAN_UPX,training_median_upx) \
  X(s,u32,RG_QUALITY_TRAINING_RMS_UPX,training_rms_upx) X(s,u32,RG_QUALITY_TRAINING_MAX_UPX,training_max_upx) \
  X(s,u32,RG_QUALITY_TRAINING_COUNT,training_count) X(s,u32,RG_QUALITY_HELD_OUT_MEDIAN_UPX,held_out_median_upx) \
  X(s,u32,RG_QUALITY_HELD_OUT_RMS_UPX,held_out_rms_upx) X(s,u32,RG_QUALITY_HELD_OUT_MAX_UPX,held_out_max_upx) \
  X(s,u32,RG_QUALITY_HELD_OUT_COUNT,held_out_count) X(s,u32,RG_QUALITY_PACKING_ERROR_NPX,packing_error_npx) \
  X(s,u32,RG_QUALITY_PACKING_ERROR_PRAD,packing_error_prad)

enum rg_line_points_field {
  RG_LINE_POINTS_FRACTION_BITS = 0, /* u16 */
  RG_LINE_POINTS_RESERVED = 2, /* u16 */
  RG_LINE_POINTS_DATA_OFFSET = 4 /* u32 */
};
#define RG_LINE_POINTS_FIELDS_SIZE 8u

enum rg_line_point_field {
  RG_LINE_POINT_X = 0, /* i32 */
  RG_LINE_POINT_Y = 4, /* i32 */
  RG_LINE_POINT_Z = 8 /* i32 */
};
#define RG_LINE_POINT_SIZE 12u

enum rg_mask_field {
  RG_MASK_COLUMNS = 0, /* u16 */
  RG_MASK_ROWS = 2, /* u16 */
  RG_MASK_CELL_LOG2 = 4, /* u8 */
  RG_MASK_RESERVED = 5, /* u8 */
  RG_MASK_DATA_OFFSET = 8 /* u32 */
};
#define RG_MASK_FIELDS_SIZE 12u

#define RG_MASK_MEMBERS(X, s) \
  X(s,u16,RG_MASK_COLUMNS,columns) X(s,u16,RG_MASK_ROWS,rows) X(s,u8,RG_MASK_CELL_LOG2,cell_log2)

enum rg_uncertainty_field {
  RG_UNCERTAINTY_COLUMNS = 0, /* u16 */
  RG_UNCERTAINTY_ROWS = 2, /* u16 */
  RG_UNCERTAINTY_SCALE_X = 4, /* u32, q32 intervals per pixel */
  RG_UNCERTAINTY_SCALE_Y = 8, /* u32, q32 intervals per pixel */
  RG_UNCERTAINTY_DATA_OFFSET = 12 /* u32 */
};
#define RG_UNCERTAINTY_FIELDS_SIZE 16u

#define RG_UNCERTAINTY_MEMBERS(X, s) \
  X(s,u16,RG_UNCERTAINTY_COLUMNS,columns) X(s,u16,RG_UNCERTAINTY_ROWS,rows) \
  X(s,u32,RG_UNCERTAINTY_SCALE_X,scale_x_q32) X(s,u32,RG_UNCERTAINTY_SCALE_Y,scale_y_q32)

enum rg_inverse_field {
  RG_INVERSE_A0 = 0, /* i32, q27 */
  RG_INVERSE_B0 = 4, /* i32, q27 */
  RG_INVERSE_A1 = 8, /* i32, q27 */
  RG_INVERSE_B1 = 12, /* i32, q27 */
  RG_INVERSE_COLUMNS = 16, /* u16 */
  RG_INVERSE_ROWS = 18, /* u16 */
  RG_INVERSE_SCALE_A = 20, /* u32, q21 cells per chart unit */
  RG_INVERSE_SCALE_B = 24, /* u32, q21 cells per chart unit */
  RG_INVERSE_CHART = 28, /* u16 */
  RG_INVERSE_FRACTION_BITS = 30, /* u16 */
  RG_INVERSE_DATA_OFFSET = 32, /* u32 */
  RG_INVERSE_COS_LIMIT = 36 /* i32, q30 */
};
#define RG_INVERSE_FIELDS_SIZE 40u

#define RG_INVERSE_MEMBERS(X, s) \
  X(s,i32,RG_INVERSE_A0,a0_q27) X(s,i32,RG_INVERSE_B0,b0_q27) X(s,i32,RG_INVERSE_A1,a1_q27) \
  X(s,i32,RG_INVERSE_B1,b1_q27) X(s,u16,RG_INVERSE_COLUMNS,columns) X(s,u16,RG_INVERSE_ROWS,rows) \
  X(s,u32,RG_INVERSE_SCALE_A,scale_a_q21) X(s,u32,RG_INVERSE_SCALE_B,scale_b_q21) \
  X(s,i32,RG_INVERSE_COS_LIMIT,cos_limit_q30)

enum rg_capture_field {
  RG_CAPTURE_LENS_POSITION = 0, /* i32, q16 dioptres */
  RG_CAPTURE_LENS_TOLERANCE = 4, /* u32, q16 dioptres */
  RG_CAPTURE_CROP_X = 8, /* i32 */
  RG_CAPTURE_CROP_Y = 12, /* i32 */
  RG_CAPTURE_CROP_WIDTH = 16, /* u32 */
  RG_CAPTURE_CROP_HEIGHT = 20, /* u32 */
  RG_CAPTURE_ZOOM = 24, /* u32, q16 */
  RG_CAPTURE_KNOWN = 28, /* u8 */
  RG_CAPTURE_ORIENTATION = 29, /* u8 */
  RG_CAPTURE_RESERVED = 30, /* u16 */
  RG_CAPTURE_TEMPERATURE = 32, /* i32, q16 degrees Celsius */
  RG_CAPTURE_EXPOSURE = 36, /* u32 */
  RG_CAPTURE_ANALOGUE_GAIN = 40 /* u32, q16 */
};
#define RG_CAPTURE_SIZE 44u

#define RG_CAPTURE_MEMBERS(X, s) \
  X(s,i32,RG_CAPTURE_LENS_POSITION,lens_position_q16) X(s,u32,RG_CAPTURE_LENS_TOLERANCE,lens_tolerance_q16) \
  X(s,i32,RG_CAPTURE_CROP_X,crop_x) X(s,i32,RG_CAPTURE_CROP_Y,crop_y) X(s,u32,RG_CAPTURE_CROP_WIDTH,crop_width) \
  X(s,u32,RG_CAPTURE_CROP_HEIGHT,crop_height) X(s,u32,RG_CAPTURE_ZOOM,zoom_q16) X(s,u8,RG_CAPTURE_KNOWN,known) \
  X(s,u8,RG_CAPTURE_ORIENTATION,orientation) X(s,i32,RG_CAPTURE_TEMPERATURE,temperature_q16) \
  X(s,u32,RG_CAPTURE_EXPOSURE,exposure_us) X(s,u32,RG_CAPTURE_ANALOGUE_GAIN,analogue_gain_q16)

enum rg_stack_field {
  RG_STACK_CONDITION = 0, /* u16 */
  RG_STACK_KNOTS = 2 /* u16 */
};
#define RG_STACK_FIELDS_SIZE 4u

#define RG_STACK_MEMBERS(X, s) \
  X(s,u16,RG_STACK_CONDITION,condition)

enum rg_stack_sample_field {
  RG_STACK_SAMPLE_VALUE = 0 /* i32 */
};
#define RG_STACK_SAMPLE_VALUE_SIZE 4u

enum rg_row_time_field {
  RG_ROW_TIME_ROW_TIME = 0, /* i32, q10 nanoseconds */
  RG_ROW_TIME_DEVIATION = 4 /* u32, q10 nanoseconds */
};
#define RG_ROW_TIME_SIZE 8u

#define RG_ROW_TIME_MEMBERS(X, s) \
  X(s,i32,RG_ROW_TIME_ROW_TIME,row_time_ns_q10) X(s,u32,RG_ROW_TIME_DEVIATION,stddev_ns_q10)

enum rg_slot_field {
  RG_SLOT_MAGIC = 0, /* u8[8] */
  RG_SLOT_MAJOR = 8, /* u16 */
  RG_SLOT_BLOB_OFFSET = 10, /* u16 */
  RG_SLOT_SEQUENCE = 12, /* u32 */
  RG_SLOT_BLOB_SIZE = 16, /* u32 */
  RG_SLOT_BLOB_CRC = 20, /* u32 */
  RG_SLOT_ROOM = 24, /* u8[36] */
  RG_SLOT_HEADER_CRC = 60 /* u32 */
};
#define RG_SLOT_HEADER_SIZE 64u
/* ---- end of what is written ---- */
/* clang-format on */

/* ---- Remap -------------------------------------------------------------- */

enum rg_remap_direction {
  RG_UNDISTORT, /* frames of the camera become the view */
  RG_DISTORT    /* frames of the view become those that the camera would see */
};
#define RG_HAS_VIEW 0x80u
#define RG_BEND_SHIFT_MASK 0xfu /* the bits that contain the shift */

/* Distance in bytes from the minimum to the maximum of the source rectangle on
 * an axis. */
#define RG_REMAP_MIN_TO_MAX (RG_REMAP_MAX_X - RG_REMAP_MIN_X)

/* Returns the shift of a remap section's bends. */
static inline uint32_t rg_bend_shift(const uint8_t* section) {
  return section[RG_REMAP_BEND_SHIFT] & RG_BEND_SHIFT_MASK;
}

/* Returns whether a remap section has the fields of a view. */
static inline int rg_has_view(const uint8_t* section) {
  return (section[RG_REMAP_BEND_SHIFT] & RG_HAS_VIEW) != 0;
}

/* Returns whether a remap section is an inverse table, which distorts. */
static inline int rg_distorts(const uint8_t* section) {
  return rg_has_view(section) && section[RG_VIEW_DIRECTION] == RG_DISTORT;
}

/* Returns the vertices of a remap section. */
static inline const uint8_t* rg_find_vertices(const uint8_t* section) {
  return section + rg_load_u32(section + RG_REMAP_DATA_OFFSET);
}

/* Returns the size of a vertex of a remap section in bytes. */
static inline uint32_t rg_vertex_size(const uint8_t* section) {
  return section[RG_REMAP_PART_LOG2] != 0 ? RG_BENT_VERTEX_SIZE
                                          : RG_VERTEX_SIZE;
}

#endif /* RAYGRID_BLOB_LAYOUT_H */
