#ifndef RAYGRID_CAMERA_PICTURE_STREAM_H
#define RAYGRID_CAMERA_PICTURE_STREAM_H

#include <cstddef>
#include <cstdint>

#include "newest_stream.h"

namespace raygrid {

/// A motion JPEG stream of the newest picture.
class PictureStream : public NewestStream {
 public:
  explicit PictureStream(size_t max_size);

  void ShowPicture(const uint8_t* jpeg, size_t size);
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_PICTURE_STREAM_H
