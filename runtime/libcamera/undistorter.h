/// Undistorts the frames of a source, in order, in a separate thread, with
/// intrinsics updated from each frame's metadata if the blob supports it.
#ifndef RAYGRID_LIBCAMERA_UNDISTORTER_H
#define RAYGRID_LIBCAMERA_UNDISTORTER_H

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "band_remap.h"
#include "bounded_queue.h"
#include "camera_error.h"
#include "duration_histogram.h"
#include "frame_source.h"
#include "invalid_blocks.h"
#include "operating_point_follower.h"
#include "stream_guard.h"

namespace raygrid {

/// An undistorted frame, with contiguous planes and rows without padding.
struct UndistortedFrame {
  std::vector<uint8_t> bytes;
  rg_target target;  // points into bytes
  FrameInfo info;
  Clock::time_point arrived;
  Clock::duration remap_time;  // including the border of InvalidBlocks
};

/// Called with each frame before and after undistortion, in the thread of the
/// Undistorter; data is valid only during the call.
class FrameObserver {
 public:
  virtual ~FrameObserver() = default;
  virtual void OnFrame(const CapturedFrame& before,
                       const UndistortedFrame& after) = 0;
};

struct UndistorterOptions {
  uint32_t num_buffers = 4;
  unsigned num_threads = 1;  // see BandRemap
  bool every_frame = false;  // waits for the consumer; else drops the oldest
  bool only_valid = false;   // fills InvalidBlocks with border
};

struct UndistorterStatistics {
  uint64_t undistorted = 0;
  uint64_t dropped = 0;  // undistorted frames not taken in time
  DurationHistogram remap;
  FrameInfo last_info = {};
  OperatingPointCounts stack;
};

class Undistorter {
 public:
  /// Source and guard must outlive this object; the camera is copied. Throws
  /// CameraError if the blob has no remap table, its output size is invalid for
  /// the format, or only_valid is set and no block is valid.
  Undistorter(const rg_camera& camera, FrameSource* source, StreamGuard* guard,
              const UndistorterOptions& options);
  ~Undistorter() { Stop(); }

  /// The format of the output frames.
  const StreamFormat& format() const { return format_; }

  void Start(FrameObserver* observer = nullptr);
  /// Returns the oldest frame, to be returned by ReturnFrame(); NULL on
  /// timeout.
  UndistortedFrame* Take(std::chrono::milliseconds timeout);
  void ReturnFrame(UndistortedFrame* frame) { free_.Push(frame); }
  /// Whether the stream has ended.
  bool is_finished() const { return ready_.is_finished(); }
  /// The error that ended the stream; nullopt if it ended regularly.
  std::optional<CameraError> fault() const;
  UndistorterStatistics statistics() const;
  void Stop();

 private:
  void Run();
  void HideInvalidBlocks();
  void Undistort(const CapturedFrame& captured);
  UndistortedFrame* AcquireBuffer();

  rg_camera camera_;
  OperatingPointFollower stack_{&camera_};
  FrameSource* const source_;
  StreamGuard* const guard_;
  const UndistorterOptions options_;
  FrameObserver* observer_ = nullptr;
  StreamFormat format_;
  std::vector<UndistortedFrame> frames_;
  std::optional<InvalidBlocks> invalid_;  // blocks to fill with border
  BandRemap bands_;
  BoundedQueue<UndistortedFrame*> free_, ready_;
  mutable std::mutex mutex_;  // guards the next two
  UndistorterStatistics statistics_;
  std::optional<CameraError> fault_;
  std::atomic<bool> is_stopped_{false};
  std::thread thread_;
};

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_UNDISTORTER_H
