/* The bytes of the blob: an offset for every field, by the name that SPEC.md
 * gives it, and the sizes of what is counted in bytes.
 *
 * A comment at an offset says the field's type, the format of its number, and
 * its meaning. Offsets are from the first byte of the header, entry, section,
 * plane, vertex or point that the name begins with. RESERVED is the first of
 * several reserved fields. A field of y stands directly behind that of x: by 4,
 * 2 or 1 bytes, as many as the field has. Code that goes over both axes adds
 * them to the offset of x. */
#ifndef RAYGRID_BLOB_LAYOUT_H
#define RAYGRID_BLOB_LAYOUT_H

#include <stdint.h>

#include "bytes.h"

/* ---- Header and section table ------------------------------------------- */

enum rg_header_field {
  RG_HEADER_MAGIC = 0,          /* u8[8]: "RAYGRID" and a zero */
  RG_HEADER_MAJOR = 8,          /* u16: version that readers must know */
  RG_HEADER_MINOR = 10,         /* u16: lowest version that has all used */
  RG_HEADER_TOTAL_SIZE = 12,    /* u32: bytes of the blob */
  RG_HEADER_SECTION_COUNT = 16, /* u16: entries of the section table */
  RG_HEADER_HEADER_SIZE = 18,   /* u16: RG_HEADER_SIZE */
  RG_HEADER_RESERVED = 20,      /* u32: 0, and another one behind it */
  RG_HEADER_HEADER_CRC = 28     /* u32: CRC of the bytes before it, continued
                                   over the section table */
};
#define RG_HEADER_SIZE 32u /* the section table follows */

enum rg_entry_field {
  RG_ENTRY_TYPE = 0,   /* u16: rg_section_type */
  RG_ENTRY_FLAGS = 2,  /* u16: 0 or RG_SECTION_CRITICAL */
  RG_ENTRY_OFFSET = 4, /* u32: section, from the blob's first byte */
  RG_ENTRY_SIZE = 8,   /* u32: bytes of the section, not of the entry */
  RG_ENTRY_CRC = 12    /* u32: CRC of the section */
};
#define RG_SECTION_ENTRY_SIZE 16u

/* ---- Camera ------------------------------------------------------------- */

enum rg_camera_field {
  RG_CAMERA_WIDTH = 0,    /* u16: image, px */
  RG_CAMERA_HEIGHT = 2,   /* u16: image, px */
  RG_CAMERA_RESERVED = 4, /* u32: 0 */
  RG_CAMERA_NAME = 8,     /* u8[32]: UTF-8, then zeros, at least one */
  RG_CAMERA_SERIAL = 40   /* u8[32]: UTF-8, then zeros, at least one */
};
#define RG_CAMERA_SIZE 72u
#define RG_TEXT_SIZE 32u /* name and serial, zero-padded */

/* ---- Central grid, and inverse grid ------------------------------------- */

/* Code that serves both kinds of grid uses these names: an inverse grid has its
 * fields in the same places. */
enum rg_grid_field {
  RG_GRID_X0 = 0,             /* i32, q16 px: area, inclusive */
  RG_GRID_Y0 = 4,             /* i32, q16 px: area, inclusive */
  RG_GRID_X1 = 8,             /* i32, q16 px: area, inclusive */
  RG_GRID_Y1 = 12,            /* i32, q16 px: area, inclusive */
  RG_GRID_COLUMNS = 16,       /* u16: control points across, cells + 3 */
  RG_GRID_ROWS = 18,          /* u16: control points down, cells + 3 */
  RG_GRID_SCALE_X = 20,       /* u32, q32: cells per pixel */
  RG_GRID_SCALE_Y = 24,       /* u32, q32: cells per pixel */
  RG_GRID_CHART = 28,         /* u16: RG_CHART_STEREOGRAPHIC */
  RG_GRID_FRACTION_BITS = 30, /* u16: 29, or less in a narrow grid */
  RG_GRID_DATA_OFFSET = 32,   /* u32: control points, or plane, from the
                                 section's first byte */
  RG_GRID_RESERVED = 36       /* u32: 0 */
};
enum rg_inverse_field {
  RG_INVERSE_A0 = 0,             /* i32, q27: rectangle of the chart */
  RG_INVERSE_B0 = 4,             /* i32, q27: rectangle of the chart */
  RG_INVERSE_A1 = 8,             /* i32, q27: rectangle of the chart */
  RG_INVERSE_B1 = 12,            /* i32, q27: rectangle of the chart */
  RG_INVERSE_COLUMNS = 16,       /* u16: control points along a, cells + 3 */
  RG_INVERSE_ROWS = 18,          /* u16: control points along b, cells + 3 */
  RG_INVERSE_SCALE_A = 20,       /* u32, q21: cells per chart unit */
  RG_INVERSE_SCALE_B = 24,       /* u32, q21: cells per chart unit */
  RG_INVERSE_CHART = 28,         /* u16: RG_CHART_STEREOGRAPHIC */
  RG_INVERSE_FRACTION_BITS = 30, /* u16: 14 to 28 */
  RG_INVERSE_DATA_OFFSET = 32,   /* u32: plane, from the section's first byte */
  RG_INVERSE_COS_LIMIT = 36      /* i32, q30: c |c|, c the cosine of the widest
                                    direction */
};
#define RG_GRID_FIELDS_SIZE 40u
#define RG_CONTROL_POINT_SIZE 8u /* i32 a, b in q29, of a grid not narrow */

/* The plane of a narrow grid, in front of its residuals. */
enum rg_plane_field {
  RG_PLANE_ORIGIN = 0,      /* i32[2], q29 or q17 px: a, b or x, y */
  RG_PLANE_COLUMN_STEP = 8, /* i32[2], q29 or q17 px: a, b or x, y */
  RG_PLANE_ROW_STEP = 16    /* i32[2], q29 or q17 px: a, b or x, y */
};
#define RG_NARROW_PLANE_SIZE 24u
#define RG_NARROW_POINT_SIZE 4u /* residuals i16 a, b of a control point */

/* ---- Remap -------------------------------------------------------------- */

enum rg_remap_field {
  RG_REMAP_WIDTH = 0,          /* u16: output, px */
  RG_REMAP_HEIGHT = 2,         /* u16: output, px */
  RG_REMAP_COLUMNS = 4,        /* u16: vertices across, blocks + 1 */
  RG_REMAP_ROWS = 6,           /* u16: vertices down, blocks + 1 */
  RG_REMAP_BLOCK_LOG2 = 8,     /* u8: blocks are 2^this px wide and high */
  RG_REMAP_RESIDUAL_SHIFT = 9, /* u8: residuals are q(12 - this) px */
  RG_REMAP_PART_LOG2 = 10,     /* u8: parts are 2^this px wide and high; 0: the
                                  table has no bends */
  RG_REMAP_BEND_SHIFT = 11,    /* u8: bends are q(12 - this) px, the low four
                                  bits; and RG_HAS_VIEW */
  RG_REMAP_MIN_X = 12,         /* i32, q12 px: source rectangle, inclusive */
  RG_REMAP_MIN_Y = 16,         /* i32, q12 px: source rectangle, inclusive */
  RG_REMAP_MAX_X = 20,         /* i32, q12 px: source rectangle, inclusive */
  RG_REMAP_MAX_Y = 24,         /* i32, q12 px: source rectangle, inclusive */
  RG_REMAP_ORIGIN = 28,        /* i32[2], q12 px: x, y of vertex (0, 0) */
  RG_REMAP_COLUMN_STEP = 36,   /* i32[2], q12 px: x, y to the next column */
  RG_REMAP_ROW_STEP = 44,      /* i32[2], q12 px: x, y to the next row */
  RG_REMAP_FX = 52,            /* u32, q16 px: virtual camera */
  RG_REMAP_FY = 56,            /* u32, q16 px: virtual camera */
  RG_REMAP_CX = 60,            /* i32, q16 px: virtual camera */
  RG_REMAP_CY = 64,            /* i32, q16 px: virtual camera */
  RG_REMAP_BOUND_UPX = 68,     /* u32, 1e-6 px: error asked for */
  RG_REMAP_MAX_ERROR_UPX = 72, /* u32, 1e-6 px: worst error measured */
  RG_REMAP_DATA_OFFSET = 76    /* u32: vertices, from the section's first byte;
                                  the empty-block mask follows them */
};
#define RG_REMAP_FIELDS_SIZE 80u

/* The fields of a table's view, behind those, where its bend shift's byte has
 * the bit RG_HAS_VIEW. */
enum rg_view_field {
  RG_VIEW_PROJECTION = 80, /* u8: rg_projection */
  RG_VIEW_MODE = 81,       /* u8: the mode that real frames are of, counted from
                              1; 0: frames as calibrated */
  RG_VIEW_DIRECTION = 82,  /* u8: rg_direction */
  RG_VIEW_RESERVED = 83,   /* u8: 0 */
  RG_VIEW_ROTATION = 84,   /* i32[9], q30: axes of the view to camera axes, row
                              by row */
  RG_VIEW_SOURCE_WIDTH = 120, /* u16: source, px */
  RG_VIEW_SOURCE_HEIGHT = 122 /* u16: source, px */
};
#define RG_VIEW_FIELDS_SIZE 124u /* with those of the table */

enum rg_direction {
  RG_UNDISTORT, /* frames of the camera become the view */
  RG_DISTORT    /* frames of the view become those that the camera would see */
};
#define RG_HAS_VIEW 0x80u
#define RG_BEND_SHIFT_BITS 0xfu /* of that byte, the shift itself */

/* From the rectangle's lower end on an axis to its upper one. */
#define RG_REMAP_MIN_TO_MAX (RG_REMAP_MAX_X - RG_REMAP_MIN_X)

enum rg_vertex_field {
  RG_VERTEX_X = 0,  /* i16, q(12 - residual_shift) px: residual */
  RG_VERTEX_Y = 2,  /* i16, q(12 - residual_shift) px: residual */
  RG_VERTEX_HX = 4, /* i8, q(12 - bend_shift) px: edge from the left vertex */
  RG_VERTEX_HY = 5, /* i8, q(12 - bend_shift) px: edge from the left vertex */
  RG_VERTEX_VX = 6, /* i8, q(12 - bend_shift) px: edge from the upper vertex */
  RG_VERTEX_VY = 7  /* i8, q(12 - bend_shift) px: edge from the upper vertex */
};
#define RG_VERTEX_SIZE 4u      /* of a table without bends */
#define RG_BENT_VERTEX_SIZE 8u /* of a table with bends */

/* The shift of a remap section's bends. */
static inline uint32_t rg_bend_shift(const uint8_t* section) {
  return section[RG_REMAP_BEND_SHIFT] & RG_BEND_SHIFT_BITS;
}

/* Whether a remap section says that it has the fields of a view. */
static inline int rg_has_view(const uint8_t* section) {
  return (section[RG_REMAP_BEND_SHIFT] & RG_HAS_VIEW) != 0;
}

/* Whether a remap section is of a table that distorts. */
static inline int rg_distorts(const uint8_t* section) {
  return rg_has_view(section) && section[RG_VIEW_DIRECTION] == RG_DISTORT;
}

/* The vertices of a remap section. */
static inline const uint8_t* rg_find_vertices(const uint8_t* section) {
  return section + rg_load_u32(section + RG_REMAP_DATA_OFFSET);
}

/* The bytes of a vertex of a remap section. */
static inline uint32_t rg_vertex_size(const uint8_t* section) {
  return section[RG_REMAP_PART_LOG2] != 0 ? RG_BENT_VERTEX_SIZE
                                          : RG_VERTEX_SIZE;
}

/* ---- Sensor modes ------------------------------------------------------- */

/* A mode; the section is a row of them. */
enum rg_mode_field {
  RG_MODE_WIDTH = 0,     /* u16: its frames, px */
  RG_MODE_HEIGHT = 2,    /* u16: its frames, px */
  RG_MODE_OFFSET_X = 4,  /* i32, q16 calibrated px: edge of its first pixel */
  RG_MODE_OFFSET_Y = 8,  /* i32, q16 calibrated px: edge of its first pixel */
  RG_MODE_SCALE_X = 12,  /* u32, q16: calibrated px a side of its pixel */
  RG_MODE_SCALE_Y = 16,  /* u32, q16: calibrated px a side of its pixel */
  RG_MODE_FLIP_X = 20,   /* u8: 1 if x is counted from the right */
  RG_MODE_FLIP_Y = 21,   /* u8: 1 if y is counted from the bottom */
  RG_MODE_RESERVED = 22, /* u16: 0, and two u32 behind it */
  RG_MODE_NAME = 32      /* u8[32]: UTF-8, then zeros, at least one */
};
#define RG_MODE_SIZE 64u

/* ---- Quality ------------------------------------------------------------ */

/* RG_UNKNOWN_FIGURE stands for what is not known. */
enum rg_quality_field {
  RG_QUALITY_TRAINING_MEDIAN_UPX = 0,  /* u32, 1e-6 px: residual norms */
  RG_QUALITY_TRAINING_RMS_UPX = 4,     /* u32, 1e-6 px: residual norms */
  RG_QUALITY_TRAINING_MAX_UPX = 8,     /* u32, 1e-6 px: residual norms */
  RG_QUALITY_TRAINING_COUNT = 12,      /* u32: features */
  RG_QUALITY_HELD_OUT_MEDIAN_UPX = 16, /* u32, 1e-6 px: residual norms */
  RG_QUALITY_HELD_OUT_RMS_UPX = 20,    /* u32, 1e-6 px: residual norms */
  RG_QUALITY_HELD_OUT_MAX_UPX = 24,    /* u32, 1e-6 px: residual norms */
  RG_QUALITY_HELD_OUT_COUNT = 28,      /* u32: features */
  RG_QUALITY_PACKING_ERROR_NPX = 32,   /* u32, 1e-9 px: worst added error */
  RG_QUALITY_PACKING_ERROR_PRAD = 36   /* u32, 1e-12 rad: worst added error */
};
#define RG_QUALITY_SIZE 40u

/* ---- Line points -------------------------------------------------------- */

enum rg_line_points_field {
  RG_LINE_POINTS_FRACTION_BITS = 0, /* u16: RG_LINE_POINT_BITS */
  RG_LINE_POINTS_RESERVED = 2,      /* u16: 0 */
  RG_LINE_POINTS_DATA_OFFSET = 4    /* u32: points, from the section's first
                                       byte */
};
#define RG_LINE_POINTS_FIELDS_SIZE 8u

enum rg_line_point_field {
  RG_LINE_POINT_X = 0, /* i32, q28 m */
  RG_LINE_POINT_Y = 4, /* i32, q28 m */
  RG_LINE_POINT_Z = 8  /* i32, q28 m */
};
#define RG_LINE_POINT_SIZE 12u

/* ---- Validity mask ------------------------------------------------------ */

enum rg_mask_field {
  RG_MASK_COLUMNS = 0,    /* u16: cells across */
  RG_MASK_ROWS = 2,       /* u16: cells down */
  RG_MASK_CELL_LOG2 = 4,  /* u8: cells are 2^this px wide and high */
  RG_MASK_RESERVED = 5,   /* u8: 0, and a u16 behind it */
  RG_MASK_DATA_OFFSET = 8 /* u32: bits, from the section's first byte */
};
#define RG_MASK_FIELDS_SIZE 12u

/* ---- Uncertainty -------------------------------------------------------- */

enum rg_uncertainty_field {
  RG_UNCERTAINTY_COLUMNS = 0,     /* u16: values across the area */
  RG_UNCERTAINTY_ROWS = 2,        /* u16: values down the area */
  RG_UNCERTAINTY_SCALE_X = 4,     /* u32, q32: intervals per pixel */
  RG_UNCERTAINTY_SCALE_Y = 8,     /* u32, q32: intervals per pixel */
  RG_UNCERTAINTY_DATA_OFFSET = 12 /* u32: values, from the section's first
                                     byte */
};
#define RG_UNCERTAINTY_FIELDS_SIZE 16u

/* ---- Capture ------------------------------------------------------------ */

/* How the camera stood while it was calibrated. What is not known is 0. */
enum rg_capture_field {
  RG_CAPTURE_LENS_POSITION = 0,  /* i32, q16 dioptres */
  RG_CAPTURE_LENS_TOLERANCE = 4, /* u32, q16 dioptres: inclusive */
  RG_CAPTURE_CROP_X = 8,         /* i32: shown part of the sensor, its px */
  RG_CAPTURE_CROP_Y = 12,        /* i32: shown part of the sensor, its px */
  RG_CAPTURE_CROP_WIDTH = 16,    /* u32: shown part of the sensor, its px */
  RG_CAPTURE_CROP_HEIGHT = 20,   /* u32: shown part of the sensor, its px */
  RG_CAPTURE_ZOOM = 24,          /* u32, q16: magnification over the widest */
  RG_CAPTURE_KNOWN = 28,         /* u8: bits of rg_capture_known */
  RG_CAPTURE_ORIENTATION = 29,   /* u8: 1 to 8, as EXIF has it */
  RG_CAPTURE_RESERVED = 30,      /* u16: 0 */
  RG_CAPTURE_TEMPERATURE = 32,   /* i32, q16 degrees Celsius, of the sensor */
  RG_CAPTURE_EXPOSURE = 36,      /* u32, microseconds */
  RG_CAPTURE_ANALOGUE_GAIN = 40  /* u32, q16: analogue, a factor */
};
#define RG_CAPTURE_SIZE 44u

/* ---- Stack -------------------------------------------------------------- */

/* The camera at other conditions, knot after knot. */
enum rg_stack_field {
  RG_STACK_CONDITION = 0, /* u16: rg_condition */
  RG_STACK_KNOTS = 2      /* u16: how many */
};
#define RG_STACK_FIELDS_SIZE 4u
#define RG_KNOT_VALUE_SIZE 4u /* i32, q16, behind a knot's sections */

/* ---- Row time ----------------------------------------------------------- */

enum rg_row_time_field {
  RG_ROW_TIME_ROW_TIME = 0, /* i32, q10 ns: of a row after the one above */
  RG_ROW_TIME_DEVIATION = 4 /* u32, q10 ns: standard; 0: not known */
};
#define RG_ROW_TIME_SIZE 8u

/* ---- Slots -------------------------------------------------------------- */

/* In front of a blob in flash, where two have room. */
enum rg_slot_field {
  RG_SLOT_MAGIC = 0,        /* u8[8]: "RGSLOTS" and a zero */
  RG_SLOT_MAJOR = 8,        /* u16: version that readers must know */
  RG_SLOT_BLOB_OFFSET = 10, /* u16: RG_SLOT_HEADER_SIZE */
  RG_SLOT_SEQUENCE = 12,    /* u32: one more than that of the blob before */
  RG_SLOT_BLOB_SIZE = 16,   /* u32: bytes of the blob, which follows */
  RG_SLOT_BLOB_CRC = 20,    /* u32: CRC of these bytes */
  RG_SLOT_ROOM = 24,        /* u8[36]: 0; readers do not look at it */
  RG_SLOT_HEADER_CRC = 60   /* u32: CRC of the bytes before it */
};
#define RG_SLOT_HEADER_SIZE 64u

#endif /* RAYGRID_BLOB_LAYOUT_H */
