#ifndef RAYGRID_CAPTURE_LIVE_PREVIEW_H
#define RAYGRID_CAPTURE_LIVE_PREVIEW_H

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

#include "downscaled_jpeg.h"
#include "newest_stream.h"

namespace raygrid {

/// Motion JPEG of the newest frame, at most 1280 pixels per side and 15 frames
/// per second, encoded in a separate thread while a client watches.
class LivePreview {
 public:
  LivePreview();
  ~LivePreview() { End(); }

  /// Copies the frame if a client watches.
  void Show(const StreamFormat& format, const rg_image& image);
  /// Ends the stream.
  void End();
  NewestStream* stream() { return &stream_; }

 private:
  void Encode();

  NewestStream stream_;
  std::mutex mutex_;  // guards all members below
  std::condition_variable changed_;
  StreamFormat format_ = {};
  std::vector<uint8_t> bytes_;  // copy of the newest frame
  bool is_full_ = false, is_stopped_ = false;
  std::thread encoder_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_LIVE_PREVIEW_H
