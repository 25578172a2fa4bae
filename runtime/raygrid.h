/** @file
 * Runtime for cameras calibrated by raygrid: unprojection, projection and
 * undistortion from a blob. C99, integers only, no allocation, no globals, no
 * library calls; results are bit-identical on every processor.
 *
 *     rg_camera camera;
 *     if (rg_camera_open(&camera, blob, blob_size) != RG_OK) ...;
 *     rg_pixel pixel = {RG_PIXEL(320), RG_PIXEL(240)};
 *     rg_ray ray;
 *     if (rg_unproject(&camera, pixel, &ray) == RG_OK) ...;
 *
 * Conventions: pixel (0, 0) is the centre of the top-left pixel; camera axes
 * are x right, y down, z forward; angles are in radians. The suffix _qN of a
 * name means fixed point with N fraction bits: the integer is the value times
 * 2^N. Pointers must not be NULL unless stated.
 *
 * Thread safety: functions with a const rg_camera may be called by several
 * threads and interrupt handlers at a time. Functions with a non-const one
 * (rg_camera_open(), rg_select_remap(), rg_set_operating_point(),
 * rg_select_ray_kernels()) must not run while other functions use the camera.
 *
 * Cost per core: runtime/COST.md. */
#ifndef RAYGRID_RAYGRID_H
#define RAYGRID_RAYGRID_H

#include <stdint.h>

#include "rg_projection.h"
#include "rg_status.h"

#ifdef __cplusplus
extern "C" {
#endif
#if defined(__GNUC__)
#pragma GCC visibility push(default)
#endif

/** Major version of the library. */
#define RAYGRID_VERSION_MAJOR 0
/** Minor version of the library. */
#define RAYGRID_VERSION_MINOR 2
/** Patch version of the library. */
#define RAYGRID_VERSION_PATCH 0

/** A whole number of pixels in q16. */
#define RG_PIXEL(n) ((int32_t)((n)*65536))

/** An open camera: at most 64 bytes, owned by the caller. The blob must outlive
 * it. The fields are private. */
typedef struct rg_camera {
  /** @cond */
  const uint8_t* blob;
  const uint8_t* grid;        /* base section, or the lower sample in use */
  const uint8_t* inverse;     /* likewise; NULL, as the next two, if absent */
  const uint8_t* line_points; /* first point in the section */
  const uint8_t* remap;       /* selected base section, never a sample's */
  const struct rg_operating_point_ops*
      stack;                          /* NULL: no operating point was set */
  uint32_t sample_shift;              /* bytes from the base sections to the
                                       sections of the lower sample in use */
  uint32_t sample_size;               /* bytes from one sample to the next */
  uint16_t frame_width, frame_height; /* source size of the selected table */
  uint16_t weight_q14;                /* weight of the upper sample */
  uint16_t surface;                   /* RG_SURFACE_..., the ray kernels */
  /** @endcond */
} rg_camera;

/** A position in an image, in pixels. */
typedef struct rg_pixel {
  int32_t x_q16; /**< to the right, q16 pixels */
  int32_t y_q16; /**< down, q16 pixels */
} rg_pixel;

/** A direction in camera axes. */
typedef struct rg_ray {
  int32_t x_q30; /**< right, q30 */
  int32_t y_q30; /**< down, q30 */
  int32_t z_q30; /**< forward, q30 */
} rg_ray;

/** An observation line of a non-central camera: a point and a direction. */
typedef struct rg_line {
  int32_t point_q28[3]; /**< x, y, z in camera axes, q28 metres */
  rg_ray direction;     /**< unit direction */
} rg_line;

/** @name Opening a blob
 * @{ */

/** Validates a blob and opens it in place; no remap table is selected yet.
 *
 * Cost: one pass over the blob for its CRCs.
 *
 * @param[out] camera written only if RG_OK is returned
 * @param bytes the blob, aligned to 4 bytes; must stay in place while the
 *     camera is in use
 * @param num_bytes size of the blob or of the memory that contains it
 * @return RG_OK, or the first error found (rg_status.h) */
rg_status rg_camera_open(rg_camera* camera, const void* bytes,
                         uint32_t num_bytes);

/** Selects the kernels that compute rays and projections. All kernels compute
 * bit-identical results.
 *
 * @param camera an open camera
 * @param name NULL: the fastest that the processor supports, the default;
 *     "portable"; or, on x86-64, "avx2"
 * @retval RG_OK done
 * @retval RG_ERR_ARGUMENT kernels unknown or not supported; nothing changes */
rg_status rg_select_ray_kernels(rg_camera* camera, const char* name);

/** Gets the size of the calibrated images, in which positions are expressed.
 *
 * @param camera an open camera
 * @param[out] width in pixels
 * @param[out] height in pixels */
void rg_calibrated_size(const rg_camera* camera, uint16_t* width,
                        uint16_t* height);

/** @}
 * @name Unprojection: pixels to rays
 * @{ */

/** Unprojects a pixel: computes the direction that it observes from the cubic
 * B-spline surface of the central-generic model in stereographic coordinates
 * (Schoeps et al., CVPR 2020, section "Camera Model").
 *
 * Runs in constant time: no loop depends on the data.
 *
 * @param camera an open camera
 * @param pixel in calibrated images
 * @param[out] ray unit direction within 4e-8; written only if RG_OK is returned
 * @retval RG_OK done
 * @retval RG_ERR_OUTSIDE_AREA the pixel is outside the calibrated area
 * @retval RG_ERR_NONCENTRAL the camera is non-central; use rg_unproject_line()
 */
rg_status rg_unproject(const rg_camera* camera, rg_pixel pixel, rg_ray* ray);

/** Unprojects a pixel of any camera: the line in space that it observes.
 *
 * @param camera an open camera
 * @param pixel in calibrated images
 * @param[out] line its point is within 7e-8 m of the B-spline, and (0, 0, 0)
 *     for a central camera; written only if RG_OK is returned
 * @retval RG_OK done
 * @retval RG_ERR_OUTSIDE_AREA the pixel is outside the calibrated area */
rg_status rg_unproject_line(const rg_camera* camera, rg_pixel pixel,
                            rg_line* line);

/** Unprojects an array of pixels with rg_unproject().
 *
 * @param camera an open, central camera
 * @param pixels num_pixels positions in calibrated images
 * @param[out] rays num_pixels unit directions; (0, 0, 0) for pixels outside the
 *     calibrated area
 * @param num_pixels length of both arrays
 * @return number of pixels inside the calibrated area */
uint32_t rg_unproject_batch(const rg_camera* camera, const rg_pixel* pixels,
                            rg_ray* rays, uint32_t num_pixels);

/** Unprojects a row of pixels, one pixel apart; same results as
 * rg_unproject_batch().
 *
 * @param camera an open, central camera
 * @param first the leftmost position, in calibrated images
 * @param[out] rays num_pixels unit directions; (0, 0, 0) for pixels outside the
 *     calibrated area
 * @param num_pixels length of the row
 * @return number of pixels inside the calibrated area */
uint32_t rg_unproject_row(const rg_camera* camera, rg_pixel first, rg_ray* rays,
                          uint32_t num_pixels);

/** Unprojects an array of pixels with rg_unproject_line().
 *
 * @param camera an open camera
 * @param pixels num_pixels positions in calibrated images
 * @param[out] lines num_pixels lines; all zeros for pixels outside the
 *     calibrated area
 * @param num_pixels length of both arrays
 * @return number of pixels inside the calibrated area */
uint32_t rg_unproject_lines(const rg_camera* camera, const rg_pixel* pixels,
                            rg_line* lines, uint32_t num_pixels);

/** @}
 * @name Projection: points to pixels
 * @{ */

/** Coordinate of a missing pixel: x and y of points that are not visible. */
#define RG_NO_PIXEL INT32_MIN

/** Largest number of fraction bits of rg_project_point(). */
#define RG_POINT_MAX_BITS 27u

/** Projects a direction, or a point at any distance, into the image: the
 * inverse of rg_unproject(). The blob's inverse grid gives an initial value and
 * its Jacobian; usually one Newton step follows, at most five.
 *
 * @param camera an open camera
 * @param direction in camera axes, of any length but zero; also a 3-D point
 *     whose coordinates share any unit and fixed-point format
 * @param[out] pixel in calibrated images, within 0.002 px of the exact inverse;
 *     written only if RG_OK is returned
 * @retval RG_OK done
 * @retval RG_ERR_NOT_SEEN no pixel of the calibrated area observes the
 *     direction, or it is 151 degrees or more from the z axis
 * @retval RG_ERR_NONCENTRAL the camera is non-central; use rg_project_point()
 * @retval RG_ERR_NO_INVERSE the blob has no inverse grid: its format is older
 *     than 1.3, or the model has no inverse that such a grid can represent */
rg_status rg_project(const rg_camera* camera, const rg_ray* direction,
                     rg_pixel* pixel);

/** Projects an array of directions or points with rg_project().
 *
 * @param camera an open, central camera
 * @param directions num_points directions or points in camera axes
 * @param[out] pixels num_points positions; both coordinates are RG_NO_PIXEL for
 *     points that are not visible
 * @param num_points length of both arrays
 * @return number of visible points */
uint32_t rg_project_batch(const rg_camera* camera, const rg_ray* directions,
                          rg_pixel* pixels, uint32_t num_points);

/** Projects a 3-D point into the image of any camera. For a non-central camera
 * it finds the pixel whose observation line passes through the point.
 *
 * Precondition for non-central cameras: lines whose directions differ by a
 * radian pass the camera's centre at positions that differ by less than a sixth
 * of the point's distance, and all lines pass it within a tenth of the distance
 * times the sine of half the field of view.
 *
 * Cost: one rg_project() for a central camera. For a non-central one three to
 * four rg_project() and two to three rg_unproject_line() if these positions
 * differ by hundredths of the distance; near the border of the calibrated area,
 * or outside it, up to 24 and 12.
 *
 * @param camera an open camera
 * @param point x, y, z in camera axes, in metres times 2^fraction_bits, each of
 *     magnitude below 2^30: 64 m with 24 bits, 1 km with 20
 * @param fraction_bits 0 to RG_POINT_MAX_BITS; more bits are more accurate
 * @param[out] pixel in calibrated images, within 0.002 px of a pixel whose line
 *     (rg_unproject_line()) passes the point at a distance of at most two units
 *     in the last place; written only if RG_OK is returned
 * @retval RG_OK done
 * @retval RG_ERR_ARGUMENT fraction_bits is too large
 * @retval RG_ERR_NOT_SEEN as rg_project()
 * @retval RG_ERR_NO_INVERSE as rg_project() */
rg_status rg_project_point(const rg_camera* camera, const int32_t point[3],
                           uint32_t fraction_bits, rg_pixel* pixel);

/** @}
 * @name Quality of the calibration
 * @{ */

/** Checks whether a pixel is in the valid region: inside the calibrated area
 * and, if the blob has a validity mask, marked as valid by it.
 *
 * @param camera an open camera
 * @param pixel in calibrated images
 * @return 1 if valid, else 0 */
int rg_is_valid(const rg_camera* camera, rg_pixel pixel);

/** Gets the predicted uncertainty of projection at a pixel: the standard
 * deviation of a coordinate, the RMS of both axes.
 *
 * @param camera an open camera
 * @param pixel in calibrated images
 * @param[out] pixels_q12 in q12 pixels; written only if RG_OK is returned
 * @retval RG_OK done
 * @retval RG_ERR_OUTSIDE_AREA the pixel is outside the calibrated area
 * @retval RG_ERR_UNKNOWN the blob has no uncertainty at this pixel
 * @retval RG_ERR_UNCERTAINTY the section's counts contradict its size, which
 *     rg_camera_open() does not check */
rg_status rg_uncertainty(const rg_camera* camera, rg_pixel pixel,
                         uint16_t* pixels_q12);

/** Gets the line delay of a rolling shutter: the readout time per row of
 * frames as calibrated. Row r is read line_delay (r - (height - 1) / 2) after
 * the centre of the frame. Other sensor modes have different line delays.
 *
 * @param camera an open camera
 * @param[out] line_delay_ns_q10 in q10 nanoseconds, of magnitude at most 2^30
 * (1 ms); negative if the last row is read first, about 0 for a global shutter;
 * written only if RG_OK is returned
 * @param[out] std_dev_ns_q10 its standard deviation in q10 nanoseconds, 0 if
 *     unknown; may be NULL
 * @retval RG_OK done
 * @retval RG_ERR_UNKNOWN the blob has no line delay, which raygrid calibrate
 *     --rolling-shutter estimates
 * @retval RG_ERR_SECTION_SIZE malformed section, which rg_camera_open() does
 *     not check
 * @retval RG_ERR_ROW_TIME as RG_ERR_SECTION_SIZE: a value is out of range */
rg_status rg_line_delay(const rg_camera* camera, int32_t* line_delay_ns_q10,
                        uint32_t* std_dev_ns_q10);

/** @}
 * @name Sensor modes
 * @{ */

/** A sensor mode: the mapping of its frames to the calibrated images. Its pixel
 * (i, j), counted from the opposite side if flipped, covers scale_x x scale_y
 * calibrated pixels, the first of which is at offset + scale (i, j). Cropping
 * has scale 1; 2 x 2 binning, or scaling down by two, has scale 2. */
typedef struct rg_mode {
  uint16_t width;       /**< width of the mode's frames, pixels */
  uint16_t height;      /**< height of the mode's frames, pixels */
  int32_t offset_x_q16; /**< q16 calibrated pixels */
  int32_t offset_y_q16; /**< q16 calibrated pixels */
  uint32_t scale_x_q16; /**< calibrated pixels per pixel, q16, 1/64 to 64 */
  uint32_t scale_y_q16; /**< calibrated pixels per pixel, q16, 1/64 to 64 */
  uint8_t flip_x;       /**< 1: mirrored left to right */
  uint8_t flip_y;       /**< 1: mirrored top to bottom */
} rg_mode;

/** Converts a position in the mode's frames to calibrated images, for
 * rg_unproject(); within 0.0001 px.
 *
 * @param mode how the frames map to the calibrated images
 * @param pixel in the mode's frames
 * @param[out] calibrated in calibrated images; written only if RG_OK is
 *     returned
 * @retval RG_OK done
 * @retval RG_ERR_ARGUMENT an impossible mode, or a position 16384 px or more
 *     away */
rg_status rg_mode_to_calibrated(const rg_mode* mode, rg_pixel pixel,
                                rg_pixel* calibrated);

/** Converts a position in calibrated images, such as from rg_project(), to the
 * mode's frames; within 0.0001 px.
 *
 * @param mode how the frames map to the calibrated images
 * @param calibrated in calibrated images
 * @param[out] pixel in the mode's frames; written only if RG_OK is returned
 * @retval RG_OK done
 * @retval RG_ERR_ARGUMENT an impossible mode, or a position 16384 px or more
 *     away */
rg_status rg_mode_from_calibrated(const rg_mode* mode, rg_pixel calibrated,
                                  rg_pixel* pixel);

/** Result of rg_match(): whether a blob fits the frames. */
typedef enum rg_match_result {
  RG_MATCH_EXACT,     /**< the frames are as calibrated */
  RG_MATCH_MODE,      /**< positions map by the sensor mode, and the blob has a
                         remap table for it */
  RG_MATCH_DERIVABLE, /**< positions map by the sensor mode, but no remap table
                         undistorts such frames */
  RG_MATCH_NONE       /**< another camera, or the mapping is unknown */
} rg_match_result;

/** Index returned by rg_match() if there is no remap table for the frames. */
#define RG_NO_TABLE UINT32_MAX

/** Checks whether a blob matches the frames of a camera, and finds the remap
 * table that undistorts them.
 *
 * @param camera an open camera
 * @param mode the sensor mode, or NULL if unknown: sizes alone do not
 *     distinguish cropping from binning
 * @param width of a frame, pixels
 * @param height of a frame, pixels
 * @param serial the camera's serial number, zero-terminated, or NULL if
 *     unknown; a blob without a serial matches any camera
 * @param[out] remap index of the first table for such frames, or RG_NO_TABLE;
 *     may be NULL. Offsets and scales of modes match up to rounding, 1 unit of
 *     q16.
 * @return how they match */
rg_match_result rg_match(const rg_camera* camera, const rg_mode* mode,
                         uint16_t width, uint16_t height, const char* serial,
                         uint32_t* remap);

/** @}
 * @name Operating point: focus or temperature
 * @{ */

/** Sets the operating point of a camera that was calibrated over focus or
 * temperature (the blob's stack). Rays, projections and remap tables, also ones
 * selected later, are interpolated between the two nearest samples from then
 * on. rg_camera_open() resets it. Call it between frames.
 *
 * The first call validates the grids of all samples, and the selected table as
 * rg_select_remap() does; later calls only read the samples' values.
 *
 * @param camera an open camera
 * @param value_q16 q16 dioptres or degrees Celsius; raygrid inspect prints
 *     which
 * @retval RG_OK done
 * @retval RG_EXTRAPOLATED done, but the value is outside the calibrated range
 *     and was clamped to it
 * @retval RG_ERR_NO_STACK the blob has no stack of operating points
 * @return any other value is the first error found; nothing changes */
rg_status rg_set_operating_point(rg_camera* camera, int32_t value_q16);

/** @}
 * @name Remap tables
 * @{ */

/** Validates a remap table of the blob and selects it for the undistortion of
 * frames and points.
 *
 * Cost: one pass over the table on Linux and on 64-bit processors, which check
 * for RG_ERR_REMAP_VERTEX. Others do not check for it; such a table is harmless
 * there.
 *
 * @param camera an open camera
 * @param index 0-based index of the table
 * @retval RG_OK done
 * @retval RG_ERR_NO_REMAP the blob has no such table
 * @return any other value is the first error found; nothing changes */
rg_status rg_select_remap(rg_camera* camera, uint32_t index);

/** Gets the size of the undistorted image.
 *
 * @param camera an open camera
 * @param[out] width in pixels; written only if RG_OK is returned
 * @param[out] height in pixels; written only if RG_OK is returned
 * @retval RG_OK done
 * @retval RG_ERR_NO_REMAP no remap table is selected */
rg_status rg_remap_size(const rg_camera* camera, uint16_t* width,
                        uint16_t* height);

/** Gets the size of the source frames of the selected table: the size of the
 * calibrated images, or of another sensor mode. Without a selected table it is
 * the size of the calibrated images.
 *
 * @param camera an open camera
 * @param[out] width in pixels
 * @param[out] height in pixels */
void rg_frame_size(const rg_camera* camera, uint16_t* width, uint16_t* height);

/** Gets the sensor mode of the selected table: how the camera's frames, which
 * are the input of rg_remap(), or its output for an inverse remap table, map
 * to the calibrated images.
 *
 * @param camera an open camera
 * @param[out] mode its width and height are the size of the camera's frames,
 *     which differs from rg_frame_size() for an inverse remap table; written
 *     only if RG_OK is returned
 * @retval RG_OK done
 * @retval RG_ERR_NO_REMAP no remap table is selected */
rg_status rg_remap_mode(const rg_camera* camera, rg_mode* mode);

/** The virtual camera of the undistorted image, with the centre of the real
 * camera. For an inverse remap table it is the camera of the source image. */
typedef struct rg_view {
  uint16_t width;           /**< width of the undistorted image, pixels */
  uint16_t height;          /**< height of the undistorted image, pixels */
  rg_projection projection; /**< how directions map to pixels */
  uint32_t fx_q16;          /**< K: q16 pixels, per radian at the centre */
  uint32_t fy_q16;          /**< K: q16 pixels, per radian at the centre */
  int32_t cx_q16;           /**< K: principal point, q16 pixels */
  int32_t cy_q16;           /**< K: principal point, q16 pixels */
  int32_t rotation_q30[9];  /**< camera_from_view, 3 x 3, row-major, q30 */
  uint8_t distorts; /**< 1: an inverse remap table, which distorts images
                       of the view into frames of the camera */
} rg_view;

/** Gets the view of the selected table.
 *
 * @param camera an open camera
 * @param[out] view written only if RG_OK is returned
 * @retval RG_OK done
 * @retval RG_ERR_NO_REMAP no remap table is selected */
rg_status rg_remap_view(const rg_camera* camera, rg_view* view);

/** Undistorts a position: computes where it appears in the undistorted image,
 * inside that image or not. For a non-central camera the scene is assumed to be
 * far away, as for frames, unless the table is for a finite distance.
 *
 * @param camera an open camera with a selected table
 * @param pixel in calibrated images
 * @param[out] undistorted within 6e-6 of the view's focal length (0.003 px at
 *     500 px): pinhole up to 85 degrees from its z axis, cylindrical up to 85
 *     degrees of elevation, stereographic up to 140 degrees from its z axis
 *     (within 1e-4 up to 170), others up to 170; written only if RG_OK is
 *     returned
 * @retval RG_OK done
 * @retval RG_ERR_NO_REMAP no remap table is selected
 * @retval RG_ERR_OUTSIDE_AREA the pixel is outside the calibrated area
 * @retval RG_ERR_NOT_SEEN the view cannot show the direction, such as one
 *     behind a pinhole, or its position would be 16384 px or more from pixel
 *     (0, 0) or from the view's principal point */
rg_status rg_undistort_point(const rg_camera* camera, rg_pixel pixel,
                             rg_pixel* undistorted);

/** Undistorts an array of positions with rg_undistort_point().
 *
 * @param camera an open camera with a selected table
 * @param pixels num_points positions in calibrated images
 * @param[out] undistorted num_points positions; both coordinates are
 *     RG_NO_PIXEL where rg_undistort_point() fails
 * @param num_points length of both arrays
 * @return number of positions that were undistorted */
uint32_t rg_undistort_points(const rg_camera* camera, const rg_pixel* pixels,
                             rg_pixel* undistorted, uint32_t num_points);

/** @}
 * @name Undistortion of frames
 * @{ */

/** Pixel format of a frame; the undistorted frame has the same one.
 *
 * The enumerators list V4L2 and libcamera names. The order of colours does not
 * matter: formats in parentheses are handled alike. Samples of more than 8 bits
 * and RGB565 words are little-endian; packed samples are as on CSI-2.
 *
 * Widths of Bayer formats and of formats with half-width chroma are even;
 * widths of 10-bit packed formats are multiples of 4, of 12-bit packed formats
 * multiples of 2. Heights of Bayer formats and of formats with half-height
 * chroma are even, because their rows come in pairs. */
typedef enum rg_format {
  RG_FORMAT_GREY8,    /**< GREY, R8 */
  RG_FORMAT_GREY16,   /**< Y10, Y12, Y14, Y16: the low bits of 16 */
  RG_FORMAT_GREY10P,  /**< Y10P */
  RG_FORMAT_GREY12P,  /**< Y12P */
  RG_FORMAT_RGB24,    /**< RGB888 (BGR888) */
  RG_FORMAT_RGB32,    /**< XRGB8888 (any four interleaved channels) */
  RG_FORMAT_YUYV,     /**< YUYV (YVYU) */
  RG_FORMAT_UYVY,     /**< UYVY (VYUY) */
  RG_FORMAT_NV12,     /**< NV12 (NV21): two planes */
  RG_FORMAT_YUV420,   /**< YUV420 (YVU420): three planes */
  RG_FORMAT_BAYER8,   /**< 8-bit Bayer, any order; each colour of the 2 x 2
                         pattern is remapped by itself */
  RG_FORMAT_BAYER16,  /**< Bayer of 10, 12, 14 or 16 bits: the low bits of 16 */
  RG_FORMAT_BAYER10P, /**< 10-bit packed Bayer */
  RG_FORMAT_BAYER12P, /**< 12-bit packed Bayer */
  RG_FORMAT_RGB565,   /**< RGBP: 16-bit words, red in the upper 5 bits, then
                         green in 6 and blue in 5 */
  RG_NUM_FORMATS      /**< number of formats; not a format */
} rg_format;

/** A source frame, or the part of it that is in a ring buffer of rows. Row r of
 * a plane of full height starts at data + (r mod ring_rows) * stride; a chroma
 * plane of half height has a ring of half the rows. */
typedef struct rg_image {
  rg_format format;   /**< pixel format */
  uint16_t width;     /**< width of the whole frame, pixels */
  uint16_t height;    /**< height of the whole frame, pixels */
  uint16_t ring_rows; /**< rows of the ring buffer; 0: the whole frame is in
                         memory */
  uint16_t first_row; /**< ring buffer: first row */
  uint16_t num_rows;  /**< ring buffer: number of rows, at most ring_rows */
  /** A plane of the frame. */
  struct {
    const uint8_t* data; /**< row 0 of the plane or of its ring buffer */
    uint32_t stride;     /**< bytes per row, below 2^31 */
  } planes[3];           /**< planes of the format; unused ones are ignored */
} rg_image;

/** Value of pixels without a source or with one outside the calibrated area.
 */
typedef enum rg_border {
  RG_BORDER_VALUE, /**< border_values */
  RG_BORDER_CLAMP, /**< the nearest pixel of the calibrated area */
  RG_BORDER_KEEP   /**< the target keeps its contents */
} rg_border;

/** Interpolation between source pixels. */
typedef enum rg_sampling {
  RG_SAMPLING_BILINEAR, /**< bilinear, between the four nearest pixels */
  RG_SAMPLING_NEAREST   /**< the nearest pixel */
} rg_sampling;

/** Kernels: inner loops for one instruction set. All kernels write
 * bit-identical output. Targets without Linux have their kernels built in and
 * ignore this; RG_PORTABLE_KERNELS, defined as 1 for all files, selects the
 * portable ones there. */
typedef struct rg_kernels rg_kernels;

/** Finds kernels by name, for measurements and tests.
 *
 * @param name "portable", or one such as "avx2" or "neon" (README.md,
 *     "Kernels"); NULL: the fastest that this processor supports; finding it
 *     takes up to a microsecond in a virtual machine
 * @return static kernels; NULL if none of this name are built or supported */
const rg_kernels* rg_find_kernels(const char* name);

/** Rows [first_row, first_row + num_rows) of the undistorted image; even
 * numbers if the format's rows come in pairs (NV12, YUV420, Bayer). */
typedef struct rg_target {
  /** A plane of the undistorted image. */
  struct {
    uint8_t* data;      /**< address of first_row, or of its chroma row */
    uint32_t stride;    /**< bytes per row, below 2^31 */
  } planes[3];          /**< planes of the format; unused ones are ignored */
  uint16_t first_row;   /**< first row to write */
  uint16_t num_rows;    /**< number of rows to write */
  rg_border border;     /**< value of pixels without a source */
  rg_sampling sampling; /**< interpolation */
  uint16_t border_values[4]; /**< by channel, in units of the samples: RGB in
                                memory order; RGB565 red to 31, green to 63,
                                blue to 31; formats with chroma Y, then the two
                                chroma channels in memory order; Bayer as in
                                the top-left 2 x 2 pixels */
  const rg_kernels* kernels; /**< NULL: rg_find_kernels(NULL) on each call */
} rg_target;

/** Undistorts rows of a frame with the selected table; bit-identical on every
 * processor (formats/SPEC.md, "Remap arithmetic"). Bands of rows may be written
 * in any order and by several threads. A plane of the target must not overlap
 * another plane or the frame, but rows of planes with equal stride may be side
 * by side.
 *
 * @param camera an open camera with a selected table
 * @param image the frame, of the size that rg_frame_size() returns
 * @param target rows to write, with border and interpolation
 * @retval RG_OK done
 * @retval RG_ERR_NO_REMAP no remap table is selected
 * @retval RG_ERR_FORMAT unknown format, border or sampling, or
 *     RG_BORDER_CLAMP with a ring buffer
 * @retval RG_ERR_FRAME_SIZE the frame's size is not the source size of the
 *     table or not a multiple required by the format, or a stride is too small
 *     or 2^31 or more
 * @retval RG_ERR_MISALIGNED 16-bit samples or words at an odd address or with
 *     an odd stride
 * @retval RG_ERR_ROWS the rows exceed the output, or split a pair of rows
 * @retval RG_ERR_OVERLAP a plane of the target overlaps another plane
 * @retval RG_ERR_ROWS_MISSING the ring buffer lacks source rows of the band;
 * see rg_remap_source_rows() */
rg_status rg_remap(const rg_camera* camera, const rg_image* image,
                   const rg_target* target);

/** Gets the source rows that a band of the undistorted image needs, except for
 * clamped pixels: no needed row is missing, and at most one at either end is
 * not needed (one pair if rows come in pairs).
 *
 * @param camera an open camera with a selected table
 * @param format pixel format of the frames
 * @param first_row first row of the band
 * @param num_rows number of rows of the band
 * @param[out] first_source first source row; written only if RG_OK is returned
 * @param[out] num_source number of source rows, 0 for a band without source
 *     pixels; written only if RG_OK is returned
 * @retval RG_OK done
 * @retval RG_ERR_NO_REMAP no remap table is selected
 * @retval RG_ERR_FORMAT unknown format
 * @retval RG_ERR_ROWS the rows exceed the output, or split a pair of rows
 * @retval RG_ERR_FRAME_SIZE the format's rows come in pairs, and the height of
 *     the frames or of the undistorted image is odd */
rg_status rg_remap_source_rows(const rg_camera* camera, rg_format format,
                               uint16_t first_row, uint16_t num_rows,
                               uint16_t* first_source, uint16_t* num_source);

/** An 8-bit grey frame (libcamera R8, V4L2 GREY), for rg_remap_grey(). */
typedef struct rg_grey_image {
  const uint8_t* data; /**< row 0 */
  uint32_t stride;     /**< bytes per row, at least width and below 2^31 */
  uint16_t width;      /**< pixels */
  uint16_t height;     /**< pixels */
} rg_grey_image;

/** Rows [first_row, first_row + num_rows) of an undistorted 8-bit grey image,
 * for rg_remap_grey(). */
typedef struct rg_grey_target {
  uint8_t* data;      /**< where first_row is written */
  uint32_t stride;    /**< bytes per row, at least the image's width and below
                         2^31 */
  uint16_t first_row; /**< first row to write */
  uint16_t num_rows;  /**< number of rows to write */
  uint8_t border;     /**< value of pixels without a source */
} rg_grey_target;

/** Undistorts rows of a grey frame with rg_remap() and bilinear interpolation.
 *
 * @param camera an open camera with a selected table
 * @param frame the frame, of the size that rg_frame_size() returns
 * @param band rows to write, and the border value
 * @return as rg_remap() */
rg_status rg_remap_grey(const rg_camera* camera, const rg_grey_image* frame,
                        const rg_grey_target* band);

/** @}
 * @name Updates in two flash slots
 * @{ */

/** A blob in one of two flash slots (formats/SPEC.md, "Slots"). */
typedef struct rg_slot {
  const void* blob;   /**< in place, for rg_camera_open() */
  uint32_t num_bytes; /**< size of the blob */
  uint32_t sequence;  /**< higher in the newer slot, wrapping around */
  uint32_t index;     /**< 0: in the first slot, 1: in the second */
} rg_slot;

/** Finds the newest complete blob in two slots, either of which may be erased,
 * damaged or partly written. Reads nothing outside the slots, whatever they
 * contain. rg_camera_open() and rg_match() check that the bytes are a blob of
 * this camera; if they reject it, pass only the other slot. Write the next blob
 * to the slot that is not in use, even if it is the newest: otherwise a power
 * loss leaves none. The bytes are not authenticated: that requires a signature.
 *
 * Cost: one pass over both blobs for their CRCs.
 *
 * @param first slot_size bytes, aligned to 4; NULL: ignored, such as a slot
 *     whose blob rg_camera_open() rejected
 * @param second likewise
 * @param slot_size bytes of a slot, more than the 64 of its header
 * @param[out] newest the newest slot, the first one if both have the same
 *     sequence; written only if RG_OK is returned
 * @retval RG_OK done
 * @retval RG_ERR_MISALIGNED a slot is not aligned to 4 bytes
 * @retval RG_ERR_ARGUMENT newest is NULL, or slot_size too small
 * @retval RG_ERR_NO_SLOT neither slot contains a complete blob */
rg_status rg_select_slot(const void* first, const void* second,
                         uint32_t slot_size, rg_slot* newest);

/** Makes the header of a slot, for devices that write blobs themselves: erase
 * the slot, starting with its first bytes, write the blob from byte 64 on, and
 * the header last. A power loss at any moment is safe.
 *
 * @param blob the blob
 * @param num_bytes size of the blob, at most the slot's size less 64
 * @param sequence one more than the other slot's; may wrap around
 * @param[out] header 64 bytes; written only if RG_OK is returned
 * @retval RG_OK done
 * @retval RG_ERR_ARGUMENT a pointer is NULL, or num_bytes 0 */
rg_status rg_make_slot_header(const void* blob, uint32_t num_bytes,
                              uint32_t sequence, uint32_t header[16]);

/** @} */

/* ---- Deprecated names ---------------------------------------------------- */

#if !defined(RAYGRID_NO_DEPRECATED)
/** @name Deprecated names
 * Names of version 0.2, which remain valid until the next minor version.
 * RAYGRID_NO_DEPRECATED, defined before this header is included, removes them.
 * @{ */
/** @deprecated Use rg_set_operating_point(). */
#define rg_set_condition rg_set_operating_point
/** @deprecated Use rg_line_delay(). */
#define rg_row_time rg_line_delay
/** @deprecated Use rg_select_ray_kernels(). */
#define rg_choose_ray_kernels rg_select_ray_kernels
/** @deprecated Use rg_select_slot(). */
#define rg_choose_slot rg_select_slot
/** @deprecated Use rg_grey_image. */
#define rg_frame rg_grey_image
/** @deprecated Use rg_grey_target. */
#define rg_band rg_grey_target
/** @} */
#endif

/* ---- End of deprecated names --------------------------------------------- */

#if defined(__GNUC__)
#pragma GCC visibility pop
#endif
#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_RAYGRID_H */
