#ifndef RAYGRID_DATASET_IMAGE_ROOM_H
#define RAYGRID_DATASET_IMAGE_ROOM_H

#include <cstdint>

#include "camera/area.h"

namespace raygrid {

/// Room for one image that is decoded and worked on, of what there is for those
/// of all threads: half of the machine's memory, however many threads there
/// are. Who makes one waits for room. An image that needs more than there is
/// gets it when it is alone. A thread has one at a time.
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
