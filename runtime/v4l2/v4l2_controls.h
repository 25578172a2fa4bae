/// Controls of V4L2 devices by their names, as v4l2-ctl writes them.
#ifndef RAYGRID_V4L2_V4L2_CONTROLS_H
#define RAYGRID_V4L2_V4L2_CONTROLS_H

#include <string>

#include "frame_source.h"
#include "v4l2_device.h"

namespace raygrid {

/// Sets controls one after the other, since some of them enable others. Throws
/// CameraError where one is not known, or does not take the value.
void SetV4l2Controls(V4l2Device* device, const ControlValues& controls);

/// A line of each control that can be set: its name and its range.
std::string DescribeV4l2Controls(V4l2Device* device);

}  // namespace raygrid

#endif  // RAYGRID_V4L2_V4L2_CONTROLS_H
