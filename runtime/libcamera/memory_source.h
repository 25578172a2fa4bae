#ifndef RAYGRID_LIBCAMERA_MEMORY_SOURCE_H
#define RAYGRID_LIBCAMERA_MEMORY_SOURCE_H

#include <atomic>
#include <thread>
#include <vector>

#include "bounded_queue.h"
#include "frame_source.h"

namespace raygrid {

struct MemorySourceOptions {
  double frames_per_second = 30;
  uint64_t num_frames = 0;   // total; 0: repeat the recording endlessly
  bool every_frame = false;  // waits for the consumer; else drops the oldest
};

/// Plays a recording like a camera: in a separate thread, at a fixed rate, with
/// few buffers. Frames are contiguous, with rows without padding.
class MemorySource : public FrameSource {
 public:
  MemorySource(const StreamFormat& format, std::vector<uint8_t> recording,
               const MemorySourceOptions& options);
  ~MemorySource() override { Stop(); }

  const StreamFormat& format() const override { return format_; }
  void Start() override;
  std::optional<CapturedFrame> Next(std::chrono::milliseconds timeout) override;
  void Release(const CapturedFrame& frame) override;
  bool is_finished() const override { return queue_.is_finished(); }
  std::string fault() const override { return ""; }
  SourceCounts counts() const override;
  void Stop() override;

 private:
  void Play();
  CapturedFrame MakeFrame(uint64_t index, uint32_t buffer) const;

  const StreamFormat format_;
  const std::vector<uint8_t> recording_;
  const MemorySourceOptions options_;
  BoundedQueue<CapturedFrame> queue_;
  BoundedQueue<uint32_t> free_buffers_;
  std::atomic<uint64_t> arrived_{0}, dropped_{0}, missed_{0};
  std::atomic<bool> is_stopped_{false};
  std::thread thread_;
};

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_MEMORY_SOURCE_H
