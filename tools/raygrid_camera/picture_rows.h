#ifndef RAYGRID_CAMERA_PICTURE_ROWS_H
#define RAYGRID_CAMERA_PICTURE_ROWS_H

#include <cstdint>

#include "stream_format.h"

namespace raygrid {

/// Colours for people to look at: 8 bits of red, green, blue. Each 2 x 2 pixels
/// of a Bayer frame become one colour; YUV is that of BT.601.
void ReadPictureRow(const StreamFormat& format, const rg_image& image,
                    uint32_t row, uint8_t* rgb);

/// The image of a frame without gaps.
rg_image MakePackedImage(const StreamFormat& format, const uint8_t* bytes);

/// Rows of all planes to bytes without gaps, packed_size() of them.
void CopyPlanes(const StreamFormat& format, const rg_image& image,
                uint8_t* bytes);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_PICTURE_ROWS_H
