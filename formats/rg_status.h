/* Every status the raygrid C libraries return: 0 is success, errors are
 * negative. A call that fails leaves its outputs untouched. */
#ifndef RAYGRID_RG_STATUS_H
#define RAYGRID_RG_STATUS_H

#ifdef __cplusplus
extern "C" {
#endif
#if defined(__GNUC__)
#pragma GCC visibility push(default)
#endif

typedef enum rg_status {
  RG_OK = 0,

  /* The call itself. */
  RG_ERR_ARGUMENT = -1,   /* a null pointer or an impossible value */
  RG_ERR_MISALIGNED = -2, /* the blob does not start at a multiple of 4, or
                             16-bit samples at one of 2 */
  RG_ERR_BUFFER_TOO_SMALL = -3, /* the writer's buffer cannot hold the blob */

  /* Header and section table (formats/SPEC.md, "Header"). */
  RG_ERR_TRUNCATED = -10,       /* fewer bytes than the header announces */
  RG_ERR_MAGIC = -11,           /* not a raygrid blob */
  RG_ERR_VERSION = -12,         /* a major version this reader does not know */
  RG_ERR_HEADER = -13,          /* header size, total size or section count */
  RG_ERR_HEADER_CRC = -14,      /* header or section table damaged */
  RG_ERR_SECTION_TABLE = -15,   /* sections overlap, leave gaps, or run out */
  RG_ERR_SECTION_FLAGS = -16,   /* flags unknown, or wrong for the type */
  RG_ERR_SECTION_CRC = -17,     /* a section's bytes are damaged */
  RG_ERR_SECTION_UNKNOWN = -18, /* a critical section of unknown type */
  RG_ERR_SECTION_DUPLICATE =
      -19,                      /* a section that may stand once stands twice */
  RG_ERR_SECTION_MISSING = -20, /* no camera section, or no grid section */
  RG_ERR_SECTION_SIZE = -21,    /* a section's size contradicts its counts */
  RG_ERR_RESERVED = -22,        /* a reserved field or padding is not zero */

  /* Fields of the sections (formats/SPEC.md, "Sections"). */
  RG_ERR_IMAGE_SIZE = -30,    /* image width or height */
  RG_ERR_TEXT = -31,          /* name or serial not padded with zeros */
  RG_ERR_AREA = -32,          /* a grid's area empty or outside image, chart */
  RG_ERR_GRID_SIZE = -33,     /* number of control points */
  RG_ERR_GRID_SCALE = -34,    /* cells per pixel contradict area and size */
  RG_ERR_GRID_CHART = -35,    /* unknown chart or fraction bits */
  RG_ERR_CONTROL_POINT = -36, /* a control point beyond the chart's limit */
  RG_ERR_REMAP_SIZE = -37,    /* size of the output, or of the source */
  RG_ERR_REMAP_BLOCK = -38,   /* block or part size, or vertex counts */
  RG_ERR_REMAP_SHIFT = -39,   /* residual or bend shift */
  RG_ERR_REMAP_SOURCE = -40,  /* source rectangle empty or outside the image */
  RG_ERR_REMAP_CAMERA = -41,  /* focal length, projection or rotation of the
                                 virtual camera */
  RG_ERR_REMAP_VERTEX =
      -42, /* a vertex farther than 8192 px from pixel (0, 0) */
  RG_ERR_DATA_OFFSET = -43, /* the array does not start after the fields */
  RG_ERR_LINE_POINT = -46,  /* line points: fraction bits, or one too large */
  RG_ERR_MASK = -47,        /* validity mask: cell size or counts */
  RG_ERR_UNCERTAINTY = -48, /* uncertainty: number of values, or its scale */
  RG_ERR_MODE = -49,    /* a sensor mode, or a table of one that is not there */
  RG_ERR_CAPTURE = -61, /* capture: a value, or one of what is not known */
  RG_ERR_STACK = -62,   /* stack: condition or knots, or a knot's fields are not
                           those of the blob's own sections */
  RG_ERR_ROW_TIME = -65, /* row time or its deviation beyond a millisecond */

  /* Use of an open camera. */
  RG_ERR_OUTSIDE_AREA = -50, /* pixel outside the calibrated area */
  RG_ERR_NO_REMAP = -51,     /* no remap table, or none is in use */
  RG_ERR_FRAME_SIZE = -52,   /* frame size or stride does not fit the blob */
  RG_ERR_ROWS = -53,         /* rows beyond the output's last, or half a pair */
  RG_ERR_NOT_SEEN = -54,     /* no pixel of the area sees the direction */
  RG_ERR_FORMAT = -55,       /* unknown pixel format, border or sampling */
  RG_ERR_ROWS_MISSING = -56, /* source rows that the ring does not hold */
  RG_ERR_NONCENTRAL = -57,   /* the camera has lines, not rays */
  RG_ERR_UNKNOWN = -58,      /* the blob does not say */
  RG_ERR_OVERLAP = -59,      /* a plane of the target lies in another plane */
  RG_ERR_NO_INVERSE = -60,   /* the blob has no inverse grid: pack it anew */
  RG_ERR_NO_STACK = -63,     /* the blob is of one condition alone */
  RG_EXTRAPOLATED = -64,     /* no fault: the condition lies outside the stack's
                                range, and its nearest end is in use */

  /* Slots (formats/SPEC.md, "Slots"). */
  RG_ERR_NO_SLOT = -70 /* neither slot has a whole blob */
} rg_status;

/* The status as a short English text, for messages; never NULL. */
const char* rg_status_text(rg_status status);

#if defined(__GNUC__)
#pragma GCC visibility pop
#endif
#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_RG_STATUS_H */
