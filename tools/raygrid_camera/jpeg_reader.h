#ifndef RAYGRID_CAMERA_JPEG_READER_H
#define RAYGRID_CAMERA_JPEG_READER_H

#include <memory>

#include "frame_reader.h"

namespace raygrid {

/// Decodes a JPEG of the format's size, without colours for R8, to a frame with
/// rows without padding. Returns false if any data is missing or corrupt.
bool DecodeJpeg(const uint8_t* bytes, size_t number, const StreamFormat& format,
                uint8_t* frame);

/// Reads concatenated JPEGs of equal size, ignoring bytes between them. Grey
/// pictures become R8, others BGR888.
std::unique_ptr<FrameReader> MakeJpegReader(InputStream* stream);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_JPEG_READER_H
