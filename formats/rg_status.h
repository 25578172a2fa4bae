/** @file
 * Status codes of the raygrid C libraries. */
#ifndef RAYGRID_RG_STATUS_H
#define RAYGRID_RG_STATUS_H

#ifdef __cplusplus
extern "C" {
#endif
#if defined(__GNUC__)
#pragma GCC visibility push(default)
#endif

/** Result of a call: 0 is success, errors are negative. A call that fails
 * leaves its outputs untouched. rg_status_text() returns the first sentence of
 * a comment; tools/blob_format writes rg_status.c from them. */
typedef enum rg_status {
  RG_OK = 0, /**< success */

  /* The call itself. */
  RG_ERR_ARGUMENT =
      -1, /**< invalid argument. A null pointer, or an impossible value */
  RG_ERR_MISALIGNED = -2, /**< blob is not aligned to 4 bytes, or 16-bit samples
                             are not aligned to 2 bytes */
  RG_ERR_BUFFER_TOO_SMALL = -3, /**< buffer too small for the blob */

  /* Header and section table (formats/SPEC.md, "Header"). */
  RG_ERR_TRUNCATED = -10, /**< blob is truncated */
  RG_ERR_MAGIC = -11,     /**< not a raygrid blob */
  RG_ERR_VERSION = -12,   /**< unsupported format version */
  RG_ERR_HEADER =
      -13, /**< header size, total size or section count out of range */
  RG_ERR_HEADER_CRC = -14,      /**< header or section table is corrupt (CRC) */
  RG_ERR_SECTION_TABLE = -15,   /**< sections overlap or leave gaps */
  RG_ERR_SECTION_FLAGS = -16,   /**< invalid section flags */
  RG_ERR_SECTION_CRC = -17,     /**< a section is corrupt (CRC) */
  RG_ERR_SECTION_UNKNOWN = -18, /**< unknown critical section */
  RG_ERR_SECTION_DUPLICATE = -19, /**< duplicate section */
  RG_ERR_SECTION_MISSING = -20,   /**< camera or grid section missing */
  RG_ERR_SECTION_SIZE = -21, /**< section size does not match its contents */
  RG_ERR_RESERVED = -22,     /**< reserved field is not zero */

  /* Fields of the sections (formats/SPEC.md, "Sections"). */
  RG_ERR_IMAGE_SIZE = -30, /**< image size out of range */
  RG_ERR_TEXT = -31,       /**< name or serial is not zero-padded text */
  RG_ERR_AREA = -32, /**< grid area is empty or outside the image or chart */
  RG_ERR_GRID_SIZE = -33,  /**< number of control points out of range */
  RG_ERR_GRID_SCALE = -34, /**< grid scale does not match area and grid size */
  RG_ERR_GRID_CHART = -35, /**< unknown chart or number format of grid */
  RG_ERR_CONTROL_POINT = -36, /**< control point out of range */
  RG_ERR_REMAP_SIZE = -37,    /**< remap size out of range */
  RG_ERR_REMAP_BLOCK =
      -38, /**< remap block size, tile size or vertex counts out of range */
  RG_ERR_REMAP_SHIFT =
      -39, /**< remap residual or curvature shift out of range */
  RG_ERR_REMAP_SOURCE =
      -40, /**< remap source rectangle is empty or outside the image */
  RG_ERR_REMAP_CAMERA =
      -41, /**< focal length of the remap view is not positive. Or its
              projection or rotation is invalid */
  RG_ERR_REMAP_VERTEX = -42, /**< remap vertex out of range. More than 8192 px
                                from pixel (0, 0) */
  RG_ERR_DATA_OFFSET = -43,  /**< data offset of a section out of range */
  RG_ERR_LINE_POINT = -46,  /**< ray origin or its number format out of range */
  RG_ERR_MASK = -47,        /**< validity mask cells out of range */
  RG_ERR_UNCERTAINTY = -48, /**< uncertainty values or scale out of range */
  RG_ERR_MODE = -49,        /**< sensor mode out of range or missing */
  RG_ERR_CAPTURE = -61,     /**< recorded capture settings out of range */
  RG_ERR_STACK = -62, /**< operating-point samples do not match the blob */
  RG_ERR_ROW_TIME =
      -65, /**< line delay or its uncertainty out of range. Above 1 ms */

  /* Use of an open camera. */
  RG_ERR_OUTSIDE_AREA = -50, /**< pixel is outside the calibrated area */
  RG_ERR_NO_REMAP = -51,     /**< no such remap table, or none selected */
  RG_ERR_FRAME_SIZE = -52, /**< frame size or stride does not match the blob */
  RG_ERR_ROWS = -53,       /**< rows out of range or not in whole pairs */
  RG_ERR_NOT_SEEN =
      -54,             /**< direction is outside the calibrated field of view */
  RG_ERR_FORMAT = -55, /**< unknown pixel format, border or sampling */
  RG_ERR_ROWS_MISSING = -56, /**< source rows for this band are missing */
  RG_ERR_NONCENTRAL =
      -57, /**< camera is non-central: rays have no common origin */
  RG_ERR_UNKNOWN = -58, /**< not recorded in the blob */
  RG_ERR_OVERLAP = -59, /**< output plane overlaps another plane */
  RG_ERR_NO_INVERSE =
      -60, /**< no inverse grid (format before 1.3); pack the blob again */
  RG_ERR_NO_STACK = -63, /**< blob has a single operating point */
  RG_EXTRAPOLATED = -64, /**< operating point out of range: clamped to nearest
                            end. Not an error */

  /* Slots (formats/SPEC.md, "Slots"). */
  RG_ERR_NO_SLOT = -70 /**< neither slot holds a valid blob */
} rg_status;

/** Describes a status.
 *
 * @param status any value, including unknown ones
 * @return a short English text, zero-terminated, static; never NULL */
const char* rg_status_text(rg_status status);

#if defined(__GNUC__)
#pragma GCC visibility pop
#endif
#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_RG_STATUS_H */
