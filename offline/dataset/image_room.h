#ifndef RAYGRID_DATASET_IMAGE_ROOM_H
#define RAYGRID_DATASET_IMAGE_ROOM_H

#include <cstdint>

#include "camera/area.h"

namespace raygrid {

/// Reserves memory for decoding and processing one image, out of half of the
/// machine's memory for all threads together. The constructor waits until
/// enough is available; an image that needs more than the total waits until it
/// is the only one. A thread must hold only one at a time.
class ImageRoom {
 public:
  explicit ImageRoom(const ImageSize& size);
  ~ImageRoom();
  ImageRoom(const ImageRoom&) = delete;
  ImageRoom& operator=(const ImageRoom&) = delete;

 private:
  int64_t num_pixels_;
};

}  // namespace raygrid

#endif  // RAYGRID_DATASET_IMAGE_ROOM_H
