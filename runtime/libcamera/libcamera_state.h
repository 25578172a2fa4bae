/// Controls that fix focus, exposure, gain and white balance of a camera.
#ifndef RAYGRID_LIBCAMERA_LIBCAMERA_STATE_H
#define RAYGRID_LIBCAMERA_LIBCAMERA_STATE_H

#include <libcamera/controls.h>

#include "frame_source.h"

namespace raygrid {

struct LibcameraLock {
  libcamera::ControlList fixing, releasing;  // for a request
  StateLock told;
};

/// The camera has these controls. `given` were set at the start: modes go back
/// to them, or to the camera's defaults. `now` is the last frame's, with the
/// lens position to fix.
LibcameraLock MakeLibcameraLock(const libcamera::ControlInfoMap& controls,
                                const libcamera::ControlList& given,
                                const FrameInfo& now);

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_LIBCAMERA_STATE_H
