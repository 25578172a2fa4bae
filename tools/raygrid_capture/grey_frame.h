#ifndef RAYGRID_CAPTURE_GREY_FRAME_H
#define RAYGRID_CAPTURE_GREY_FRAME_H

#include "dataset/image_files.h"
#include "stream_format.h"

namespace raygrid {

/// Throws CameraError for formats that hold no grey level of each pixel: those
/// of colour filters, and packed ones.
void RequireGrey(const PixelFormatInfo& pixel_format);

/// The grey levels of a frame: its own, with all their bits, where it has them,
/// as grey and YUV formats do. Of red, green and blue they are made as of files
/// in colour. More than 8 bits become 16, the highest ones in use.
Image GreyOf(const StreamFormat& format, const rg_image& frame);

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_GREY_FRAME_H
