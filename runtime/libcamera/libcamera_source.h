/// Frames from a libcamera camera, in its own buffers: no pixels are copied.
#ifndef RAYGRID_LIBCAMERA_LIBCAMERA_SOURCE_H
#define RAYGRID_LIBCAMERA_LIBCAMERA_SOURCE_H

#include <libcamera/camera.h>
#include <libcamera/camera_manager.h>
#include <libcamera/framebuffer_allocator.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "bounded_queue.h"
#include "frame_source.h"
#include "mapped_buffers.h"

namespace raygrid {

/// libcamera's list of cameras; at most one instance per process.
class CameraList {
 public:
  CameraList();
  ~CameraList() { manager_->stop(); }

  /// Lists cameras, their formats and sizes, as text.
  std::string Describe() const;
  /// Finds a camera by its id or a unique part of it; "": the only camera.
  std::shared_ptr<libcamera::Camera> Find(const std::string& id) const;

 private:
  std::unique_ptr<libcamera::CameraManager> manager_;
};

struct LibcameraOptions {
  std::string format;        // "": the camera's default, if supported
  unsigned width, height;    // requested; validate() may adjust them
  bool every_frame = false;  // never drop a frame for a newer one
  ControlValues controls;    // set in this order, before the first frame
};

class LibcameraSource : public FrameSource {
 public:
  /// Acquires and configures the camera. Throws CameraError.
  LibcameraSource(std::shared_ptr<libcamera::Camera> camera,
                  const LibcameraOptions& options);
  ~LibcameraSource() override;

  const StreamFormat& format() const override { return format_; }
  bool reports_crops() const override { return true; }
  std::string memory() const override { return "libcamera's"; }
  void Start() override;
  std::optional<CapturedFrame> Next(std::chrono::milliseconds timeout) override;
  void Release(const CapturedFrame& frame) override;
  bool is_finished() const override { return queue_->is_finished(); }
  std::string fault() const override;
  SourceCounts counts() const override;
  StateLock LockState() override;
  void FocusAt(const LensFocus& focus) override;
  void UnlockState() override;
  void Stop() override;

 private:
  void Configure(const LibcameraOptions& options);
  void Allocate();
  void Free();
  void OnCompleted(libcamera::Request* request);
  void OnDisconnected();
  void CountMissed(uint32_t sequence);
  void Queue(libcamera::Request* request);
  void QueueAgain(uint32_t buffer);
  void SendUnlock();

  std::shared_ptr<libcamera::Camera> camera_;
  std::unique_ptr<libcamera::CameraConfiguration> configuration_;
  StreamFormat format_;
  int orientation_ = 0;  // configured orientation; 0: not an EXIF value
  unsigned widest_ = 0;  // sensor width in pixels; 0: unknown
  libcamera::ControlList controls_;  // set before the first frame
  std::unique_ptr<libcamera::FrameBufferAllocator> allocator_;
  std::unique_ptr<MappedBuffers> buffers_;
  std::vector<std::unique_ptr<libcamera::Request>> requests_;
  std::unique_ptr<BoundedQueue<CapturedFrame>> queue_;
  std::mutex state_mutex_;  // guards the next four
  std::optional<FrameInfo> last_info_;
  LensFocus focus_;                         // for LockState()
  libcamera::ControlList next_controls_;    // for the next request
  libcamera::ControlList unlock_controls_;  // set by UnlockState()
  std::atomic<bool> is_running_{false}, is_disconnected_{false};
  std::optional<uint32_t> last_sequence_;  // used by libcamera's thread
  std::atomic<uint64_t> arrived_{0}, dropped_{0}, damaged_{0}, missed_{0};
};

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_LIBCAMERA_SOURCE_H
