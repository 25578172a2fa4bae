/// V4L2's codes of pixel formats.
#ifndef RAYGRID_V4L2_V4L2_FORMATS_H
#define RAYGRID_V4L2_V4L2_FORMATS_H

#include <cstdint>
#include <string>

#include "stream_format.h"

namespace raygrid {

/// NULL for a format that the runtime does not support.
const PixelFormatInfo* FindV4l2Format(uint32_t code);

/// Whether each frame is a JPEG.
bool IsJpegFormat(uint32_t code);

/// libcamera's name if supported; MJPEG; otherwise V4L2's four characters.
std::string V4l2FormatName(uint32_t code);

}  // namespace raygrid

#endif  // RAYGRID_V4L2_V4L2_FORMATS_H
