/* raygrid on the board: from pixels to rays, and from frames to undistorted
 * frames. C99, integers only, no allocation, no globals, no library calls.
 *
 *   rg_camera camera;
 *   if (rg_camera_open(&camera, blob, blob_size) != RG_OK) ...;
 *   rg_pixel pixel = {RG_PIXEL(320), RG_PIXEL(240)};
 *   rg_ray ray;
 *   if (rg_unproject(&camera, pixel, &ray) == RG_OK) ...;
 *
 * Conventions: pixel (0, 0) is the centre of the top-left pixel; camera axes
 * are x right, y down, z forward. A name's suffix _qN says that the integer
 * holds the value times 2^N. */
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

#define RAYGRID_VERSION_MAJOR 0
#define RAYGRID_VERSION_MINOR 2
#define RAYGRID_VERSION_PATCH 0

/* A whole number of pixels in q16. */
#define RG_PIXEL(n) ((int32_t)((n)*65536))

/* An open camera: at most 64 bytes, owned by the caller, only read after
 * opening, so threads and interrupt handlers may share it. The fields are not
 * for use outside the library. */
typedef struct rg_camera {
  const uint8_t* blob;
  const uint8_t* grid;    /* a section, or its like in a knot */
  const uint8_t* inverse; /* likewise; this and others are NULL where there is
                             none */
  const uint8_t* line_points; /* not the section, but its first point */
  const uint8_t* remap;       /* the section in use, never its like in a knot */
  const struct rg_stack_code* stack;  /* NULL: no condition was set */
  uint32_t knot_shift;                /* bytes from the blob's own sections to
                                         their like in the knot in use */
  uint32_t knot_size;                 /* bytes from one knot to the next */
  uint16_t frame_width, frame_height; /* frames that the table takes */
  uint16_t weight_q14;                /* of the knot above the one in use; 0: it
                                         does not count */
  uint16_t surface;                   /* the kernels of rays */
} rg_camera;

typedef struct rg_pixel {
  int32_t x_q16, y_q16;
} rg_pixel;

/* A direction in camera axes. */
typedef struct rg_ray {
  int32_t x_q30, y_q30, z_q30;
} rg_ray;

/* Validates a blob and prepares a camera that reads it in place; no remap table
 * is in use yet.
 *
 * bytes   multiple of 4; must stay where it is while the camera is in use.
 * RG_OK, or the first fault found (rg_status.h); the camera is then untouched.
 * Cost: one pass over the blob for its CRCs. */
rg_status rg_camera_open(rg_camera* camera, const void* bytes,
                         uint32_t num_bytes);

/* Chooses what computes this camera's rays and projections; all gives the same
 * bits. Not while others use the camera.
 *
 * name  NULL, the fastest that the processor has, as rg_camera_open() does;
 *       "portable"; or "avx2", on x86-64
 *
 * RG_OK, or RG_ERR_ARGUMENT for what is not there; then no change. */
rg_status rg_choose_ray_kernels(rg_camera* camera, const char* name);

/* Turns an image position into the direction it looks at: the cubic B-spline
 * surface of the paper's central model (section "Camera Model") in
 * stereographic coordinates.
 *
 * ray   unit length within 4e-8; written only when RG_OK is returned.
 *
 * RG_OK                done
 * RG_ERR_OUTSIDE_AREA  pixel lies outside the calibrated area
 * RG_ERR_NONCENTRAL    the camera has lines, not rays: rg_unproject_line()
 *
 * No loop depends on the data; cost per core in runtime/COST.md. */
rg_status rg_unproject(const rg_camera* camera, rg_pixel pixel, rg_ray* ray);

/* A line in space: from the point, in metres, along the direction. */
typedef struct rg_line {
  int32_t point_q28[3]; /* x, y, z in camera axes */
  rg_ray direction;
} rg_line;

/* rg_unproject() for any camera: the line that an image position sees. The
 * point of a central camera is (0, 0, 0).
 *
 * line  point within 7e-8 m of the B-spline; written only when RG_OK is
 *       returned. RG_ERR_OUTSIDE_AREA as above. */
rg_status rg_unproject_line(const rg_camera* camera, rg_pixel pixel,
                            rg_line* line);

/* 1 if the pixel lies in the calibrated area, and in a part of it that the
 * blob's mask, if there is one, calls valid. */
int rg_is_valid(const rg_camera* camera, rg_pixel pixel);

/* How much later than the row above it a rolling shutter reads a row of frames
 * as calibrated: row r is read row_time (r - (height - 1) / 2) later than the
 * frame's middle. Frames of other modes have rows of their own.
 *
 * row_time_ns_q10   q10 nanoseconds, of magnitude at most 2^30, a millisecond;
 *                   negative where the last row is read first, about 0 of a
 *                   global shutter. Written only when RG_OK is returned.
 * deviation_ns_q10  its standard deviation; 0: not known. May be NULL.
 *
 * RG_ERR_UNKNOWN    the blob does not say: raygrid calibrate --rolling-shutter
 * RG_ERR_SECTION_SIZE, RG_ERR_ROW_TIME: a forged one, not checked on opening */
rg_status rg_row_time(const rg_camera* camera, int32_t* row_time_ns_q10,
                      uint32_t* deviation_ns_q10);

/* The standard deviation of projection at a pixel, in q12 pixels.
 * RG_ERR_UNKNOWN where the blob does not say, RG_ERR_OUTSIDE_AREA;
 * RG_ERR_UNCERTAINTY where a forged one would be read beyond its values. */
rg_status rg_uncertainty(const rg_camera* camera, rg_pixel pixel,
                         uint16_t* pixels_q12);

/* rg_unproject() for num_pixels pixels. Rays outside the area become (0, 0, 0).
 * Returns how many pixels lay inside. */
uint32_t rg_unproject_batch(const rg_camera* camera, const rg_pixel* pixels,
                            rg_ray* rays, uint32_t num_pixels);

/* rg_unproject_batch() for a row of pixels: first, and those to the right of
 * it, one pixel apart. */
uint32_t rg_unproject_row(const rg_camera* camera, rg_pixel first, rg_ray* rays,
                          uint32_t num_pixels);

/* rg_unproject_line() for num_pixels pixels. Lines of those outside the area
 * become zeros. Returns how many pixels lay inside. */
uint32_t rg_unproject_lines(const rg_camera* camera, const rg_pixel* pixels,
                            rg_line* lines, uint32_t num_pixels);

/* Turns a direction into the image position that sees it: rg_unproject() the
 * other way round. The blob's inverse grid says where about that is and how it
 * changes: one step from there is the rule, and five are the most.
 *
 * direction  camera axes, any length but zero: also a 3-D point, in any unit
 *            and number format that its three coordinates share.
 * pixel      within 0.002 px of the surface's exact inverse; written only when
 *            RG_OK is returned.
 *
 * RG_OK                done
 * RG_ERR_NOT_SEEN      no pixel of the calibrated area looks there, or only one
 *                      151 degrees from the z axis or more
 * RG_ERR_NONCENTRAL    the camera has lines, not rays: rg_project_point()
 * RG_ERR_NO_INVERSE    the blob has no inverse grid: it is from before format
 *                      1.3, or of a camera that no such grid leads back to
 *
 * Cost per core in runtime/COST.md. */
rg_status rg_project(const rg_camera* camera, const rg_ray* direction,
                     rg_pixel* pixel);

/* rg_project() for num_points directions or points. Pixels of those not seen
 * become RG_NO_PIXEL twice. Returns how many are seen. */
uint32_t rg_project_batch(const rg_camera* camera, const rg_ray* directions,
                          rg_pixel* pixels, uint32_t num_points);

/* Turns a 3-D point into the image position that sees it, for any camera: of a
 * camera of lines, the one whose line goes through the point.
 *
 * point          x, y, z in camera axes, in metres times 2^fraction_bits, all
 *                less than 2^30 in magnitude: 64 m with 24 bits, 1 km with 20
 * fraction_bits  0 to RG_POINT_MAX_BITS, the more the better
 * pixel          within 0.002 px of the one whose line, by rg_unproject_line(),
 *                goes through a point at most two steps of that format away;
 *                written only when RG_OK is returned
 *
 * For that, lines that differ by a radian must pass the camera's centre at
 * places that differ by less than a sixth of the point's distance, and all of
 * them within a tenth of it times the sine of half the field of view.
 *
 * RG_ERR_ARGUMENT      more fraction_bits
 * RG_OK, or what rg_project() returns instead, but not RG_ERR_NONCENTRAL.
 *
 * Cost: three to four rg_project() and two to three rg_unproject_line() where
 * those places differ by hundredths of the distance; near the edge of the area,
 * or outside of it, up to 24 and 12. One rg_project() of a central camera. */
rg_status rg_project_point(const rg_camera* camera, const int32_t point[3],
                           uint32_t fraction_bits, rg_pixel* pixel);

#define RG_POINT_MAX_BITS 27u

/* A coordinate that no pixel has. */
#define RG_NO_PIXEL INT32_MIN

/* A sensor mode: how its frames lie in the frames that were calibrated. Its
 * pixel (i, j), counted from the other side where flipped, covers the
 * calibrated pixels from (offset + scale i) on, scale of them a side: a crop
 * has scale 1, binning by two, or a scaler that halves, has scale 2. */
typedef struct rg_mode {
  uint16_t width, height;
  int32_t offset_x_q16, offset_y_q16; /* calibrated pixels */
  uint32_t scale_x_q16, scale_y_q16;  /* 1/64 to 64 */
  uint8_t flip_x, flip_y;
} rg_mode;

/* A position in the mode's frames to one in calibrated frames, for
 * rg_unproject(), and back from rg_project(); within 0.0001 px.
 *
 * RG_ERR_ARGUMENT  an impossible mode, or a position 16384 px away or more */
rg_status rg_mode_to_calibrated(const rg_mode* mode, rg_pixel pixel,
                                rg_pixel* calibrated);
rg_status rg_mode_from_calibrated(const rg_mode* mode, rg_pixel calibrated,
                                  rg_pixel* pixel);

typedef enum rg_match_result {
  RG_MATCH_EXACT,     /* frames are as calibrated */
  RG_MATCH_MODE,      /* positions are, through the mode, and the blob has a
                         table for frames of it */
  RG_MATCH_DERIVABLE, /* positions are, through the mode; frames can not be
                         remapped */
  RG_MATCH_NONE       /* another camera, or not known how the frames lie */
} rg_match_result;

/* Whether a blob is for the frames at hand, and which of its tables is.
 *
 * mode    NULL: not known. Sizes alone do not tell crops from binning.
 * width, height  of a frame
 * serial  zero-terminated, or NULL: not known. A blob without a serial is for
 *         any camera.
 * remap   where the index goes of the first table that undistorts such frames,
 *         or RG_NO_TABLE; or NULL. A mode is that of a table if offsets and
 *         scales differ by no more than they are rounded by: 1. */
rg_match_result rg_match(const rg_camera* camera, const rg_mode* mode,
                         uint16_t width, uint16_t height, const char* serial,
                         uint32_t* remap);

#define RG_NO_TABLE UINT32_MAX

/* Validates the index-th remap table of the blob, counted from 0, and makes it
 * the one in use: before the first frame, or point of an undistorted one. Not
 * while others use the camera.
 *
 * RG_OK, RG_ERR_NO_REMAP if there is none, or the first fault found; then no
 * change. Cost: one pass over the table on Linux and 64-bit processors, which
 * refuse RG_ERR_REMAP_VERTEX; others do not look for it, and do no harm. */
rg_status rg_select_remap(rg_camera* camera, uint32_t index);

/* Makes the camera that of a condition, of a blob with a stack of cameras: the
 * position of the lens, or the temperature of the sensor, as raygrid inspect
 * tells. Rays, projections and frames are blended between the two knots around
 * it, from then on, also with a table that is chosen later. Before a frame; not
 * while others use the camera. rg_camera_open() undoes it.
 *
 * value_q16  dioptres, or degrees Celsius; the unit is that of the stack
 *
 * RG_OK            done
 * RG_EXTRAPOLATED  done, but the value lies outside the stack's range: the
 *                  camera is that of the nearest end of the range
 * RG_ERR_NO_STACK, or the first fault found; then no change.
 *
 * The first call checks the grids of all knots, and the table in use as
 * rg_select_remap() does. Others only read the knots' values. */
rg_status rg_set_condition(rg_camera* camera, int32_t value_q16);

/* Size of the undistorted image; RG_ERR_NO_REMAP if no table is in use. */
rg_status rg_remap_size(const rg_camera* camera, uint16_t* width,
                        uint16_t* height);

/* Size of the frames that rg_remap() takes with the table in use: as
 * calibrated, or of another mode. As calibrated if no table is in use. */
void rg_frame_size(const rg_camera* camera, uint16_t* width, uint16_t* height);

/* Size of the frames that were calibrated, which positions lie in. */
void rg_calibrated_size(const rg_camera* camera, uint16_t* width,
                        uint16_t* height);

/* How the camera's frames of the table in use lie in those that were
 * calibrated: the frames that rg_remap() takes or, of a table that distorts,
 * the ones that it makes. width and height are theirs in both cases, and not
 * those of rg_frame_size() if the table distorts: it takes pictures of the
 * view. RG_ERR_NO_REMAP if no table is in use. */
rg_status rg_remap_mode(const rg_camera* camera, rg_mode* mode);

/* The virtual camera that the undistorted image seems to come from: it stands
 * where the real one does. Of a table that distorts, the one that its source is
 * from. */
typedef struct rg_view {
  uint16_t width, height;
  rg_projection projection;
  uint32_t fx_q16, fy_q16; /* K, in pixels; pixels per radian in the middle */
  int32_t cx_q16, cy_q16;
  int32_t rotation_q30[9]; /* a direction in axes of the view to one in camera
                              axes, row by row */
  uint8_t
      distorts; /* 1: the table makes frames of the camera out of the view */
} rg_view;

/* The view of the table in use; RG_ERR_NO_REMAP if there is none. */
rg_status rg_remap_view(const rg_camera* camera, rg_view* view);

/* Moves an image position, in calibrated frames, to where it lies in the
 * undistorted image, whether that is inside it or not. Of a camera of lines:
 * where it does if what it sees is far away, as for frames, unless their table
 * is for scenes at a distance.
 *
 * undistorted  within 6e-6 of the virtual camera's focal length (0.003 px if
 *              that is 500 px): of a pinhole up to 85 degrees from its z axis,
 *              of a cylinder up to 85 degrees above and below, of a
 *              stereographic view up to 140 degrees from its z axis (within
 *              1e-4 up to 170), of others up to 170; written only when RG_OK is
 *              returned.
 *
 * RG_OK                done
 * RG_ERR_NO_REMAP      no remap table is in use, and so no virtual camera
 * RG_ERR_OUTSIDE_AREA  pixel lies outside the calibrated area
 * RG_ERR_NOT_SEEN      it looks where the view shows nothing, as backwards in a
 *                      pinhole's, or comes to lie 16384 px or more away from
 *                      pixel (0, 0) or the virtual camera's centre */
rg_status rg_undistort_point(const rg_camera* camera, rg_pixel pixel,
                             rg_pixel* undistorted);

/* rg_undistort_point() for num_points pixels. Points of those that have none
 * become RG_NO_PIXEL twice. Returns how many have one. */
uint32_t rg_undistort_points(const rg_camera* camera, const rg_pixel* pixels,
                             rg_pixel* undistorted, uint32_t num_points);

/* The contents of frames; the undistorted frame holds the same. The order of
 * colours does not matter: the names in brackets are the same to this library.
 * Samples of more than 8 bits are little-endian, words of RGB565 too. Packed
 * samples are as on CSI-2.
 *
 * Widths of formats from YUYV to BAYER12P are even; those of 10-bit packed ones
 * are multiples of 4, of 12-bit packed ones of 2. Heights of NV12, YUV420 and
 * Bayer are even, since their rows come in pairs. */
typedef enum rg_format {
  RG_FORMAT_GREY8,   /* GREY, R8 */
  RG_FORMAT_GREY16,  /* Y10, Y12, Y14, Y16: in the low bits of 16 */
  RG_FORMAT_GREY10P, /* Y10P */
  RG_FORMAT_GREY12P, /* Y12P */
  RG_FORMAT_RGB24,   /* RGB888 (BGR888) */
  RG_FORMAT_RGB32,   /* XRGB8888 (any four interleaved channels) */
  RG_FORMAT_YUYV,    /* (YVYU) */
  RG_FORMAT_UYVY,    /* (VYUY) */
  RG_FORMAT_NV12,    /* (NV21) two planes */
  RG_FORMAT_YUV420,  /* (YVU420) three planes */
  RG_FORMAT_BAYER8,  /* (any order), each colour on its own lattice */
  RG_FORMAT_BAYER16, /* 10, 12, 14 or 16 bits in the low bits of 16 */
  RG_FORMAT_BAYER10P,
  RG_FORMAT_BAYER12P,
  RG_FORMAT_RGB565, /* RGBP: words of 16 bits, red in the high 5, then green in
                       6, blue in 5 */
  RG_NUM_FORMATS
} rg_format;

/* A frame, or a part of it in a ring of rows. Row r of a plane of full height
 * lies at data + (r mod ring_rows) stride; a chroma plane of half height has a
 * ring of half the rows. */
typedef struct rg_image {
  rg_format format;
  uint16_t width, height;       /* of the whole frame */
  uint16_t ring_rows;           /* 0: no ring, the whole frame is there */
  uint16_t first_row, num_rows; /* in a ring: rows that are there, at most
                                   ring_rows */
  struct {
    const uint8_t* data;
    uint32_t stride; /* bytes from one row to the next, less than 2^31 */
  } planes[3];
} rg_image;

/* The values of pixels that the camera does not see, or that lie outside the
 * calibrated area. */
typedef enum rg_border {
  RG_BORDER_VALUE, /* border_values */
  RG_BORDER_CLAMP, /* the nearest pixel of the calibrated area */
  RG_BORDER_KEEP   /* what the target holds */
} rg_border;

typedef enum rg_sampling {
  RG_SAMPLING_BILINEAR,
  RG_SAMPLING_NEAREST
} rg_sampling;

/* The inner loops for a kind of processor; all give the same bits. Boards
 * without Linux have them built in, and this is not used: RG_PORTABLE_KERNELS,
 * defined as 1 for all files, then says that they be portable. */
typedef struct rg_kernels rg_kernels;

/* By name, for measurements and tests: "portable", "sse4", "avx2", "avx512",
 * "neon", "rvv"; the fastest of this processor for NULL, found by instructions
 * that may take a microsecond in a virtual machine. NULL if there is none of
 * that name. */
const rg_kernels* rg_find_kernels(const char* name);

/* Rows [first_row, first_row + num_rows) of the undistorted image; even numbers
 * where the format's rows come in pairs (NV12, YUV420, Bayer). */
typedef struct rg_target {
  struct {
    uint8_t* data;   /* where first_row goes, or the chroma row of it */
    uint32_t stride; /* less than 2^31 */
  } planes[3];
  uint16_t first_row, num_rows;
  rg_border border;
  rg_sampling sampling;
  uint16_t border_values[4]; /* of each channel: RGB as it lies in memory; of
                                RGB565 red to 31, green to 63, blue to 31; where
                                there is chroma, packed or not, Y, then the
                                chroma that comes first in memory, and the other
                                one; Bayer as in the top-left 2 x 2 pixels */
  const rg_kernels* kernels; /* NULL: found anew by each call */
} rg_target;

/* Undistorts rows of a frame (formats/SPEC.md, "Remap arithmetic": every target
 * gives the same bits). Bands may be asked for in any order and, into different
 * memory, by several threads. A plane of the target must not overlap another
 * one nor the frame; rows of planes with one stride may lie beside each other.
 *
 * RG_ERR_NO_REMAP      no remap table is in use
 * RG_ERR_FORMAT        unknown format, border or sampling; clamping from a ring
 * RG_ERR_FRAME_SIZE    frame is not of the table's size, a stride is too small
 *                      or 2^31 bytes or more, a size not a multiple of what the
 *                      format wants
 * RG_ERR_MISALIGNED    samples or words of 16 bits at an odd address, or with
 *                      an odd stride
 * RG_ERR_ROWS          the band ends below the output, or cuts a pair of rows
 * RG_ERR_OVERLAP       a plane of the target lies in another plane
 * RG_ERR_ROWS_MISSING  the ring does not hold the rows that the band needs */
rg_status rg_remap(const rg_camera* camera, const rg_image* image,
                   const rg_target* target);

/* The source rows that rows [first_row, first_row + num_rows) of the output
 * need, clamped pixels apart: none is missing, and at most one at either end is
 * not needed (a pair where rows come in pairs). *num_source is 0 for a band
 * without any source.
 *
 * RG_ERR_NO_REMAP, RG_ERR_FORMAT, RG_ERR_ROWS as above; RG_ERR_FRAME_SIZE where
 * rows come in pairs, and the height of the camera's image or that of the
 * undistorted one is odd. */
rg_status rg_remap_source_rows(const rg_camera* camera, rg_format format,
                               uint16_t first_row, uint16_t num_rows,
                               uint16_t* first_source, uint16_t* num_source);

/* An 8-bit grey image (libcamera R8, V4L2 GREY). */
typedef struct rg_frame {
  const uint8_t* data; /* first row */
  uint32_t stride; /* bytes from one row to the next, at least width and less
                      than 2^31 */
  uint16_t width, height;
} rg_frame;

/* Rows [first_row, first_row + num_rows) of the undistorted image. */
typedef struct rg_band {
  uint8_t* data;   /* where first_row goes */
  uint32_t stride; /* likewise, of the undistorted image */
  uint16_t first_row, num_rows;
  uint8_t border; /* value where the camera sees nothing, or is uncalibrated */
} rg_band;

/* rg_remap() of a grey frame, bilinear; with the same statuses. */
rg_status rg_remap_grey(const rg_camera* camera, const rg_frame* frame,
                        const rg_band* band);

/* A blob in one of two slots of flash (formats/SPEC.md, "Slots"). */
typedef struct rg_slot {
  const void* blob; /* in place, for rg_camera_open() */
  uint32_t num_bytes;
  uint32_t sequence;
  uint32_t index; /* 0: in the first slot, 1: in the second */
} rg_slot;

/* Finds the newest whole blob of two slots, of which one may be erased, damaged
 * or half written. Whether the bytes are a blob of this camera,
 * rg_camera_open() and rg_match() say; if they refuse it, look at the other
 * slot alone. Write the next blob to the slot that is not in use, which may be
 * the newest: else a cut of power leaves none. Who wrote the bytes nothing here
 * says: signatures are for what boots the device.
 *
 * first, second  multiples of 4, slot_size bytes each. NULL: not looked at, as
 *                a slot whose blob rg_camera_open() refuses.
 * slot_size      bytes, more than a slot's header has
 * newest         written only when RG_OK is returned; of two with the same
 *                sequence the first
 *
 * RG_OK, RG_ERR_MISALIGNED, RG_ERR_ARGUMENT, or RG_ERR_NO_SLOT if neither slot
 * has a whole blob. Nothing outside the slots is read, whatever they hold.
 * Cost: one pass over both blobs for their CRCs. */
rg_status rg_choose_slot(const void* first, const void* second,
                         uint32_t slot_size, rg_slot* newest);

/* The header of a slot, for devices that write blobs by themselves: erase the
 * slot, its first bytes first, then write the blob from byte 64 on, and the
 * header last. Power may be cut at any moment of that.
 *
 * num_bytes  of the blob, at most the slot's size less 64
 * sequence   that of the slot that stays plus 1, which may wrap around
 * header     64 bytes; written only when RG_OK is returned
 *
 * RG_OK, or RG_ERR_ARGUMENT for null pointers or no bytes. */
rg_status rg_make_slot_header(const void* blob, uint32_t num_bytes,
                              uint32_t sequence, uint32_t header[16]);

#if defined(__GNUC__)
#pragma GCC visibility pop
#endif
#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_RAYGRID_H */
