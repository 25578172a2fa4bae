#ifndef RAYGRID_CAPTURE_LIVE_PICTURE_H
#define RAYGRID_CAPTURE_LIVE_PICTURE_H

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

#include "newest_stream.h"
#include "smaller_picture.h"

namespace raygrid {

/// The newest frame as motion JPEG of at most 1280 pixels a side and 15 a
/// second, encoded by a thread of its own while someone looks.
class LivePicture {
 public:
  LivePicture();
  ~LivePicture() { End(); }

  /// Copies the frame, unless nobody looks.
  void Show(const StreamFormat& format, const rg_image& image);
  /// No picture comes after.
  void End();
  NewestStream* stream() { return &stream_; }

 private:
  void Encode();

  NewestStream stream_;
  std::mutex mutex_;  // of all that follows
  std::condition_variable changed_;
  StreamFormat format_ = {};
  std::vector<uint8_t> bytes_;  // the newest frame's copy
  bool is_full_ = false, is_stopped_ = false;
  std::thread encoder_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_LIVE_PICTURE_H
