#ifndef RAYGRID_CAMERA_JPEG_READER_H
#define RAYGRID_CAMERA_JPEG_READER_H

#include <memory>

#include "frame_reader.h"

namespace raygrid {

/// Makes a frame, rows without gaps, of a JPEG that has the format's size and,
/// for R8, no colours. Returns whether all pixels are as they were written.
bool DecodeJpeg(const uint8_t* bytes, size_t number, const StreamFormat& format,
                uint8_t* frame);

/// Pictures in JPEG one behind the other, whatever stands between them, all of
/// one size. Grey ones become R8, others BGR888.
std::unique_ptr<FrameReader> MakeJpegReader(InputStream* stream);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_JPEG_READER_H
