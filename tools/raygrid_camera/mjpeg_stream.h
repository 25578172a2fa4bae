#ifndef RAYGRID_CAMERA_MJPEG_STREAM_H
#define RAYGRID_CAMERA_MJPEG_STREAM_H

#include <cstddef>
#include <cstdint>

#include "newest_stream.h"

namespace raygrid {

/// A motion JPEG stream of the newest picture.
class MjpegStream : public NewestStream {
 public:
  explicit MjpegStream(size_t max_size);

  void ShowImage(const uint8_t* jpeg, size_t size);
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_MJPEG_STREAM_H
