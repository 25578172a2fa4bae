#include "dataset/image_memory_budget.h"

#include <unistd.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>

namespace raygrid {
namespace {

// Returns the maximum total number of pixels of images processed concurrently,
// such that they use half of the memory.
int64_t MaxPixels() {
  constexpr int64_t kBytesPerPixel = 50;  // peak during detection
  const int64_t pages = sysconf(_SC_PHYS_PAGES);
  const int64_t bytes = std::max<int64_t>(0, pages) * sysconf(_SC_PAGESIZE);
  return bytes / 2 / kBytesPerPixel;
}

std::mutex room_mutex;
std::condition_variable room_changed;
int64_t room_taken = 0;

}  // namespace

ImageMemoryBudget::ImageMemoryBudget(const ImageSize& size)
    : num_pixels_(static_cast<int64_t>(size.width) * size.height) {
  static const int64_t max_pixels = MaxPixels();
  std::unique_lock<std::mutex> lock(room_mutex);
  room_changed.wait(lock, [this] {
    return room_taken == 0 || room_taken + num_pixels_ <= max_pixels;
  });
  room_taken += num_pixels_;
}

ImageMemoryBudget::~ImageMemoryBudget() {
  const std::lock_guard<std::mutex> lock(room_mutex);
  room_taken -= num_pixels_;
  room_changed.notify_all();
}

}  // namespace raygrid
