#include "rg_status.h"

const char* rg_status_text(rg_status status) {
  switch (status) {
    case RG_OK:
      return "done";
    case RG_ERR_ARGUMENT:
      return "invalid argument";
    case RG_ERR_MISALIGNED:
      return "blob does not start at a multiple of 4 bytes, or samples of 16 "
             "bits at one of 2";
    case RG_ERR_BUFFER_TOO_SMALL:
      return "buffer too small for the blob";
    case RG_ERR_TRUNCATED:
      return "blob is truncated";
    case RG_ERR_MAGIC:
      return "not a raygrid blob";
    case RG_ERR_VERSION:
      return "unsupported format version";
    case RG_ERR_HEADER:
      return "header size, total size or section count out of range";
    case RG_ERR_HEADER_CRC:
      return "header or section table is damaged (CRC)";
    case RG_ERR_SECTION_TABLE:
      return "section table does not tile the blob";
    case RG_ERR_SECTION_FLAGS:
      return "section flags are wrong";
    case RG_ERR_SECTION_CRC:
      return "a section is damaged (CRC)";
    case RG_ERR_SECTION_UNKNOWN:
      return "unknown critical section";
    case RG_ERR_SECTION_DUPLICATE:
      return "a section stands twice";
    case RG_ERR_SECTION_MISSING:
      return "camera or grid section is missing";
    case RG_ERR_SECTION_SIZE:
      return "section size contradicts its contents";
    case RG_ERR_RESERVED:
      return "a reserved field is not zero";
    case RG_ERR_IMAGE_SIZE:
      return "image size out of range";
    case RG_ERR_TEXT:
      return "name or serial is not zero-padded text";
    case RG_ERR_AREA:
      return "a grid's area is empty, or outside the image or the chart";
    case RG_ERR_GRID_SIZE:
      return "number of control points out of range";
    case RG_ERR_GRID_SCALE:
      return "grid scale contradicts area and grid size";
    case RG_ERR_GRID_CHART:
      return "unknown chart or number format of the grid";
    case RG_ERR_CONTROL_POINT:
      return "control point out of range";
    case RG_ERR_REMAP_SIZE:
      return "remap size out of range";
    case RG_ERR_REMAP_BLOCK:
      return "remap block or part size or vertex counts out of range";
    case RG_ERR_REMAP_SHIFT:
      return "remap residual or bend shift out of range";
    case RG_ERR_REMAP_SOURCE:
      return "remap source rectangle is empty or outside the image";
    case RG_ERR_REMAP_CAMERA:
      return "focal length of the remap's virtual camera is not positive";
    case RG_ERR_REMAP_VERTEX:
      return "remap vertex out of range";
    case RG_ERR_DATA_OFFSET:
      return "data offset of a section out of range";
    case RG_ERR_LINE_POINT:
      return "line point or its number format out of range";
    case RG_ERR_MASK:
      return "cells of the validity mask out of range";
    case RG_ERR_UNCERTAINTY:
      return "values or scale of the uncertainty out of range";
    case RG_ERR_MODE:
      return "sensor mode out of range, or a table's mode is missing";
    case RG_ERR_CAPTURE:
      return "what calibration recorded of the camera is out of range";
    case RG_ERR_STACK:
      return "stack of cameras contradicts the blob's own sections";
    case RG_ERR_ROW_TIME:
      return "row time or its deviation out of range";
    case RG_ERR_OUTSIDE_AREA:
      return "pixel lies outside the calibrated area";
    case RG_ERR_NO_REMAP:
      return "blob has no such remap table, or none is in use";
    case RG_ERR_FRAME_SIZE:
      return "frame size or stride does not fit the blob";
    case RG_ERR_ROWS:
      return "rows beyond the end of the output, or half a pair of rows";
    case RG_ERR_NOT_SEEN:
      return "no pixel of the calibrated area sees this direction";
    case RG_ERR_FORMAT:
      return "unknown pixel format, border or sampling";
    case RG_ERR_ROWS_MISSING:
      return "the ring of rows lacks rows that the band needs";
    case RG_ERR_NONCENTRAL:
      return "the camera is not central: it has lines, not rays";
    case RG_ERR_UNKNOWN:
      return "the blob does not say";
    case RG_ERR_OVERLAP:
      return "a plane of the target overlaps another plane";
    case RG_ERR_NO_INVERSE:
      return "blob has no inverse grid, as before format 1.3; pack it anew";
    case RG_ERR_NO_STACK:
      return "blob has no stack of cameras: it is of one condition";
    case RG_EXTRAPOLATED:
      return "condition lies outside the stack: its nearest end is in use";
    case RG_ERR_NO_SLOT:
      return "neither slot has a whole blob";
  }
  return "unknown status";
}
