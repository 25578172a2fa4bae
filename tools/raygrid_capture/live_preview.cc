#include "live_preview.h"

#include "rgb_rows.h"

namespace raygrid {
namespace {

constexpr int kMaxLiveSide = 1280;
constexpr size_t kInitialImageSize = 256 * 1024;
constexpr char kLiveType[] =
    "multipart/x-mixed-replace; boundary=raygrid-live-picture";
// Browsers display a picture once they have received the header fields of the
// next one. Therefore, these follow each picture immediately, without the next
// one's size.
constexpr char kNextImage[] =
    "\r\n--raygrid-live-picture\r\nContent-Type: image/jpeg\r\n\r\n";
// Leaves processor time for board detection.
constexpr std::chrono::milliseconds kLivePause(66);

}  // namespace

LivePreview::LivePreview()
    : stream_(kLiveType, kNextImage, kInitialImageSize),
      encoder_(&LivePreview::Encode, this) {}

void LivePreview::Show(const StreamFormat& format, const rg_image& image) {
  if (!stream_.has_clients()) return;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    format_ = format;
    bytes_.resize(format.packed_size());
    CopyPlanes(format, image, bytes_.data());
    is_full_ = true;
  }
  changed_.notify_one();
}

void LivePreview::End() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_stopped_ = true;
  }
  changed_.notify_one();
  if (encoder_.joinable()) encoder_.join();
  stream_.End();
}

void LivePreview::Encode() {
  DownscaledJpegEncoder smaller;
  std::vector<uint8_t> bytes;
  std::unique_lock<std::mutex> lock(mutex_);
  while (!is_stopped_) {
    changed_.wait(lock, [this] { return is_full_ || is_stopped_; });
    if (is_stopped_) return;
    const StreamFormat format = format_;
    bytes.swap(bytes_);
    is_full_ = false;
    lock.unlock();
    const std::vector<uint8_t>& jpeg = smaller.Encode(
        format, MakePackedImage(format, bytes.data()), kMaxLiveSide);
    if (!jpeg.empty())
      stream_.Publish(
          {{reinterpret_cast<const char*>(jpeg.data()), jpeg.size()},
           kNextImage});
    lock.lock();
    changed_.wait_for(lock, kLivePause, [this] { return is_stopped_; });
  }
}

}  // namespace raygrid
