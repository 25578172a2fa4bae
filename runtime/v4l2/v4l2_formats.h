/// V4L2's codes of pixel formats (FourCC).
#ifndef RAYGRID_V4L2_V4L2_FORMATS_H
#define RAYGRID_V4L2_V4L2_FORMATS_H

#include <cstdint>
#include <string>

#include "stream_format.h"

namespace raygrid {

/// Finds a format; NULL if the runtime does not support it.
const PixelFormatInfo* FindV4l2Format(uint32_t code);

/// Whether frames of this format are JPEGs.
bool IsJpegFormat(uint32_t code);

/// Returns libcamera's name if supported; MJPEG; otherwise the FourCC.
std::string V4l2FormatName(uint32_t code);

}  // namespace raygrid

#endif  // RAYGRID_V4L2_V4L2_FORMATS_H
