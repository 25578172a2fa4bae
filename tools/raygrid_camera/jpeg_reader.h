#ifndef RAYGRID_CAMERA_JPEG_READER_H
#define RAYGRID_CAMERA_JPEG_READER_H

#include <memory>

#include "frame_reader.h"

namespace raygrid {

/// Pictures in JPEG one behind the other, whatever stands between them, all of
/// one size. Grey ones become R8, others BGR888.
std::unique_ptr<FrameReader> MakeJpegReader(InputStream* stream);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_JPEG_READER_H
