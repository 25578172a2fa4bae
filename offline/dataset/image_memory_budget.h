#ifndef RAYGRID_DATASET_IMAGE_MEMORY_BUDGET_H
#define RAYGRID_DATASET_IMAGE_MEMORY_BUDGET_H

#include <cstdint>

#include "camera/area.h"

namespace raygrid {

/// Reserves memory for decoding and processing one image, out of half of the
/// machine's memory for all threads together. The constructor waits until
/// enough is available; an image that needs more than the total waits until it
/// is the only one. A thread must hold only one at a time.
class ImageMemoryBudget {
 public:
  explicit ImageMemoryBudget(const ImageSize& size);
  ~ImageMemoryBudget();
  ImageMemoryBudget(const ImageMemoryBudget&) = delete;
  ImageMemoryBudget& operator=(const ImageMemoryBudget&) = delete;

 private:
  int64_t num_pixels_;
};

}  // namespace raygrid

#endif  // RAYGRID_DATASET_IMAGE_MEMORY_BUDGET_H
