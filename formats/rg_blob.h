/* The calibration blob: what the host writes and the board reads in place.
 * Byte by byte in SPEC.md and blob_layout.h; the field names here are the names
 * there.
 *
 * C99, no allocation, no floating point. Bytes from outside are validated once
 * by rg_blob_open(); everything after that may rely on them. */
#ifndef RAYGRID_RG_BLOB_H
#define RAYGRID_RG_BLOB_H

#include <stdint.h>

#include "blob_layout.h"
#include "rg_projection.h"
#include "rg_status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define RG_FORMAT_MAJOR 1

#define RG_MAX_SECTIONS 16u
#define RG_SECTION_CRITICAL                        \
  1u /* flag: a reader that does not know it stops \
      */

#define RG_MAX_IMAGE_SIZE 16384u
#define RG_MAX_REMAP_SIZE 8192u
#define RG_MIN_REMAP_SOURCE 2u
#define RG_MIN_GRID_SIZE 4u
#define RG_MAX_GRID_SIZE 1027u
#define RG_CHART_STEREOGRAPHIC 1u
#define RG_CONTROL_POINT_BITS 29u /* fraction bits */
#define RG_NARROW_MIN_BITS 14u    /* of narrow grids' residuals */
#define RG_NARROW_MAX_BITS 28u
#define RG_CONTROL_POINT_LIMIT 0x7f000000      /* 3.96875 in q29 */
#define RG_VERTEX_LIMIT_Q12 (INT32_C(1) << 25) /* 8192 px */
#define RG_MAX_RESIDUAL_SHIFT 10u
#define RG_MAX_BEND_SHIFT 10u
#define RG_MAX_MODES 255u
#define RG_MIN_MODE_SCALE_Q16 (UINT32_C(1) << 10) /* 1/64 */
#define RG_MAX_MODE_SCALE_Q16 (UINT32_C(64) << 16)
#define RG_MODE_OFFSET_LIMIT_Q16 (INT32_C(1) << 30)  /* 16384 px */
#define RG_ROTATION_TOLERANCE_Q30 (INT32_C(1) << 10) /* of products of rows */
#define RG_LINE_POINT_BITS 28u                       /* fraction bits */
#define RG_LINE_POINT_LIMIT 0x7f000000               /* 7.9375 m in q28 */
#define RG_MIN_MASK_CELL_LOG2 2u
#define RG_MAX_MASK_CELL_LOG2 8u
#define RG_MAX_UNCERTAINTY_SIZE 65u
#define RG_UNKNOWN_UNCERTAINTY 0xffffu
#define RG_CHART_LIMIT_Q27 (INT32_C(1) << 29) /* 4 */
#define RG_INVERSE_PIXEL_BITS 17u /* of an inverse grid's control points */
#define RG_UNKNOWN_FIGURE 0xffffffffu
#define RG_LENS_POSITION_LIMIT_Q16 (INT32_C(1024) << 16) /* dioptres */
#define RG_CROP_LIMIT 65536u                             /* px of the sensor */
#define RG_MAX_CROP_SCALE                             \
  64u /* of a crop's and an image's pixel, either way \
       */
#define RG_MIN_ZOOM_Q16 (UINT32_C(1) << 16)
#define RG_MAX_ZOOM_Q16 (UINT32_C(1024) << 16)
#define RG_MAX_ORIENTATION 8u
#define RG_TEMPERATURE_LIMIT_Q16 (INT32_C(1024) << 16) /* degrees Celsius */
#define RG_MAX_EXPOSURE_US (UINT32_C(1) << 30)
#define RG_MAX_ANALOGUE_GAIN_Q16 (UINT32_C(1024) << 16)
#define RG_MIN_KNOTS 2u
#define RG_MAX_KNOTS 64u
#define RG_CONDITION_LIMIT_Q16 (INT32_C(1024) << 16) /* dioptres or degrees */
#define RG_ROW_TIME_LIMIT_Q10 (INT32_C(1) << 30)     /* ns: a millisecond */

/* Identity of the camera. */
typedef struct rg_camera_section {
  uint16_t width, height; /* pixels, 1 to RG_MAX_IMAGE_SIZE */
  const char* name;   /* RG_TEXT_SIZE bytes: UTF-8, then at least one zero */
  const char* serial; /* likewise; both point into the blob */
} rg_camera_section;

/* Central model: control points of a uniform cubic B-spline over the area,
 * in stereographic coordinates of the direction. */
typedef struct rg_grid_section {
  int32_t x0_q16, y0_q16, x1_q16, y1_q16; /* calibrated area, inclusive */
  uint16_t columns, rows;                 /* control points: cells + 3 */
  uint32_t scale_x_q32, scale_y_q32;      /* cells per pixel */
  const uint8_t* control_points; /* in the blob, little-endian: row-major pairs
                                    of i32 q29, or a plane and pairs of i16 */
} rg_grid_section;

/* Control points of 16 bits: (i, j) is origin + i column_step + j row_step +
 * residual, of a and of b; in an inverse grid of x and of y, in q17 pixels. */
typedef struct rg_narrow_grid {
  uint32_t fraction_bits; /* of the residuals */
  int32_t origin_q29[2], column_step_q29[2], row_step_q29[2];
  const int16_t* residuals; /* columns * rows pairs, host order */
} rg_narrow_grid;

/* Undistortion: source positions at the corners of square output blocks. */
typedef struct rg_remap_section {
  uint16_t width, height; /* output, pixels */
  uint16_t columns, rows; /* vertices: blocks + 1 */
  uint8_t block_log2;     /* blocks of 8 to 64 px */
  uint8_t residual_shift; /* residuals are q(12 - shift) */
  uint8_t part_log2;  /* bent blocks are cut into parts of 8 to 32 px; 0: they
                         are not bent */
  uint8_t bend_shift; /* bends are q(12 - shift) */
  int32_t min_x_q12, min_y_q12;       /* source positions outside these are */
  int32_t max_x_q12, max_y_q12;       /* border */
  int32_t origin_x_q12, origin_y_q12; /* vertex (i, j) = origin + i column_step
                                         + j row_step + residual << shift */
  int32_t column_step_x_q12, column_step_y_q12;
  int32_t row_step_x_q12, row_step_y_q12;
  uint32_t fx_q16, fy_q16; /* the virtual camera of the output */
  int32_t cx_q16, cy_q16;
  uint8_t has_view;   /* 0: a pinhole in camera axes, of frames as calibrated */
  uint8_t projection; /* with a view: rg_projection */
  uint8_t mode;       /* and the mode of real frames, from 1; or 0 */
  uint8_t direction;  /* and rg_direction */
  uint16_t source_width, source_height; /* and the source's size, pixels */
  int32_t rotation_q30[9];     /* and its axes to camera axes, row by row */
  uint32_t bound_upx;          /* geometric error asked for, micropixels */
  uint32_t max_error_upx;      /* and measured over all output pixels */
  const uint8_t* vertices;     /* row-major pairs of i16 residuals, each with
                                  four i8 bends if there are any */
  const int8_t* bends;         /* only to write them: four a vertex */
  const uint8_t* empty_blocks; /* a bit a block, row-major, LSB first; 1: no
                                  pixel of it has a source */
} rg_remap_section;

/* A sensor mode: how its frames lie in those that were calibrated. Its pixel
 * (i, j), counted from the other side where flipped, covers the calibrated
 * pixels from (offset + scale i) on, scale of them a side. */
typedef struct rg_mode_section {
  uint16_t width, height; /* its frames, pixels */
  int32_t offset_x_q16, offset_y_q16;
  uint32_t scale_x_q16, scale_y_q16;
  uint8_t flip_x, flip_y;
  const char* name; /* RG_TEXT_SIZE bytes: UTF-8, then at least one zero */
} rg_mode_section;

/* The figures known of the calibration. RG_UNKNOWN_FIGURE where not measured.
 */
typedef struct rg_quality_section {
  uint32_t training_median_upx, training_rms_upx, training_max_upx;
  uint32_t training_count;
  uint32_t held_out_median_upx, held_out_rms_upx, held_out_max_upx;
  uint32_t held_out_count;
  uint32_t packing_error_npx;  /* worst un-projection error that packing added,
                                  nanopixels */
  uint32_t packing_error_prad; /* the same in picoradians */
} rg_quality_section;

/* The way back from the chart to the image: a narrow grid over a rectangle of
 * the chart, whose control points are pixels. */
typedef struct rg_inverse_section {
  int32_t a0_q27, b0_q27, a1_q27, b1_q27; /* rectangle of the chart */
  uint16_t columns, rows;                 /* control points: cells + 3 */
  uint32_t scale_a_q21, scale_b_q21;      /* cells per chart unit */
  int32_t cos_limit_q30; /* c |c|, c the cosine of the widest direction */
} rg_inverse_section;

/* Which square cells of the image were calibrated. */
typedef struct rg_mask_section {
  uint16_t columns, rows; /* cells */
  uint8_t cell_log2;      /* cells of 4 to 256 px */
  const uint8_t* bits;    /* row-major, LSB first; 1: valid */
} rg_mask_section;

/* Standard deviation of projection, over the area. */
typedef struct rg_uncertainty_section {
  uint16_t columns, rows;            /* values, edge to edge of the area */
  uint32_t scale_x_q32, scale_y_q32; /* intervals per pixel */
  const uint8_t* values; /* row-major u16 q12 px; RG_UNKNOWN_UNCERTAINTY */
} rg_uncertainty_section;

enum rg_capture_known {
  RG_KNOWS_LENS_POSITION = 1, /* and its tolerance */
  RG_KNOWS_CROP = 2,
  RG_KNOWS_ZOOM = 4,
  RG_KNOWS_ORIENTATION = 8,
  RG_KNOWS_TEMPERATURE = 16,
  RG_KNOWS_EXPOSURE = 32,
  RG_KNOWS_GAIN = 64
};

/* How the camera stood while it was calibrated. What is not known is 0. */
typedef struct rg_capture_section {
  uint8_t known; /* bits of rg_capture_known */
  int32_t lens_position_q16;
  uint32_t lens_tolerance_q16;
  int32_t crop_x, crop_y; /* the shown part of the sensor, in its pixels */
  uint32_t crop_width, crop_height;
  uint32_t zoom_q16;       /* magnification over the widest */
  uint8_t orientation;     /* 1 to 8, as EXIF has it */
  int32_t temperature_q16; /* of the sensor, degrees Celsius */
  uint32_t exposure_us;
  uint32_t analogue_gain_q16; /* a factor */
} rg_capture_section;

typedef enum rg_condition {
  RG_CONDITION_LENS_POSITION = 1, /* dioptres */
  RG_CONDITION_TEMPERATURE = 2    /* of the sensor, degrees Celsius */
} rg_condition;

/* The camera at other conditions. A knot has its like of each grid and table of
 * the blob, in the order of the section table, and as large; and its value
 * behind them: rg_knot_value(). */
typedef struct rg_stack_section {
  uint16_t condition;   /* rg_condition */
  uint16_t num_knots;   /* RG_MIN_KNOTS to RG_MAX_KNOTS */
  const uint8_t* knots; /* in the blob */
  uint32_t knot_size;   /* bytes from one to the next */
} rg_stack_section;

/* How much later than the row above it a sensor reads a row. */
typedef struct rg_row_time_section {
  int32_t row_time_ns_q10;   /* negative: the last row is read first */
  uint32_t deviation_ns_q10; /* standard; 0: not known */
} rg_row_time_section;

/* A validated blob. Offsets are from the first byte; 0 means absent. */
typedef struct rg_blob {
  const uint8_t* bytes;
  uint32_t size;
  uint32_t camera, grid, remap, quality, inverse;
  uint32_t line_points, mask, uncertainty, modes, capture, stack, row_time;
} rg_blob;

/* Validates num_bytes bytes, by every limit of SPEC.md, and finds the sections.
 * The bytes are read in place and kept: they must outlive *blob.
 *
 * bytes  multiple of 4. Bytes after the blob's own end are not looked at.
 *
 * Nothing outside bytes[0, num_bytes) is read, whatever they hold. Every
 * status from RG_ERR_MISALIGNED to RG_ERR_MODE, and RG_ERR_CAPTURE,
 * RG_ERR_STACK and RG_ERR_ROW_TIME, names one fault. */
rg_status rg_blob_open(const void* bytes, uint32_t num_bytes, rg_blob* blob);

/* Sections of a blob that rg_blob_open() accepted. The optional ones,
 * from quality on, must be present (blob->quality not 0). */
void rg_blob_camera(const rg_blob* blob, rg_camera_section* camera);
void rg_blob_grid(const rg_blob* blob, rg_grid_section* grid);
/* A control point, also of 16 bits. */
void rg_blob_control_point(const rg_blob* blob, uint32_t column, uint32_t row,
                           int32_t point_q29[2]);
void rg_blob_quality(const rg_blob* blob, rg_quality_section* quality);

void rg_blob_inverse(const rg_blob* blob, rg_inverse_section* inverse);
void rg_blob_mask(const rg_blob* blob, rg_mask_section* mask);
void rg_blob_uncertainty(const rg_blob* blob,
                         rg_uncertainty_section* uncertainty);
void rg_blob_capture(const rg_blob* blob, rg_capture_section* capture);
void rg_blob_stack(const rg_blob* blob, rg_stack_section* stack);

/* The value of a knot, counted from 0, in q16; they ascend. */
int32_t rg_knot_value(const rg_stack_section* stack, uint32_t knot);

void rg_blob_row_time(const rg_blob* blob, rg_row_time_section* row_time);

/* How many modes a blob has, and the index-th of them, counted from 0. */
uint32_t rg_blob_num_modes(const rg_blob* blob);
void rg_blob_mode(const rg_blob* blob, uint32_t index, rg_mode_section* mode);

/* Triples of i32 q28 metres of a non-central camera, as many as control points;
 * blob->line_points must not be 0. */
const uint8_t* rg_blob_line_points(const rg_blob* blob);

/* The index-th section of a type in the bytes of a blob that rg_blob_open()
 * accepted, or NULL. */
const uint8_t* rg_find_section(const uint8_t* bytes, uint32_t type,
                               uint32_t index);

/* The fields of a remap section that was accepted, from its first byte. */
void rg_read_remap(const uint8_t* section, rg_remap_section* remap);

/* ---- Writing, on the host ------------------------------------------------ */

/* A remap section and its residuals: columns * rows pairs in host order. */
typedef struct rg_remap_contents {
  const rg_remap_section* section;
  const int16_t* residuals;
} rg_remap_contents;

/* A knot of a stack. What it does not have is the blob's own. */
typedef struct rg_knot_contents {
  int32_t value_q16;
  const int32_t* control_points_q29;    /* of a wide grid */
  const rg_narrow_grid* narrow;         /* or of a narrow one */
  const rg_narrow_grid* inverse_points; /* if the blob has an inverse grid */
  const rg_remap_contents* remaps;      /* as many as the blob has */
} rg_knot_contents;

typedef struct rg_stack_contents {
  uint16_t condition; /* rg_condition */
  uint16_t num_knots;
  const rg_knot_contents* knots;
} rg_stack_contents;

typedef struct rg_blob_contents {
  const rg_camera_section* camera;
  const rg_grid_section* grid;       /* control_points: columns * rows pairs */
  const int32_t* control_points_q29; /* in host order, instead of the former */
  const rg_narrow_grid* narrow;      /* or of 16 bits, if not NULL */
  const rg_remap_section* remap;     /* NULL: none */
  const int16_t* residuals;          /* columns * rows pairs, host order */
  const rg_quality_section* quality; /* NULL: none */
  const rg_inverse_section* inverse; /* NULL: none */
  const rg_narrow_grid* inverse_points; /* of it */
  const rg_remap_contents* more_remaps; /* behind the first */
  uint32_t num_more_remaps;
  const rg_mode_section* modes; /* those that tables name */
  uint32_t num_modes;
  const int32_t* line_points_q28;            /* NULL: a central camera */
  const rg_mask_section* mask;               /* NULL: none */
  const rg_uncertainty_section* uncertainty; /* NULL: none */
  const uint16_t* uncertainties_q12;         /* in host order */
  const rg_capture_section* capture;         /* NULL: none */
  const rg_stack_contents* stack;            /* NULL: none */
  const rg_row_time_section* row_time;       /* NULL: none */
} rg_blob_contents;

/* Bytes that rg_blob_write() will need. */
uint32_t rg_blob_size(const rg_blob_contents* contents);

/* Writes the blob into buffer (multiple of 4) and opens it again: whatever
 * rg_blob_open() would refuse is refused here, with the same status. */
rg_status rg_blob_write(const rg_blob_contents* contents, void* buffer,
                        uint32_t buffer_size);

/* One remap section alone: its size, and its bytes into section (multiple of 4,
 * as large as that). */
uint32_t rg_remap_section_size(const rg_remap_section* remap);
void rg_write_remap(const rg_remap_section* remap, const int16_t* residuals,
                    uint8_t* section);

/* Cells per pixel, or per chart unit, as the format wants them:
 * floor(cells 2^48 / span). */
uint32_t rg_grid_scale_q32(uint32_t cells, uint32_t span);

#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_RG_BLOB_H */
