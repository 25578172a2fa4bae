#ifndef RAYGRID_CAMERA_PIPE_SOURCE_H
#define RAYGRID_CAMERA_PIPE_SOURCE_H

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "bounded_queue.h"
#include "frame_reader.h"
#include "frame_source.h"
#include "input_stream.h"

namespace raygrid {

struct PipeOptions {
  std::string format;        // libcamera's name, or MJPEG; "": by header
  unsigned width, height;    // if the stream does not specify them
  bool every_frame = false;  // let the writer wait instead of dropping frames
  double timeout_s = 5;      // for the first byte
};

/// Frames from another program through a pipe. If processing is slow, frames
/// are dropped as by a camera, or the writer waits.
class PipeSource : public FrameSource {
 public:
  /// Reads the header of the stream. Throws CameraError if none arrives.
  ///
  /// @param is_interrupted returns true after SIGINT or SIGTERM
  PipeSource(int fd, const PipeOptions& options,
             std::function<bool()> is_interrupted);
  ~PipeSource() override { Stop(); }

  const StreamFormat& format() const override { return reader_->format(); }
  void Start() override;
  std::optional<CapturedFrame> Next(std::chrono::milliseconds timeout) override;
  void Release(const CapturedFrame& frame) override;
  bool is_finished() const override { return queue_.is_finished(); }
  std::string fault() const override;
  SourceCounts counts() const override;
  void Stop() override;

 private:
  bool MustStop() const;
  void Run();
  void ReadFrames();
  void Deliver(uint32_t buffer);
  void Fail(const std::string& why);

  const std::function<bool()> is_interrupted_;
  std::atomic<bool> is_stopped_{false};
  std::optional<Clock::time_point> deadline_;  // for the first bytes
  InputStream stream_;
  std::unique_ptr<FrameReader> reader_;
  std::vector<std::vector<uint8_t>> buffers_;
  BoundedQueue<CapturedFrame> queue_;
  BoundedQueue<uint32_t> free_;
  mutable std::mutex mutex_;  // guards fault_
  std::string fault_;
  uint32_t num_read_ = 0;  // used by the reading thread only
  std::atomic<uint64_t> arrived_{0}, dropped_{0}, damaged_{0};
  std::thread thread_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_PIPE_SOURCE_H
