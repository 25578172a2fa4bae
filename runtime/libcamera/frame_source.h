/// A source of frames: a camera, or a recording in memory.
#ifndef RAYGRID_LIBCAMERA_FRAME_SOURCE_H
#define RAYGRID_LIBCAMERA_FRAME_SOURCE_H

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "raygrid.h"
#include "state_lock.h"
#include "stream_format.h"

namespace raygrid {

using Clock = std::chrono::steady_clock;

/// A rectangle in sensor pixels.
struct SensorCrop {
  int x, y;
  unsigned width, height;
};

inline bool operator==(const SensorCrop& a, const SensorCrop& b) {
  return a.x == b.x && a.y == b.y && a.width == b.width && a.height == b.height;
}

/// Name of a camera control, and its value as specified by the user.
using ControlValue = std::pair<std::string, std::string>;
using ControlValues = std::vector<ControlValue>;

/// The metadata of a frame.
struct FrameInfo {
  uint32_t sequence;
  uint64_t timestamp_ns;
  std::optional<SensorCrop> crop;
  std::optional<float> lens_position;  // dioptres
  std::optional<double> zoom;          // relative to the widest setting
  std::optional<int> orientation;      // 1 to 8, as in EXIF
  std::optional<float> sensor_temperature_c;
  std::optional<float> exposure_us;
  std::optional<float> analogue_gain;  // factor
  // Focus of lenses whose position has no unit, only to detect its motion. V4L2
  // is polled once a second, so the value may be older than the frame.
  std::optional<int> focus_steps;
};

/// The focus values of a FrameInfo.
struct LensFocus {
  std::optional<float> lens_position;  // dioptres
  std::optional<int> focus_steps;
};

/// A frame in the source's own memory, which the caller may use until it is
/// released.
struct CapturedFrame {
  rg_image image;
  FrameInfo info;
  uint32_t buffer;  // index in the source's memory
  Clock::time_point arrived;
};

struct SourceCounts {
  uint64_t arrived;  // complete frames
  uint64_t dropped;  // complete frames not taken in time
  uint64_t damaged;  // incomplete frames, or with an error
  uint64_t missed;   // sequence numbers that the camera skipped
};

/// Start() and Stop() are called once, by the same thread; Next() and Release()
/// by one thread in between; LockState() and UnlockState() by any thread. The
/// camera has only the configured number of buffers; it cannot reuse those of
/// frames that are not released.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  virtual const StreamFormat& format() const = 0;
  /// Whether frames have their sensor crop.
  virtual bool reports_crops() const { return false; }
  /// Owner of the frames' memory, for display; empty: this program.
  virtual std::string memory() const { return ""; }
  virtual void Start() = 0;
  /// Returns the oldest frame; nullopt on timeout.
  virtual std::optional<CapturedFrame> Next(
      std::chrono::milliseconds timeout) = 0;
  virtual void Release(const CapturedFrame& frame) = 0;
  /// Whether the stream has ended.
  virtual bool is_finished() const = 0;
  /// Returns why the stream ended; empty if it ended regularly.
  virtual std::string fault() const = 0;
  virtual SourceCounts counts() const = 0;
  /// Fixes focus, exposure, gain and white balance at their current values, so
  /// that all later frames have a constant lens position and brightness. Call
  /// it when frames arrive and the image is sharp. It does not wait: the next
  /// few frames may still have other values. Frames captured before may have
  /// another lens position, whatever their metadata: discard them. Controls
  /// that the camera rejects stay automatic, without an error. Another call
  /// fixes the values at that time.
  virtual StateLock LockState() {
    return MakeUnlockedState("the source is not a camera");
  }
  /// Makes LockState() set the focus of an earlier frame instead of leaving it
  /// unchanged.
  virtual void FocusAt(const LensFocus&) {}
  /// Restores the automatic modes that LockState() disabled. Stop() does so,
  /// too, because some cameras keep their controls after a program ends.
  virtual void UnlockState() {}
  virtual void Stop() = 0;
};

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_FRAME_SOURCE_H
