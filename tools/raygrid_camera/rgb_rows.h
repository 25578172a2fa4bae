#ifndef RAYGRID_CAMERA_RGB_ROWS_H
#define RAYGRID_CAMERA_RGB_ROWS_H

#include <cstdint>

#include "stream_format.h"

namespace raygrid {

/// Converts a row to 8-bit RGB for display. Each 2 x 2 pixels of a Bayer frame
/// become one colour; YUV is converted by BT.601.
void ReadRgbRow(const StreamFormat& format, const rg_image& image, uint32_t row,
                uint8_t* rgb);

/// Returns an image of a frame without padding.
rg_image MakePackedImage(const StreamFormat& format, const uint8_t* bytes);

/// Copies the rows of all planes to packed_size() bytes, without padding.
void CopyPlanes(const StreamFormat& format, const rg_image& image,
                uint8_t* bytes);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_RGB_ROWS_H
