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
std::condition_variable budget_changed;
int64_t pixels_reserved = 0;

}  // namespace

ImageMemoryBudget::ImageMemoryBudget(const ImageSize& size)
    : num_pixels_(static_cast<int64_t>(size.width) * size.height) {
  static const int64_t max_pixels = MaxPixels();
  std::unique_lock<std::mutex> lock(room_mutex);
  budget_changed.wait(lock, [this] {
    return pixels_reserved == 0 || pixels_reserved + num_pixels_ <= max_pixels;
  });
  pixels_reserved += num_pixels_;
}

ImageMemoryBudget::~ImageMemoryBudget() {
  const std::lock_guard<std::mutex> lock(room_mutex);
  pixels_reserved -= num_pixels_;
  budget_changed.notify_all();
}

}  // namespace raygrid
