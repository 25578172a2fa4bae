/// Parts of a camera's state that are fixed while it streams.
#ifndef RAYGRID_LIBCAMERA_STATE_LOCK_H
#define RAYGRID_LIBCAMERA_STATE_LOCK_H

#include <string>
#include <vector>

namespace raygrid {

/// How far LockState() of a source came, in short texts for people. Each begins
/// with its subject: focus, exposure, gain or white balance.
struct StateLock {
  std::vector<std::string> locked;  // "focus at 1.25 dioptres", "gain 2.1"
  std::vector<std::string> open;    // "focus: the camera has no control for it"
};

/// Everything is open, for that reason.
StateLock NothingLocked(const std::string& reason);

/// "exposure 8.3 ms"
std::string DescribeExposure(double exposure_us);

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_STATE_LOCK_H
