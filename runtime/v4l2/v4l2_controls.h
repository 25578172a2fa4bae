/// Controls of V4L2 devices by name, as in v4l2-ctl.
#ifndef RAYGRID_V4L2_V4L2_CONTROLS_H
#define RAYGRID_V4L2_V4L2_CONTROLS_H

#include <linux/videodev2.h>

#include <cstdint>
#include <optional>
#include <string>

#include "frame_source.h"
#include "v4l2_device.h"

namespace raygrid {

/// Sets controls in order, because some enable others. Throws CameraError for
/// an unknown control or a rejected value.
void SetV4l2Controls(V4l2Device* device, const ControlValues& controls);

/// Queries a control by its id; nullopt if the device does not have it.
std::optional<v4l2_query_ext_ctrl> QueryV4l2Control(V4l2Device* device,
                                                    uint32_t id);
std::optional<int32_t> GetV4l2Control(V4l2Device* device, uint32_t id);
/// Sets a control. Returns 0, or the errno.
int SetV4l2Control(V4l2Device* device, uint32_t id, int32_t value);

/// Returns whether a control's value is in effect. A control governed by an
/// automatic mode is inactive, with an outdated value unless it is volatile.
inline bool IsInEffect(const v4l2_query_ext_ctrl& control) {
  return (control.flags & V4L2_CTRL_FLAG_INACTIVE) == 0 ||
         (control.flags & V4L2_CTRL_FLAG_VOLATILE) != 0;
}

/// The unit of V4L2_CID_EXPOSURE_ABSOLUTE.
constexpr float kExposureUnit_us = 100;

/// Lists the controls that can be set, with name and range, one per line.
std::string DescribeV4l2Controls(V4l2Device* device);

}  // namespace raygrid

#endif  // RAYGRID_V4L2_V4L2_CONTROLS_H
