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
 * leaves its outputs untouched. */
typedef enum rg_status {
  RG_OK = 0, /**< success */

  /* The call itself. */
  RG_ERR_ARGUMENT = -1,   /**< a null pointer or an impossible value */
  RG_ERR_MISALIGNED = -2, /**< the blob is not aligned to 4 bytes, or 16-bit
                             samples are not aligned to 2 */
  RG_ERR_BUFFER_TOO_SMALL = -3, /**< the buffer cannot hold the blob */

  /* Header and section table (formats/SPEC.md, "Header"). */
  RG_ERR_TRUNCATED = -10,       /**< fewer bytes than the header states */
  RG_ERR_MAGIC = -11,           /**< not a raygrid blob */
  RG_ERR_VERSION = -12,         /**< unsupported major format version */
  RG_ERR_HEADER = -13,          /**< invalid header size, total size or section
                                   count */
  RG_ERR_HEADER_CRC = -14,      /**< CRC mismatch in the header or the section
                                   table */
  RG_ERR_SECTION_TABLE = -15,   /**< sections overlap, leave gaps, or exceed the
                                   blob */
  RG_ERR_SECTION_FLAGS = -16,   /**< unknown flags, or flags invalid for the
                                   section type */
  RG_ERR_SECTION_CRC = -17,     /**< CRC mismatch in a section */
  RG_ERR_SECTION_UNKNOWN = -18, /**< a critical section of unknown type */
  RG_ERR_SECTION_DUPLICATE = -19, /**< two sections of a type that is allowed
                                     once */
  RG_ERR_SECTION_MISSING = -20,   /**< no camera section, or no grid section */
  RG_ERR_SECTION_SIZE = -21, /**< section size inconsistent with its counts */
  RG_ERR_RESERVED = -22,     /**< reserved field or padding not zero */

  /* Fields of the sections (formats/SPEC.md, "Sections"). */
  RG_ERR_IMAGE_SIZE = -30, /**< invalid image width or height */
  RG_ERR_TEXT = -31,       /**< name or serial not padded with zeros */
  RG_ERR_AREA = -32, /**< a grid's area is empty, or exceeds the image or the
                        chart */
  RG_ERR_GRID_SIZE = -33,     /**< invalid number of control points */
  RG_ERR_GRID_SCALE = -34,    /**< knots per pixel inconsistent with area and
                                 size */
  RG_ERR_GRID_CHART = -35,    /**< unknown chart or number of fraction bits */
  RG_ERR_CONTROL_POINT = -36, /**< a control point exceeds the chart's limit */
  RG_ERR_REMAP_SIZE = -37,    /**< invalid output or source size of a remap
                                 table */
  RG_ERR_REMAP_BLOCK = -38,   /**< invalid block size, tile size or vertex
                                 count of a remap table */
  RG_ERR_REMAP_SHIFT = -39,   /**< invalid residual or bend shift of a
                                 remap table */
  RG_ERR_REMAP_SOURCE = -40,  /**< source rectangle of a remap table empty or
                                 outside the image */
  RG_ERR_REMAP_CAMERA = -41,  /**< invalid focal length, projection or rotation
                                 of the virtual camera */
  RG_ERR_REMAP_VERTEX = -42,  /**< a remap vertex more than 8192 px from pixel
                                 (0, 0) */
  RG_ERR_DATA_OFFSET = -43,   /**< an array does not start after the fields */
  RG_ERR_LINE_POINT = -46,    /**< line points of a non-central camera: invalid
                                 number of fraction bits, or a point too far */
  RG_ERR_MASK = -47,          /**< validity mask: invalid cell size or counts */
  RG_ERR_UNCERTAINTY = -48,   /**< uncertainty: invalid counts or scale */
  RG_ERR_MODE = -49,    /**< invalid sensor mode, or one of a remap table that
                           does not exist */
  RG_ERR_CAPTURE = -61, /**< invalid capture settings, or a value in a field
                           marked as unknown */
  RG_ERR_STACK = -62,   /**< stack of operating points: invalid samples, or ones
                           inconsistent with the blob's own sections */
  RG_ERR_ROW_TIME = -65, /**< line delay or its standard deviation above 1 ms */

  /* Use of an open camera. */
  RG_ERR_OUTSIDE_AREA = -50, /**< pixel outside the calibrated area */
  RG_ERR_NO_REMAP = -51,     /**< no such remap table, or none selected */
  RG_ERR_FRAME_SIZE = -52,   /**< frame size or stride does not match the remap
                                table */
  RG_ERR_ROWS = -53,         /**< rows exceed the output, or split a pair */
  RG_ERR_NOT_SEEN = -54,     /**< the direction or point projects to no pixel of
                                the calibrated area */
  RG_ERR_FORMAT = -55,       /**< unknown pixel format, border or sampling */
  RG_ERR_ROWS_MISSING = -56, /**< source rows not in the ring buffer */
  RG_ERR_NONCENTRAL = -57,   /**< the camera is non-central: pixels observe
                                lines, not rays from one centre */
  RG_ERR_UNKNOWN = -58,      /**< the blob does not contain the value */
  RG_ERR_OVERLAP = -59,      /**< a target plane overlaps another plane */
  RG_ERR_NO_INVERSE = -60,   /**< the blob has no inverse grid; pack it again */
  RG_ERR_NO_STACK = -63,     /**< the blob has no stack of operating points */
  RG_EXTRAPOLATED = -64,     /**< not an error: the operating point is outside
                                the calibrated range and was clamped to it */

  /* Slots (formats/SPEC.md, "Slots"). */
  RG_ERR_NO_SLOT = -70 /**< neither slot contains a complete blob */
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
