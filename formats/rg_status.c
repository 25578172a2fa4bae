#include "rg_status.h"

/* clang-format off */
const char* rg_status_text(rg_status status) {
  switch (status) {
    /* ---- written by tools/blob_format; not for editing ---- */
    case RG_OK: return "success";
    case RG_ERR_ARGUMENT: return "invalid argument";
    case RG_ERR_MISALIGNED: return "blob is not aligned to 4 bytes, or 16-bit samples are not aligned to 2 bytes";
    case RG_ERR_BUFFER_TOO_SMALL: return "buffer too small for the blob";
    case RG_ERR_TRUNCATED: return "blob is truncated";
    case RG_ERR_MAGIC: return "not a raygrid blob";
    case RG_ERR_VERSION: return "unsupported format version";
    case RG_ERR_HEADER: return "header size, total size or section count out of range";
    case RG_ERR_HEADER_CRC: return "header or section table is corrupt (CRC)";
    case RG_ERR_SECTION_TABLE: return "sections overlap or leave gaps";
    case RG_ERR_SECTION_FLAGS: return "invalid section flags";
    case RG_ERR_SECTION_CRC: return "a section is corrupt (CRC)";
    case RG_ERR_SECTION_UNKNOWN: return "unknown critical section";
    case RG_ERR_SECTION_DUPLICATE: return "duplicate section";
    case RG_ERR_SECTION_MISSING: return "camera or grid section missing";
    case RG_ERR_SECTION_SIZE: return "section size does not match its contents";
    case RG_ERR_RESERVED: return "reserved field is not zero";
    case RG_ERR_IMAGE_SIZE: return "image size out of range";
    case RG_ERR_TEXT: return "name or serial is not zero-padded text";
    case RG_ERR_AREA: return "grid area is empty or outside the image or chart";
    case RG_ERR_GRID_SIZE: return "number of control points out of range";
    case RG_ERR_GRID_SCALE: return "grid scale does not match area and grid size";
    case RG_ERR_GRID_CHART: return "unknown chart or number format of grid";
    case RG_ERR_CONTROL_POINT: return "control point out of range";
    case RG_ERR_REMAP_SIZE: return "remap size out of range";
    case RG_ERR_REMAP_BLOCK: return "remap block size, tile size or vertex counts out of range";
    case RG_ERR_REMAP_SHIFT: return "remap residual or curvature shift out of range";
    case RG_ERR_REMAP_SOURCE: return "remap source rectangle is empty or outside the image";
    case RG_ERR_REMAP_CAMERA: return "focal length of the remap view is not positive";
    case RG_ERR_REMAP_VERTEX: return "remap vertex out of range";
    case RG_ERR_DATA_OFFSET: return "data offset of a section out of range";
    case RG_ERR_LINE_POINT: return "ray origin or its number format out of range";
    case RG_ERR_MASK: return "validity mask cells out of range";
    case RG_ERR_UNCERTAINTY: return "uncertainty values or scale out of range";
    case RG_ERR_MODE: return "sensor mode out of range or missing";
    case RG_ERR_CAPTURE: return "recorded capture settings out of range";
    case RG_ERR_STACK: return "operating-point samples do not match the blob";
    case RG_ERR_ROW_TIME: return "line delay or its uncertainty out of range";
    case RG_ERR_OUTSIDE_AREA: return "pixel is outside the calibrated area";
    case RG_ERR_NO_REMAP: return "no such remap table, or none selected";
    case RG_ERR_FRAME_SIZE: return "frame size or stride does not match the blob";
    case RG_ERR_ROWS: return "rows out of range or not in whole pairs";
    case RG_ERR_NOT_SEEN: return "direction is outside the calibrated field of view";
    case RG_ERR_FORMAT: return "unknown pixel format, border or sampling";
    case RG_ERR_ROWS_MISSING: return "source rows for this band are missing";
    case RG_ERR_NONCENTRAL: return "camera is non-central: rays have no common origin";
    case RG_ERR_UNKNOWN: return "not recorded in the blob";
    case RG_ERR_OVERLAP: return "output plane overlaps another plane";
    case RG_ERR_NO_INVERSE: return "no inverse grid (format before 1.3); pack the blob again";
    case RG_ERR_NO_STACK: return "blob has a single operating point";
    case RG_EXTRAPOLATED: return "operating point out of range: clamped to nearest end";
    case RG_ERR_NO_SLOT: return "neither slot holds a valid blob";
    /* ---- end of what is written ---- */
  }
  return "unknown status";
}
/* clang-format on */
