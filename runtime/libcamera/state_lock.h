/// Camera settings that are fixed while streaming.
#ifndef RAYGRID_LIBCAMERA_STATE_LOCK_H
#define RAYGRID_LIBCAMERA_STATE_LOCK_H

#include <string>
#include <vector>

namespace raygrid {

/// Result of LockState(): short texts for display. Each begins with its
/// subject: focus, exposure, gain or white balance.
struct StateLock {
  std::vector<std::string> locked;  // "focus at 1.25 dioptres", "gain 2.1"
  std::vector<std::string> open;    // "focus: the camera has no control for it"
};

/// Returns a result in which no setting is fixed, with the reason.
StateLock MakeUnlockedState(const std::string& reason);

/// Formats an exposure time: "exposure 8.3 ms".
std::string DescribeExposure(double exposure_us);

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_STATE_LOCK_H
