#include "live_picture.h"

#include "picture_rows.h"

namespace raygrid {
namespace {

constexpr int kMaxLiveSide = 1280;
constexpr size_t kUsualLiveSize = 256 * 1024;
// Leaves the processor to those who look for boards.
constexpr std::chrono::milliseconds kLivePause(66);
// Browsers show a picture of a stream when the next one begins.
constexpr std::chrono::milliseconds kStillPause(300);

}  // namespace

LivePicture::LivePicture()
    : stream_(kUsualLiveSize), encoder_(&LivePicture::Encode, this) {}

void LivePicture::Show(const StreamFormat& format, const rg_image& image) {
  if (!stream_.has_clients()) return;
  const std::lock_guard<std::mutex> showing(showing_);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (is_full_ || is_stopped_) return;
  }
  format_ = format;
  bytes_.resize(format.packed_size());
  CopyPlanes(format, image, bytes_.data());
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_full_ = true;
  }
  changed_.notify_one();
}

void LivePicture::End() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_stopped_ = true;
  }
  changed_.notify_one();
  if (encoder_.joinable()) encoder_.join();
  stream_.End();
}

void LivePicture::Encode() {
  SmallerPicture smaller;
  std::vector<uint8_t> still;  // to be shown once more
  std::unique_lock<std::mutex> lock(mutex_);
  while (!is_stopped_) {
    const auto has_more = [this] { return is_full_ || is_stopped_; };
    if (still.empty()) {
      changed_.wait(lock, has_more);
    } else if (!changed_.wait_for(lock, kStillPause, has_more)) {
      stream_.ShowPicture(still.data(), still.size());
      still.clear();
    }
    if (!is_full_ || is_stopped_) continue;
    lock.unlock();
    const rg_image image = MakePackedImage(format_, bytes_.data());
    still = smaller.Encode(format_, image, kMaxLiveSide);
    if (!still.empty()) stream_.ShowPicture(still.data(), still.size());
    lock.lock();
    changed_.wait_for(lock, kLivePause, [this] { return is_stopped_; });
    is_full_ = false;
  }
}

}  // namespace raygrid
