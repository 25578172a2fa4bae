#ifndef RAYGRID_CAPTURE_GREY_FRAME_H
#define RAYGRID_CAPTURE_GREY_FRAME_H

#include "dataset/image_files.h"
#include "stream_format.h"

namespace raygrid {

/// Throws CameraError for formats without a grey level per pixel: Bayer and
/// packed formats.
void RequireGrey(const PixelFormatInfo& pixel_format);

/// Returns the grey levels of a frame: the luma of grey and YUV formats, with
/// all bits; computed from RGB as for colour files. More than 8 bits are
/// shifted to the highest bits of 16.
Image ConvertToGrey(const StreamFormat& format, const rg_image& frame);

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_GREY_FRAME_H
