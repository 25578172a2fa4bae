/// Fixes focus, exposure, gain and white balance of a V4L2 device at their
/// current values.
#ifndef RAYGRID_V4L2_V4L2_STATE_H
#define RAYGRID_V4L2_V4L2_STATE_H

#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

#include "state_lock.h"
#include "v4l2_device.h"

namespace raygrid {

/// Lock() and Unlock() may be called by any thread while others read frames.
class V4l2StateLock {
 public:
  /// The device must outlive this object.
  explicit V4l2StateLock(V4l2Device* device) : device_(device) {}
  ~V4l2StateLock() { Unlock(); }
  V4l2StateLock(const V4l2StateLock&) = delete;
  V4l2StateLock& operator=(const V4l2StateLock&) = delete;

  /// Makes Lock() set this focus; nullopt: the current focus is kept.
  void FocusAt(std::optional<int> focus_steps);
  /// Disables automatic modes, one control after another.
  StateLock Lock();
  /// Restores the modes that Lock() disabled, and the original focus, as far as
  /// the device accepts them.
  void Unlock();

 private:
  struct Subject;
  struct Mode {
    uint32_t id;
    int32_t value;
  };

  int EndMode(const Subject& subject);
  std::optional<int32_t> GetRequestedValue(uint32_t id) const;
  bool Fix(const Subject& subject, StateLock* lock);

  V4l2Device* const device_;
  std::mutex mutex_;  // guards all members below; held during Lock() and
                      // Unlock()
  std::vector<Mode>
      disabled_modes_;  // disabled modes with their original values
  std::optional<int32_t> focus_;
};

}  // namespace raygrid

#endif  // RAYGRID_V4L2_V4L2_STATE_H
