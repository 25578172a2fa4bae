/* The calibration blob, which hosts write and devices read in place. Its bytes
 * are specified in SPEC.md and blob_layout.h; fields here have the same names.
 *
 * C99, no allocation, no floating point. Untrusted bytes are validated once by
 * rg_blob_open(); all other functions rely on this. */
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
#define RG_NARROW_MIN_BITS 14u    /* bits of the residuals of narrow grids */
#define RG_NARROW_MAX_BITS 28u
#define RG_CONTROL_POINT_LIMIT 0x7f000000      /* 3.96875 in q29 */
#define RG_VERTEX_LIMIT_Q12 (INT32_C(1) << 25) /* 8192 px */
#define RG_MAX_RESIDUAL_SHIFT 10u
#define RG_MAX_BEND_SHIFT 10u
#define RG_MAX_MODES 255u
#define RG_MIN_MODE_SCALE_Q16 (UINT32_C(1) << 10) /* 1/64 */
#define RG_MAX_MODE_SCALE_Q16 (UINT32_C(64) << 16)
#define RG_MODE_OFFSET_LIMIT_Q16 (INT32_C(1) << 30)  /* 16384 px */
#define RG_ROTATION_TOLERANCE_Q30 (INT32_C(1) << 10) /* of row products */
#define RG_LINE_POINT_BITS 28u                       /* fraction bits */
#define RG_LINE_POINT_LIMIT 0x7f000000               /* 7.9375 m in q28 */
#define RG_MIN_MASK_CELL_LOG2 2u
#define RG_MAX_MASK_CELL_LOG2 8u
#define RG_MAX_UNCERTAINTY_SIZE 65u
#define RG_UNKNOWN_UNCERTAINTY 0xffffu
#define RG_CHART_LIMIT_Q27 (INT32_C(1) << 29) /* 4 */
#define RG_INVERSE_PIXEL_BITS 17u             /* inverse grids: fraction bits */
#define RG_UNKNOWN_METRIC 0xffffffffu
#define RG_LENS_POSITION_LIMIT_Q16 (INT32_C(1024) << 16) /* dioptres */
#define RG_CROP_LIMIT 65536u                             /* sensor px */
#define RG_MAX_CROP_SCALE                             \
  64u /* of a crop's and an image's pixel, either way \
       */
#define RG_MIN_ZOOM_Q16 (UINT32_C(1) << 16)
#define RG_MAX_ZOOM_Q16 (UINT32_C(1024) << 16)
#define RG_MAX_ORIENTATION 8u
#define RG_TEMPERATURE_LIMIT_Q16 (INT32_C(1024) << 16) /* degrees Celsius */
#define RG_MAX_EXPOSURE_US (UINT32_C(1) << 30)
#define RG_MAX_ANALOGUE_GAIN_Q16 (UINT32_C(1024) << 16)
#define RG_MIN_STACK_SAMPLES 2u
#define RG_MAX_STACK_SAMPLES 64u
#define RG_OPERATING_POINT_LIMIT_Q16 \
  (INT32_C(1024) << 16)                          /* dioptres or degrees */
#define RG_ROW_TIME_LIMIT_Q10 (INT32_C(1) << 30) /* ns: a millisecond */

/* Identity of the camera. */
typedef struct rg_camera_section {
  uint16_t width, height; /* pixels, 1 to RG_MAX_IMAGE_SIZE */
  const char* name;   /* RG_TEXT_SIZE bytes: UTF-8, then at least one zero */
  const char* serial; /* likewise, a serial number; both point into the blob */
} rg_camera_section;

/* Central model: control points of a uniform cubic B-spline over the calibrated
 * area, in stereographic coordinates of the direction. */
typedef struct rg_grid_section {
  int32_t x0_q16, y0_q16, x1_q16, y1_q16; /* calibrated area, inclusive */
  uint16_t columns, rows;                 /* control points: cells + 3 */
  uint32_t scale_x_q32, scale_y_q32;      /* cells per pixel */
  const uint8_t* control_points; /* in the blob, little-endian: row-major pairs
                                    of i32 q29, or a plane and pairs of i16 */
} rg_grid_section;

/* 16-bit control points: (i, j) is origin + i column_step + j row_step +
 * residual, for a and b; in an inverse grid for x and y, in q17 pixels. */
typedef struct rg_narrow_grid {
  uint32_t fraction_bits; /* fraction bits of the residuals */
  int32_t origin_q29[2], column_step_q29[2], row_step_q29[2];
  const int16_t* residuals; /* columns * rows pairs, host order */
} rg_narrow_grid;

/* Remap table: source positions at the corners of square output blocks. */
typedef struct rg_remap_section {
  uint16_t width, height; /* output size, pixels */
  uint16_t columns, rows; /* vertices: blocks + 1 */
  uint8_t block_log2;     /* log2 of the block size, 8 to 64 px */
  uint8_t residual_shift; /* residuals are q(12 - shift) */
  uint8_t part_log2;  /* log2 of the tile size of bent blocks, 8 to 32 px; 0: no
                         bends */
  uint8_t bend_shift; /* bends are q(12 - shift) */
  int32_t min_x_q12, min_y_q12;       /* source positions outside this range */
  int32_t max_x_q12, max_y_q12;       /* are border */
  int32_t origin_x_q12, origin_y_q12; /* vertex (i, j) = origin + i column_step
                                         + j row_step + residual << shift */
  int32_t column_step_x_q12, column_step_y_q12;
  int32_t row_step_x_q12, row_step_y_q12;
  uint32_t fx_q16, fy_q16; /* intrinsics of the view */
  int32_t cx_q16, cy_q16;
  uint8_t has_view;   /* 0: pinhole in camera axes, frames as calibrated */
  uint8_t projection; /* rg_projection; up to rotation: with a view */
  uint8_t mode;       /* 1-based mode of the frames; 0: as calibrated */
  uint8_t direction;  /* rg_remap_direction */
  uint16_t source_width, source_height; /* source size, pixels */
  int32_t rotation_q30[9];              /* camera_from_view, row-major */
  uint32_t bound_upx;          /* requested geometric error, micropixels */
  uint32_t max_error_upx;      /* maximum over all output pixels, measured */
  const uint8_t* vertices;     /* row-major pairs of i16 residuals, each with
                                  four i8 bends if there are any */
  const int8_t* bends;         /* for writing only: four per vertex */
  const uint8_t* empty_blocks; /* one bit per block, row-major, LSB first; 1: no
                                  pixel of the block has a source */
} rg_remap_section;

/* A sensor mode: the mapping of its frames to the calibrated images. Its pixel
 * (i, j), counted from the opposite side if flipped, covers scale_x x scale_y
 * calibrated pixels from offset + scale (i, j). */
typedef struct rg_mode_section {
  uint16_t width, height; /* size of the mode's frames, pixels */
  int32_t offset_x_q16, offset_y_q16;
  uint32_t scale_x_q16, scale_y_q16;
  uint8_t flip_x, flip_y;
  const char* name; /* RG_TEXT_SIZE bytes: UTF-8, then at least one zero */
} rg_mode_section;

/* Quality metrics of the calibration; RG_UNKNOWN_METRIC if not measured.
 */
typedef struct rg_quality_section {
  uint32_t training_median_upx, training_rms_upx, training_max_upx;
  uint32_t training_count;
  uint32_t held_out_median_upx, held_out_rms_upx, held_out_max_upx;
  uint32_t held_out_count;
  uint32_t packing_error_npx;  /* maximum unprojection error added by packing,
                                  nanopixels */
  uint32_t packing_error_prad; /* likewise, in picoradians */
} rg_quality_section;

/* Inverse grid, from the chart to the image: a narrow grid over a rectangle of
 * the chart, whose control points are pixel positions. */
typedef struct rg_inverse_section {
  int32_t a0_q27, b0_q27, a1_q27, b1_q27; /* rectangle of the chart */
  uint16_t columns, rows;                 /* control points: cells + 3 */
  uint32_t scale_a_q21, scale_b_q21;      /* cells per chart unit */
  int32_t cos_limit_q30; /* c |c|, c the cosine of the widest direction */
} rg_inverse_section;

/* Validity mask: valid region as square cells of the image. */
typedef struct rg_mask_section {
  uint16_t columns, rows; /* cells */
  uint8_t cell_log2;      /* cells of 4 to 256 px */
  const uint8_t* bits;    /* row-major, LSB first; 1: valid */
} rg_mask_section;

/* Predicted uncertainty: standard deviation of projection over the area. */
typedef struct rg_uncertainty_section {
  uint16_t columns, rows;            /* values, from edge to edge */
  uint32_t scale_x_q32, scale_y_q32; /* intervals per pixel */
  const uint8_t* values; /* row-major u16 q12 px; RG_UNKNOWN_UNCERTAINTY */
} rg_uncertainty_section;

enum rg_capture_fields {
  RG_CAPTURE_HAS_LENS_POSITION = 1, /* and its tolerance */
  RG_CAPTURE_HAS_CROP = 2,
  RG_CAPTURE_HAS_ZOOM = 4,
  RG_CAPTURE_HAS_ORIENTATION = 8,
  RG_CAPTURE_HAS_TEMPERATURE = 16,
  RG_CAPTURE_HAS_EXPOSURE = 32,
  RG_CAPTURE_HAS_GAIN = 64
};

/* Capture settings during calibration. Unknown fields are 0. */
typedef struct rg_capture_section {
  uint8_t known; /* bits of rg_capture_fields */
  int32_t lens_position_q16;
  uint32_t lens_tolerance_q16;
  int32_t crop_x, crop_y; /* crop of the sensor, in its pixels */
  uint32_t crop_width, crop_height;
  uint32_t zoom_q16;       /* zoom factor relative to the widest setting */
  uint8_t orientation;     /* 1 to 8, as in EXIF */
  int32_t temperature_q16; /* sensor temperature, degrees Celsius */
  uint32_t exposure_us;
  uint32_t analogue_gain_q16; /* factor */
} rg_capture_section;

typedef enum rg_operating_parameter {
  RG_OPERATING_PARAMETER_LENS_POSITION = 1, /* dioptres */
  RG_OPERATING_PARAMETER_TEMPERATURE = 2    /* sensor, degrees Celsius */
} rg_operating_parameter;

/* The operating-point stack. A sample contains a variant of each grid and table
 * of the blob, in the order of the section table and of equal size, followed by
 * its value: rg_stack_sample_value(). */
typedef struct rg_stack_section {
  uint16_t condition;     /* rg_operating_parameter */
  uint16_t num_samples;   /* number of samples, RG_MIN_STACK_SAMPLES to
                             RG_MAX_STACK_SAMPLES */
  const uint8_t* samples; /* samples in the blob */
  uint32_t sample_size;   /* bytes from one sample to the next */
} rg_stack_section;

/* Line delay: the readout time per row of a rolling shutter. */
typedef struct rg_row_time_section {
  int32_t row_time_ns_q10; /* negative: the last row is read first */
  uint32_t stddev_ns_q10;  /* standard deviation; 0: unknown */
} rg_row_time_section;

/* A validated blob. Offsets are from the first byte; 0 means absent. */
typedef struct rg_blob {
  const uint8_t* bytes;
  uint32_t size;
  uint32_t camera, grid, remap, quality, inverse;
  uint32_t line_points, mask, uncertainty, modes, capture, stack, row_time;
} rg_blob;

/* Validates num_bytes bytes against every limit of SPEC.md, and finds the
 * sections. The bytes are used in place: they must outlive *blob.
 *
 * bytes  multiple of 4. Bytes after the end of the blob are ignored.
 *
 * Nothing outside bytes[0, num_bytes) is read, whatever the contents. Each
 * status from RG_ERR_MISALIGNED to RG_ERR_MODE, and RG_ERR_CAPTURE,
 * RG_ERR_STACK and RG_ERR_ROW_TIME, means one fault. */
rg_status rg_blob_open(const void* bytes, uint32_t num_bytes, rg_blob* blob);

/* Read sections of a blob that rg_blob_open() accepted. Optional sections, from
 * quality on, must be present (blob->quality not 0). */
void rg_blob_camera(const rg_blob* blob, rg_camera_section* camera);
void rg_blob_grid(const rg_blob* blob, rg_grid_section* grid);
/* Computes a control point, also from 16-bit residuals. */
void rg_blob_control_point(const rg_blob* blob, uint32_t column, uint32_t row,
                           int32_t point_q29[2]);
void rg_blob_quality(const rg_blob* blob, rg_quality_section* quality);

void rg_blob_inverse(const rg_blob* blob, rg_inverse_section* inverse);
void rg_blob_mask(const rg_blob* blob, rg_mask_section* mask);
void rg_blob_uncertainty(const rg_blob* blob,
                         rg_uncertainty_section* uncertainty);
void rg_blob_capture(const rg_blob* blob, rg_capture_section* capture);
void rg_blob_stack(const rg_blob* blob, rg_stack_section* stack);

/* Returns the value of a sample, 0-based, in q16; values ascend. */
int32_t rg_stack_sample_value(const rg_stack_section* stack, uint32_t sample);

void rg_blob_row_time(const rg_blob* blob, rg_row_time_section* row_time);

/* Returns the number of modes; reads the index-th mode, 0-based. */
uint32_t rg_blob_num_modes(const rg_blob* blob);
void rg_blob_mode(const rg_blob* blob, uint32_t index, rg_mode_section* mode);

/* Returns the line points of a non-central camera: i32 triples in q28 metres,
 * one per control point. blob->line_points must not be 0. */
const uint8_t* rg_blob_line_points(const rg_blob* blob);

/* Returns the index-th section of a type in the bytes of a blob that
 * rg_blob_open() accepted, or NULL. */
const uint8_t* rg_find_section(const uint8_t* bytes, uint32_t type,
                               uint32_t index);

/* Reads the fields of an accepted remap section from its first byte. */
void rg_read_remap(const uint8_t* section, rg_remap_section* remap);

/* ---- Writing, on the host ------------------------------------------------ */

/* A remap section and its residuals: columns * rows pairs in host order. */
typedef struct rg_remap_contents {
  const rg_remap_section* section;
  const int16_t* residuals;
} rg_remap_contents;

/* A sample of the stack. Other sections are inherited from the base camera. */
typedef struct rg_stack_sample_contents {
  int32_t value_q16;
  const int32_t* control_points_q29;    /* wide grid */
  const rg_narrow_grid* narrow;         /* narrow grid instead */
  const rg_narrow_grid* inverse_points; /* if the blob has an inverse grid */
  const rg_remap_contents* remaps;      /* one per remap table of the blob */
} rg_stack_sample_contents;

typedef struct rg_stack_contents {
  uint16_t condition; /* rg_operating_parameter */
  uint16_t num_samples;
  const rg_stack_sample_contents* samples;
} rg_stack_contents;

typedef struct rg_blob_contents {
  const rg_camera_section* camera;
  const rg_grid_section* grid;       /* control_points: columns * rows pairs */
  const int32_t* control_points_q29; /* overrides them, in host order */
  const rg_narrow_grid* narrow;      /* 16-bit points instead, if not NULL */
  const rg_remap_section* remap;     /* NULL: none */
  const int16_t* residuals;          /* columns * rows pairs, host order */
  const rg_quality_section* quality; /* NULL: none */
  const rg_inverse_section* inverse; /* NULL: none */
  const rg_narrow_grid* inverse_points; /* control points of the inverse grid */
  const rg_remap_contents* more_remaps; /* tables after the first */
  uint32_t num_more_remaps;
  const rg_mode_section* modes; /* modes that tables refer to */
  uint32_t num_modes;
  const int32_t* line_points_q28;            /* NULL: a central camera */
  const rg_mask_section* mask;               /* NULL: none */
  const rg_uncertainty_section* uncertainty; /* NULL: none */
  const uint16_t* uncertainties_q12;         /* in host order */
  const rg_capture_section* capture;         /* NULL: none */
  const rg_stack_contents* stack;            /* NULL: none */
  const rg_row_time_section* row_time;       /* NULL: none */
} rg_blob_contents;

/* Returns the number of bytes that rg_blob_write() writes. */
uint32_t rg_blob_size(const rg_blob_contents* contents);

/* Writes the blob into buffer (multiple of 4) and validates it: contents that
 * rg_blob_open() rejects are rejected with the same status. */
rg_status rg_blob_write(const rg_blob_contents* contents, void* buffer,
                        uint32_t buffer_size);

/* Size of a single remap section, and writing it into section (multiple of 4,
 * of this size). */
uint32_t rg_remap_section_size(const rg_remap_section* remap);
void rg_write_remap(const rg_remap_section* remap, const int16_t* residuals,
                    uint8_t* section);

/* Returns cells per pixel, or per chart unit, as required by the format:
 * floor(cells 2^48 / span). */
uint32_t rg_grid_scale_q32(uint32_t cells, uint32_t span);

#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_RG_BLOB_H */
