/// V4L2's codes of pixel formats.
#ifndef RAYGRID_V4L2_V4L2_FORMATS_H
#define RAYGRID_V4L2_V4L2_FORMATS_H

#include <cstdint>
#include <string>

#include "stream_format.h"

namespace raygrid {

/// NULL for a format that the runtime does not undistort.
const PixelFormatInfo* FindV4l2Format(uint32_t code);

/// JPEGs, each of which is a frame.
bool IsJpegFormat(uint32_t code);

/// libcamera's name where it is undistorted; MJPEG; else V4L2's four letters.
std::string V4l2FormatName(uint32_t code);

}  // namespace raygrid

#endif  // RAYGRID_V4L2_V4L2_FORMATS_H
