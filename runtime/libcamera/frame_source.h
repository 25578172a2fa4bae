/// A source of frames: a camera, or memory.
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

/// A rectangle of the sensor's pixels.
struct SensorCrop {
  int x, y;
  unsigned width, height;
};

inline bool operator==(const SensorCrop& a, const SensorCrop& b) {
  return a.x == b.x && a.y == b.y && a.width == b.width && a.height == b.height;
}

/// A control of a camera by its name, and its value as it was given.
using ControlValue = std::pair<std::string, std::string>;
using ControlValues = std::vector<ControlValue>;

/// The values that the camera tells of a frame.
struct FrameInfo {
  uint32_t sequence;
  uint64_t timestamp_ns;
  std::optional<SensorCrop> crop;
  std::optional<float> lens_position;  // dioptres
  std::optional<double> zoom;          // magnification over the widest
  std::optional<int> orientation;      // 1 to 8, as EXIF has it
  std::optional<float> sensor_temperature_c;
  std::optional<float> exposure_us;
  std::optional<float> analogue_gain;  // a factor
  // The focus of lenses whose position has no unit: it only tells that they
  // moved.
  // V4L2 is asked once a second, so that frames may tell an older one.
  std::optional<int> focus_steps;
};

/// The focus that a FrameInfo tells.
struct LensFocus {
  std::optional<float> lens_position;  // dioptres
  std::optional<int> focus_steps;
};

/// A frame in the source's own memory, which is the caller's until it is given
/// back.
struct CapturedFrame {
  rg_image image;
  FrameInfo info;
  uint32_t buffer;  // the source's number of its memory
  Clock::time_point arrived;
};

struct SourceCounts {
  uint64_t arrived;  // whole frames
  uint64_t dropped;  // of these, not taken in time
  uint64_t damaged;  // incomplete, or with an error
  uint64_t missed;   // numbers that the camera skipped
};

/// Start() and Stop() once, by the same thread; Next() and Release() by one
/// thread in between; LockState() and UnlockState() by any thread. Frames not
/// released come to the camera's account: it has only as many buffers as it was
/// configured with.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  virtual const StreamFormat& format() const = 0;
  /// Frames come with the part of the sensor that they show.
  virtual bool tells_crops() const { return false; }
  /// Whose memory frames lie in, for people; empty: this program's.
  virtual std::string memory() const { return ""; }
  virtual void Start() = 0;
  /// The oldest frame; nothing when none comes in that time.
  virtual std::optional<CapturedFrame> Next(
      std::chrono::milliseconds timeout) = 0;
  virtual void Release(const CapturedFrame& frame) = 0;
  /// No frame will come any more.
  virtual bool is_finished() const = 0;
  /// Why it ended; empty where that is in order.
  virtual std::string fault() const = 0;
  virtual SourceCounts counts() const = 0;
  /// Fixes focus, exposure, gain and white balance at what they are, so that
  /// all frames from then on have one position of the lens and one brightness.
  /// Call it once frames come and the image is sharp. It does not wait: the
  /// next few frames may still be as before. Frames that were taken before may
  /// show another position of the lens, whatever they tell: keep none of them.
  /// What the camera refuses stays open and ends nothing. Called again, it
  /// fixes what there is then.
  virtual StateLock LockState() {
    return NothingLocked("the source is not a camera");
  }
  /// Makes LockState() move the lens to the focus of a frame taken before,
  /// instead of leaving it where it is.
  virtual void FocusAt(const LensFocus&) {}
  /// Puts the automatic modes that LockState() ended back as they were. Stop()
  /// does it, too, since some cameras keep their controls after a program.
  virtual void UnlockState() {}
  virtual void Stop() = 0;
};

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_FRAME_SOURCE_H
