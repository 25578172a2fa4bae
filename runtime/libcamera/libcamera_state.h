/// Controls that fix focus, exposure, gain and white balance of a camera.
#ifndef RAYGRID_LIBCAMERA_LIBCAMERA_STATE_H
#define RAYGRID_LIBCAMERA_LIBCAMERA_STATE_H

#include <libcamera/controls.h>

#include "frame_source.h"

namespace raygrid {

struct LibcameraLock {
  libcamera::ControlList lock_controls, unlock_controls;  // for requests
  StateLock lock_state;
};

/// Selects from the camera's controls. `given`: controls set at the start, to
/// which modes are restored, otherwise to the camera's defaults. `now`:
/// metadata of the last frame, with the lens position to fix.
LibcameraLock MakeLibcameraLock(const libcamera::ControlInfoMap& controls,
                                const libcamera::ControlList& given,
                                const FrameInfo& now);

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_LIBCAMERA_STATE_H
