/// Frames of a V4L2 device, in its own buffers: no pixels are copied.
#ifndef RAYGRID_V4L2_V4L2_SOURCE_H
#define RAYGRID_V4L2_V4L2_SOURCE_H

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "bounded_queue.h"
#include "frame_source.h"
#include "v4l2_buffers.h"
#include "v4l2_capture.h"
#include "v4l2_device.h"
#include "v4l2_state.h"
#include "v4l2_stream.h"

namespace raygrid {

/// Decodes a JPEG to a frame with rows without padding. Returns false if it is
/// corrupt or has another format.
using JpegDecoder =
    std::function<bool(const uint8_t* bytes, size_t number,
                       const StreamFormat& format, uint8_t* frame)>;

struct V4l2Options {
  std::string format;        // libcamera's name; "": the device's default
  unsigned width, height;    // requested; the driver may adjust them
  bool every_frame = false;  // never drop a frame for a newer one
  ControlValues controls;    // set in this order, before the first frame
  JpegDecoder decode_jpeg = nullptr;  // null: JPEGs are not accepted
};

class V4l2Source : public FrameSource {
 public:
  /// Sets controls and format, and allocates buffers. Throws CameraError.
  V4l2Source(std::unique_ptr<V4l2Device> device, const V4l2Options& options);
  ~V4l2Source() override { Stop(); }

  const StreamFormat& format() const override { return stream_.format; }
  bool reports_crops() const override { return reader_->reports_crops(); }
  std::string memory() const override;
  void Start() override;
  std::optional<CapturedFrame> Next(std::chrono::milliseconds timeout) override;
  void Release(const CapturedFrame& frame) override;
  bool is_finished() const override { return queue_->is_finished(); }
  std::string fault() const override;
  SourceCounts counts() const override;
  StateLock LockState() override;
  void FocusAt(const LensFocus& focus) override {
    state_.FocusAt(focus.focus_steps);
  }
  void UnlockState() override;
  void Stop() override;

 private:
  void Run();
  bool TakeFrame(short events);
  void Deliver(const V4l2Filled& filled);
  void Decode(const V4l2Filled& filled, Clock::time_point arrived);
  void Push(const V4l2Filled& filled, const uint8_t* const planes[3],
            uint32_t buffer, Clock::time_point arrived);
  std::optional<uint32_t> PopDecoded();
  void CountMissed(uint32_t sequence);
  void Queue(uint32_t buffer);
  void Fail(int error);

  const std::unique_ptr<V4l2Device> device_;
  V4l2Stream stream_;
  std::unique_ptr<V4l2Buffers> buffers_;
  std::unique_ptr<V4l2CaptureReader> reader_;
  V4l2StateLock state_;
  FrameInfo reported_ = {};  // last values of the reader, in the thread
  Clock::time_point reported_at_;
  std::atomic<bool> has_changed_{false};  // since the last reading
  std::unique_ptr<BoundedQueue<CapturedFrame>> queue_;
  // JPEGs only: decoded frames, and the queue of free ones.
  const JpegDecoder decode_jpeg_;
  std::vector<std::vector<uint8_t>> decoded_;
  BoundedQueue<uint32_t> free_;
  std::atomic<bool> is_stopped_{false};
  bool is_streaming_ = false;
  mutable std::mutex mutex_;  // guards fault_
  std::string fault_;
  std::optional<uint32_t> last_sequence_;  // used by the thread, as the next
  int num_failures_ = 0;                   // consecutive failures
  std::atomic<uint64_t> arrived_{0}, dropped_{0}, damaged_{0}, missed_{0};
  std::thread thread_;
};

}  // namespace raygrid

#endif  // RAYGRID_V4L2_V4L2_SOURCE_H
