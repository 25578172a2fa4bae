/// Controls of V4L2 devices by their names, as v4l2-ctl writes them.
#ifndef RAYGRID_V4L2_V4L2_CONTROLS_H
#define RAYGRID_V4L2_V4L2_CONTROLS_H

#include <linux/videodev2.h>

#include <cstdint>
#include <optional>
#include <string>

#include "frame_source.h"
#include "v4l2_device.h"

namespace raygrid {

/// Sets controls one after the other, since some of them enable others. Throws
/// CameraError where one is not known, or does not take the value.
void SetV4l2Controls(V4l2Device* device, const ControlValues& controls);

/// A control by its number; nothing where the device does not have it.
std::optional<v4l2_query_ext_ctrl> QueryV4l2Control(V4l2Device* device,
                                                    uint32_t id);
std::optional<int32_t> GetV4l2Control(V4l2Device* device, uint32_t id);
/// Returns 0, or the errno.
int SetV4l2Control(V4l2Device* device, uint32_t id, int32_t value);

/// Its value is the camera's own. A control that an automatic mode governs is
/// inactive, and may hold what was set long ago, unless it is volatile.
inline bool IsInEffect(const v4l2_query_ext_ctrl& control) {
  return (control.flags & V4L2_CTRL_FLAG_INACTIVE) == 0 ||
         (control.flags & V4L2_CTRL_FLAG_VOLATILE) != 0;
}

/// The unit of V4L2_CID_EXPOSURE_ABSOLUTE.
constexpr float kExposureUnit_us = 100;

/// A line of each control that can be set: its name and its range.
std::string DescribeV4l2Controls(V4l2Device* device);

}  // namespace raygrid

#endif  // RAYGRID_V4L2_V4L2_CONTROLS_H
